"""Settings of the model predictive planner."""

from dataclasses import dataclass, fields

from cca_core._checks import check_real
from cca_core._repr import short_repr


@dataclass(frozen=True, slots=True, kw_only=True)
class MpcPlannerSettings:
    """Limits and thresholds of `MpcPlanner` in closed loop.

    Parameters
    ----------
    replan_period : float
        Time between two solutions [s].
    hold_time : float
        Time for which a solution is driven if no new one is found [s].
    start_fraction : float
        Fraction of the clearance that a trajectory must keep to start passing [-].
    continue_fraction : float
        Fraction of the clearance that it must keep to continue [-].
    outside_a_y_factor : float
        Factor on the lateral acceleration while the ego is outside its lane [-].
    curve_a_y : float
        Lateral acceleration that limits the speed in curves [m/s^2].
    blocking_gap : float
        Lateral gap to the ego below which a vehicle ahead is followed [m].
    vehicle_range : float
        Distance along the route beyond which vehicles are ignored [m].
    max_route_offset : float
        Lateral offset beyond which the ego is off its route [m].
    stop_deceleration : float
        Deceleration without a solution [m/s^2].
    drive_lag, yaw_lag : float
        Lags of the drive and of the yaw rate behind the steering angle, by which commands lead [s].
    prepared_vehicles : int
        Number of vehicles up to which all programs are built before the first cycle [-].

    Raises
    ------
    InputError
        If a value is negative.
    """

    replan_period: float = 0.1
    hold_time: float = 1.0
    start_fraction: float = 0.8
    continue_fraction: float = 0.4
    outside_a_y_factor: float = 1.5
    curve_a_y: float = 2.5
    blocking_gap: float = 0.3
    vehicle_range: float = 250.0
    max_route_offset: float = 15.0
    stop_deceleration: float = 4.0
    drive_lag: float = 0.1
    yaw_lag: float = 0.1
    prepared_vehicles: int = 4

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for field in fields(self):
            check_real(field.name, getattr(self, field.name), ge=0.0)

"""How the ego passes others: comfort, distances and what others are held capable of."""

from dataclasses import dataclass

from cca_core._checks import check_real
from cca_core.vehicle import STALE_AGE


@dataclass(frozen=True, slots=True, kw_only=True)
class EvasionSettings:
    """How the ego passes others.

    Parameters
    ----------
    lateral_acceleration : float
        Peak lateral acceleration that a swerve aims at [m/s^2]: the knob from smooth (2) to fast (3.5). A
        swerve by w takes sqrt(5.77 w / a) seconds.
    lateral_acceleration_limit : float
        Lateral acceleration above which a swerve is not driven [m/s^2].
    clearance : float
        Distance kept between boxes [m].
    min_ttc : float
        Time to contact with a vehicle in front at which the ego is fully beside its path [s].
    preparation_time : float
        Time before a swerve becomes due [s].
    x_safety : float
        Distance kept to vehicles on the lane beside [m], eq 11.
    awareness_range : float
        Distance up to which all vehicles are known by their messages [m]. Beyond it a vehicle at the speed
        limit is assumed on the lane beside; 0 makes that lane never free, infinity trusts silence.
    stale_after : float
        Age from which on a vehicle's messages are no longer believed and its lane is not free [s].
    min_speed_advantage : float
        Least speed advantage over a vehicle to be passed [m/s].
    assumed_braking : float
        Largest deceleration of others that is provided for [m/s^2].
    assumed_acceleration : float
        Largest acceleration of others that is provided for [m/s^2]; with 0 here and for `braking` everybody
        is taken to go on as now, which is the paper's view.
    assumed_acceleration_passed : float
        The same for the vehicle that is passed [m/s^2].

    Raises
    ------
    InputError
        If a value is out of range.
    """

    lateral_acceleration: float = 2.0
    lateral_acceleration_limit: float = 4.0
    clearance: float = 1.0
    min_ttc: float = 1.0
    preparation_time: float = 0.25
    x_safety: float = 7.0
    awareness_range: float = 300.0
    stale_after: float = STALE_AGE
    min_speed_advantage: float = 2.0
    assumed_braking: float = 8.0
    assumed_acceleration: float = 3.0
    assumed_acceleration_passed: float = 0.0

    def __post_init__(self) -> None:
        check_real("lateral_acceleration", self.lateral_acceleration, gt=0.0)
        check_real("lateral_acceleration_limit", self.lateral_acceleration_limit, gt=0.0)
        for name in (
            "clearance", "min_ttc", "preparation_time", "x_safety", "stale_after", "min_speed_advantage",
            "assumed_braking", "assumed_acceleration", "assumed_acceleration_passed",
        ):  # fmt: skip
            check_real(name, getattr(self, name), ge=0.0)
        check_real("awareness_range", self.awareness_range, ge=0.0, allow_inf=True)

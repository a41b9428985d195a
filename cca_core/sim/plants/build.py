"""The ego's plants by name; the multi-body car also comes to rest and moves off again."""

from cca_core.errors import InputError
from cca_core.sim.plants.multi_body import MultiBodyPlant
from cca_core.sim.plants.plant import Plant
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.vehicle import VehicleParams, VehicleState

__all__ = ["PLANTS", "RestartableMultiBodyPlant", "make_plant"]

PLANTS = ("single_track", "multi_body")
"""Names of the plants."""

_HANDS_OVER = 2.5  # speed above which the multi-body model takes over from rest [m/s]
_ROLLS = 2.0  # speed below which it only rolls to rest [m/s]


class RestartableMultiBodyPlant:
    """Multi-body car that moves off as a single track, since the model itself cannot.

    Parameters
    ----------
    vehicle : VehicleParams
        The car as a single track.
    state : VehicleState
        Where it starts.

    Raises
    ------
    MissingExtraError
        If commonroad-vehicle-models is not installed.
    """

    def __init__(self, vehicle: VehicleParams, state: VehicleState) -> None:
        self._vehicle = vehicle
        self._multi_body: MultiBodyPlant | None = MultiBodyPlant(state)
        self._single_track = SingleTrackPlant(vehicle, state)
        self.a_y = 0.0

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""
        return self._now.state

    @property
    def _now(self) -> Plant:
        return self._multi_body or self._single_track

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Drive on for a while.

        Parameters
        ----------
        delta : float
            Commanded road-wheel angle [rad], left positive.
        a_x : float
            Commanded acceleration [m/s^2].
        dt : float
            Duration [s].
        """
        state = self.state
        if self._multi_body is not None and a_x > 0.0 and state.v_x < _ROLLS:
            self._multi_body = None
            self._single_track = SingleTrackPlant(self._vehicle, state)
        elif self._multi_body is None and state.v_x > _HANDS_OVER:
            self._multi_body = MultiBodyPlant(state)
        self._now.step(delta, a_x, dt)
        self.a_y = self._now.a_y


def make_plant(name: str, vehicle: VehicleParams, state: VehicleState) -> Plant:
    """Put a car on the road.

    Parameters
    ----------
    name : {"single_track", "multi_body"}
        Single track on tires that can slide, or the multi-body BMW 320i (extra ``plant``).
    vehicle : VehicleParams
        The ego.
    state : VehicleState
        Where it starts.

    Returns
    -------
    plant : Plant
        The car.

    Raises
    ------
    InputError
        If the name is unknown.
    MissingExtraError
        If the multi-body model is not installed.
    """
    if name not in PLANTS:
        raise InputError(f"plant must be one of {', '.join(PLANTS)}, was {name!r}")
    return (
        SingleTrackPlant(vehicle, state)
        if name == "single_track"
        else RestartableMultiBodyPlant(vehicle, state)
    )

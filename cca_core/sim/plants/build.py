"""The ego's plants by name."""

from collections.abc import Callable

from cca_core.errors import InputError
from cca_core.sim.plants.multi_body import MIN_MULTI_BODY_SPEED, MultiBodyPlant
from cca_core.sim.plants.plant import Plant
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.vehicle import VehicleParams, VehicleState


class RestartableMultiBodyPlant:
    """Multi-body car that moves off as a single track, since the model itself cannot."""

    def __init__(self, vehicle: VehicleParams, state: VehicleState, *, restart_speed: float = 2.5) -> None:
        self._vehicle, self._restart_speed = vehicle, restart_speed
        self._multi_body: MultiBodyPlant | None = MultiBodyPlant(state)
        self._single_track = SingleTrackPlant(vehicle, state)
        self.a_y = 0.0

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""
        return self._active.state

    @property
    def _active(self) -> Plant:
        return self._multi_body or self._single_track

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Advance by a time step [s] with a commanded road-wheel angle [rad] and acceleration [m/s^2]."""
        state = self.state
        if a_x > 0.0 and self._multi_body is not None and state.v_x < MIN_MULTI_BODY_SPEED:
            self._multi_body = None
            self._single_track = SingleTrackPlant(self._vehicle, state)
        elif self._multi_body is None and state.v_x > self._restart_speed:
            self._multi_body = MultiBodyPlant(state)
        self._active.step(delta, a_x, dt)
        self.a_y = self._active.a_y


PLANTS: dict[str, Callable[[VehicleParams, VehicleState], Plant]] = {
    "single_track": SingleTrackPlant,
    "multi_body": RestartableMultiBodyPlant,
}
"""Plants by name: single track on tires that can slide, or multi-body BMW 320i (extra ``plant``)."""


def make_plant(name: str, vehicle: VehicleParams, state: VehicleState) -> Plant:
    """Make a plant.

    Parameters
    ----------
    name : {"single_track", "multi_body"}
        One of `PLANTS`.
    vehicle : VehicleParams
        The ego.
    state : VehicleState
        Its motion at the start.

    Returns
    -------
    plant : Plant
        The plant.

    Raises
    ------
    InputError
        If the name is unknown.
    MissingExtraError
        If the multi-body model is not installed.
    """
    if name not in PLANTS:
        raise InputError(f"plant must be one of {', '.join(PLANTS)}, was {name!r}")
    return PLANTS[name](vehicle, state)

"""The ego's plants by name."""

import math
from collections.abc import Callable

from cca_core._checks import check_real, shown
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


PlantMaker = Callable[[VehicleParams, VehicleState], Plant]
"""Makes a plant from the ego and its motion at the start, such as a class of plants."""

PLANTS: dict[str, PlantMaker] = {
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


def plant_name(plant: str | Plant | PlantMaker) -> str:
    """Return the name of a plant in logs: its own, or that of its class."""
    return plant if isinstance(plant, str) else str(getattr(plant, "__name__", type(plant).__name__))


def start_plant(
    plant: str | Plant | PlantMaker, vehicle: VehicleParams, start: VehicleState, max_distance: float
) -> Plant:
    """Return the plant of a name, of a maker, or given; it must be within a distance [m] of the start."""
    if isinstance(plant, str):
        return make_plant(plant, vehicle, start)
    made: object = plant
    if isinstance(plant, type) or (callable(plant) and not hasattr(plant, "step")):
        made = plant(vehicle, start)
    missing = [name for name in ("state", "step", "a_y") if not hasattr(made, name)]
    if missing or not callable(made.step):  # type: ignore[attr-defined]  # it has one, or is refused before
        raise InputError(
            f"plant must be one of {', '.join(PLANTS)}, or have state, a method step and a_y; "
            f"{shown(made)} has no {' and '.join(missing) or 'method step'}"
        )
    return _checked(made, start, max_distance)  # type: ignore[arg-type]  # it has all members


def _checked(plant: Plant, start: VehicleState, max_distance: float) -> Plant:
    """Return a plant whose motion fits the start."""
    state: object = plant.state
    if not isinstance(state, VehicleState):
        raise InputError(f"plant.state must be a VehicleState, was {shown(state)}")
    check_real("plant.a_y", plant.a_y)
    distance = math.hypot(state.x - start.x, state.y - start.y)
    if distance > max_distance or math.cos(state.psi - start.psi) < 0.0:
        raise InputError(
            f"plant.state must be at the scenario's start, at most {max_distance:g} m away and in its "
            f"direction, was {distance:.1f} m away with heading {state.psi:.2f} rad ({start.psi:.2f} there); "
            "a run needs a new plant"
        )
    return plant

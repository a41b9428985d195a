"""Run through the gates of a double lane change, with the distances of the body to them."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cca_core._checks import Array, check_real
from cca_core._repr import short_repr
from cca_core.band import Band
from cca_core.follow import PreviewController
from cca_core.geometry import box_gap
from cca_core.sim.handling.iso3888 import DoubleLaneChange
from cca_core.sim.handling.tracking import Steering, TrackingRun, track_path
from cca_core.sim.plants.plant import Plant
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.vehicle import VehicleState


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GateRun:
    """One run through the gates.

    Parameters
    ----------
    gaps : ndarray, shape (3, 2)
        Minimum distance of the body to the right and the left side of each gate [m], negative in a collision.
    sideslip : float
        Largest sideslip angle of the center of gravity without sign [rad].
    exit_speed : float
        Speed at the end of the run [m/s].
    poses : ndarray, shape (n, 3)
        Position [m] and heading [rad] of the center of gravity every 20 ms.
    run : TrackingRun
        Steering, lateral acceleration and errors.
    """

    gaps: Array
    sideslip: float
    exit_speed: float
    poses: Array
    run: TrackingRun

    __repr__ = short_repr

    @property
    def gap(self) -> float:
        """Minimum distance of the body to any gate [m], negative in a collision."""
        return float(self.gaps.min())

    @property
    def passed(self) -> bool:
        """Whether the car reached the end without a collision."""
        return self.run.finished and self.gap > 0.0

    @property
    def a_y(self) -> float:
        """Largest lateral acceleration without sign [m/s^2]."""
        return float(np.abs(self.run.a_y).max())


@dataclass(slots=True)
class _RecordingPlant:
    """A plant that records its motion; its throttle is released at a position."""

    plant: Plant
    release: float
    drag: float
    a_y: float = 0.0
    motion: list[VehicleState] = field(default_factory=list)

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""
        return self.plant.state

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Advance by a time step."""
        state = self.plant.state
        self.motion.append(state)
        self.plant.step(delta, -self.drag if state.x > self.release else a_x, dt)
        self.a_y = self.plant.a_y


def drive_through(
    course: DoubleLaneChange,
    band: Band,
    speed: float,
    plant: Callable[[VehicleState], Plant] | None = None,
    *,
    steer: Steering | None = None,
    drag: float = 0.4,
) -> GateRun:
    """Drive along a path through the gates.

    Parameters
    ----------
    course : DoubleLaneChange
        The track.
    band : Band
        A path through it.
    speed : float
        Entry speed [m/s], constant up to the release of the throttle.
    plant : callable, optional
        Makes the plant from its initial motion; the default is a single track of the band's vehicle.
    steer : callable, optional
        Steering law; the default is the preview controller for the band's vehicle, with the angles that tires
        need near their limit.
    drag : float
        Deceleration of the engine after the throttle is released [m/s^2].

    Returns
    -------
    run : GateRun
        Distances to the gates, and the motion.

    Raises
    ------
    InputError
        If `speed` is not positive or `drag` is negative.
    """
    car, path = band.problem.vehicle, band.path()
    x, y = path.position(path.start).tolist()
    start = VehicleState(x=x, y=y, psi=0.0, v_x=check_real("speed", speed, gt=0.0))
    driven = _RecordingPlant(
        plant(start) if plant else SingleTrackPlant(car, start),
        course.release - car.front, check_real("drag", drag, ge=0.0),
    )  # fmt: skip
    # 12 m/s^2: what linear tires would give at the largest angle; real ones give about 7
    law = steer or PreviewController(car, a_y_max=12.0).steer
    run = track_path(driven, law, path, speed, margin=30.0)
    poses = np.array([(state.x, state.y, state.psi) for state in driven.motion])
    poses[:, 2] = np.unwrap(poses[:, 2])
    cycle = np.arange(len(poses))
    fine = np.linspace(0.0, cycle[-1], 8 * len(cycle))  # 8 poses of the body a cycle
    x, y, psi = (np.interp(fine, cycle, column) for column in poses.T)
    body = car.body_at(x, y, psi)
    gaps = np.array([box_gap(body, block).min() for block in course.obstacles()]).reshape(3, 2)
    sideslip = max(abs(math.atan2(state.v_y, state.v_x)) for state in driven.motion)
    return GateRun(gaps=gaps, sideslip=sideslip, exit_speed=driven.state.v_x, poses=poses, run=run)

"""Path tracking: a lane change as path, a closed steering loop, and its errors."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array, check_real
from cca_core._repr import short_repr
from cca_core.follow import PoseEstimator, SpeedSettings, profile_acceleration
from cca_core.geometry import quintic_step
from cca_core.path import Path, interpolate_path
from cca_core.sim.plants.plant import Plant
from cca_core.sim.world.traffic import CYCLE_TIME
from cca_core.vehicle import VehicleState

Steering = Callable[[VehicleState, Path], float]
"""A steering law: road-wheel angle [rad] from the motion of the car and the path to follow."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TrackingRun:
    """One run along a path.

    Parameters
    ----------
    s, d : ndarray, shape (n,)
        Arc length and lateral error of the center of gravity [m], left positive.
    delta : ndarray, shape (n,)
        Road-wheel angle [rad].
    a_y : ndarray, shape (n,)
        Lateral acceleration [m/s^2].
    finished : bool
        Whether the end was reached within the maximum lateral error.
    """

    s: Array
    d: Array
    delta: Array
    a_y: Array
    finished: bool

    __repr__ = short_repr

    @property
    def peak(self) -> float:
        """Largest lateral error without sign [m]; infinite if the end was not reached."""
        return float(np.abs(self.d).max()) if self.finished else math.inf

    @property
    def rms(self) -> float:
        """Root mean square of the lateral error [m]; infinite if the end was not reached."""
        return float(np.sqrt(np.mean(self.d**2))) if self.finished else math.inf


def lane_change_path(width: float, length: float, *, before: float = 80.0, after: float = 150.0) -> Path:
    """Straight road with a quintic lane change to the left.

    Parameters
    ----------
    width : float
        Lateral offset [m].
    length : float
        Length of the lane change [m].
    before, after : float
        Length of the straight road before and after it [m].

    Returns
    -------
    path : Path
        The path, from the origin along +x. Its peak lateral acceleration at a speed v is
        5.7735 width v^2 / length^2.

    Raises
    ------
    InputError
        If a value is not finite, or a distance is not positive or exceeds 1000 km.
    """
    width = check_real("width", width)
    length, before, after = (
        check_real(name, value, gt=0.0, le=1e6)
        for name, value in (("length", length), ("before", before), ("after", after))
    )
    total = before + length + after
    x = np.linspace(0.0, total, math.ceil(total) + 1)
    fraction = np.clip((x - before) / length, 0.0, 1.0)
    y = quintic_step(fraction, width)
    return interpolate_path(np.column_stack((x, y)), start_tangent=(1.0, 0.0), end_tangent=(1.0, 0.0))


def track_path(
    plant: Plant,
    steer: Steering,
    path: Path,
    speed: float | tuple[Array, Array],
    *,
    delay: float = 0.0,
    fix_sigma: float = 0.0,
    seed: int = 1,
    margin: float = 60.0,
    max_error: float = 5.0,
) -> TrackingRun:
    """Drive along a path.

    Parameters
    ----------
    plant : Plant
        The car, on or near the path, with its initial speed.
    steer : callable
        Steering law, called every 20 ms.
    path : Path
        The path.
    speed : float or tuple of ndarray
        Target speed [m/s], or arc lengths [m] and squares of speeds [m^2/s^2] as `squared_speed_limit`
        gives them.
    delay : float
        Dead time between steering command and car [s].
    fix_sigma : float
        Standard deviation of position fixes at 10 Hz, which are filtered with speed and yaw rate
        (`PoseEstimator`) [m]; with 0 the law gets the true motion.
    seed : int
        Seed of the noise [-].
    margin : float
        Length of the path that is left at the end of the run [m].
    max_error : float
        Lateral error at which the run ends [m].

    Returns
    -------
    run : TrackingRun
        True errors of the center of gravity, whatever the law got.

    Raises
    ------
    InputError
        If `delay`, `fix_sigma` or `margin` is negative, or `max_error` not positive.
    """
    delay = check_real("delay", delay, ge=0.0)
    fix_sigma = check_real("fix_sigma", fix_sigma, ge=0.0)
    end = path.end - check_real("margin", margin, ge=0.0)
    max_error = check_real("max_error", max_error, gt=0.0)
    rng = np.random.default_rng(seed)
    estimator = PoseEstimator(plant.state, fix_sigma=max(fix_sigma, 1e-3))
    queue = [plant.state.delta] * round(delay / CYCLE_TIME)
    s = float(path.project((plant.state.x, plant.state.y))[0])
    rows: list[tuple[float, float, float, float]] = []
    k = 0
    while s < end:
        state = plant.state
        s, d, _, _ = path.foot_point(state.x, state.y, s)
        rows.append((s, d, state.delta, plant.a_y))
        if abs(d) > max_error or (state.v_x < 0.05 and k > 500):
            break
        estimate = state
        if fix_sigma > 0.0:
            estimate = estimator.predict(state, CYCLE_TIME) if k else state
            if k % 5 == 0:
                x, y = rng.normal((state.x, state.y), fix_sigma)
                estimate = estimator.correct(float(x), float(y))
        queue.append(steer(replace(estimate, delta=state.delta), path))
        plant.step(queue.pop(0), _acceleration(state.v_x, s, speed), CYCLE_TIME)
        k += 1
    columns = np.array(rows).T
    return TrackingRun(s=columns[0], d=columns[1], delta=columns[2], a_y=columns[3], finished=s >= end)


def _acceleration(v_x: float, s: float, speed: float | tuple[Array, Array]) -> float:
    if isinstance(speed, tuple):
        return profile_acceleration(s, v_x, speed, SpeedSettings())
    return min(max(1.5 * (speed - v_x), -3.0), 2.0)

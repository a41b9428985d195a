"""Plan of a safe stop for the kit: a model of the vehicle drives it in advance."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.follow import PreviewController, friction_limited
from cca_core.path import Path
from cca_core.planner import SafeStop
from cca_core.rig.safe_stop import SAFE_STOP_POINTS, StopProfile
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.vehicle import VehicleParams, VehicleState

_FINAL_BRAKING = 2.0  # where the stop is at rest, at least [m/s^2]
_REST = 0.1  # speed below which the model is at rest [m/s]
_RESOLUTION = 0.05  # of the spacing on CAN [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class SafeStopSettings:
    """How a safe stop is planned.

    Parameters
    ----------
    deceleration : float
        Deceleration on a straight of a stop that is not certified, and of one that is where its path ends
        [m/s^2], positive.
    grip_fraction : float
        Fraction of the friction circle that steering and braking share [-].
    reaction_time : float
        Time that may pass before the brakes are applied [s]: interval of the plans, timeout and two cycles.
    gain : float
        Acceleration per difference to the speed of a certified stop [1/s].
    lag : float
        Time constant of the brakes, for a stop that ends with its path [s].
    step : float
        Time step of the model [s], positive.
    max_time : float
        Time after which the model ends if it is not at rest [s], positive.

    Raises
    ------
    InputError
        If a value is not finite or out of range.
    """

    deceleration: float = 7.0
    grip_fraction: float = 0.85
    reaction_time: float = 0.3
    gain: float = 2.0
    lag: float = 0.1
    step: float = 0.05
    max_time: float = 25.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_real("deceleration", self.deceleration, gt=0.0)
        check_real("grip_fraction", self.grip_fraction, gt=0.0, le=1.0)
        check_real("reaction_time", self.reaction_time, ge=0.0, le=2.0)
        check_real("gain", self.gain, ge=0.0)
        check_real("lag", self.lag, ge=0.0)
        check_real("step", self.step, gt=0.0, le=0.1)
        check_real("max_time", self.max_time, gt=0.0)


def plan_safe_stop(
    vehicle: VehicleParams,
    reference: Path,
    state: VehicleState,
    settings: SafeStopSettings | None = None,
    *,
    stop: SafeStop | None = None,
    s_guess: float | None = None,
) -> StopProfile:
    """Plan a stop for the kit by driving a model of the vehicle.

    Parameters
    ----------
    vehicle : VehicleParams
        The ego.
    reference : Path
        Path of the last command, such as `Command.reference`.
    state : VehicleState
        Motion of the ego now.
    settings : SafeStopSettings, optional
        Braking and model.
    stop : SafeStop, optional
        `Command.safe_stop`: the model follows its poses with its accelerations. Without it, or if it does not
        move, the model brakes along `reference`.
    s_guess : float, optional
        Station close to the ego on `reference` [m]; the default searches the whole path.

    Returns
    -------
    safe_stop : StopProfile
        Its first point is at the ego.

    Raises
    ------
    InputError
        If `s_guess` is not finite.

    Notes
    -----
    The model is `SingleTrackPlant`, steered by a `PreviewController`. Without `stop` it coasts for the
    reaction time and then brakes, so that the points cover the distance of a car that brakes late. With it,
    it comes to rest where the poses end, also if the stop drives on for all of its time.
    """
    settings = settings or SafeStopSettings()
    guess = None if s_guess is None else check_real("s_guess", s_guess)
    path = None if stop is None or state.v_x < _REST else stop.path()
    if stop is not None and path is not None:
        s = float(path.project((state.x, state.y))[0])
        return _roll_out(vehicle, path, state, settings, _demand(stop, path.end, settings), s, 0.0)
    s = float(reference.project((state.x, state.y))[0]) if guess is None else guess
    return _roll_out(
        vehicle, reference, replace(state, a_x=0.0), settings, lambda *_: -settings.deceleration, s,
        settings.reaction_time,
    )  # fmt: skip


def _demand(stop: SafeStop, end: float, settings: SafeStopSettings) -> Callable[[float, float, float], float]:
    """Return the acceleration of a stop at a time, a station and a speed: at rest before its path ends."""
    moving = np.flatnonzero(stop.v > _REST)
    rest = float(stop.t[moving[-1] + 1]) if moving[-1] + 1 < len(stop.t) else math.inf

    def demand(t: float, s: float, v: float) -> float:
        lack = float(np.interp(t, stop.t, stop.v)) - v
        a_x = float(np.interp(t, stop.t, stop.a_x)) + settings.gain * lack if t < rest else -_FINAL_BRAKING
        left = max(end - s - settings.lag * v, 0.0)
        return min(a_x, -settings.deceleration) if v * v > 2.0 * settings.deceleration * left else a_x

    return demand


def _roll_out(
    vehicle: VehicleParams, path: Path, state: VehicleState, settings: SafeStopSettings,
    demand: Callable[[float, float, float], float], begin: float, coasting: float,
) -> StopProfile:  # fmt: skip
    """Drive a model along a path with demanded accelerations, the first of them late, and sample it."""
    car, controller = SingleTrackPlant(vehicle, state), PreviewController(vehicle)
    driven, t, a_y = 0.0, 0.0, state.v_x * state.r
    points = []
    while t < settings.max_time and (t < settings.reaction_time or car.state.v_x > _REST):
        now = car.state
        delta = controller.steer(now, path, settings.step, s_guess=begin)
        a_x = friction_limited(
            demand(t, begin + driven, now.v_x), a_y, vehicle.mu, grip_fraction=settings.grip_fraction
        )
        points.append((driven, now.psi - state.psi, delta, a_x))
        car.step(delta, a_x if t >= coasting else 0.0, settings.step)
        driven += 0.5 * (now.v_x + car.state.v_x) * settings.step
        t, a_y = t + settings.step, car.a_y
    at, *columns = np.array(points).T
    spacing = math.ceil(max(driven / (SAFE_STOP_POINTS - 1), _RESOLUTION) / _RESOLUTION) * _RESOLUTION
    stations = spacing * np.arange(SAFE_STOP_POINTS)
    heading, delta, a_x = (np.interp(stations, at, column) for column in columns)
    a_x[-1] = min(a_x[-1], -_FINAL_BRAKING)
    return StopProfile(
        spacing=spacing, heading=tuple(heading.tolist()), delta=tuple(delta.tolist()),
        a_x=tuple(a_x.tolist()),
    )  # fmt: skip

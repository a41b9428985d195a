"""Safe stop: steering and braking over distance that bring the ego to rest on its reference path."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import check_array, check_real
from cca_core.errors import InputError
from cca_core.follow import PreviewController, friction_limited
from cca_core.path import Path
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.vehicle import VehicleParams, VehicleState

SAFE_STOP_POINTS = 26
"""Number of points of a safe stop; thirteen CAN messages carry them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StopProfile:
    """Steering and braking over the distance from where it was planned.

    Parameters
    ----------
    spacing : float
        Distance between two points [m], positive.
    delta : tuple of float
        Road-wheel angle at each of 26 points [rad], left positive.
    deceleration : tuple of float
        Deceleration at each point [m/s^2], not negative.

    Raises
    ------
    InputError
        If a value is not finite or out of range, or there are not 26 points.

    Notes
    -----
    Distance instead of time makes the steering independent of the moment at which the brakes are applied: a
    kit that misses its commands brakes only after its timeout.
    """

    spacing: float
    delta: tuple[float, ...]
    deceleration: tuple[float, ...]

    def __post_init__(self) -> None:
        check_real("spacing", self.spacing, gt=0.0)
        check_array("delta", self.delta, (SAFE_STOP_POINTS,))
        lowest = check_array("deceleration", self.deceleration, (SAFE_STOP_POINTS,)).min()
        if lowest < 0.0:
            raise InputError(f"deceleration must be at least 0, was {lowest:g}")

    def at(self, distance: float) -> tuple[float, float]:
        """Command at a distance from the start.

        Parameters
        ----------
        distance : float
            Distance traveled since the safe stop was planned [m]. The last point counts beyond the end.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive.
        a_x : float
            Acceleration [m/s^2], not positive.
        """
        last = SAFE_STOP_POINTS - 1
        position = min(max(distance / self.spacing, 0.0), float(last))
        i = min(int(position), last - 1)
        w = position - i
        delta = (1.0 - w) * self.delta[i] + w * self.delta[i + 1]
        return delta, -((1.0 - w) * self.deceleration[i] + w * self.deceleration[i + 1])


class StoredStop:
    """The last safe stop of a computer, and the distance since it was planned."""

    def __init__(self) -> None:
        self.plan: StopProfile | None = None
        self._distance, self._v, self._t = 0.0, 0.0, -math.inf

    def load(self, plan: StopProfile, t: float) -> None:
        """Store a safe stop that begins at the present position."""
        self.plan, self._distance, self._t = plan, 0.0, t

    def move(self, v_x: float, t: float) -> None:
        """Advance by the distance since the last call, at a measured speed [m/s]."""
        self._distance += 0.5 * (self._v + v_x) * self._elapsed(t)
        self._v, self._t = v_x, t

    def execute(self, t: float | None = None) -> tuple[float, float] | None:
        """Return road-wheel angle [rad] and acceleration [m/s^2] at this distance; None without a plan."""
        if self.plan is None:
            return None
        if t is not None:  # no speed is measured: the vehicle has braked as planned
            _, a_x = self.plan.at(self._distance)
            self.move(max(self._v + a_x * self._elapsed(t), 0.0), t)
        return self.plan.at(self._distance)

    def _elapsed(self, t: float) -> float:
        """Time since the last call [s]; a pause of the process counts as 1 s."""
        return min(max(t - self._t, 0.0), 1.0) if self._t > -math.inf else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SafeStopSettings:
    """How a safe stop is planned.

    Parameters
    ----------
    deceleration : float
        Deceleration on a straight [m/s^2], positive.
    grip_fraction : float
        Fraction of the friction circle that steering and braking share [-].
    reaction_time : float
        Time that may pass before the brakes are applied [s]: interval of the plans, timeout and two cycles.
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
    step: float = 0.05
    max_time: float = 20.0

    def __post_init__(self) -> None:
        check_real("deceleration", self.deceleration, gt=0.0)
        check_real("grip_fraction", self.grip_fraction, gt=0.0, le=1.0)
        check_real("reaction_time", self.reaction_time, ge=0.0, le=2.0)
        check_real("step", self.step, gt=0.0, le=0.1)
        check_real("max_time", self.max_time, gt=0.0)


def plan_safe_stop(
    vehicle: VehicleParams,
    reference: Path,
    state: VehicleState,
    settings: SafeStopSettings | None = None,
    *,
    s_guess: float | None = None,
) -> StopProfile:
    """Plan the stop on the reference path by driving a model of the vehicle along it.

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
    s_guess : float, optional
        Station close to the ego on the path [m]; the default searches the whole path.

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
    The model is `SingleTrackPlant`, steered by a `PreviewController`. It coasts for the reaction time and
    then brakes, so that the points cover the distance of a car that brakes late.
    """
    settings = settings or SafeStopSettings()
    car, controller = SingleTrackPlant(vehicle, replace(state, a_x=0.0)), PreviewController(vehicle)
    if s_guess is None:
        guess = float(reference.project((state.x, state.y))[0])
    else:
        guess = check_real("s_guess", s_guess)
    distance, t, a_y = 0.0, 0.0, state.v_x * state.r
    points = []
    while t < settings.max_time and (t < settings.reaction_time or car.state.v_x > 0.1):
        now = car.state
        delta = controller.steer(now, reference, settings.step, s_guess=guess)
        brake = friction_limited(
            -settings.deceleration, a_y, vehicle.mu, grip_fraction=settings.grip_fraction
        )
        points.append((distance, delta, -brake))
        car.step(delta, brake if t >= settings.reaction_time else 0.0, settings.step)
        distance += 0.5 * (now.v_x + car.state.v_x) * settings.step
        t, a_y = t + settings.step, car.a_y
    at, delta, deceleration = np.array(points).T
    spacing = max(distance / (SAFE_STOP_POINTS - 1), 0.02)
    stations = spacing * np.arange(SAFE_STOP_POINTS)
    return StopProfile(
        spacing=spacing, delta=tuple(np.interp(stations, at, delta).tolist()),
        deceleration=tuple(np.interp(stations, at, deceleration).tolist()),
    )  # fmt: skip

"""Inputs of a planner and of a cycle: which of them can be used."""

import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from types import NoneType
from typing import Protocol

import numpy as np

from cca_core.errors import InputError
from cca_core.follow import PreviewController, SpeedSettings, has_shipped_gains
from cca_core.frenet import FrenetVehicle
from cca_core.path import Path, Road
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.tuning import DecisionSettings
from cca_core.vehicle import (
    MAX_COORDINATE,
    MAX_SPEED,
    STALE_AGE,
    RemoteVehicle,
    VehicleParams,
    VehicleState,
)
from cca_core.vehicle.remote import is_finite_number

__all__ = [
    "CycleClock",
    "RadioHealth",
    "check_arguments",
    "check_road",
    "first_station",
    "invalid_input_reason",
    "invalid_state_reason",
    "is_list",
    "usable_range",
    "vehicles_on_level",
    "warn_of_foreign_gains",
    "warn_of_tight_bend",
]

_MAX_TIME = 1e12  # [s]; larger numbers have no resolution left for a cycle
_SPACING = 2.0  # of the stations at which the ego's first one is searched [m]
_ROUNDING = 1e-6  # of differences between times [s]
_MAX_PERIOD = 0.1  # to which the limits of steering and jerk apply [s]; longer cycles count as this


class RadioHealth(Protocol):
    """Whether the list of other vehicles is complete; `Tracker.health` returns one."""

    @property
    def trusted(self) -> bool:
        """Whether a vehicle that is not in the list is not there."""

    @property
    def reason(self) -> str:
        """Why not."""


class CycleClock:
    """Period of each cycle: by the caller's time stamps, or the last one if a stamp cannot be used."""

    def __init__(self) -> None:
        self.t = -math.inf  # now: the stamps, as long as all can be used; never steps back [s]
        self.period = 0.02  # last one by the stamps [s]
        self.lost_time = 0.0  # time without a usable stamp [s]
        self.now = math.nan  # on the caller's clock; NaN while that is being set back [s]
        self._stamp = math.nan
        self._assumed = 0.0  # time added since the last usable stamp [s]

    @property
    def is_lost(self) -> bool:
        """Whether there was no usable stamp for so long that the ages of other vehicles mean nothing."""
        return self.lost_time > STALE_AGE + _ROUNDING

    def advance(self, t: object) -> tuple[float, str]:
        """Return the period of this cycle [s], and what is wrong with its time stamp; empty if nothing is."""
        stamp, last = _as_time(t), self._stamp
        if stamp > last:
            passed = stamp - last
            period = max(passed - self._assumed, 1e-3)
            if self._assumed == 0.0:
                self.period = min(period, _MAX_PERIOD)
            self._stamp, self._assumed, self.lost_time, self.now = stamp, 0.0, 0.0, stamp
            self.t = stamp if self.t == last else self.t + period
            fault = f"t jumped by {passed:.1f} s; counted as {_MAX_PERIOD:g} s" if passed > STALE_AGE else ""
            return min(period, _MAX_PERIOD), fault
        if math.isnan(last) and not math.isnan(stamp):
            self._stamp, self._assumed, self.lost_time, self.now = stamp, 0.0, 0.0, stamp
            self.t = max(self.t, stamp)
            return _MAX_PERIOD, ""
        if stamp < last:
            self._stamp, self._assumed, self.now = stamp, 0.0, math.nan
            fault = f"t stepped back by {last - stamp:.3g} s"
        else:
            self._assumed += self.period
            self.now = last + self._assumed
            repeated = f"t repeats {stamp:.12g} s"
            fault = repeated if stamp == last else f"t must be a time in seconds, was {_shown(t)}"
        self.t = max(self.t, 0.0) + self.period
        self.lost_time += self.period
        return self.period, f"{fault}; continued with the last period ({self.period:.3g} s)"


def check_arguments(
    vehicle: object, road: object, evasion: object, speed: object, controller: object
) -> None:
    """Raise InputError for an argument of `Planner` that has the wrong type."""
    for name, value, kinds in (
        ("vehicle", vehicle, (VehicleParams,)),
        ("road", road, (Road, Path)),
        ("evasion", evasion, (EvasionSettings, NoneType)),
        ("speed", speed, (SpeedSettings, NoneType)),
        ("controller", controller, (PreviewController, NoneType)),
    ):
        if not isinstance(value, kinds):
            raise InputError(f"{name} must be {kinds[0].__name__}, was {type(value).__name__}")


def check_road(road: object) -> None:
    """Raise InputError if a route is none."""
    if not isinstance(road, Road | Path):
        raise InputError(f"road must be Road or Path, was {type(road).__name__}")


def warn_of_tight_bend(path: Path, vehicle: VehicleParams) -> None:
    """Warn of a curve that the vehicle cannot drive at any speed."""
    radius = vehicle.wheelbase / math.tan(min(vehicle.delta_max, 1.5))
    if path.min_radius < radius:
        warnings.warn(
            f"the path has a curve of radius {path.min_radius:.2g} m at s={path.s_min_radius:.1f} m, "
            f"the vehicle turns with {radius:.2g} m at least; fit_path with curvature_limit widens it",
            stacklevel=3,
        )  # fmt: skip


def warn_of_foreign_gains(vehicle: VehicleParams) -> None:
    """Warn of a vehicle that no gains were designed for, once for each vehicle."""
    if not has_shipped_gains(vehicle):
        numbers = vehicle.m, vehicle.I_z, vehicle.l_f, vehicle.l_r, vehicle.C_f, vehicle.C_r
        _warn_once_of_gains(*map(float, numbers), float(vehicle.steering_lag))


@lru_cache
def _warn_once_of_gains(*_: float) -> None:
    warnings.warn(
        "no steering gains were designed for this vehicle, so the shipped ones of a preset steer it (the "
        "feedforward is its own; if design_gains finds none, its error names a region= that has some); pass "
        "controller=PreviewController(vehicle, design_gains(vehicle))",
        stacklevel=4,
    )


def _as_time(t: object) -> float:
    """Return a time stamp in seconds, NaN if it is none."""
    if type(t) is float:  # an abstract class is slow to ask
        return t if abs(t) < _MAX_TIME else math.nan
    try:
        time = float(t) if is_finite_number(t) else math.nan  # type: ignore[arg-type]
    except Exception:  # a number type of the caller's
        return math.nan
    return time if abs(time) < _MAX_TIME else math.nan


def _shown(value: object) -> str:
    try:
        return str(value)[:20]
    except Exception:  # an object of the caller's
        return type(value).__name__


def invalid_input_reason(t: object, last_t: float, state: object) -> str:
    """Return why time or state cannot be used by a planner that needs increasing times; empty if they can."""
    if not _as_time(t) > last_t:
        return f"t must be finite and increase, was {_shown(t)} after {last_t:g}"
    return invalid_state_reason(last_t, state, math.inf)


def invalid_state_reason(t: float, state: object, max_age: float) -> str:
    """Return why the ego's state cannot be used at a time; empty if it can."""
    if not isinstance(state, VehicleState):
        return f"state must be a VehicleState, was {type(state).__name__}"
    if max(abs(state.x), abs(state.y)) > MAX_COORDINATE or state.v_x > MAX_SPEED:
        return "state must be that of a road vehicle (position in meters, speed in m/s)"
    age = 0.0 if state.t is None else t - float(state.t)
    if age > max_age + _ROUNDING:
        return f"state is {age:.3g} s old (limit {max_age:g} s)"
    if age < -max_age - _ROUNDING:
        return f"state was measured {-age:.3g} s after t; both must come from one clock"
    return ""


def first_station(path: Path, state: VehicleState) -> float:
    """Station at which the ego begins [m]: of equally near ones the first where it heads along the route."""
    nearest = float(path.project((state.x, state.y))[0])
    stations = np.linspace(path.start, path.end, max(2, math.ceil(path.length / _SPACING) + 1))
    xy, first, _ = path.derivatives(stations)
    along = first[:, 0] * math.cos(state.psi) + first[:, 1] * math.sin(state.psi) > 0.0
    distance = np.where(along, np.hypot(xy[:, 0] - state.x, xy[:, 1] - state.y), math.inf)
    if not along.any():
        return nearest
    near = np.append(distance <= distance.min() + _SPACING, False)
    begin = int(np.argmax(near))
    end = begin + int(np.argmin(near[begin:]))
    guess = float(stations[begin + int(np.argmin(distance[begin:end]))])
    return nearest if abs(guess - nearest) <= _SPACING else float(path.project((state.x, state.y), guess)[0])


def vehicles_on_level(
    vehicles: Sequence[FrenetVehicle], road: Road, settings: DecisionSettings
) -> tuple[list[FrenetVehicle], tuple[tuple[str, str], ...], tuple[str, ...]]:
    """Return the vehicles at the height of the route, others with the reason, and faults of heights."""
    if all([n.remote.z is None for n in vehicles]):
        return list(vehicles), (), ()
    kept: list[FrenetVehicle] = []
    others: list[tuple[str, str]] = []
    faults: list[str] = []
    for n in vehicles:
        difference = _height_above(n, road)
        if abs(difference) <= settings.level_gap:
            kept.append(n)
            continue
        limit = settings.level_gap + 2.0 * math.hypot(n.remote.sigma_z, road.sigma_elevation)
        limit += settings.max_grade * abs(n.d)
        text = f"{abs(difference):.1f} m {'above' if difference > 0.0 else 'below'} the route"
        if limit < abs(difference) <= settings.max_level_gap:
            others.append((n.id, f"{text} (limit {limit:.1f} m)"))
            continue
        if abs(difference) > settings.max_level_gap:
            faults.append(f"{n.id} is {text}; heights beyond {settings.max_level_gap:g} m are not used")
        kept.append(n)
    on_level = {n.id for n in kept}  # on another branch of the route
    return kept, tuple(item for item in others if item[0] not in on_level), tuple(faults)


def _height_above(vehicle: FrenetVehicle, road: Road) -> float:
    """Height above or below (negative) the part of the route at a body [m]; 0 if it is unknown."""
    z = vehicle.remote.z
    if z is None or not (math.isfinite(z) and vehicle.remote.sigma_z >= 0.0):
        return 0.0
    low, high = road.height_range(vehicle.rear, vehicle.front)
    return z - min(max(z, low), high) if low <= high else 0.0


def usable_range(
    awareness_range: object, radio: RadioHealth | None, remotes: object
) -> tuple[float, tuple[str, ...]]:
    """Return the awareness range of a cycle [m], and why it is 0 if it should not be."""
    faults, value = [], 0.0
    try:
        value = float(awareness_range)  # type: ignore[arg-type]
    except Exception:  # a number type of the caller's
        value = math.nan
    if isinstance(awareness_range, str) or not value >= 0.0:
        faults.append(f"awareness_range must be at least 0 m, was {_shown(awareness_range)}; counted as 0 m")
    if not is_list(remotes):
        faults.append(
            f"remotes must be an iterable of vehicles, was {type(remotes).__name__}; awareness range 0 m"
        )
    try:
        if radio is not None:
            trusted: object = radio.trusted
            if not isinstance(trusted, bool | np.bool_):
                faults.append(f"trusted must be True or False, was {_shown(trusted)}; awareness range 0 m")
            elif not trusted:
                faults.append(f"other vehicles may be unknown: {radio.reason}; awareness range 0 m")
    except Exception as error:  # an object of the caller's
        faults.append(f"radio cannot be used ({type(error).__name__}); awareness range 0 m")
    return 0.0 if faults else value, tuple(faults)


def is_list(remotes: object) -> bool:
    """Return whether an argument can be a list of vehicles."""
    if type(remotes) in (list, tuple):
        return True
    return isinstance(remotes, Iterable | RemoteVehicle) and not isinstance(remotes, str | bytes | Mapping)

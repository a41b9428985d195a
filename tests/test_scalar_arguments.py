"""Public functions take any value for a number: they return, or raise an error of the library."""

import dataclasses
import importlib
import inspect
import math
import pkgutil
import typing
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import cca_core
from cca_core import LocalFrame, Path, PreviewController, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.errors import CcaError
from cca_core.follow import PoseEstimator, SpeedSettings
from cca_core.v2x import Fix, Tracker

CAR = VehicleParams.bmw_320i()
PATH = Path([0.0, 10.0], [[[0.0, 0.0, 10.0, 0.0], [0.0, 0.0, 0.0, 0.0]]])
STATE = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0)
REMOTE = RemoteVehicle(id="a", x=5.0, y=0.0, psi=0.0, v_x=5.0, length=4.0, width=2.0)
INSTANCES = [
    PATH, Road(PATH), CAR, LocalFrame(45.0, 14.0), STATE, REMOTE, PreviewController(CAR),
    PoseEstimator(STATE),    Tracker(LocalFrame(45.0, 14.0)), Fix(0.0, 0.0, 0.0, 0.0, 1.0), SpeedSettings(),
]  # fmt: skip
NODES = np.column_stack((np.arange(8.0), np.zeros(8)))
GIVEN: dict[str, Any] = {
    "xy": NODES, "nodes": NODES, "road": Road(PATH), "lat": 45.0, "lon": 14.0, "breaks": [0.0, 10.0],
    "coefficients": PATH.coefficients, "profile": (np.array([0.0, 9.0]), np.array([4.0, 0.0])),
    "distances": np.array([1.0]), "remotes": [REMOTE], "id": "a", "times": [0.0, 1.0], "stations": [0.0, 9.0],
    "u": np.zeros(8), "name": "a", "obstacle": [3.0, 1.0], "side": "left", "vehicle_id": "a", "lead_id": "a",
}  # fmt: skip
SLOW = {"MpcPlanner", "paper_scenarios"}  # they compile programs, or cover others of this list
VALUES = [
    10**400, -(10**400), math.nan, math.inf, -math.inf, 1e300, -1e300, "a", "1", None, 1j, [1.0], b"x",
    object(),
]  # fmt: skip


def is_number(hint: object) -> bool:
    """Return whether a parameter takes a number, alone or in an array."""
    if typing.get_origin(hint) in (dict, tuple, Callable):
        return False
    parts = typing.get_args(hint)
    return hint in (float, int) or float in parts or int in parts or "_NestedSequence" in str(hint)


def usual(parameter: inspect.Parameter, hint: Any) -> Any:
    """Return a usual value of a parameter; KeyError if there is none."""
    if parameter.default is not inspect.Parameter.empty:
        return parameter.default
    if parameter.name in GIVEN:
        return GIVEN[parameter.name]
    found = [value for value in INSTANCES if hint is type(value)]
    if found:
        return found[0]
    if is_number(hint):
        return 3 if hint is int else 1.0
    if dataclasses.is_dataclass(hint):
        return hint()  # type: ignore[operator]  # settings
    raise KeyError(parameter.name)


def public_callables() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Find the functions, classes and methods that take a number; methods of an instance are bound."""
    done = set()
    for package in ["", *(f".{m.name}" for m in pkgutil.iter_modules(cca_core.__path__) if m.name[0] != "_")]:
        module = importlib.import_module(f"cca_core{package}")
        for name in getattr(module, "__all__", None) or [key for key in vars(module) if key[0] != "_"]:
            item = getattr(module, name)
            own = getattr(item, "__module__", "").startswith("cca_core")
            if name in done | SLOW or not own or not callable(item) or hasattr(item, "__members__"):
                continue
            done.add(name)
            yield f"{module.__name__}.{name}", item
            for instance in INSTANCES:
                if type(instance) is item:
                    for key, value in vars(item).items():
                        if inspect.isfunction(value) and key[0] != "_":
                            yield f"{module.__name__}.{name}.{key}", getattr(instance, key)


def arguments(function: Callable[..., Any]) -> tuple[dict[str, Any], list[str]]:
    """Return usual arguments and the names of the numbers among them."""
    hints = typing.get_type_hints(function.__init__ if inspect.isclass(function) else function)  # type: ignore[misc]
    parameters = [
        p
        for p in inspect.signature(function).parameters.values()
        if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    ]
    numbers = [p.name for p in parameters if is_number(hints.get(p.name))]
    return {p.name: usual(p, hints.get(p.name)) for p in parameters} if numbers else {}, numbers


def wrong_errors(function: Callable[..., Any]) -> list[str]:
    """Call a function with odd numbers; return the errors that are none of the library."""
    try:
        given, numbers = arguments(function)
    except (KeyError, TypeError, ValueError, NameError):
        return []  # no usual arguments
    found = []
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        for name in numbers:
            for value in VALUES:
                try:
                    function(**{**given, name: value})
                except CcaError:
                    pass
                except Exception as error:
                    found.append(f"{name}={str(value)[:9]}: {type(error).__name__}: {error}"[:120])
    return found


CALLABLES = dict(public_callables())


@pytest.mark.parametrize("name", CALLABLES)
def test_odd_number_gives_value_or_input_error(name: str) -> None:
    assert wrong_errors(CALLABLES[name]) == []


def test_sweep_reaches_public_formulas() -> None:
    """The sweep reaches what it is meant for."""
    reached = []
    for name, function in CALLABLES.items():
        try:
            if arguments(function)[1]:
                reached.append(name)
        except (KeyError, TypeError, ValueError, NameError):
            continue
    assert len(reached) >= 100
    for name in ("follow.friction_limited", "follow.stop_acceleration", "follow.profile_acceleration",
                 "geometry.wrap_angle", "v2x.position_bounds", "predict.predict_distance",
                 "predict.reachable_interval", "Path.foot_point"):  # fmt: skip
        assert f"cca_core.{name}" in reached

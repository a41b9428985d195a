"""Errors and the checks at the library's boundary."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import Road, VehicleParams, fit_path
from cca_core._checks import check_array, check_points, check_real
from cca_core.baselines import Problem
from cca_core.errors import CcaError, InfeasibleError, InputError, MissingExtraError, Status
from cca_core.path import read_waypoints
from cca_core.report import animate
from cca_core.sim import RoadUser, eebl, overtaking, simulate
from cca_core.v2x import PlausibilitySettings


@pytest.mark.parametrize(
    ("error", "builtin"),
    [(InputError, ValueError), (MissingExtraError, ImportError), (InfeasibleError, RuntimeError)],
)
def test_error_is_cca_error_and_builtin(error: type, builtin: type) -> None:
    assert issubclass(error, CcaError)
    assert issubclass(error, builtin)


def test_infeasible_error_has_partial_result() -> None:
    partial = object()
    error = InfeasibleError("no solution", partial)
    assert error.result is partial
    assert str(error) == "no solution"
    assert InfeasibleError("no solution").result is None


def test_statuses_are_distinct_sentences() -> None:
    values = [status.value for status in Status]
    assert len(values) == len(set(values)) == 5
    assert all(isinstance(value, str) and len(value.split()) >= 4 for value in values)


ROAD = Road(fit_path([[0.0, 0.0], [400.0, 0.0], [900.0, 0.0]]))
SCENARIO = eebl()
FLAGS: dict[str, Callable[[Any], object]] = {
    "closed": lambda flag: fit_path([[0.0, 0.0], [50.0, 0.0], [50.0, 50.0]], closed=flag),
    "skip_invalid": lambda flag: read_waypoints("missing.csv", skip_invalid=flag),
    "connected": lambda flag: RoadUser(id="a", s=0.0, d=0.0, v_x=1.0, connected=flag),
    "shared_modem": lambda flag: replace(SCENARIO, shared_modem=flag),
    "real_time": lambda flag: simulate(SCENARIO, real_time=flag),
    "v2v": lambda flag: overtaking("2", ROAD.path, v2v=flag),
    "frozen": lambda flag: PlausibilitySettings(frozen=flag),
    "standalone": lambda flag: animate([], standalone=flag),
    "solvable": lambda flag: Problem(
        name="a",
        road=ROAD,
        vehicle=VehicleParams.bmw_320i(),
        start=0.0,
        goal=100.0,
        v_x=10.0,
        others=(),
        solvable=flag,
    ),
}


@pytest.mark.parametrize("value", ["no", "True", 1, 0, None, 1.0, []], ids=str)
@pytest.mark.parametrize("name", FLAGS)
def test_flag_that_is_no_bool_raises(name: str, value: Any) -> None:
    """A text such as "no" is truthy; it does not count as True."""
    with pytest.raises(InputError, match=f"^{name} must be True or False, was "):
        FLAGS[name](value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, None, "fast", [1.0, 2.0], 1j, {}])
def test_check_real_error_names_argument(value: object) -> None:
    with pytest.raises(InputError, match=r"^speed must be"):
        check_real("speed", value)


@pytest.mark.parametrize(
    ("value", "bounds", "words"),
    [
        (0.0, {"gt": 0.0}, "speed must be greater than 0, was 0"),
        (-1.0, {"ge": 0.0}, "speed must be at least 0, was -1"),
        (91.0, {"le": 90.0}, "speed must be at most 90, was 91"),
        (-np.inf, {"allow_inf": True, "gt": 0.0}, "speed must be greater than 0, was -inf"),
    ],
)
def test_check_real_message_has_bound_and_value(value: float, bounds: dict, words: str) -> None:
    with pytest.raises(InputError) as caught:
        check_real("speed", value, **bounds)
    assert str(caught.value) == words


@pytest.mark.parametrize(
    ("value", "bounds"),
    [
        (0, {"ge": 0.0}),
        (90, {"le": 90.0}),
        (np.float32(3.5), {}),
        (np.array(2.0), {}),
        (np.inf, {"allow_inf": True}),
    ],
)
def test_check_real_accepts_bounds(value: float, bounds: dict) -> None:
    number = check_real("speed", value, **bounds)
    assert type(number) is float
    assert number == float(value)


def test_check_real_rejects_nan_if_infinity_allowed() -> None:
    with pytest.raises(InputError, match="finite"):
        check_real("limit", np.nan, allow_inf=True)


def test_check_array_returns_copy() -> None:
    mine = np.zeros((3, 2))
    theirs = check_array("xy", mine, (None, 2))
    theirs[0, 0] = 1.0
    assert mine[0, 0] == 0.0


@pytest.mark.parametrize("value", [np.zeros(3), np.zeros((3, 3)), np.zeros((1, 3, 2)), 5.0, [], [[]]])
def test_check_array_rejects_wrong_shape(value: object) -> None:
    with pytest.raises(InputError, match=r"^xy must have shape \(n, 2\)"):
        check_array("xy", value, (None, 2))


@pytest.mark.parametrize("value", [[["a", "b"]], [[1.0, 2.0], [3.0]], [[None, 1.0]], "abc", [[1j, 2.0]]])
def test_check_array_rejects_invalid_numbers(value: object) -> None:
    with pytest.raises(InputError, match=r"^xy must be"):
        check_array("xy", value, (None, 2))


def test_check_array_error_names_index() -> None:
    values = np.zeros((4, 2))
    values[2, 1] = np.nan
    with pytest.raises(InputError, match=r"^xy must be finite, was nan at \[2, 1\]"):
        check_array("xy", values, (None, 2))


def test_check_points_rejects_too_few() -> None:
    with pytest.raises(InputError, match=r"^xy must have at least 2 points, had 1"):
        check_points("xy", [[0.0, 0.0]], 2)
    assert check_points("xy", [[0, 0], [1, 1]], 2).dtype == np.float64

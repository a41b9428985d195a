"""What Python, notebooks and other processes expect of the library's objects."""

import ast
import copy
import dataclasses
import pickle
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any

import pytest

import cca_core
from cca_core import InfeasibleError, Lane, Planner, PreviewController, VehicleState
from cca_core.sim.study.pool import local_processes
from tests.support.recorded_data import CAR, OTHERS, ROAD, ROUTE, driven, examples, parts

EXAMPLES = examples()
COPIES: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}
SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize("name", sorted(EXAMPLES))
@pytest.mark.parametrize("how", COPIES)
def test_copies_are_equal(name: str, how: str) -> None:
    value = EXAMPLES[name]
    again = COPIES[how](value)
    assert type(again) is type(value)
    assert parts(again) == parts(value)


@pytest.mark.parametrize("how", COPIES)
def test_copied_path_is_read_only_and_equal(how: str) -> None:
    ROUTE.project((30.0, 2.0))
    again = COPIES[how](ROUTE)
    assert not again.coefficients.flags.writeable
    assert not again.breaks.flags.writeable
    assert again.foot_point(30.2, 1.0, 29.0) == ROUTE.foot_point(30.2, 1.0, 29.0)
    assert len(pickle.dumps(ROUTE)) < 1000 + ROUTE.breaks.nbytes + ROUTE.coefficients.nbytes


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_equal_records_have_equal_hash(name: str) -> None:
    value = EXAMPLES[name]
    again = pickle.loads(pickle.dumps(value))
    assert (hash(value) == hash(again)) == (value == again)


def test_settings_and_decisions_can_be_keys() -> None:
    assert {Lane(d=0.0): 1}[Lane(d=0.0)] == 1
    decision = EXAMPLES["Decision"]
    assert {decision: 1}[dataclasses.replace(decision)] == 1


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_repr_names_the_class(name: str) -> None:
    assert repr(EXAMPLES[name]).startswith(f"{name}(")


@pytest.mark.parametrize("name", ["Band", "CleanedRoute", "LocalFrame", "Path", "Road"])
def test_repr_is_one_readable_line(name: str) -> None:
    text = repr(EXAMPLES[name])
    assert len(text) < 120
    assert "\n" not in text
    assert "array" not in text
    assert any(character.isdigit() for character in text)


def test_errors_can_be_pickled() -> None:
    error = pickle.loads(pickle.dumps(InfeasibleError("no solution", (1.0, 2.0))))
    assert str(error) == "no solution"
    assert error.result == (1.0, 2.0)


@pytest.mark.parametrize("how", ["pickle", "deepcopy"])
@pytest.mark.parametrize("steps", [0, 60, 160])
def test_copied_planner_is_bitwise_identical(how: str, steps: int) -> None:
    planner = Planner(CAR, ROAD, cruise_speed=20.0)
    before = driven(planner, range(steps))
    assert steps < 160 or before[-1].band is not None
    again = COPIES[how](planner)
    here, there = (driven(each, range(steps, 260)) for each in (planner, again))
    assert parts(there) == parts(here)
    assert any(command.band is not None for command in here)


def test_copied_controller_is_bitwise_identical() -> None:
    controller = PreviewController(CAR)
    states = [VehicleState(x=0.4 * i, y=0.5, psi=0.02, v_x=20.0) for i in range(60)]
    for state in states[:30]:
        controller.steer(state, ROUTE)
    again, route = pickle.loads(pickle.dumps((controller, ROUTE)))
    here = [controller.steer(state, ROUTE) for state in states[30:]]
    assert [again.steer(state, route) for state in states[30:]] == here


def test_planner_runs_in_other_processes() -> None:
    """Spawned ones too, which share nothing but what is pickled."""
    planner = Planner(CAR, ROAD, cruise_speed=20.0)
    state = VehicleState(x=100.0, y=0.1, psi=0.0, v_x=20.0)
    with local_processes(1) as pool:
        there = pool.submit(planner.step, 0.0, state, OTHERS).result(timeout=60.0)
    assert parts(there) == parts(planner.step(0.0, state, OTHERS))


def test_library_never_prints_or_configures_logging() -> None:
    folder = FilePath(cca_core.__file__).parent
    for file in folder.rglob("*.py"):
        if file.is_relative_to(folder / "cli"):
            continue  # a command line prints
        calls = [n for n in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(n, ast.Call)]
        assert not {"print", "logging.basicConfig"} & {ast.unparse(call.func) for call in calls}, file

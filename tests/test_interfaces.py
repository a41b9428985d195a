"""What Python, notebooks and other processes expect of the library's objects."""

import ast
import copy
import dataclasses
import math
import multiprocessing
import pickle
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest

import cca_core
from cca_core import (
    Band,
    InfeasibleError,
    InputError,
    Lane,
    Path,
    Planner,
    PreviewController,
    Road,
    VehicleState,
    fit_path,
    relax_band,
)
from cca_core.geometry import boxes
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
def test_a_copied_path_is_read_only_and_drives_the_same(how: str) -> None:
    ROUTE.project((30.0, 2.0))
    again = COPIES[how](ROUTE)
    assert not again.coefficients.flags.writeable
    assert not again.breaks.flags.writeable
    assert again.foot_point(30.2, 1.0, 29.0) == ROUTE.foot_point(30.2, 1.0, 29.0)
    assert len(pickle.dumps(ROUTE)) < 1000 + ROUTE.breaks.nbytes + ROUTE.coefficients.nbytes


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_hash_agrees_with_equality(name: str) -> None:
    value = EXAMPLES[name]
    again = pickle.loads(pickle.dumps(value))
    assert hash(value) == hash(value)
    if value == again:
        assert hash(value) == hash(again)


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
    error = pickle.loads(pickle.dumps(InfeasibleError("no room", (1.0, 2.0))))
    assert str(error) == "no room"
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


def test_a_copied_controller_goes_on_bit_for_bit() -> None:
    controller = PreviewController(CAR)
    states = [VehicleState(x=0.4 * i, y=0.5, psi=0.02, v_x=20.0) for i in range(60)]
    for state in states[:30]:
        controller.steer(state, ROUTE)
    again, route = pickle.loads(pickle.dumps((controller, ROUTE)))
    here = [controller.steer(state, ROUTE) for state in states[30:]]
    assert [again.steer(state, route) for state in states[30:]] == here


def test_other_processes_can_drive() -> None:
    """Spawned ones too, which share nothing but what is pickled."""
    planner = Planner(CAR, ROAD, cruise_speed=20.0)
    state = VehicleState(x=100.0, y=0.1, psi=0.0, v_x=20.0)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        there = pool.submit(planner.step, 0.0, state, OTHERS).result(timeout=60.0)
    assert parts(there) == parts(planner.step(0.0, state, OTHERS))


def test_nothing_prints_or_configures_logging() -> None:
    for file in FilePath(cca_core.__file__).parent.rglob("*.py"):
        calls = [n for n in ast.walk(ast.parse(file.read_text(encoding="utf-8"))) if isinstance(n, ast.Call)]
        assert not {"print", "logging.basicConfig"} & {ast.unparse(call.func) for call in calls}, file


def drawn(value: Any) -> tuple[ElementTree.Element, list[np.ndarray]]:
    """SVG of something, and the points of its paths in pixels."""
    root = ElementTree.fromstring(value.to_svg())
    found = []
    for path in root.iter(f"{SVG}path"):
        numbers = re.findall(r"-?\d+(?:\.\d+)?", path.get("d", ""))
        if "h" not in path.get("d", "") and "v" not in path.get("d", ""):
            found.append(np.array(numbers, dtype=float).reshape(-1, 2))
    return root, found


def circle(radius: float) -> Path:
    angle = np.linspace(0.0, 1.9 * math.pi, 80)
    return fit_path(radius * np.column_stack((np.cos(angle), np.sin(angle))), tolerance=0.001 * radius)


def bent(**more: Any) -> Band:
    nodes = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    return relax_band(nodes, [boxes(50.0, -0.8, 0.0, 4.5, 1.8)], side="left", vehicle=CAR, **more)


PICTURES = {
    "band": bent(),
    "band with edges": bent(corridor=(-1.75, 5.25)),
    "band without obstacles": relax_band(ROUTE.sample(5.0), vehicle=CAR),
    "path": circle(50.0),
    "short path": Path([0.0, 1e-3], [[[0.0, 0.0, 0.0, 3.0], [0.0, 0.0, 1e-3, -2.0]]]),
    "long path": circle(1e5),
    "road": ROAD,
    "road toward us": Road(circle(50.0), lanes=[Lane(d=0.0), Lane(d=3.5, direction=-1)]),
}


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_whole_and_small(name: str) -> None:
    text = PICTURES[name].to_svg()
    assert text is not None
    root, paths = drawn(PICTURES[name])
    assert len(text) < 50_000
    assert not re.search(r"href|url\(|script|nan|inf(?!\s?m)", re.sub(r"<t.*?</t\w+>", "", text))
    width, height = float(root.get("width", "")), float(root.get("height", ""))
    assert root.get("viewBox") == f"0 0 {width:g} {height:g}"
    assert width == 640.0
    assert 60.0 < height <= 450.0
    points = np.concatenate(paths)
    assert points.min() >= 0.0
    assert points[:, 0].max() <= width
    assert points[:, 1].max() <= height
    assert root.find(f"{SVG}title").text == repr(PICTURES[name])  # type: ignore[union-attr]


def test_a_picture_is_to_scale() -> None:
    """A circle stays round, and the scale bar says how large it is."""
    root, (line, _arrow) = drawn(circle(50.0))
    size = np.ptp(line, axis=0)
    assert size[0] == pytest.approx(size[1], abs=0.3)
    bar = re.search(r"M16 \d+v4H([\d.]+)", ElementTree.tostring(root, encoding="unicode"))
    length = next(text.text for text in root.iter(f"{SVG}text") if text.text and text.text.endswith(" m"))
    assert bar is not None
    assert size[0] / (float(bar[1]) - 16.0) * float(length.removesuffix(" m")) == pytest.approx(
        100.0, rel=0.01
    )


def test_left_is_up_when_driving_to_the_right() -> None:
    _, paths = drawn(bent())
    route, obstacle, band = paths[0], paths[1], paths[2]
    assert np.ptp(route[:, 1]) == 0.0
    assert band[:, 1].min() < route[0, 1] - 5.0
    assert band[:, 1].max() == pytest.approx(route[0, 1], abs=0.1)
    assert obstacle[:, 1].mean() > route[0, 1]
    assert route[-1, 0] > route[0, 0]


def test_a_band_that_must_not_be_driven_looks_so() -> None:
    failed, driven = bent(curvature_limit=1e-4), bent()
    assert not failed.ok
    text = failed.to_svg()
    assert f"<title>INFEASIBLE: {failed.message}</title>" in text
    assert "#0072B2" in driven.to_svg()
    assert "#0072B2" not in text


def test_edges_are_drawn_where_they_are() -> None:
    _, paths = drawn(bent(corridor=(-1.75, 5.25)))
    route, right, left = paths[:3]
    scale = (route[-1, 0] - route[0, 0]) / 100.0
    assert (route[0, 1] - left[0, 1]) / scale == pytest.approx(5.25, abs=0.05)
    assert (right[0, 1] - route[0, 1]) / scale == pytest.approx(1.75, abs=0.05)


def test_many_bands_have_no_picture() -> None:
    many = relax_band(np.stack([ROUTE.sample(5.0)] * 2), vehicle=CAR)
    assert many._repr_svg_() is None
    with pytest.raises(InputError, match="many bands"):
        many.to_svg()
    assert many[0].to_svg() == many[0]._repr_svg_()

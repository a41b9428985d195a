import math
import re
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from cca_core import Band, InputError, Lane, Path, Road, fit_path, relax_band
from cca_core.geometry import boxes
from cca_core.plot import to_svg
from tests.support.recorded_data import CAR, ROAD, ROUTE

SVG = "{http://www.w3.org/2000/svg}"


def svg_paths(value: Any) -> tuple[ElementTree.Element, list[np.ndarray]]:
    """SVG of an object, and the points of its paths in pixels."""
    root = ElementTree.fromstring(to_svg(value))
    found = []
    for path in root.iter(f"{SVG}path"):
        numbers = re.findall(r"-?\d+(?:\.\d+)?", path.get("d", ""))
        if "h" not in path.get("d", "") and "v" not in path.get("d", ""):
            found.append(np.array(numbers, dtype=float).reshape(-1, 2))
    return root, found


def circle(radius: float) -> Path:
    angle = np.linspace(0.0, 1.9 * math.pi, 80)
    return fit_path(radius * np.column_stack((np.cos(angle), np.sin(angle))), tolerance=0.001 * radius)


def evading_band(**more: Any) -> Band:
    nodes = np.column_stack((np.arange(0.0, 101.0), np.zeros(101)))
    return relax_band(nodes, [boxes(50.0, -0.8, 0.0, 4.5, 1.8)], side="left", vehicle=CAR, **more)


PICTURES = {
    "band": evading_band(),
    "band with edges": evading_band(corridor=(-1.75, 5.25)),
    "band without obstacles": relax_band(ROUTE.sample(5.0), vehicle=CAR),
    "path": circle(50.0),
    "short path": Path([0.0, 1e-3], [[[0.0, 0.0, 0.0, 3.0], [0.0, 0.0, 1e-3, -2.0]]]),
    "long path": circle(1e5),
    "road": ROAD,
    "road with an opposing lane": Road(circle(50.0), lanes=[Lane(d=0.0), Lane(d=3.5, direction=-1)]),
}


@pytest.mark.parametrize("name", PICTURES)
def test_picture_is_complete_and_small(name: str) -> None:
    text = to_svg(PICTURES[name])
    assert text is not None
    root, paths = svg_paths(PICTURES[name])
    assert len(text) < 50_000
    assert not re.search(r"href|url\(|script|nan|inf(?!\s?m)", re.sub(r"<t.*?</t\w+>", "", text))
    width, height = float(root.get("width", "")), float(root.get("height", ""))
    assert root.get("viewBox") == f"0 0 {width:g} {height:g}"
    assert width == 520.0
    captions = [text.text or "" for text in root.iter(f"{SVG}text")]
    assert max(map(len, captions)) < 80  # which fit
    assert 60.0 < height <= 450.0
    points = np.concatenate(paths)
    assert points.min() >= 0.0
    assert points[:, 0].max() <= width
    assert points[:, 1].max() <= height
    assert root.find(f"{SVG}title").text == repr(PICTURES[name])  # type: ignore[union-attr]


def test_picture_is_to_scale() -> None:
    """A circle stays round, and the scale bar gives its size."""
    root, (line, _arrow) = svg_paths(circle(50.0))
    size = np.ptp(line, axis=0)
    assert size[0] == pytest.approx(size[1], abs=0.3)
    bar = re.search(r"M16 \d+v4H([\d.]+)", ElementTree.tostring(root, encoding="unicode"))
    length = next(text.text for text in root.iter(f"{SVG}text") if text.text and text.text.endswith(" m"))
    assert bar is not None
    assert size[0] / (float(bar[1]) - 16.0) * float(length.removesuffix(" m")) == pytest.approx(
        100.0, rel=0.01
    )


def test_left_is_up_when_driving_to_the_right() -> None:
    _, paths = svg_paths(evading_band())
    route, obstacle, band = paths[0], paths[1], paths[2]
    assert np.ptp(route[:, 1]) == 0.0
    assert band[:, 1].min() < route[0, 1] - 5.0
    assert band[:, 1].max() == pytest.approx(route[0, 1], abs=0.1)
    assert obstacle[:, 1].mean() > route[0, 1]
    assert route[-1, 0] > route[0, 0]


def test_infeasible_band_has_another_color() -> None:
    failed, driven = evading_band(curvature_limit=1e-4), evading_band()
    assert not failed.ok
    text = to_svg(failed)
    assert f"<title>INFEASIBLE: {failed.message}</title>" in text
    assert "#0072B2" in to_svg(driven)
    assert "#0072B2" not in text


def test_edges_are_at_their_lateral_offsets() -> None:
    _, paths = svg_paths(evading_band(corridor=(-1.75, 5.25)))
    route, right, left = paths[:3]
    scale = (route[-1, 0] - route[0, 0]) / 100.0
    assert (route[0, 1] - left[0, 1]) / scale == pytest.approx(5.25, abs=0.05)
    assert (right[0, 1] - route[0, 1]) / scale == pytest.approx(1.75, abs=0.05)


def test_batch_of_bands_has_no_picture() -> None:
    many = relax_band(np.stack([ROUTE.sample(5.0)] * 2), vehicle=CAR)
    assert many._repr_svg_() is None
    with pytest.raises(InputError, match="single band"):
        to_svg(many)


@pytest.mark.parametrize("name", ["band", "path", "road"])
def test_jupyter_shows_the_picture(name: str) -> None:
    assert PICTURES[name]._repr_svg_() == to_svg(PICTURES[name])


def test_unknown_object_raises() -> None:
    with pytest.raises(InputError, match="item must be a Band, Path or Road, was int"):
        to_svg(1)

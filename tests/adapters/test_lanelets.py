"""Lanelets of CommonRoad as roads."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cca_core import InputError
from cca_core.adapters import join_lanelets
from cca_core.sim import CommonRoadScenario, read_commonroad
from tests.support.commonroad_files import ROAD, document, lanelet, written

SIGN = (
    '<trafficSign id="70"><trafficSignElement><trafficSignID>274</trafficSignID>'
    "<additionalValue>13.9</additionalValue></trafficSignElement></trafficSign>"
)


def scenario(tmp_path: Path, *inner: str, version: str = "2020a") -> CommonRoadScenario:
    return read_commonroad(written(tmp_path, document(*inner, version=version)))


def test_lanelets_are_a_road_with_lanes_of_both_directions(tmp_path: Path) -> None:
    road = join_lanelets(scenario(tmp_path, ROAD), [1, 2])
    assert road.path.length == pytest.approx(200.0, abs=1e-6)
    assert [(lane.direction, round(lane.d, 3), round(lane.width, 3)) for lane in road.lanes] == [
        (-1, -3.5, 3.5), (1, 0.0, 3.5), (1, 3.5, 3.5),
    ]  # fmt: skip
    assert not any(lane.boundaries for lane in road.lanes)
    assert (road.speed_limit, road.speed_limits) == (36.0, None)


def test_lane_that_begins_behind_the_first_lanelet(tmp_path: Path) -> None:
    parts = (
        lanelet(1, (0.0, 100.0), 0.0, '<successor ref="2"/>'),
        lanelet(2, (100.0, 200.0), 0.0, '<predecessor ref="1"/><adjacentLeft ref="4" drivingDir="same"/>'),
        lanelet(4, (100.0, 200.0), 3.5, '<adjacentRight ref="2" drivingDir="same"/>'),
    )
    road = join_lanelets(scenario(tmp_path, *parts), [1, 2])
    assert road.lane_at(3.5, 50.0) is None
    assert road.lane_at(3.5, 150.0) is not None


@pytest.mark.parametrize("version", ["2020a", "2018b"])
def test_speed_limits_of_signs(tmp_path: Path, version: str) -> None:
    limit = '<trafficSignRef ref="70"/>' if version == "2020a" else "<speedLimit>13.9</speedLimit>"
    parts = (
        lanelet(1, (0.0, 100.0), 0.0, '<successor ref="2"/>'),
        lanelet(2, (100.0, 200.0), 0.0, f'<predecessor ref="1"/>{limit}'),
        SIGN if version == "2020a" else "",
    )
    road = join_lanelets(scenario(tmp_path, *parts, version=version), [1, 2], speed_limit=20.0)
    assert road.speed_limits is not None
    assert road.speed_limits == pytest.approx(np.array([(0.0, 20.0), (100.0, 13.9)]), abs=1e-6)


def arc_lanelet() -> str:
    """A left turn of 50 m radius over 90 degrees, 4 m wide, a point every degree."""
    angles = [math.radians(k) for k in range(91)]
    sides = []
    for tag, r in (("leftBound", 48.0), ("rightBound", 52.0)):
        rows = ((r * math.sin(a), 50.0 - r * math.cos(a)) for a in angles)
        sides.append(
            f"<{tag}>" + "".join(f"<point><x>{x}</x><y>{y}</y></point>" for x, y in rows) + f"</{tag}>"
        )
    return f'<lanelet id="1">{"".join(sides)}</lanelet>'


def test_curve_keeps_length_curvature_and_width(tmp_path: Path) -> None:
    road = join_lanelets(scenario(tmp_path, arc_lanelet()), [1])
    s = np.linspace(10.0, 68.0, 30)
    assert road.path.length == pytest.approx(25.0 * math.pi, abs=0.1)
    assert road.path.curvature(s) == pytest.approx(0.02, abs=1e-3)
    x, y = road.path.position(s).T
    assert np.hypot(x, y - 50.0) == pytest.approx(50.0, abs=0.1)
    for station in s.tolist():
        assert road.ego_lane.bounds_at(station) == pytest.approx((-2.0, 2.0), abs=0.15)


@pytest.mark.parametrize(
    ("ids", "words"),
    [
        ([], "^lanelet_ids must be a sequence of ids"),
        ("1", "^lanelet_ids must be a sequence of ids"),
        ([1, 9], "^lanelet_ids must be lanelets of the scenario, one was 9"),
        ([2, 1], "^lanelet 1 must be a successor of lanelet 2"),
        ([1, 4], "^lanelet 4 must be a successor of lanelet 1"),
    ],
)
def test_invalid_lanelets_raise(tmp_path: Path, ids: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        join_lanelets(scenario(tmp_path, ROAD), ids)

"""Nets of SUMO from files: lanes through junctions as roads."""

import math
from pathlib import Path

import pytest

from cca_core import InputError, Lane, Road
from cca_core.adapters import read_sumo_net
from tests.support.sumo_files import write_net


def bounds(road: Road, d: float, s: float) -> tuple[int, float, float]:
    """Direction and boundaries of the lane at a position."""
    lane = road.lane_at(d, s)
    assert isinstance(lane, Lane)
    at = lane.bounds_at(s)
    assert at is not None
    return lane.direction, *at


def test_road_goes_straight_over_a_junction(tmp_path: Path) -> None:
    road = read_sumo_net(write_net(tmp_path)).road_along(["in", "on"])
    assert road.path.length == pytest.approx(400.0, abs=1e-6)
    assert road.path.position(210.0) == pytest.approx((210.0, -5.25), abs=1e-6)
    assert [(lane.direction, round(lane.d, 2), round(lane.width, 2)) for lane in road.lanes] == [
        (1, 0.0, 3.5), (1, 3.5, 3.5), (-1, 7.0, 3.5),
    ]  # fmt: skip
    assert not any(lane.boundaries for lane in road.lanes)
    assert [road.highest_limit(s, s) for s in (199.0, 221.0)] == [20.0, 25.0]


def test_lane_that_leads_along_all_edges_is_taken(tmp_path: Path) -> None:
    road = read_sumo_net(write_net(tmp_path)).road_along(["in", "on", "end"])
    assert road.path.position(0.0) == pytest.approx((0.0, -1.75), abs=1e-6)
    assert road.path.length == pytest.approx(600.0, abs=1e-6)
    assert bounds(road, -3.5, 390.0) == pytest.approx((1, -5.25, -1.75))
    assert road.lane_at(-3.5, 420.0) is None  # the right lane ends at the junction
    assert bounds(road, 3.5, 210.0) == pytest.approx((-1, 1.75, 5.25))
    assert road.lane_at(3.5, 450.0) is None
    assert road.highest_limit(500.0, 500.0) == 14.0


def test_road_turns_within_a_junction(tmp_path: Path) -> None:
    road = read_sumo_net(write_net(tmp_path)).road_along(["in", "up"])
    assert road.path.length == pytest.approx(200.0 + 0.5 * math.pi * 21.75 + 180.0, abs=0.5)
    assert 15.0 < road.path.min_radius < 25.0
    assert road.path.position(road.path.end) == pytest.approx((221.75, 200.0), abs=0.06)
    assert bounds(road, -3.5, 100.0)[1:] == pytest.approx((-5.25, -1.75), abs=0.1)
    assert road.lane_at(-3.5, 215.0) is None
    assert bounds(road, 0.0, 300.0)[1:] == pytest.approx((-1.6, 1.6), abs=0.1)


def test_lane_of_other_vehicles_is_no_lane(tmp_path: Path) -> None:
    net = read_sumo_net(write_net(tmp_path))
    assert net.road_along(["in"], 0).lane_at(-2.75, 100.0) is None
    assert net.road_along(["in"], 0, vehicle_class="bicycle").lane_at(-2.75, 100.0) is not None


@pytest.mark.parametrize(
    ("edges", "lane", "words"),
    [
        (["in", "end"], None, "^edge_ids must follow each other, 'in' leads to 'on', 'up', not 'end'"),
        (["in", "up"], 0, r"behind 'in'; lanes that lead along: 1$"),
        (["in", "up"], 0, "^edge_ids must be reachable without a lane change, was not behind 'in'"),
        (["in", "on", "end"], 0, "^edge_ids must be reachable without a lane change, was not behind 'on'"),
        (["no"], None, "^edge_ids must be edges of the net, one was 'no'"),
        ("in", None, "^edge_ids must be a sequence of ids"),
        ([], None, "^edge_ids must be a sequence of ids"),
        (["in"], 3, "^lane must be at most 2, was 3"),
        (["in"], 2, "^vehicle_class must be allowed on lane 'in_2', was 'passenger'"),
    ],
)
def test_invalid_route_raises(tmp_path: Path, edges: list[str], lane: int | None, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_sumo_net(write_net(tmp_path)).road_along(edges, lane)


def one_lane(fields: str) -> str:
    return f'<net><edge id="a"><lane id="a_0" index="0" {fields}/></edge></net>'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<OpenDRIVE/>", "^root element must be net, was 'OpenDRIVE'"),
        ("<net/>", "^net must hold an edge with a lane"),
        (one_lane('speed="9"'), "^shape of lane 'a_0' must have two"),
        (one_lane('shape="0,0 1,0"'), "^speed of lane 'a_0' must be given"),
        (one_lane('speed="x" shape="0,0 1,0"'), "^speed of lane"),
        (one_lane('speed="9" shape="0,0 z,0"'), "^shape of lane"),
    ],
)
def test_broken_net_raises(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "broken.net.xml"
    file.write_text(text)
    with pytest.raises(InputError, match=words):
        read_sumo_net(file)

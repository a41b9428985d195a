"""Roads that vary along the route: speed limits, lanes, and several roads end to end."""

import math
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Lane, Path, Road
from cca_core.path import join_roads
from cca_core.serial import from_dict, to_dict


def line(length: float, x: float = 0.0, start: float = 0.0) -> Path:
    return Path([start, start + length], [[[0.0, 0.0, length, x], [0.0, 0.0, 0.0, 0.0]]])


LINE = line(500.0)
ENDING = [(0.0, 1.75, 5.25), (200.0, 1.75, 5.25), (260.0, 1.75, 1.75)]
LIMITS = [(0.0, 30.0), (100.0, 20.0), (200.0, 25.0)]


def test_speed_limits_hold_from_their_station() -> None:
    road = Road(LINE, speed_limits=LIMITS)
    assert road.speed_limit == 30.0
    assert [road.highest_limit(s, s) for s in (-5.0, 0.0, 99.9, 100.0, 199.0, 200.0, 900.0)] == [
        30.0, 30.0, 30.0, 20.0, 20.0, 25.0, 25.0,
    ]  # fmt: skip
    assert road.highest_limit(120.0, 150.0) == 20.0
    assert road.highest_limit(120.0, 200.0) == 25.0
    assert road.highest_limit(50.0, 300.0) == 30.0


def test_constant_limit_holds_everywhere() -> None:
    road = Road(LINE, speed_limit=13.0)
    assert road.speed_limits is None
    assert road.highest_limit(-1e3, 1e3) == 13.0


@pytest.mark.parametrize(
    "limits", [[], [(0.0, 10.0), (0.0, 12.0)], [(0.0, -1.0)], [(0.0, math.nan)], [1.0, 2.0], "30"]
)
def test_invalid_speed_limits_raise(limits: Any) -> None:
    with pytest.raises(InputError, match=r"^speed_limits must"):
        Road(LINE, speed_limits=limits)


def test_lane_that_ends_has_bounds_where_it_is() -> None:
    lane = Lane.from_boundaries(ENDING)
    assert (lane.d, lane.width, lane.start, lane.end) == (3.5, 3.5, 0.0, 260.0)
    assert lane.bounds_at(100.0) == (1.75, 5.25)
    assert lane.bounds_at(230.0) == pytest.approx((1.75, 3.5))
    assert lane.bounds_at(261.0) is None
    assert lane.inner_bounds(50.0, 150.0) == (1.75, 5.25)
    assert lane.inner_bounds(150.0, 230.0) == pytest.approx((1.75, 3.5))
    assert lane.inner_bounds(150.0, 300.0) is None
    assert lane.outer_bounds == (1.75, 5.25)


def test_constant_lane_is_as_long_as_the_road() -> None:
    lane = Lane(d=3.5)
    assert (lane.start, lane.end) == (-math.inf, math.inf)
    assert lane.inner_bounds(-1e6, 1e6) == lane.bounds_at(3.0) == lane.outer_bounds == (1.75, 5.25)


@pytest.mark.parametrize(
    "rows",
    [
        [(0.0, 1.0, 2.0)],
        [(0.0, 1.0, 2.0), (0.0, 1.0, 2.0)],
        [(0.0, 2.0, 1.0), (9.0, 1.0, 2.0)],
        [(0.0, 1.0, 1.0), (9.0, 1.0, 1.0)],
        [(0.0, 1.0), (9.0, 2.0)],
        [(0.0, 1.0, math.inf), (9.0, 1.0, 2.0)],
        [],
        7,
    ],
)
def test_invalid_boundaries_raise(rows: Any) -> None:
    with pytest.raises(InputError, match="boundaries"):
        Lane.from_boundaries(rows)


def test_lanes_and_edges_vary_along_the_road() -> None:
    ending = Lane.from_boundaries(ENDING)
    narrowing = Lane.from_boundaries([(0.0, -2.0, 1.75), (500.0, -1.5, 1.75)])
    road = Road(LINE, [narrowing, ending])
    assert road.ego_lane is narrowing
    assert road.lane_at(3.0, 100.0) is ending
    assert road.lane_at(3.0, 400.0) is None
    assert road.lane_at(3.0) is ending
    assert road.edges_at(0.0) == (-2.0, 5.25)
    assert road.edges_at(500.0) == road.edges_at(900.0) == (-1.5, 1.75)
    assert (road.right_edge, road.left_edge) == (-2.0, 5.25)


@pytest.mark.parametrize(
    "rows", [[(0.0, -1.75, 1.75), (400.0, -1.75, 1.75)], [(0.0, -1.75, 1.75), (500.0, 0.5, 1.75)]]
)
def test_ego_lane_that_ends_on_the_road_raises(rows: Any) -> None:
    with pytest.raises(InputError, match=r"^lanes must contain the route"):
        Road(LINE, [Lane.from_boundaries(rows)])


def test_varying_road_survives_its_description() -> None:
    lanes = [Lane(d=0.0), Lane.from_boundaries(ENDING)]
    road = Road(LINE, lanes, speed_limits=LIMITS)
    again = from_dict(Road, to_dict(road))
    assert again.lanes == road.lanes
    assert np.array_equal(again.speed_limits, road.speed_limits)


def test_joined_roads_keep_geometry_limits_and_lanes() -> None:
    quarter = 50.0 * math.pi
    k = 4.0 / 3.0 * math.tan(math.pi / 8.0) * 100.0  # cubic of a quarter circle
    x, y = (500.0, 500.0 + k, 600.0, 600.0), (0.0, 0.0, 100.0 - k, 100.0)
    cubic = [[-a + 3 * b - 3 * c + d, 3 * a - 6 * b + 3 * c, 3 * b - 3 * a, a] for a, b, c, d in (x, y)]
    bend = Path([0.0, quarter], [cubic])
    first = Road(LINE, [Lane(d=0.0), Lane(d=3.5, direction=-1)], speed_limits=LIMITS, stop_lines=[480.0])
    second = Road(bend, [Lane(d=0.0, width=3.0), Lane(d=3.4, direction=-1)], speed_limit=14.0)
    road = join_roads([first, second])
    assert road.path.length == pytest.approx(500.0 + quarter)
    assert road.path.position(500.0 + 30.0) == pytest.approx(bend.position(30.0))
    assert road.path.position(40.0) == pytest.approx((40.0, 0.0))
    assert road.speed_limits is not None
    assert road.speed_limits.tolist() == [[0, 30], [100, 20], [200, 25], [500, 14]]
    assert road.stop_lines == (480.0,)
    assert len(road.lanes) == 2
    assert road.ego_lane.bounds_at(100.0) == (-1.75, 1.75)
    assert road.ego_lane.bounds_at(501.0) == pytest.approx((-1.5, 1.5))
    opposing = road.lane_at(3.5, 10.0)
    assert opposing is not None
    assert opposing.direction == -1
    assert opposing.bounds_at(550.0) == pytest.approx((1.65, 5.15))


def test_equal_roads_join_to_a_constant_road() -> None:
    lanes = [Lane(d=0.0), Lane(d=3.5)]
    road = join_roads([Road(line(100.0), lanes), Road(line(80.0, 100.0, 7.0), lanes)])
    assert road.lanes == tuple(lanes)
    assert (road.path.start, road.path.end) == (0.0, 180.0)
    assert road.speed_limits is None
    assert road.elevation is None


def test_lane_without_continuation_ends_at_the_joint() -> None:
    road = join_roads([Road(line(100.0), [Lane(d=0.0), Lane(d=3.5)]), Road(line(80.0, 100.0))])
    lane = road.lane_at(3.5)
    assert lane is not None
    assert (lane.start, lane.end) == (0.0, 100.0)
    assert road.lane_at(3.5, 150.0) is None


def test_heights_of_joined_roads_are_kept() -> None:
    hill = Road(line(80.0, 100.0), elevation=[(0.0, 0.0), (80.0, 8.0)])
    road = join_roads([Road(line(100.0)), hill])
    assert road.height_range(0.0, 100.0) == (0.0, 0.0)
    assert road.height_range(140.0, 180.0) == pytest.approx((4.0, 8.0))


def test_roads_that_do_not_meet_raise() -> None:
    with pytest.raises(InputError, match=r"^gap between roads 0 and 1 must be at most 0.02 m, was 1 m"):
        join_roads([Road(line(100.0)), Road(line(80.0, 101.0))])
    north = Path([0.0, 80.0], [[[0.0, 0.0, 0.0, 100.0], [0.0, 0.0, 80.0, 0.0]]])
    with pytest.raises(
        InputError, match=r"^turn between roads 0 and 1 must be at most 0.02 rad, was 1.57 rad"
    ):
        join_roads([Road(line(100.0)), Road(north)])
    with pytest.raises(InputError, match=r"^roads must be a sequence of Road"):
        join_roads([])

"""Planner on roads whose speed limit and lanes vary."""

import numpy as np
import pytest

from cca_core import Lane, Planner, Road
from cca_core.planner import EvasionSettings
from tests.support.planner_drives import (
    ALL_KNOWN,
    CAR,
    CYCLE,
    ClosedLoop,
    ScriptedVehicle,
    ego_state,
    straight,
)

LIMITS = ((0.0, 25.0), (400.3, 14.0), (600.7, 22.0))


def speeds_at(loop: ClosedLoop, stations: tuple[float, ...]) -> list[float]:
    return np.interp(stations, loop.x, loop.v).tolist()


def planner_on(road: Road, evasion: EvasionSettings = ALL_KNOWN, cruise: float = 25.0) -> Planner:
    return Planner(CAR, road, cruise_speed=cruise, evasion=evasion)


def ending(start: float, end: float) -> Lane:
    return Lane.from_boundaries([(start, 1.75, 5.25), (end, 1.75, 5.25)])


@pytest.mark.parametrize("cruise", [25.0, 40.0])
def test_lower_limit_is_kept_at_its_station(cruise: float) -> None:
    loop = ClosedLoop(planner_on(Road(straight(), speed_limits=LIMITS), cruise=cruise), [], 40.0, v=25.0)
    v, x = np.array(loop.v), np.array(loop.x)
    assert v[(x >= 400.3) & (x <= 600.7)].max() <= 14.0 + 1e-6
    assert v[x < 230.0].min() > 24.9
    assert v.max() <= 25.0 + 1e-6
    assert min(c.a_x for c in loop.commands) >= -2.05
    assert speeds_at(loop, (500.0, 720.0)) == pytest.approx([14.0, 22.0], abs=0.3)


@pytest.mark.parametrize("cruise", [15.0, 10.0, 4.0, 1.0])
@pytest.mark.parametrize("limited", [False, True], ids=["cruise speed", "speed limit"])
def test_ego_that_is_too_fast_at_the_start_slows_in_comfort(cruise: float, limited: bool) -> None:
    road = Road(straight(), speed_limits=[(0.0, cruise)] if limited else None)
    loop = ClosedLoop(planner_on(road, cruise=25.0 if limited else cruise), [], 15.0, v=22.0)
    assert min(c.a_x for c in loop.commands) >= -2.2
    assert loop.v[-1] == pytest.approx(cruise, abs=0.3)
    name = "speed limit" if limited else "cruise speed"
    assert loop.commands[50].decision.reason.startswith(f"slowing to {cruise:.1f} m/s: {name}")


def test_ego_slows_in_comfort_after_its_driver_was_faster() -> None:
    planner, v, x = planner_on(Road(straight()), cruise=10.0), 10.0, 0.0
    asked = []
    for k in range(800):
        command = planner.step(k * CYCLE, ego_state(x, v), [])
        by_driver = 100 <= k < 200
        v = max(v + (5.0 if by_driver else command.a_x) * CYCLE, 0.0)
        x += v * CYCLE
        if not by_driver:
            asked.append(command.a_x)
    assert min(asked) >= -2.3
    assert v == pytest.approx(10.0, abs=0.3)


def test_too_fast_ego_brakes_hard_for_the_end_of_its_route() -> None:
    road = Road(straight())
    end = road.path.end
    loop = ClosedLoop(planner_on(road, cruise=10.0), [], 10.0, start=end - 80.0, v=22.0)
    assert min(c.a_x for c in loop.commands) < -4.0
    assert loop.x[-1] == pytest.approx(end, abs=0.1)
    assert "the route ends in" in loop.commands[20].decision.reason


def test_limit_that_does_not_change_is_the_constant_one() -> None:
    constant = planner_on(Road(straight(), speed_limit=18.0))
    table = planner_on(Road(straight(), speed_limits=[(0.0, 18.0)]))
    first, second = (
        ClosedLoop(p, [ScriptedVehicle("R", 60.0, 0.0, 9.0)], 12.0, v=17.0) for p in (constant, table)
    )
    assert first.x == second.x
    assert [c.a_x for c in first.commands] == [c.a_x for c in second.commands]


def test_cruise_speed_changes_on_a_road_with_limits() -> None:
    planner = planner_on(Road(straight(), speed_limits=LIMITS), cruise=25.0)
    ClosedLoop(planner, [], 1.0, v=25.0)
    planner.cruise_speed = 12.0
    planner.cruise_speed = 24.0
    assert ClosedLoop(planner, [], 2.0, v=25.0).collided_with is None


def test_parked_car_is_passed_where_the_lane_is_long_enough() -> None:
    road = Road(straight(), [Lane(d=0.0), ending(0.0, 600.0)])
    loop = ClosedLoop(planner_on(road, cruise=20.0), [ScriptedVehicle("R", 200.0, 0.0, 0.0)], 30.0)
    assert loop.collided_with is None
    assert loop.x[-1] > 400.0
    assert max(loop.y) > 2.0


@pytest.mark.parametrize(
    ("lane", "words"),
    [
        (ending(0.0, 210.0), "not passing on the left: lane ends too early (in "),
        (ending(215.0, 900.0), "not passing on the left or right: no lane"),
        (
            Lane.from_boundaries([(0.0, 1.75, 3.0), (900.0, 1.75, 3.0)]),
            "not passing on the left: no space next to R",
        ),
    ],
    ids=["ends", "begins", "narrow"],
)
def test_parked_car_is_not_passed_where_the_lane_is_missing(lane: Lane, words: str) -> None:
    loop = ClosedLoop(
        planner_on(Road(straight(), [Lane(d=0.0), lane]), cruise=20.0),
        [ScriptedVehicle("R", 200.0, 0.0, 0.0)], 25.0,
    )  # fmt: skip
    assert loop.collided_with is None
    assert loop.x[-1] < 220.0
    assert max(map(abs, loop.y)) < 0.5
    assert any(words in c.decision.reason for c in loop.commands)


def test_maneuver_stays_within_a_lane_that_narrows() -> None:
    narrow = Lane.from_boundaries(
        [(0.0, 1.75, 5.25), (150.0, 1.75, 5.25), (220.0, 1.75, 4.6), (900.0, 1.75, 4.6)]
    )
    road = Road(straight(), [Lane(d=0.0), narrow])
    loop = ClosedLoop(planner_on(road, cruise=20.0), [ScriptedVehicle("R", 220.0, 0.0, 0.0)], 30.0)
    assert loop.collided_with is None
    assert loop.x[-1] > 400.0
    assert max(loop.y) + 0.5 * CAR.width < 4.6


def test_narrow_ego_lane_ahead_is_kept() -> None:
    ego = Lane.from_boundaries(
        [(0.0, -1.75, 1.75), (400.0, -1.75, 1.75), (430.0, -1.3, 1.3), (1200.0, -1.3, 1.3)]
    )
    loop = ClosedLoop(planner_on(Road(straight(), [ego]), cruise=20.0), [], 30.0)
    assert max(map(abs, loop.y)) < 0.1
    assert loop.x[-1] > 550.0

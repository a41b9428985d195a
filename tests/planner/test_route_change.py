"""Another route, other limits and another cruise speed under way: no jump in commands."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Lane, Path, Planner, RemoteVehicle, Road, Status
from cca_core.path import fit_path
from cca_core.planner import Mode
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import (
    CAR,
    CYCLE,
    TWO_LANE_ROAD,
    TWO_LANES,
    ClosedLoop,
    Reception,
    ScriptedVehicle,
    ego_state,
    make_planner,
    straight,
)
from tests.support.sweeps import sweep

CHANGE = 3.0  # time of a change [s]
STEERING_STEP = 2e-3  # of a maneuver without a change, in a cycle: 1.3e-3 [rad]
JERK_STEP = 3.0 * CYCLE + 1e-9  # of the acceleration in a cycle by the jerk of normal driving [m/s^2]
WIDE = (Lane(d=0.0, width=4.5), Lane(d=4.0))


def line(y: float = 0.0, length: float = 1200.0, start: float = 0.0) -> Path:
    return Path([start, start + length], [[[0.0, 0.0, length, 0.0], [0.0, 0.0, 0.0, y]]])


def fork(at: float, radius: float = 300.0, sign: float = 1.0) -> Path:
    """Straight to a station, then a curve."""
    turn = np.linspace(0.01, 0.8, 80)
    curve = np.column_stack((at + radius * np.sin(turn), sign * radius * (1.0 - np.cos(turn))))
    before = np.arange(0.0, at + 1.0, 4.0)
    return fit_path(np.vstack((np.column_stack((before, np.zeros_like(before))), curve)), tolerance=0.02)


def at_time(time: float, change: Callable[[], None]) -> Reception:
    """Call a function once, before the first cycle from a time on."""
    done: list[bool] = []

    def receive(t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
        if t >= time - 1e-9 and not done:
            done.append(True)
            change()
        return remotes

    return receive


def drive(
    change: Callable[[Planner], Any], *, slow: bool = False, time: float = CHANGE, seconds: float = 12.0,
    lanes: tuple[Lane, ...] = TWO_LANES, cruise: float = 20.0, v: float = 20.0,
) -> ClosedLoop:  # fmt: skip
    """Drive with a change at a time; `slow` with a car ahead that is passed."""
    planner = make_planner(lanes, cruise=cruise)
    traffic = [ScriptedVehicle("R", 70.0, 0.0, 8.0)] if slow else []
    return ClosedLoop(planner, traffic, seconds, v=v, receive=at_time(time, lambda: change(planner)))


def commands_of(run: ClosedLoop) -> np.ndarray[Any, Any]:
    return np.array([(c.delta, c.a_x) for c in run.commands])


def assert_smooth(run: ClosedLoop, *, steering: float = STEERING_STEP) -> None:
    steps = np.abs(np.diff(commands_of(run), axis=0)).max(axis=0)
    assert steps[0] < steering
    assert steps[1] < JERK_STEP
    assert run.collided_with is None
    assert {c.status for c in run.commands} == {Status.OK}


@pytest.mark.parametrize("time", sweep(CHANGE, 0.0, 4.74))
@pytest.mark.parametrize(
    "same",
    [
        lambda planner: planner.road,
        lambda planner: Road(straight(), TWO_LANES),
        lambda planner: Road(straight(), tuple(reversed(TWO_LANES))),
    ],
    ids=["same object", "equal road", "lanes in other order"],
)
def test_same_route_changes_no_bit(time: float, same: Callable[[Planner], Road]) -> None:
    run = drive(lambda planner: planner.set_route(same(planner)), slow=True, time=time)
    assert np.array_equal(commands_of(run), commands_of(drive(lambda planner: None, slow=True)))


@pytest.mark.parametrize("y", [1.0, -1.0, 0.2])
def test_shifted_route_is_reached_in_comfort(y: float) -> None:
    run = drive(lambda planner: planner.set_route(Road(line(y), WIDE)), lanes=WIDE)
    assert_smooth(run)
    assert max(map(abs, run.a_y)) < 1.2
    assert run.y[-1] == pytest.approx(y, abs=0.02)
    overshoot = max(math.copysign(1.0, y) * np.array(run.y)) - abs(y)
    assert overshoot < 0.03


def test_route_in_adjacent_lane_is_reached_in_comfort() -> None:
    run = drive(lambda planner: planner.set_route(Road(line(3.5), (Lane(d=0.0), Lane(d=-3.5)))))
    assert_smooth(run)
    assert max(map(abs, run.a_y)) < 2.3
    assert run.y[-1] == pytest.approx(3.5, abs=0.02)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("time", [1.0, 4.5])
def test_fork_ahead_is_taken(sign: float, time: float) -> None:
    """At 40 and at 110 m, before a fork at 150 m."""
    path = fork(150.0, sign=sign)
    run = drive(lambda planner: planner.set_route(Road(path, TWO_LANES)), time=time)
    assert_smooth(run)
    assert abs(float(path.project((run.x[-1], run.y[-1]))[1])) < 0.05
    assert max(map(abs, run.a_y)) < 1.6


def test_fork_just_passed_is_taken_within_limits() -> None:
    path = fork(150.0)
    run = drive(lambda planner: planner.set_route(Road(path, TWO_LANES)), time=6.8)
    assert abs(float(path.project((run.x[-1], run.y[-1]))[1])) < 0.05
    assert max(map(abs, run.a_y)) < 3.5


@pytest.mark.parametrize("limit", [12.0, 19.0])
def test_lower_speed_limit_is_met_in_comfort(limit: float) -> None:
    run = drive(lambda planner: planner.set_route(Road(straight(), TWO_LANES, speed_limit=limit)))
    assert_smooth(run)
    assert min(run.a_x) > -2.3
    assert run.v[-1] == pytest.approx(limit, abs=0.1)


@pytest.mark.parametrize(("cruise", "v"), [(10.0, 20.0), (25.0, 12.0)])
def test_other_cruise_speed_is_met_in_comfort(cruise: float, v: float) -> None:
    run = drive(lambda planner: setattr(planner, "cruise_speed", cruise), cruise=v, v=v)
    assert_smooth(run)
    assert min(run.a_x) > -2.3
    assert run.v[-1] == pytest.approx(cruise, abs=0.15)


@pytest.mark.parametrize("time", sweep(3.0, 6.0, 1.7, 4.7, 7.6, quick=2))
@pytest.mark.parametrize(
    ("road", "y"),
    [
        (Road(line(1.0), TWO_LANES), 1.0),
        (Road(line(-1.0), TWO_LANES), -1.0),
        (Road(line(0.0, start=-100.0), TWO_LANES), 0.0),
        (Road(line(0.0), TWO_LANES, speed_limit=17.0), 0.0),
        (Road(fork(260.0), TWO_LANES), None),
    ],
    ids=["1 m left", "1 m right", "other stations", "lower limit", "fork ahead"],
)
def test_change_within_maneuver_is_smooth(time: float, road: Road, y: float | None) -> None:
    """The car is passed from 1.7 to 7.6 s."""
    run = drive(lambda planner: planner.set_route(road), slow=True, time=time)
    assert_smooth(run)
    assert run.gaps["R"] > 0.6
    assert max(map(abs, run.a_y)) < 2.6
    d = float(road.path.project((run.x[-1], run.y[-1]))[1])
    assert abs(d) < 0.1
    if y is not None:
        assert run.y[-1] == pytest.approx(y, abs=0.1)


def test_longer_route_changes_nothing_nearby() -> None:
    run = drive(lambda planner: planner.set_route(Road(line(0.0, 2400.0), TWO_LANES)), slow=True, time=4.0)
    last = commands_of(drive(lambda planner: None, slow=True))
    assert commands_of(run) == pytest.approx(last, abs=1e-3)  # its path is sampled anew


def test_route_set_in_every_cycle_is_driven_smoothly() -> None:
    """A route that grows, as a simulator gives it edge by edge."""
    planner = make_planner()
    traffic = [ScriptedVehicle("R", 70.0, 0.0, 8.0)]

    def receive(t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
        planner.set_route(Road(line(0.0, 600.0 + 20.0 * round(t)), TWO_LANES))
        return remotes

    run = ClosedLoop(planner, traffic, 12.0, receive=receive)
    assert_smooth(run)
    assert run.x[-1] > traffic[0].x + 10.0


def test_second_lap_stays_second_lap() -> None:
    """Two laps of a ring: the ego stops where they end, though the first lap is as near."""
    angle = np.linspace(0.0, 4.0 * math.pi, 241)
    laps = fit_path(40.0 * np.column_stack((np.sin(angle), 1.0 - np.cos(angle))), tolerance=0.05)
    planner = Planner(CAR, laps, cruise_speed=8.0)
    s = 0.7 * laps.length
    x, y = laps.position(s).tolist()
    plant = SingleTrackPlant(CAR, ego_state(x, 8.0, y=y, psi=float(laps.heading(s)), r=0.2))
    planner.set_route(laps.cut(0.6 * laps.length, laps.end))
    for k in range(1200):
        if k == 50:
            planner.set_route(Road(laps, speed_limit=7.0))
        command = planner.step(CYCLE * k, plant.state, [])
        plant.step(command.delta, command.a_x, CYCLE)
    assert plant.state.v_x < 0.1
    assert math.hypot(*(laps.position(laps.end) - (plant.state.x, plant.state.y))) < 2.0


def test_route_elsewhere_leads_to_safe_stop() -> None:
    run = drive(lambda planner: planner.set_route(Road(line(400.0))), slow=True, time=4.0)
    assert run.commands[-1].mode is Mode.SAFE_STOP
    assert "off the route" in run.commands[-1].decision.reason
    assert run.v[-1] < 0.1


def test_route_against_ego_leads_to_safe_stop() -> None:
    back = Path([0.0, 1200.0], [[[0.0, 0.0, -1200.0, 1200.0], [0.0, 0.0, 0.0, 0.0]]])
    run = drive(lambda planner: planner.set_route(back), time=1.0)
    assert "heading" in run.commands[-1].decision.reason
    assert run.v[-1] < 0.1


def test_route_before_first_step_is_driven() -> None:
    planner = make_planner()
    planner.set_route(Road(line(0.0), TWO_LANES, speed_limit=15.0))
    assert ClosedLoop(planner, [], 20.0, v=10.0).v[-1] == pytest.approx(15.0, abs=0.1)


@pytest.mark.parametrize("road", [None, "road", 3.0, TWO_LANES])
def test_route_that_is_none_raises_and_changes_nothing(road: Any) -> None:
    planner = make_planner()
    with pytest.raises(InputError, match="road must be Road or Path"):
        planner.set_route(road)
    assert planner.road.lanes == TWO_LANE_ROAD.lanes

"""Lane changes for good: the ego lane becomes another lane once that is known to be clear."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Lane, Path, Planner, RemoteVehicle, Road, Status
from cca_core.path import fit_path
from cca_core.planner import EvasionSettings, Mode
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import (
    CAR,
    CYCLE,
    ClosedLoop,
    Reception,
    ScriptedVehicle,
    ego_state,
    make_planner,
    straight,
)
from tests.support.sweeps import sweep

THREE_LANES = (Lane(d=-3.5), Lane(d=0.0), Lane(d=3.5))
REQUEST = 1.0  # time of the first request [s]
Event = tuple[float, float | None]  # time and lane


def requests(planner: Planner, events: list[Event]) -> Reception:
    pending = list(events)

    def receive(t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
        while pending and t >= pending[0][0] - 1e-9:
            planner.request_lane(pending.pop(0)[1])
        return remotes

    return receive


class Change:
    """A drive with requests for lanes; `sign` -1 is the mirrored world."""

    def __init__(
        self, *traffic: ScriptedVehicle, events: list[Event] | None = None, seconds: float = 16.0,
        lanes: tuple[Lane, ...] = THREE_LANES, sign: float = 1.0, **kwargs: Any,
    ) -> None:  # fmt: skip
        mirrored = tuple(Lane(d=sign * lane.d, direction=lane.direction) for lane in lanes)
        self.planner = make_planner(mirrored, **kwargs)
        for vehicle in traffic:
            vehicle.d *= sign
        asked = [(t, None if d is None else sign * d) for t, d in events or [(REQUEST, 3.5)]]
        self.run = ClosedLoop(self.planner, traffic, seconds, receive=requests(self.planner, asked))
        self.y = sign * np.array(self.run.y)
        self.reasons = [c.decision.reason for c in self.run.commands]

    @property
    def began(self) -> float:
        """Time at which the change begins, infinite if it does not [s]."""
        return next((CYCLE * k for k, reason in enumerate(self.reasons) if "changing" in reason), math.inf)

    def assert_smooth(self, *, steering: float = 2e-3) -> None:
        delta = np.array([c.delta for c in self.run.commands])
        a_x = np.array([c.a_x for c in self.run.commands])
        assert np.abs(np.diff(delta)).max() < steering
        assert np.abs(np.diff(a_x)).max() < 0.3
        assert max(map(abs, self.run.a_y)) < 2.3
        assert a_x.min() > -2.1
        assert self.run.collided_with is None
        assert {c.status for c in self.run.commands} == {Status.OK}


@pytest.mark.parametrize("d", [3.5, -3.5])
def test_free_lane_becomes_ego_lane(d: float) -> None:
    change = Change(events=[(REQUEST, d)])
    change.assert_smooth()
    assert change.began == pytest.approx(REQUEST)
    assert change.run.y[-1] == pytest.approx(d, abs=0.05)
    assert change.planner.lane == d
    assert change.planner.requested_lane is None
    side = "left" if d > 0.0 else "right"
    assert any(f"changing to the {side} lane" in reason for reason in change.reasons)
    assert change.reasons[-1].startswith("keeping lane")


@pytest.mark.parametrize("at", sweep(2.0, 1.5, 3.0))
@pytest.mark.parametrize("jump", [-0.8, -0.5, 0.5, 0.8])
def test_change_goes_on_after_a_jump_of_position(at: float, jump: float) -> None:
    """The ego is off its path then, and the change goes on from where it is."""
    planner, plant = make_planner(THREE_LANES), SingleTrackPlant(CAR, ego_state(20.0, 20.0))
    planner.request_lane(3.5)
    commands = []
    for k in range(600):
        t, state = CYCLE * k, plant.state
        if t >= at:
            state = replace(state, y=state.y + jump)
        commands.append(planner.step(t, state, []))
        plant.step(commands[-1].delta, commands[-1].a_x, CYCLE)
    modes = [command.mode for command in commands]
    assert Mode.RETURN not in modes[modes.index(Mode.EVADE_LEFT) :]
    assert state.y == pytest.approx(3.5, abs=0.05)


def test_change_stays_within_both_lanes() -> None:
    change = Change()
    assert max(change.y) < 3.55
    assert min(change.y) > -0.01
    assert max(map(abs, change.run.a_y)) < 1.2


def test_request_without_change_gives_same_bits() -> None:
    """The lane of the route is the ego lane already."""
    plain = Change(ScriptedVehicle("R", 70.0, 0.0, 8.0), events=[(99.0, 0.0)])
    asked = Change(ScriptedVehicle("R", 70.0, 0.0, 8.0), events=[(1.0, 0.0), (3.0, None), (4.0, 0.4)])
    assert [(c.delta, c.a_x) for c in plain.run.commands] == [(c.delta, c.a_x) for c in asked.run.commands]


@pytest.mark.parametrize(("gap", "v"), sweep((0.0, 17.0), (-12.0, 20.0), (0.0, 20.0), (-2.0, 22.0), quick=2))
def test_vehicle_alongside_is_waited_for(gap: float, v: float) -> None:
    change = Change(ScriptedVehicle("R2", gap, 3.5, v), seconds=40.0)
    change.assert_smooth()
    assert change.began > REQUEST + 2.0
    assert change.y[-1] == pytest.approx(3.5, abs=0.05)
    waiting = {re.sub(r"\b\d+", "n", reason) for reason in change.reasons if reason.startswith("waiting")}
    assert waiting <= {
        f"waiting for the left lane: R2 {where} at n.n m/s"
        for where in ("alongside", "n m ahead", "n m behind")
    }
    assert waiting
    assert min(change.run.v) > 14.0


def test_fast_follower_passes_first() -> None:
    fast = ScriptedVehicle("R2", -40.0, 3.5, 32.0)
    change = Change(fast)
    change.assert_smooth()
    assert REQUEST + 1.0 < change.began < 8.0
    assert change.y[-1] == pytest.approx(3.5, abs=0.05)
    assert "waiting for the left lane: R2 24 m behind at 32.0 m/s" in change.reasons


def test_distant_follower_is_not_waited_for() -> None:
    change = Change(ScriptedVehicle("R2", -80.0, 3.5, 20.0))
    assert change.began == pytest.approx(REQUEST)


def test_slow_car_in_other_lane_is_passed_first() -> None:
    slow = ScriptedVehicle("R2", 60.0, 3.5, 12.0)
    change = Change(slow, seconds=30.0)
    change.assert_smooth()
    assert change.run.x[-1] > slow.x
    assert change.y[-1] == pytest.approx(3.5, abs=0.05)
    assert min(change.run.v) > 19.9


def test_slow_lane_is_entered_in_comfort_after_a_while() -> None:
    """A column of slow cars is not passed on the right from within it: the ego falls in line."""
    settings = EvasionSettings(awareness_range=math.inf, inner_passing=False)
    column = [ScriptedVehicle(f"S{i}", 60.0 + 120.0 * i, 3.5, 12.0) for i in range(8)]
    change = Change(*column, seconds=50.0, evasion=settings)
    assert change.run.collided_with is None
    assert min(change.run.a_x) > -2.3
    assert change.y[-1] == pytest.approx(3.5, abs=0.05)
    assert change.run.v[-1] == pytest.approx(12.0, abs=0.3)


@pytest.mark.parametrize("lanes", [THREE_LANES, THREE_LANES[1:]])
@pytest.mark.parametrize(("gap", "speed"), [(24.0, 2.0), (22.0, 1.0)])
def test_queue_in_other_lane_is_not_braked_for(lanes: tuple[Lane, ...], gap: float, speed: float) -> None:
    """A change that stops behind a car before the body is in its lane does not fulfil the request."""
    queue = [ScriptedVehicle("S", gap, 3.5, 0.0), ScriptedVehicle("T", gap + 12.0, 3.5, 0.0)]
    leads = [ScriptedVehicle("L", 36.0, 0.0, speed), ScriptedVehicle("M", 45.0, 0.0, speed)]
    planner = make_planner(lanes)
    run = ClosedLoop(planner, [*queue, *leads], 6.0, v=10.5, receive=requests(planner, [(0.0, 3.5)]))
    assert run.collided_with is None
    assert min(c.a_x for c in run.commands) > -3.6


def test_slow_lead_is_left_behind() -> None:
    slow = ScriptedVehicle("L", 45.0, 0.0, 12.0)
    change = Change(slow, events=[(0.0, 3.5)], seconds=20.0)
    change.assert_smooth()
    assert change.y[-1] == pytest.approx(3.5, abs=0.05)
    assert change.run.x[-1] > slow.x + 20.0
    assert min(change.run.v) > 18.0


@pytest.mark.parametrize("time", [1.5, 2.5, 3.5, 4.0])
def test_request_cancelled_midway_leads_back(time: float) -> None:
    change = Change(events=[(REQUEST, 3.5), (time, None)])
    change.assert_smooth(steering=4e-3)
    assert change.y[-1] == pytest.approx(0.0, abs=0.05)
    assert change.planner.lane == 0.0
    assert max(change.y) < 3.3


def test_request_back_leads_back() -> None:
    change = Change(events=[(REQUEST, 3.5), (9.0, 0.0)])
    change.assert_smooth()
    assert max(change.y) == pytest.approx(3.5, abs=0.05)
    assert change.y[-1] == pytest.approx(0.0, abs=0.05)


def test_request_for_other_side_midway_is_met() -> None:
    change = Change(events=[(REQUEST, 3.5), (2.5, -3.5)], seconds=20.0)
    change.assert_smooth()
    assert change.y[-1] == pytest.approx(-3.5, abs=0.05)


def test_two_lanes_are_changed_one_by_one() -> None:
    lanes = (Lane(d=0.0), Lane(d=3.5), Lane(d=7.0))
    alongside = ScriptedVehicle("R2", 0.0, 7.0, 17.0)
    change = Change(alongside, lanes=lanes, events=[(REQUEST, 7.0)], seconds=20.0)
    change.assert_smooth()
    assert change.began == pytest.approx(REQUEST)
    assert change.y[-1] == pytest.approx(7.0, abs=0.05)
    assert change.run.gaps["R2"] > 0.8


@pytest.mark.parametrize(
    "traffic",
    [
        lambda: [],
        lambda: [ScriptedVehicle("R2", 0.0, 3.5, 20.0), ScriptedVehicle("L", 60.0, 0.0, 15.0)],
        lambda: [ScriptedVehicle("R2", -40.0, 3.5, 32.0), ScriptedVehicle("S", 120.0, 3.5, 14.0)],
    ],
    ids=["free", "alongside and lead", "fast follower"],
)
def test_mirrored_world_gives_mirrored_change(traffic: Callable[[], list[ScriptedVehicle]]) -> None:
    sides = [
        Change(
            *traffic(), sign=sign, seconds=24.0,
            evasion=EvasionSettings(awareness_range=math.inf, traffic_side=side),
        )
        for sign, side in ((1.0, "right"), (-1.0, "left"))
    ]  # fmt: skip
    assert sides[1].y == pytest.approx(sides[0].y, abs=1e-5)
    assert sides[1].run.v == pytest.approx(sides[0].run.v, abs=1e-5)


def test_unknown_lane_is_not_entered() -> None:
    change = Change(evasion=EvasionSettings(awareness_range=0.0))
    assert change.began == math.inf
    assert "waiting for the left lane: lane not confirmed clear" in change.reasons[-1]
    assert max(map(abs, change.y)) < 0.01


def test_parked_car_is_passed_in_the_new_lane() -> None:
    """The ego lane is the left one then: the car on it is passed from there and back to it."""
    parked = ScriptedVehicle("P", 500.0, 3.5, 0.0)
    change = Change(parked, seconds=40.0)
    assert change.run.collided_with is None
    assert change.run.x[-1] > parked.x + 30.0
    assert change.y[-1] == pytest.approx(3.5, abs=0.05)
    assert "EVADE_RIGHT" in change.run.actions


def test_route_set_again_keeps_the_lane() -> None:
    change = Change(seconds=8.0)
    planner, plant = change.planner, SingleTrackPlant(CAR, ego_state(change.run.x[-1], y=change.run.y[-1]))
    planner.set_route(Road(straight(), THREE_LANES))
    assert planner.lane == 3.5
    planner.set_route(Road(straight(1300.0), THREE_LANES))
    planner.request_lane(3.5)
    for k in range(250):
        command = planner.step(8.0 + CYCLE * k, plant.state, [])
        plant.step(command.delta, command.a_x, CYCLE)
        assert plant.state.y == pytest.approx(3.5, abs=0.05)
    assert planner.lane == 3.5


def test_curved_road_is_changed_on() -> None:
    """To the outer lane of a curve of 200 m radius, then to the inner one."""
    turn = np.linspace(0.0, 2.5, 120)
    path = fit_path(200.0 * np.column_stack((np.sin(turn), 1.0 - np.cos(turn))), tolerance=0.02)
    planner = Planner(CAR, Road(path, THREE_LANES), cruise_speed=15.0)
    plant, s, offsets = SingleTrackPlant(CAR, ego_state(0.0, 15.0, r=0.075)), 0.0, []
    for k in range(1200):
        if k in (50, 550):
            planner.request_lane(-3.5 if k == 50 else 3.5)
        command = planner.step(CYCLE * k, plant.state, [])
        plant.step(command.delta, command.a_x, CYCLE)
        s, d, _, _ = path.foot_point(plant.state.x, plant.state.y, s)
        offsets.append(d)
        assert abs(plant.a_y) < 2.5
    assert offsets[549] == pytest.approx(-3.5, abs=0.05)
    assert offsets[-1] == pytest.approx(3.5, abs=0.05)


def test_lost_state_within_change_is_survived() -> None:
    planner = make_planner(THREE_LANES)
    plant = SingleTrackPlant(CAR, ego_state())
    planner.request_lane(3.5)
    for k in range(600):
        state: Any = None if 120 <= k < 130 else plant.state
        command = planner.step(CYCLE * k, state, [])
        plant.step(command.delta, command.a_x, CYCLE)
    assert plant.state.y == pytest.approx(3.5, abs=0.05)
    assert command.mode is Mode.KEEP


@pytest.mark.parametrize("d", [7.0, -7.0, 1.75, math.nan, "left"])
def test_lane_that_does_not_exist_raises(d: Any) -> None:
    planner = make_planner(THREE_LANES)
    with pytest.raises(InputError, match="d must be"):
        planner.request_lane(d)
    assert planner.requested_lane is None


def test_opposing_lane_raises() -> None:
    planner = make_planner((Lane(d=0.0), Lane(d=3.5, direction=-1), Lane(d=7.0)))
    for d in (3.5, 7.0):
        with pytest.raises(InputError, match="direction 1"):
            planner.request_lane(d)


def test_lane_behind_a_gap_raises() -> None:
    planner = make_planner((Lane(d=0.0), Lane(d=8.0)))
    with pytest.raises(InputError, match="next to"):
        planner.request_lane(8.0)


def test_inner_lane_of_tight_curve_raises() -> None:
    turn = np.linspace(0.0, 1.5, 60)
    path = fit_path(4.0 * np.column_stack((np.sin(turn), 1.0 - np.cos(turn))), tolerance=0.02)
    planner = Planner(CAR, Road(path, (Lane(d=0.0), Lane(d=4.0))), cruise_speed=3.0)
    with pytest.raises(InputError, match="radius"):
        planner.request_lane(4.0)


def test_offset_within_lane_means_its_center() -> None:
    planner = make_planner(THREE_LANES)
    planner.request_lane(3.0)
    assert planner.requested_lane == 3.5


class TestVaryingLanes:
    def test_lane_that_begins_ahead_is_waited_for(self) -> None:
        lane = Lane.from_boundaries([(200.0, 1.75, 1.75), (250.0, 1.75, 5.25), (1200.0, 1.75, 5.25)])
        planner = Planner(CAR, Road(straight(), (Lane(d=0.0), lane)), cruise_speed=20.0)
        planner.request_lane(3.5)
        run = ClosedLoop(planner, [], 25.0)
        front = np.array(run.x) + CAR.front
        edge = np.interp(front, (200.0, 250.0), (1.75, 5.25))
        assert (np.array(run.y) + 0.5 * CAR.width <= edge + 0.05).all()
        assert run.y[-1] == pytest.approx(3.5, abs=0.05)

    def test_lane_that_ends_is_left_on_request(self) -> None:
        """The route is in a lane that ends; the ego moves over before that."""
        path = Path([0.0, 400.0], [[[0.0, 0.0, 400.0, 0.0], [0.0, 0.0, 0.0, 0.0]]])
        planner = Planner(CAR, Road(path, (Lane(d=0.0), Lane(d=3.5))), cruise_speed=20.0)
        planner.request_lane(3.5)
        run = ClosedLoop(planner, [ScriptedVehicle("R2", -5.0, 3.5, 20.0)], 25.0)
        assert run.collided_with is None
        assert run.y[-1] == pytest.approx(3.5, abs=0.1)

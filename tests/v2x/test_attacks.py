"""Closed loop with a liar on the air: the ego drives on bytes, some of which are false.

In these runs no liar makes the ego touch a real vehicle, leave the road, or leave its lane beside a real
vehicle. What a ghost can still cause without need, and these tests let it: following, braking up to a stop, a
swerve into a lane that is truly free, and a wait behind a slow car for as long as the ghost pretends to be
beside, or a track that fell silent still could be. Not covered: a car ahead that is first heard when a crowd
has taken all places is not known, as if it had no radio.
"""

import math
import statistics
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from cca_core import Lane, LocalFrame, Planner, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.geometry import box_gap, boxes
from cca_core.path import fit_path
from cca_core.sim import SingleTrackPlant
from cca_core.v2x import (
    Bsm,
    Channel,
    ChannelSettings,
    Sender,
    SenderSettings,
    Tracker,
    decode_bsm,
    encode_bsm,
)

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
FRAME = LocalFrame(41.3, -105.6)
LANE = 3.5
STEP = 0.02
START, SPEED = 300.0, 20.0  # of the ego
DURATION = 7.0
FROM = 1.0  # when lies begin [s]


@dataclass(frozen=True)
class Real:
    """A car that truly is there: constant speed, then constant deceleration."""

    s: float  # ahead of the ego at the start [m]
    y: float
    v: float
    brakes_at: float = math.inf
    deceleration: float = 7.0

    def at(self, t: float) -> RemoteVehicle:
        braked = min(max(t - self.brakes_at, 0.0), self.v / self.deceleration)
        v = self.v - self.deceleration * braked
        x = self.v * min(t, self.brakes_at) + (self.v + v) / 2.0 * braked
        slows = 0.0 < t - self.brakes_at and v > 0.0
        return RemoteVehicle(
            id="", x=START + self.s + x, y=self.y, psi=0.0, v_x=v, a_x=-self.deceleration if slows else 0.0,
            length=4.5, width=1.8,
        )  # fmt: skip


SLOW = Real(60.0, 0.0, 12.0)  # to be passed
BESIDE = Real(-2.0, LANE, 20.0)  # stays beside the ego
FAST = Real(-70.0, LANE, 32.0)  # comes from behind
BRAKING = Real(45.0, 0.0, 20.0, brakes_at=1.3, deceleration=7.0)  # just after its frames froze
STANDING = Real(130.0, 0.0, 0.0)
WORLDS = ((SLOW,), (SLOW, BESIDE), (SLOW, FAST))


@dataclass
class Air:
    """What a liar hears and knows."""

    t: float
    due: bool  # whether it is time to send again
    ego: VehicleState
    heard: list[tuple[float, int, bytes]]  # honest frames: when sent, by whom


Attack = Callable[[Air], Iterable[bytes]]
Filter = Callable[[float, int, bytes, list[bytes]], bytes | None]


@dataclass(frozen=True)
class Drive:
    """What happened."""

    t: np.ndarray
    ego: np.ndarray  # x, y, psi, v_x
    commands: np.ndarray
    gaps: np.ndarray  # to each real car [m]
    actions: tuple[str, ...]
    cycle: float  # mean of the planner, its own time [s]
    slowest: float  # its 99th percentile [s]
    tracker: Tracker

    @property
    def reach(self) -> np.ndarray:
        """How far the body reaches to each side [m]."""
        side = 0.5 * CAR.width * np.cos(self.ego[:, 2]) + 0.5 * CAR.length * np.abs(np.sin(self.ego[:, 2]))
        return np.column_stack((self.ego[:, 1] - side, self.ego[:, 1] + side))

    @property
    def leaves_lane(self) -> np.ndarray:
        reach = self.reach
        return (reach[:, 0] < -0.5 * LANE) | (reach[:, 1] > 0.5 * LANE)


def frame(number: int, t: float, x: float, y: float, v: float, **changes: object) -> bytes:
    """A message of a car that goes along the road."""
    lat, lon = FRAME.to_geodetic((x, y))
    values = {
        "msg_count": round(10.0 * t) % 128, "id": f"{number:08x}", "sec_mark": round(t % 60.0, 3) % 60.0,
        "latitude_deg": float(lat), "longitude_deg": float(lon), "speed": v, "psi": 0.0, "a_x": 0.0, "r": 0.0,
        "transmission": "forward", "length": 4.5, "width": 1.8,
    }  # fmt: skip
    return encode_bsm(Bsm(**(values | changes)))


def nothing(air: Air) -> Iterable[bytes]:
    return ()


def honest(t: float, i: int, data: bytes, before: list[bytes]) -> bytes:
    return data


def drive(
    reals: tuple[Real, ...],
    attack: Attack = nothing,
    sent: Filter = honest,
    t0: float = 0.0,
    duration: float = DURATION,
    lanes: int = 2,
) -> Drive:
    """Ego, real cars, honest senders, a channel, and what the liar adds; time begins at `t0`."""
    s = np.arange(0.0, 1001.0, 10.0)
    road = Road(
        fit_path(np.column_stack((s, np.zeros_like(s))), tolerance=0.05),
        [Lane(d=i * LANE, width=LANE) for i in range(lanes)], speed_limit=36.0,
    )  # fmt: skip
    rng = np.random.default_rng(1)
    planner, tracker = Planner(CAR, road, cruise_speed=SPEED), Tracker(FRAME)
    plant = SingleTrackPlant(CAR, VehicleState(x=START, y=0.0, psi=0.0, v_x=SPEED))
    channel = Channel(ChannelSettings(latency=0.05), rng)
    senders = [Sender(f"{i:08x}", FRAME, SenderSettings(), rng) for i in range(len(reals))]
    heard: list[tuple[float, int, bytes]] = []
    own: list[list[bytes]] = [[] for _ in reals]
    rows, commands, gaps, actions, cycles = [], [], [], [], []
    for k in range(round(duration / STEP)):
        since, state = k * STEP, plant.state
        t = t0 + since
        truth = [real.at(since) for real in reals]
        for i, (sender, vehicle) in enumerate(zip(senders, truth, strict=True)):
            data = sender.poll(t, vehicle)
            if data is not None:
                heard.append((t, i, data))
                says = sent(since, i, data, own[i])
                own[i].append(data)
                if says is not None:
                    channel.send(t, (vehicle.x, vehicle.y), says, sender=sender.id)
        if since >= FROM:
            for data in attack(Air(t, k % 5 == 0, state, heard)):
                channel.send(t, (state.x, state.y), data, sender="liar")
        for arrival in channel.receive(t, (state.x, state.y)):
            tracker.update(arrival.data, t)
        remotes = tracker.vehicles(t, state)
        awareness_range = 0.0 if tracker.is_saturated(t) else math.inf
        begun = time.thread_time()
        command = planner.step(t, state, remotes, awareness_range=awareness_range)
        cycles.append(time.thread_time() - begun)
        rows.append((since, state.x, state.y, state.psi, state.v_x))
        commands.append((command.delta, command.a_x))
        body = boxes(
            state.x + CAR.box_offset * math.cos(state.psi), state.y + CAR.box_offset * math.sin(state.psi),
            state.psi, CAR.length, CAR.width,
        )  # fmt: skip
        gaps.append([float(box_gap(body, boxes(v.x, v.y, v.psi, v.length, v.width))) for v in truth])
        name = command.decision.action.value
        if not actions or actions[-1] != name:
            actions.append(name)
        plant.step(command.delta, command.a_x, STEP)
    table = np.array(rows)
    return Drive(
        table[:, 0], table[:, 1:], np.array(commands), np.array(gaps).reshape(len(rows), -1), tuple(actions),
        statistics.fmean(cycles), float(np.quantile(cycles, 0.99)), tracker,
    )  # fmt: skip


@cache
def without_lies(reals: tuple[Real, ...]) -> Drive:
    return drive(reals)


def check(run: Drive, reals: tuple[Real, ...]) -> None:
    """What holds whatever is on the air; a cycle takes 5 times as long as around honest senders at most."""
    assert np.isfinite(run.ego).all()
    assert np.isfinite(run.commands).all()
    assert (run.gaps > 0.0).all(), f"touched a real car: {run.gaps.min(axis=0)}, {run.actions}"
    reach = run.reach
    assert reach[:, 0].min() > -0.5 * LANE, "left the road"
    assert reach[:, 1].max() < 1.5 * LANE, "left the road"
    assert (run.gaps[run.leaves_lane] > 0.5).all(), "left its lane beside a real car"
    assert run.cycle < 5.0 * max(without_lies(world).cycle for world in ((SLOW,), (SLOW, BESIDE), reals))


def ghost_ahead(distance: float, v: float) -> Attack:
    """One that drives ahead of where the ego was when the lies began."""
    return lambda air: (
        [frame(0xBAD, air.t, START + SPEED * FROM + distance + v * (air.t % 60.0 - FROM), 0.0, v)]
        if air.due
        else []
    )


def ghost_beside(air: Air) -> Iterable[bytes]:
    """One that keeps beside the ego whatever the ego does."""
    return [frame(0xBAD, air.t, air.ego.x, LANE, max(air.ego.v_x, 0.0))] if air.due else []


def ghost_upon_the_ego(air: Air) -> Iterable[bytes]:
    return [frame(0xBAD, air.t, air.ego.x, air.ego.y, max(air.ego.v_x, 0.0))] if air.due else []


def teleporting(air: Air) -> Iterable[bytes]:
    """Somewhere else on the road with every message."""
    if not air.due:
        return []
    rng = np.random.default_rng(round(100.0 * air.t))
    return [frame(0xBAD, air.t, air.ego.x + rng.uniform(-150.0, 150.0), rng.choice((0.0, LANE)), 20.0)]


def crowd(air: Air, x: tuple[float, float], y: tuple[float, float], **changes: object) -> Iterable[bytes]:
    """A thousand cars around the ego at the speed of its start, twice a second."""
    if round(air.t / STEP) % 25:
        return []
    rng = np.random.default_rng(5)
    xs, ys = START + SPEED * air.t + rng.uniform(*x, 1000), rng.uniform(*y, 1000)
    return [frame(0x1000 + i, air.t, xs[i], ys[i], SPEED, **changes) for i in range(1000)]


def thousand(air: Air) -> Iterable[bytes]:
    return crowd(air, (-300.0, 300.0), (-60.0, 60.0))


def thousand_on_the_field(air: Air) -> Iterable[bytes]:
    return crowd(air, (-150.0, 150.0), (-60.0, -10.0))


def thousand_close_by(air: Air) -> Iterable[bytes]:
    return crowd(air, (-40.0, 40.0), (-40.0, -6.0), length=0.3, width=0.3)


def later(delay: float) -> Attack:
    """All that was heard, once more."""

    def attack(air: Air) -> Iterable[bytes]:
        return [data for t, _, data in air.heard if abs(air.t - t - delay) < 0.5 * STEP]

    return attack


def a_minute_old(number: int, real: Real) -> Attack:
    """What a car sent 60 s ago, whose time stamps look fresh: the format has no minute."""

    def attack(air: Air) -> Iterable[bytes]:
        x = START + real.s + real.v * (air.t % 60.0 - 60.0)
        return [frame(number, air.t, x, real.y, real.v)] if air.due else []

    return attack


def repeats(which: int, place_only: bool, until: float = math.inf) -> Filter:
    """From `FROM` on one sender repeats its last frame, or its last place with a fresh time stamp."""

    def sent(t: float, i: int, data: bytes, before: list[bytes]) -> bytes | None:
        if i != which or not FROM <= t < until or not before:
            return data
        if not place_only:
            return before[8]
        old = decode_bsm(before[8])
        where = {"latitude_deg": old.latitude_deg, "longitude_deg": old.longitude_deg}
        return encode_bsm(replace(decode_bsm(data), **where))

    return sent


@pytest.mark.parametrize("reals", [(), (BESIDE,), (FAST,)])
@pytest.mark.parametrize(("distance", "v"), [(60.0, 0.0), (40.0, 10.0), (25.0, 0.0)])
def test_ghost_ahead(distance: float, v: float, reals: tuple[Real, ...]) -> None:
    """It makes the ego brake, and swerve only into a lane that is truly free."""
    run = drive(reals, ghost_ahead(distance, v))
    check(run, reals)
    assert reals == () or not run.leaves_lane.any()
    assert len(run.actions) > 1


@pytest.mark.parametrize("reals", WORLDS)
def test_ghost_in_adjacent_lane(reals: tuple[Real, ...]) -> None:
    """It makes the ego wait behind a slow car that it could have passed; it never moves it sideways."""
    run = drive(reals, ghost_beside)
    check(run, reals)
    assert not run.leaves_lane.any()
    assert "FOLLOW" in run.actions


@pytest.mark.parametrize("reals", WORLDS)
def test_ghost_at_ego_position(reals: tuple[Real, ...]) -> None:
    """It can make the ego stop."""
    run = drive(reals, ghost_upon_the_ego)
    check(run, reals)
    assert not run.leaves_lane.any()


@pytest.mark.parametrize("reals", WORLDS)
def test_teleporting_sender(reals: tuple[Real, ...]) -> None:
    """Its first place is believed, most of the others are not; it costs a wait."""
    run = drive(reals, teleporting)
    check(run, reals)
    assert run.tracker.counts["teleport"] > 30
    assert "EVADE_LEFT" in without_lies((SLOW,)).actions


@pytest.mark.parametrize("place_only", [False, True], ids=["frames", "places"])
@pytest.mark.parametrize(
    ("reals", "which"),
    [
        ((SLOW, FAST), 1),
        ((SLOW, BESIDE), 0),
        ((SLOW, BESIDE), 1),
        ((BRAKING, BESIDE), 0),
    ],
)
def test_frozen_sender(reals: tuple[Real, ...], which: int, place_only: bool) -> None:
    """Its track goes on, grows and blocks; the ego waits, and slows down."""
    run = drive(reals, sent=repeats(which, place_only))
    check(run, reals)
    assert not run.leaves_lane.any()
    names = ("frozen",) if place_only else ("duplicate", "out_of_order", "replay")
    assert sum(run.tracker.counts[name] for name in names) > 30


@pytest.mark.parametrize("until", [2.0, 3.0, 6.0, math.inf])
@pytest.mark.parametrize("brakes_at", [1.0, 1.3, 2.5])
def test_frozen_leader_brakes_to_standstill(brakes_at: float, until: float) -> None:
    """Only its place is frozen: its speed still tells that it brakes, and where it stands, also for long."""
    reals = (replace(BRAKING, brakes_at=brakes_at),)
    run = drive(reals, sent=repeats(0, place_only=True, until=until), duration=12.0, lanes=1)
    check(run, reals)
    assert not run.leaves_lane.any()
    assert until < 10.0 or run.ego[-50:, 3].max() < 0.5
    assert (run.tracker.vehicles(12.0)[0].age < 0.3) == (until < 10.0)


@pytest.mark.parametrize("reals", WORLDS)
@pytest.mark.parametrize("delay", [0.1, 0.5, 2.0])
def test_replay(delay: float, reals: tuple[Real, ...]) -> None:
    """Old frames of senders that are heard change nothing at all."""
    run, clean = drive(reals, later(delay)), without_lies(reals)
    check(run, reals)
    assert run.tracker.counts["out_of_order"] > 30
    np.testing.assert_array_equal(run.ego, clean.ego)


def test_replay_of_the_minute_before() -> None:
    """For a sender that is heard it is a teleport; under an id of its own it is a ghost like any other."""
    reals = (SLOW, BESIDE)
    for number, what in ((1, "teleport"), (0xBAD, "updated")):
        run = drive(reals, a_minute_old(number, BESIDE), t0=60.0)
        check(run, reals)
        assert not run.leaves_lane.any()
        assert run.tracker.counts[what] > 30
    past = Real(60.0 * SPEED, LANE, SPEED)  # was where the ego is now, a minute ago
    reals = (replace(SLOW, s=65.0),)  # not yet to be passed when the ghost comes
    run = drive(reals, a_minute_old(0xBAD, past), t0=60.0)
    check(run, reals)
    assert "EVADE_LEFT" in without_lies(reals).actions
    assert "EVADE_LEFT" not in run.actions


@pytest.mark.parametrize("attack", [thousand, thousand_on_the_field])
def test_sybil_flood(attack: Attack) -> None:
    """They make the ego stop or wait."""
    reals = (SLOW, BESIDE)
    run = drive(reals, attack)
    check(run, reals)
    assert not run.leaves_lane.any()
    assert len(run.tracker) <= 200
    assert run.tracker.counts["full"] > 1000
    assert run.tracker.is_saturated(FROM + 5.6)
    assert run.slowest < max(STEP, 1.5 * without_lies(reals).slowest)


@pytest.mark.parametrize(
    "reals", [(STANDING,), (STANDING, BESIDE), (SLOW, BESIDE), (replace(BRAKING, brakes_at=2.5), BESIDE)]
)
def test_sybil_flood_keeps_confirmed_vehicles(reals: tuple[Real, ...]) -> None:
    """Nearer than any real car, small and close together: who was heard before them stays heard."""
    run = drive(reals, thousand_close_by)
    check(run, reals)
    assert run.slowest < max(STEP, 1.5 * without_lies(reals).slowest)
    assert run.tracker.counts["full"] > 1000
    known = {vehicle.id for vehicle in run.tracker.vehicles(DURATION)}
    assert known.issuperset(f"{i:08x}" for i in range(len(reals)))


def test_sybil_flood_blocks_lane_for_new_vehicles() -> None:
    """A car that is first heard after the crowd is not taken in: then the lane beside is not known."""
    reals = (replace(SLOW, s=100.0), FAST)
    assert "EVADE_LEFT" in without_lies(reals[:1]).actions
    run = drive(reals, thousand_close_by, lambda t, i, data, before: data if i == 0 or t > 1.5 else None)
    check(run, reals)
    assert not run.leaves_lane.any()
    assert "00000001" not in {vehicle.id for vehicle in run.tracker.vehicles(DURATION)}

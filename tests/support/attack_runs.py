"""Closed loop with real vehicles, honest senders and a misbehaving one."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

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
FROM = 1.0  # begin of the attack [s]


@dataclass(frozen=True)
class Real:
    """A real vehicle: constant speed, then constant deceleration."""

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
ALONGSIDE = Real(-2.0, LANE, 20.0)
FAST = Real(-70.0, LANE, 32.0)  # approaches from behind
BRAKING = Real(45.0, 0.0, 20.0, brakes_at=1.3, deceleration=7.0)  # just after its frames freeze
STATIONARY = Real(130.0, 0.0, 0.0)
WORLDS = ((SLOW,), (SLOW, ALONGSIDE), (SLOW, FAST))


@dataclass
class Air:
    """State that an attacker can use."""

    t: float
    due: bool  # whether a message is due
    ego: VehicleState
    received: list[tuple[float, int, bytes]]  # honest frames: time, sender, bytes


Attack = Callable[[Air], Iterable[bytes]]
Filter = Callable[[float, int, bytes, list[bytes]], bytes | None]


@dataclass(frozen=True)
class Drive:
    """Record of a run."""

    t: np.ndarray
    ego: np.ndarray  # x, y, psi, v_x
    commands: np.ndarray
    gaps: np.ndarray  # to each real car [m]
    actions: tuple[str, ...]
    max_remotes: int  # largest number of vehicles in a cycle: it bounds the planner's work
    tracker: Tracker

    @property
    def reach(self) -> np.ndarray:
        """Lateral interval of the body [m]."""
        side = 0.5 * CAR.width * np.cos(self.ego[:, 2]) + 0.5 * CAR.length * np.abs(np.sin(self.ego[:, 2]))
        return np.column_stack((self.ego[:, 1] - side, self.ego[:, 1] + side))

    @property
    def leaves_lane(self) -> np.ndarray:
        reach = self.reach
        return (reach[:, 0] < -0.5 * LANE) | (reach[:, 1] > 0.5 * LANE)


def frame(number: int, t: float, x: float, y: float, v: float, **changes: object) -> bytes:
    """Message of a vehicle that drives along the road."""
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
    """Run the ego with real vehicles, honest senders, a channel and an attack; time begins at `t0`."""
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
    received: list[tuple[float, int, bytes]] = []
    own: list[list[bytes]] = [[] for _ in reals]
    rows, commands, gaps, actions, max_remotes = [], [], [], [], 0
    for k in range(round(duration / STEP)):
        since, state = k * STEP, plant.state
        t = t0 + since
        truth = [real.at(since) for real in reals]
        for i, (sender, vehicle) in enumerate(zip(senders, truth, strict=True)):
            data = sender.poll(t, vehicle)
            if data is not None:
                received.append((t, i, data))
                false = sent(since, i, data, own[i])
                own[i].append(data)
                if false is not None:
                    channel.send(t, (vehicle.x, vehicle.y), false, sender=sender.id)
        if since >= FROM:
            for data in attack(Air(t, k % 5 == 0, state, received)):
                channel.send(t, (state.x, state.y), data, sender="attacker")
        for arrival in channel.receive(t, (state.x, state.y)):
            tracker.update(arrival.data, t)
        remotes = tracker.vehicles(t, state)
        awareness_range = 0.0 if tracker.is_saturated(t) else math.inf
        command = planner.step(t, state, remotes, awareness_range=awareness_range)
        max_remotes = max(max_remotes, len(remotes))
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
        max_remotes, tracker,
    )  # fmt: skip


@cache
def without_attack(reals: tuple[Real, ...]) -> Drive:
    return drive(reals)


def check(run: Drive, reals: tuple[Real, ...]) -> None:
    """Assert safety for any attack."""
    assert np.isfinite(run.ego).all()
    assert np.isfinite(run.commands).all()
    assert (run.gaps > 0.0).all(), f"collision: {run.gaps.min(axis=0)}, {run.actions}"
    reach = run.reach
    assert reach[:, 0].min() > -0.5 * LANE, "left the road"
    assert reach[:, 1].max() < 1.5 * LANE, "left the road"
    assert (run.gaps[run.leaves_lane] > 0.5).all(), "left its lane next to a vehicle"
    assert run.max_remotes <= run.tracker.settings.max_tracks


def ghost_ahead(distance: float, v: float) -> Attack:
    """Ghost ahead of the ego's position at the begin of the attack."""
    return lambda air: (
        [frame(0xBAD, air.t, START + SPEED * FROM + distance + v * (air.t % 60.0 - FROM), 0.0, v)]
        if air.due
        else []
    )


def ghost_alongside(air: Air) -> Iterable[bytes]:
    """Ghost that stays alongside the ego."""
    return [frame(0xBAD, air.t, air.ego.x, LANE, max(air.ego.v_x, 0.0))] if air.due else []


def ghost_at_ego(air: Air) -> Iterable[bytes]:
    return [frame(0xBAD, air.t, air.ego.x, air.ego.y, max(air.ego.v_x, 0.0))] if air.due else []


def teleporting(air: Air) -> Iterable[bytes]:
    """Ghost at another position on the road with every message."""
    if not air.due:
        return []
    rng = np.random.default_rng(round(100.0 * air.t))
    return [frame(0xBAD, air.t, air.ego.x + rng.uniform(-150.0, 150.0), rng.choice((0.0, LANE)), 20.0)]


def flood(air: Air, x: tuple[float, float], y: tuple[float, float], **changes: object) -> Iterable[bytes]:
    """A thousand ghosts around the ego at its initial speed, twice a second."""
    if round(air.t / STEP) % 25:
        return []
    rng = np.random.default_rng(5)
    xs, ys = START + SPEED * air.t + rng.uniform(*x, 1000), rng.uniform(*y, 1000)
    return [frame(0x1000 + i, air.t, xs[i], ys[i], SPEED, **changes) for i in range(1000)]


def flood_around(air: Air) -> Iterable[bytes]:
    return flood(air, (-300.0, 300.0), (-60.0, 60.0))


def flood_off_road(air: Air) -> Iterable[bytes]:
    return flood(air, (-150.0, 150.0), (-60.0, -10.0))


def flood_close(air: Air) -> Iterable[bytes]:
    return flood(air, (-40.0, 40.0), (-40.0, -6.0), length=0.3, width=0.3)


def replay(delay: float) -> Attack:
    """All received frames, once more."""

    def attack(air: Air) -> Iterable[bytes]:
        return [data for t, _, data in air.received if abs(air.t - t - delay) < 0.5 * STEP]

    return attack


def replay_minute(number: int, real: Real) -> Attack:
    """Messages of a vehicle 60 s ago; their time stamps look new, as the format has no minute."""

    def attack(air: Air) -> Iterable[bytes]:
        x = START + real.s + real.v * (air.t % 60.0 - 60.0)
        return [frame(number, air.t, x, real.y, real.v)] if air.due else []

    return attack


def freeze(which: int, position_only: bool, until: float = math.inf) -> Filter:
    """From `FROM` on one sender repeats its last frame, or its last position with a new time stamp."""

    def sent(t: float, i: int, data: bytes, before: list[bytes]) -> bytes | None:
        if i != which or not FROM <= t < until or not before:
            return data
        if not position_only:
            return before[8]
        old = decode_bsm(before[8])
        frozen = {"latitude_deg": old.latitude_deg, "longitude_deg": old.longitude_deg}
        return encode_bsm(replace(decode_bsm(data), **frozen))

    return sent

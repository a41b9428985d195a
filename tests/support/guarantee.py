"""Random situations heard through a tracker, and one decision of the planner in them."""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from cca_core import Lane, LocalFrame, Planner, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.path import fit_path
from cca_core.planner import Command, EvasionSettings
from cca_core.v2x import Bsm, Tracker, TrackerSettings, encode_bsm

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
FRAME = LocalFrame(45.0, 14.0)
NOW = 6000.0  # time of the decision on the clock of the messages [s]
START = 500.0  # of the ego on its route [m]
SPEED_LIMIT = 36.0
CYCLE = 0.1  # of the drive before the decision [s]
LEFT, RIGHT = 3.5, -3.5
DEFAULT = replace(EvasionSettings(), awareness_range=math.inf)
CAUTIOUS = replace(EvasionSettings.cautious(), awareness_range=math.inf)

_CURVES: tuple[tuple[float, float], ...] = (
    (math.inf, math.inf),
    (math.inf, math.inf),
    (500.0, 500.0),
    (-800.0, -800.0),
    (250.0, -250.0),
    (math.inf, 200.0),
    (150.0, math.inf),
)  # radius near the ego and farther on [m]
_LANES = (((LEFT, 1),), ((LEFT, -1),), ((LEFT, 1), (2.0 * LEFT, -1)), ((RIGHT, 1), (LEFT, -1)), ((RIGHT, 1),))


@dataclass(frozen=True, kw_only=True)
class Sender:
    """A vehicle at the time of its last message, what that reports, and its errors as parts of two sigma."""

    s: float  # reported station and lateral offset of its center [m]
    d: float
    v: float  # along the route [m/s]
    v_d: float  # sideways [m/s]
    a: float  # reported [m/s^2]
    age: float
    length: float
    width: float
    along: float = 0.0  # error of the place, -1 to 1
    across: float = 0.0
    first: float = 0.0  # true accelerations since the message, as parts of the bounds: -1 to 1
    second: float = 0.0
    switch: float = 1.0  # time between them [s]


@dataclass(frozen=True, kw_only=True)
class Case:
    """An ego on a road and the vehicles that it hears; the first one it may have been passing for a while."""

    road: int
    v: float
    cruise: float
    d: float = 0.0
    angle: float = 0.0  # of its heading to the route [rad]
    driven: float = 0.0  # time before the decision [s]
    sigma: float = 0.0  # of positions, beyond that of the age [m]
    senders: tuple[Sender, ...] = ()


@dataclass(frozen=True, eq=False)
class Decided:
    """A decision: the planner, its command and the vehicles as the tracker gives them."""

    case: Case
    planner: Planner
    command: Command
    remotes: dict[str, RemoteVehicle]
    s: float  # station of the ego [m]
    v: float


N_ROADS = len(_CURVES) * len(_LANES)


@cache
def road_of(index: int) -> Road:
    """One of the roads: a curve, and then another one; lanes in both directions."""
    near, far = _CURVES[index % len(_CURVES)]
    ds = 5.0
    s = np.arange(0.0, 2401.0, ds)
    share = np.clip((s - START - 60.0) / 80.0, 0.0, 1.0)  # a clothoid of 80 m between the curves
    psi = np.concatenate(([0.0], np.cumsum(ds * ((1.0 - share) / near + share / far))))[:-1]
    psi = np.where(np.abs(psi) > 5.0, np.sign(psi) * 5.0, psi)  # no road meets itself
    xy = np.cumsum(ds * np.column_stack((np.cos(psi), np.sin(psi))), axis=0)
    lanes = [Lane(d=0.0, width=LEFT)]
    lanes += [Lane(d=d, width=LEFT, direction=sign) for d, sign in _LANES[index // len(_CURVES)]]
    return Road(fit_path(xy, tolerance=0.02), sorted(lanes, key=lambda lane: lane.d), speed_limit=SPEED_LIMIT)


def sample_case(rng: np.random.Generator) -> Case:
    """Sample a situation: a lead vehicle that is slower, and others in all lanes."""
    index = int(rng.integers(N_ROADS))
    road = road_of(index)
    fastest = min(SPEED_LIMIT, math.sqrt(3.0 * road.path.min_radius))
    v = rng.uniform(0.0, fastest)
    gap = rng.uniform(0.8, 4.0) * max(v, 4.0) + 8.0
    senders = [_sender(rng, START + gap, 0.0, v * rng.uniform(0.0, 0.9))]
    for _ in range(int(rng.integers(0, 7))):
        lane = road.lanes[int(rng.integers(len(road.lanes)))]
        speed = lane.direction * rng.uniform(0.0, 38.0)
        far = rng.random() < 0.4
        s = START + (rng.uniform(-150.0, 600.0) if far else rng.uniform(-40.0, 80.0))
        if lane is road.ego_lane:
            speed, s = v * rng.uniform(0.4, 1.3), START + rng.choice((-1.0, 1.0)) * rng.uniform(15.0, 200.0)
        senders.append(_sender(rng, s, lane.d, speed))
    kind = rng.random()
    driven = rng.uniform(0.3, 5.0) if kind < 0.3 else 0.0
    d, angle = (rng.uniform(-1.0, 3.5), rng.uniform(-0.06, 0.06)) if kind > 0.85 else (0.0, 0.0)
    if driven:
        senders[0] = replace(senders[0], v_d=0.0)
    return Case(
        road=index, v=v, cruise=rng.uniform(max(v, 3.0), 36.0), d=d, angle=angle, driven=driven,
        sigma=float(rng.choice((0.0, 0.0, 0.2, 0.5))), senders=tuple(senders),
    )  # fmt: skip


def _sender(rng: np.random.Generator, s: float, lane: float, v: float) -> Sender:
    length, width = ((4.5, 1.8), (4.5, 1.8), (12.0, 2.55), (18.7, 2.55))[int(rng.integers(4))]
    return Sender(
        s=s, d=lane + rng.uniform(-0.5, 0.5), v=v, v_d=rng.uniform(-1.2, 1.2) if rng.random() < 0.15 else 0.0,
        a=float(rng.choice((0.0, rng.uniform(-8.0, 3.0)))), age=rng.uniform(0.0, 0.95), length=length,
        width=width, along=rng.uniform(-1.0, 1.0), across=rng.uniform(-1.0, 1.0),
        first=rng.choice((-1.0, 1.0)), second=rng.choice((-1.0, 1.0)), switch=rng.uniform(0.0, 6.0),
    )  # fmt: skip


def name_of(i: int) -> str:
    """Id of a sender."""
    return f"{i + 1:08x}"


def heading_of(sender: Sender) -> float:
    """Heading relative to the route as reported [rad]: below that of a vehicle that crosses it."""
    aside = math.asin(min(max(sender.v_d / abs(sender.v), -0.3), 0.3)) if abs(sender.v) > 2.0 else 0.0
    return aside if sender.v >= 0.0 else math.pi - aside


def message_of(sender: Sender, i: int, road: Road) -> bytes:
    """The message of a sender."""
    x, y = road.path.to_cartesian(sender.s, sender.d)
    lat, lon = FRAME.to_geodetic((float(x), float(y)))
    t = NOW - sender.age
    kappa = float(road.path.curvature_at(sender.s))
    speed = abs(sender.v)
    psi = float(road.path.heading(sender.s)) + heading_of(sender)
    return encode_bsm(Bsm(
        msg_count=i, id=name_of(i), sec_mark=round(t % 60.0, 3), latitude_deg=float(lat),
        longitude_deg=float(lon), speed=speed, psi=math.remainder(psi, 2.0 * math.pi), a_x=sender.a,
        r=math.copysign(speed, sender.v) * kappa / (1.0 - sender.d * kappa), length=sender.length,
        width=sender.width,
    ))  # fmt: skip


def hear(case: Case) -> dict[str, RemoteVehicle]:
    """Return the vehicles that a tracker makes of the messages."""
    road = road_of(case.road)
    tracker = Tracker(FRAME, TrackerSettings(sigma_position=case.sigma))
    for i, sender in sorted(enumerate(case.senders), key=lambda item: -item[1].age):
        tracker.update(message_of(sender, i, road), NOW - sender.age + 0.01)
    return {remote.id: remote for remote in tracker.vehicles(NOW)}


def decide(case: Case, settings: EvasionSettings) -> Decided:
    """Return the decision in a situation, after the ego has driven for a while behind the first sender."""
    road = road_of(case.road)
    planner = Planner(CAR, road, cruise_speed=case.cruise, evasion=settings)
    remotes = hear(case)
    t, s, state = 0.0, START, state_at(road, START, case.d, case.angle, case.v)
    if case.driven and name_of(0) in remotes:
        t, s, state = _drive(case, planner, road, remotes[name_of(0)])
    command = planner.step(t, state, list(remotes.values()))
    return Decided(case, planner, command, remotes, s, state.v_x)


def _drive(
    case: Case, planner: Planner, road: Road, lead: RemoteVehicle
) -> tuple[float, float, VehicleState]:
    """Drive on the planner's path among the lead vehicle alone, up to `START` at the end."""
    n = round(case.driven / CYCLE)
    path, speed = road.path, case.senders[0].v
    s, v, d = START - case.v * n * CYCLE, case.v, 0.0
    ahead = case.senders[0].s + speed * (case.senders[0].age - n * CYCLE)
    state = state_at(road, s, 0.0, 0.0, v)
    for k in range(n):
        at = ahead + speed * k * CYCLE
        x, y = path.to_cartesian(at, case.senders[0].d)
        seen = replace(
            lead, x=float(x), y=float(y), psi=float(path.heading(at)), v_x=abs(speed), a_x=0.0, r=0.0,
            age=0.0, sigma_along=0.0, sigma_across=0.0,
        )  # fmt: skip
        a = planner.step(k * CYCLE, state, [seen]).a_x
        then = max(v + a * CYCLE, 0.0)
        s, v = s + 0.5 * (v + then) * CYCLE, then
        driven = planner.maneuver
        here = (0.0, 0.0) if driven is None else (driven.offset_at(s), driven.offset_at(s + 1.0))
        d, slope = here[0], here[1] - here[0]
        kappa = float(path.curvature_at(s))
        state = state_at(road, s, d, math.atan(slope / (1.0 - d * kappa)), v)
    return n * CYCLE, s, state


def state_at(road: Road, s: float, d: float, angle: float, v: float) -> VehicleState:
    """State of an ego on a road."""
    x, y = road.path.to_cartesian(s, d)
    kappa = float(road.path.curvature_at(s))
    psi = float(road.path.heading(s)) + angle
    return VehicleState(x=float(x), y=float(y), psi=psi, v_x=v, r=v * kappa)

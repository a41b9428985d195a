"""True motions of vehicles within the declared bounds, and whether they touch an ego on its safe stop."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.geometry import box_gap, boxes
from cca_core.path import Road
from tests.support.guarantee import CAR, SPEED_LIMIT, Decided, Sender, name_of, road_of

STEP = 0.05  # [s]
T = STEP * np.arange(401)
MOVES = 0.2  # speed below which the ego counts as standing [m/s]
BRAKING, ACCELERATION = 8.0, 3.0  # declared bounds [m/s^2]
INSIDE = 0.05  # beyond a lane boundary, up to which a body is in its lane [m]
DUTY_DELAY = 1.0  # after a return, from when on vehicles behind keep their distance [s]
_BEFORE = 10  # steps between a message and the decision
_SIDE_SPEED = 0.3  # from which on a vehicle is expected to move sideways [m/s]


@dataclass(frozen=True, eq=False)
class Ride:
    """The ego on its safe stop at the times `T`; indices of when it leaves its lane, and is back for good."""

    xy: Array
    psi: Array
    v: Array
    s: Array
    d: Array
    out: Mask
    begins: int
    enters: int
    back: int


def ride_of(decided: Decided) -> Ride:
    """Sample the safe stop of a command finely: constant acceleration between its times."""
    stop, road = decided.command.safe_stop, road_of(decided.case.road)
    assert stop is not None
    driven = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(stop.poses[:, :2], axis=0).T))))
    i = np.minimum(np.searchsorted(stop.t, T + 1e-9, side="right") - 1, len(stop.t) - 2)
    share = np.clip((T - stop.t[i]) / np.diff(stop.t)[i], 0.0, 1.0)
    v_0, v_1 = stop.v[i], stop.v[i + 1]
    part = share * (v_0 + 0.5 * (v_1 - v_0) * share) / np.maximum(0.5 * (v_0 + v_1), 1e-9)
    at = driven[i] + (driven[i + 1] - driven[i]) * np.minimum(part, 1.0)
    grid, first = np.unique(driven, return_index=True)
    x, y, psi = (np.interp(at, grid, row[first]) for row in stop.poses.T)
    s, d = road.path.project(np.column_stack((x, y)), decided.s + at)
    lane, half = road.ego_lane, 0.5 * CAR.width
    out = (d + half - INSIDE > lane.left) | (d - half + INSIDE < lane.right)
    turns = np.abs(d - d[0]) > 0.003
    return Ride(
        xy=np.column_stack((x, y)), psi=psi, v=np.interp(T, stop.t, stop.v), s=s, d=d, out=out,
        begins=int(np.argmax(turns)), enters=int(np.argmax(out)),
        back=min(int(np.flatnonzero(out)[-1]) + 1, len(T) - 1) if out.any() else 0,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Motions:
    """Possible motions of one vehicle at the times `T`, one a row."""

    s: Array
    d: Array
    angle: float


def min_gap(decided: Decided, rng: np.random.Generator, n: int = 24, *, reacts: bool = True) -> float:
    """Return the least gap of the ego on its safe stop to any of `n` motions of each vehicle while it moves.

    With `reacts` drivers behind in the adjacent lane keep their speed from the begin of a maneuver on, and
    their distance from 1.5 s after that.
    """
    road, ride, smallest = road_of(decided.case.road), ride_of(decided), math.inf
    known = [i for i in range(len(decided.case.senders)) if name_of(i) in decided.remotes]
    senders = [decided.case.senders[i] for i in known]
    a = [_accelerations(decided, i, road, ride, rng, n, reacts=reacts) for i in known]
    for i, sender, along in zip(known, senders, _drive(senders, a, n), strict=True):
        found = _motions(decided, i, road, along, rng)
        counts = (ride.v > MOVES) & ~_excluded(found, sender, road, ride, reacts=reacts)
        gaps = _gaps(found, sender, road, ride, counts | (T == 0.0))
        possible = counts & (gaps[:, :1] > 0.0)  # bodies do not overlap now
        smallest = min(smallest, float(np.min(gaps, where=possible, initial=math.inf)))
    return smallest


def _gaps(found: Motions, sender: Sender, road: Road, ride: Ride, counts: Mask) -> Array:
    """Gaps of bodies where they are near, infinite elsewhere."""
    gaps = np.full(counts.shape, math.inf)
    near = counts & (np.abs(found.s - ride.s) < 0.5 * (sender.length + CAR.length) + 6.0)
    near &= np.abs(found.d - ride.d) < 0.5 * (sender.width + CAR.width) + 4.0
    row, k = np.nonzero(near)
    s, d = found.s[row, k], found.d[row, k]
    x, y = road.path.to_cartesian(s, d).T
    ego = CAR.body_at(ride.xy[k, 0], ride.xy[k, 1], ride.psi[k])
    body = boxes(x, y, road.path.heading(s) + found.angle, sender.length, sender.width)
    gaps[row, k] = box_gap(ego, body)
    return gaps


def _steps(sender: Sender) -> Array:
    """Lengths of the steps from the message to the end of the ride [s]."""
    return np.concatenate((np.full(_BEFORE, sender.age / _BEFORE), np.full(len(T) - 1, STEP)))


def _accelerations(
    decided: Decided, i: int, road: Road, ride: Ride, rng: np.random.Generator, n: int, *, reacts: bool
) -> Array:
    """Accelerations since the message: the sender's own two, the extremes, and random ones of two pieces."""
    sender, certificate = decided.case.senders[i], decided.command.certificate
    high, low = max(ACCELERATION, sender.a), -max(BRAKING, -sender.a)
    since = np.concatenate(([0.0], np.cumsum(_steps(sender))))[:-1]
    first, second = rng.choice((-1.0, 1.0), n), rng.choice((-1.0, 1.0), n)
    first[n // 2 :] = rng.uniform(-1.0, 1.0, n - n // 2)
    switch = rng.uniform(0.0, 8.0, n)
    first[:4], second[:4] = (sender.first, 1.0, -1.0, 1.0), (sender.second, 1.0, -1.0, -1.0)
    switch[0], switch[3] = sender.switch, sender.age + rng.uniform(0.0, 3.0)
    share = np.where(since < switch[:, None], first[:, None], second[:, None])
    a: Array = np.where(share > 0.0, share * high, -share * low)
    if certificate is not None and name_of(i) in certificate.passed:
        a = np.minimum(a, np.where(since < sender.age - 1e-9, max(sender.a, 0.0), 0.0))
    if reacts and ride.back and _may_react(sender, road):
        k = ride.begins if sender.v > ride.v[0] else ride.enters
        a = np.where(np.arange(len(since)) >= _BEFORE + k, np.minimum(a, 0.0), a)
    return a


def _drive(senders: Sequence[Sender], a: Sequence[Array], n: int) -> list[Array]:
    """Distances driven since the message at `T`; no vehicle reverses or exceeds its speed limit."""
    if not senders:
        return []
    rates = np.concatenate(a)
    h = np.repeat(np.array([_steps(sender) for sender in senders]), n, axis=0)
    u = np.repeat([round(abs(sender.v) / 0.02) * 0.02 for sender in senders], n)
    cap, x = np.maximum(SPEED_LIMIT, u), np.zeros(len(u))
    driven = np.zeros((h.shape[1] + 1, len(u)))
    for k, (rate, step) in enumerate(zip(rates.T, h.T, strict=True)):
        then = np.minimum(np.maximum(u + rate * step, 0.0), cap)
        x += 0.5 * (u + then) * step
        u = then
        driven[k + 1] = x
    return np.split(driven[_BEFORE:].T, len(senders))


def _motions(decided: Decided, i: int, road: Road, driven: Array, rng: np.random.Generator) -> Motions:
    """Motions along the lane, from anywhere within two sigma; sideways at most as reported."""
    sender, remote, n = decided.case.senders[i], decided.remotes[name_of(i)], len(driven)
    mixed = np.arange(n) % 3 == 0
    along = np.where(mixed, sender.along, rng.choice((-1.0, 1.0), n))
    across = np.where(mixed, sender.across, rng.choice((-1.0, 1.0), n))
    aside = np.where(np.arange(n) % 2 == 0, 1.0, rng.uniform(0.0, 1.0, n))
    grid = np.arange(-700.0, 3300.0, 2.0)
    lane = grid - sender.d * (np.unwrap(road.path.heading(grid)) - float(road.path.heading(sender.s)))
    begin = np.interp(sender.s, grid, lane) + along * 2.0 * remote.sigma_along
    s = np.interp(begin[:, None] + math.copysign(1.0, sender.v) * driven, lane, grid)
    at, now = (float(x) for x in road.path.project((remote.x, remote.y), sender.s))
    angle = remote.psi - float(road.path.heading(at))
    v_d = remote.v_x * math.sin(angle)
    stop = abs(_lateral_stop(now, v_d, road)) if abs(v_d) >= _SIDE_SPEED else 0.0
    moved = np.clip(v_d * T, -stop, stop)
    d = now + across[:, None] * 2.0 * remote.sigma_across + aside[:, None] * moved
    return Motions(s=s, d=d, angle=angle)


def _lateral_stop(d: float, v_d: float, road: Road) -> float:
    """Lateral distance up to which a vehicle is expected to move: the middle of the next lane, or 1.5 s."""
    side = math.copysign(1.0, v_d)
    ahead = [(lane.d - d) * side for lane in road.lanes if (lane.d - d) * side > 0.2]
    return min(ahead) if ahead else 1.5 * abs(v_d)


def _may_react(sender: Sender, road: Road) -> bool:
    """Whether a vehicle drives in the ego's direction beside the ego lane."""
    lane, half = road.ego_lane, 0.5 * sender.width
    return sender.v >= 0.0 and (sender.d - half > lane.left - 0.6 or sender.d + half < lane.right + 0.6)


def _excluded(found: Motions, sender: Sender, road: Road, ride: Ride, *, reacts: bool) -> Mask:
    """Where a touch is the other's fault: it was behind the ego and had to keep its distance."""
    k = np.arange(len(T))
    ends = found.s + 0.5 * sender.length
    rear = ride.s + CAR.box_offset - 0.5 * CAR.length
    excluded = np.zeros(found.s.shape, dtype=bool)
    if sender.v < 0.0:
        return excluded
    delay = round(DUTY_DELAY / STEP) if ride.back else 0
    behind = ends[:, ride.back] < rear[ride.back]
    excluded |= behind[:, None] & (k >= ride.back + delay)
    if reacts and ride.out[0]:  # it follows an ego that is in its lane
        lanes = [lane for lane in road.lanes if _overlap(ride.d[0], CAR.width, lane.d, lane.width)]
        follows = any(_overlap(sender.d, sender.width, lane.d, lane.width) for lane in lanes)
        excluded |= (follows & (ends[:, 0] < rear[0]))[:, None]
    elif reacts and ride.back and _may_react(sender, road):
        begin = ride.begins if sender.v > ride.v[0] else ride.enters
        excluded |= (ends[:, begin] < rear[begin])[:, None] & (k >= begin + round(1.5 / STEP))
    return excluded


def _overlap(d: float, width: float, at: float, span: float) -> bool:
    return abs(d - at) < 0.5 * (width + span) - INSIDE

"""Last known vehicles: one that is not reported any more may still be there."""

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from cca_core.frenet import FrenetVehicle
from cca_core.frenet.convert import NO_VEHICLE
from cca_core.geometry import box_gap, boxes
from cca_core.planner.tuning import DecisionSettings
from cca_core.predict import predict_ctra
from cca_core.vehicle import MAX_SPEED, STALE_AGE, STANDSTILL_SPEED, RemoteVehicle

__all__ = ["Known", "Memory", "dead_reckoned", "recall"]

_BRAKING, _LATERAL = 8.0, 1.0  # assumed of a stale vehicle, as in the bounds of a tracker [m/s^2]
_MAX_SIGMA, _MAX_AGE, _MAX_REVERSING = 1e3, 3600.0, 20.0  # of a valid record [m, s, m/s]
_SAME_HEADING = 2e-3  # error of a heading that is dead-reckoned at a constant turn rate [rad]
_FORMER_TIME = 3.0  # for which a vehicle that is forgotten can be recognized [s]
_SAME_BODY = 0.3  # gap to a dead-reckoned body below which another id is that of the same vehicle [m]


class Known(NamedTuple):
    """Last report of a vehicle, since when it is known, and whether it was once in a complete list.

    And its lateral offset and heading as last measured, without what is dead-reckoned since then, and the
    heading of the report before.
    """

    remote: RemoteVehicle
    t: float
    since: float
    confirmed: bool
    d: float
    angle: float
    measured: float  # time of `d` and `angle`
    before: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """Vehicles by id, now and in the last seconds; since when and up to when the list may lack vehicles."""

    known: Mapping[str, Known] = field(default_factory=dict)
    former: Mapping[str, Known] = field(default_factory=dict)
    blind_since: float | None = None
    listen_until: float = -math.inf

    def on_other_route(self) -> "Memory":
        """Return what is still true on another route: not the offsets."""
        known = {name: last._replace(d=math.nan) for name, last in self.known.items()}
        return replace(self, known=known, former={})

    def is_listening(self, t: float) -> bool:
        """Return whether vehicles may be unknown, also because the ego has not heard for long enough."""
        return self.blind_since is not None or t < self.listen_until


def recall(
    memory: Memory,
    t: float,
    vehicles: Sequence[FrenetVehicle],
    dropped: Sequence[tuple[str, str]],
    settings: DecisionSettings,
    *,
    lost: bool,
    blind: bool,
) -> tuple[Memory, list[RemoteVehicle], tuple[str, ...]]:
    """Return what is known now, the vehicles missing from a cycle, dead-reckoned, and what is assumed."""
    # lost: there is no complete list; blind: the list may lack vehicles
    known, blind = memory.known, lost or blind
    since, listen_until = None, memory.listen_until
    if blind:  # the ego has to hear as long as it was blind, at most a second
        since = t if memory.blind_since is None else memory.blind_since
        listen_until = t + min(t - since, STALE_AGE)
    now: dict[str, Known] = {}
    for n in vehicles:
        remote = n.remote
        last = known.get(remote.id)
        if last is None:
            known_since = _since(memory.former, remote, t)
            now[remote.id] = Known(remote, t, known_since, not blind, n.d, n.angle, t, n.angle)
            continue
        d, angle, measured, before = n.d, n.angle, t, last.angle
        if _is_same_report(last, remote, t):  # it has only grown older
            d, angle, measured, before = last[4:]
        now[remote.id] = Known(remote, t, last.since, not blind or last.confirmed, d, angle, measured, before)
    memory = Memory(known=now, former=memory.former, blind_since=since, listen_until=listen_until)
    faults = []
    if not blind and memory.is_listening(t):
        faults.append("other vehicles may be unknown: just heard again; awareness range 0 m")
    missing: dict[str, Known] = {}
    if not known.keys() <= now.keys():
        missing = _missing(known, memory, t, dropped, settings, lost=lost)
        if missing:
            gap = t - min(last.t for last in missing.values())
            faults.append(f"{', '.join(list(missing)[:5])} not reported for {gap:.1f} s; dead-reckoned")
        missing |= _coasting(known, t, now, missing, settings)
        memory = replace(memory, former=_former(memory.former, known, missing.keys() | now.keys(), t))
    if not missing:
        return memory, [], tuple(faults)
    recalled = [dead_reckoned(last.remote, t - last.t) for last in missing.values()]
    return replace(memory, known=missing | now), recalled, tuple(faults)


def _former(
    former: Mapping[str, Known], known: Mapping[str, Known], still: Set[str], t: float
) -> dict[str, Known]:
    """Return the vehicles that have been forgotten in the last seconds."""
    return {
        name: last for name, last in (*former.items(), *known.items())
        if name not in still and t - last.t <= _FORMER_TIME
    }  # fmt: skip


def _since(former: Mapping[str, Known], remote: RemoteVehicle, t: float) -> float:
    """Return since when a vehicle is known that is new in the list: longer if it was only not reported."""
    last = former.get(remote.id)
    if last is None or t - last.t > _FORMER_TIME:
        return t
    return last.since if _is_same_body(dead_reckoned(last.remote, t - last.t), remote) else t


def _is_same_report(last: Known, remote: RemoteVehicle, t: float) -> bool:
    """Return whether a report is the last one, dead-reckoned: measured at the same time, with its turn."""
    elapsed, before = t - last.t, last.remote
    turned = math.remainder(remote.psi - before.psi, 2.0 * math.pi)
    is_as_old = 0.5 * elapsed < remote.age - before.age < 1.5 * elapsed
    return is_as_old and min(abs(turned), abs(turned - before.r * elapsed)) < _SAME_HEADING


def _missing(
    known: Mapping[str, Known],
    memory: Memory,
    t: float,
    dropped: Sequence[tuple[str, str]],
    settings: DecisionSettings,
    *,
    lost: bool,
) -> dict[str, Known]:
    """Return the known vehicles that are not reported because list, record or radio failed."""
    gone = {name: last for name, last in known.items() if name not in memory.known}
    if lost:  # nothing is forgotten while nothing is known
        return gone
    labels = {label for label, _ in dropped}
    any_of_them = memory.is_listening(t) or any(reason == NO_VEHICLE for _, reason in dropped)
    just_back = memory.blind_since is None and memory.is_listening(t)
    return {
        name: last
        for name, last in gone.items()
        if (any_of_them or name[:20] in labels)
        and (just_back or t - last.t <= (settings.memory_time if last.confirmed else STALE_AGE))
    }


def _coasting(
    known: Mapping[str, Known],
    t: float,
    now: dict[str, Known],
    missing: Mapping[str, Known],
    settings: DecisionSettings,
) -> dict[str, Known]:
    """Return the vehicles that a complete list lacks, for a fraction of the time for which they were known.

    One that is reported under another id does not coast; the other id inherits the time.
    """
    coasting = {}
    for name, last in known.items():
        elapsed, limit = t - last.t, settings.coast_fraction * (last.t - last.since)
        if name in now or name in missing or not elapsed <= min(limit, settings.max_coast_time):
            continue
        moved = dead_reckoned(last.remote, elapsed)
        heir = next((other for other, new in now.items() if _is_same_body(moved, new.remote)), None)
        if heir is None:
            coasting[name] = last
        else:
            now[heir] = now[heir]._replace(since=min(now[heir].since, last.since))
    return coasting


def dead_reckoned(remote: RemoteVehicle, time: float) -> RemoteVehicle:
    """Return a vehicle after a time without report [s]: CTRA up to an age of 1 s, then straight."""
    measured = remote.v_x - remote.a_x * min(remote.age, STALE_AGE)
    turning = min(time, max(STALE_AGE - remote.age, 0.0))
    x, y, psi = map(float, predict_ctra(remote, turning))
    v = remote.v_x + remote.a_x * turning
    if v * remote.v_x < 0.0 or (remote.v_x == 0.0 and v < 0.0):  # it has braked to standstill
        v = 0.0
    v = min(max(v, -_MAX_REVERSING), MAX_SPEED)
    straight = v * (time - turning)
    age, stale = min(remote.age + time, _MAX_AGE), remote.age + time > STALE_AGE
    before, after = (max(each - STALE_AGE, 0.0) for each in (remote.age, age))
    limit = max(abs(measured), STANDSTILL_SPEED)
    sigmas = (
        min(sigma + 0.5 * (_growth(a, after, limit) - _growth(a, before, limit)), _MAX_SIGMA)
        for sigma, a in ((remote.sigma_along, _BRAKING), (remote.sigma_across, _LATERAL))
    )
    along, across = sigmas
    return replace(
        remote, x=x + straight * math.cos(psi), y=y + straight * math.sin(psi), psi=psi, v_x=v,
        # the bounds need to know the measured speed, see `reachable_interval`
        a_x=(v - measured) / STALE_AGE if stale else remote.a_x, r=0.0 if stale else remote.r,
        age=age, sigma_along=along, sigma_across=across,
    )  # fmt: skip


def _growth(a: float, late: float, speed: float) -> float:
    """Growth of a bound in the time beyond 1 s [m]."""
    return min(0.5 * a * late * late, speed * late)


def _is_same_body(a: RemoteVehicle, b: RemoteVehicle) -> bool:
    """Return whether two bodies cannot be there at once."""
    if math.hypot(a.x - b.x, a.y - b.y) > a.length + b.length:
        return False
    body_a, body_b = (boxes(n.x, n.y, n.psi, n.length, n.width) for n in (a, b))
    return float(box_gap(body_a, body_b)) < _SAME_BODY

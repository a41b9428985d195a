"""Last known vehicles, for cycles whose list of vehicles is missing, incomplete or not to be trusted."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from cca_core.frenet import FrenetVehicle
from cca_core.frenet.convert import NO_VEHICLE
from cca_core.predict import predict_ctra
from cca_core.vehicle import MAX_SPEED, STALE_AGE, STANDSTILL_SPEED, RemoteVehicle

__all__ = ["LastKnown"]

_BRAKING, _LATERAL = 8.0, 1.0  # assumed of a stale vehicle, as in the bounds of a tracker [m/s^2]
_MAX_SIGMA, _MAX_AGE, _MAX_REVERSING = 1e3, 3600.0, 20.0  # of a valid record [m, s, m/s]


class _Known(NamedTuple):
    """Record of a vehicle, its time [s], and whether it was once in a complete list."""

    t: float
    remote: RemoteVehicle
    confirmed: bool


class LastKnown:
    """Vehicles as last reported: one that is not reported any more may still be there."""

    def __init__(self, memory_time: float) -> None:
        self._memory_time = memory_time
        self._known: dict[str, _Known] = {}
        self._blind_since: float | None = None
        self._listen_until = -math.inf

    def is_listening(self, t: float) -> bool:
        """Return whether vehicles may be unknown, also because the ego has not heard for long enough."""
        return self._blind_since is not None or t < self._listen_until

    def recall(
        self,
        t: float,
        vehicles: Sequence[FrenetVehicle],
        dropped: Sequence[tuple[str, str]],
        *,
        lost: bool,
        blind: bool,
    ) -> tuple[list[RemoteVehicle], tuple[str, ...]]:
        """Return the vehicles that are missing from a cycle, dead-reckoned, and what is assumed."""
        # lost: there is no complete list; blind: the list may lack vehicles
        blind, faults = lost or blind, []
        if blind:  # the ego has to hear as long as it was blind, at most a second
            self._blind_since = t if self._blind_since is None else self._blind_since
            self._listen_until = t + min(t - self._blind_since, STALE_AGE)
        else:
            self._blind_since = None
            if self.is_listening(t):
                faults.append("other vehicles may be unknown: just heard again; awareness range 0 m")
        now = {
            n.id: _Known(t, n.remote, not blind or (n.id in self._known and self._known[n.id].confirmed))
            for n in vehicles
        }
        missing = self._missing(t, now, dropped, lost=lost)
        self._known = missing | now
        if missing:
            gap = t - min(known.t for known in missing.values())
            faults.append(f"{', '.join(list(missing)[:5])} not reported for {gap:.1f} s; dead-reckoned")
        return [dead_reckoned(known.remote, t - known.t) for known in missing.values()], tuple(faults)

    def _missing(
        self, t: float, now: dict[str, _Known], dropped: Sequence[tuple[str, str]], *, lost: bool
    ) -> dict[str, _Known]:
        """Return the known vehicles that are not reported, but may be there."""
        if self._known.keys() <= now.keys():
            return {}
        if lost:  # nothing is forgotten while nothing is known
            return {name: known for name, known in self._known.items() if name not in now}
        labels = {label for label, _ in dropped}
        any_of_them = self.is_listening(t) or any(reason == NO_VEHICLE for _, reason in dropped)
        just_back = self._blind_since is None and self.is_listening(t)
        return {
            name: known
            for name, known in self._known.items()
            if name not in now
            and (any_of_them or name[:20] in labels)
            and (just_back or t - known.t <= (self._memory_time if known.confirmed else STALE_AGE))
        }


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

"""Coasting: vehicles whose reports have just ended are still there for a while."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from cca_core.frenet import FrenetVehicle
from cca_core.geometry import box_gap, boxes
from cca_core.predict import predict_ctra
from cca_core.vehicle import RemoteVehicle


@dataclass(frozen=True, slots=True, kw_only=True)
class Known:
    """The last report of a vehicle, and since when it is known."""

    remote: RemoteVehicle
    t: float
    since: float


def coast(
    known: Mapping[str, Known], vehicles: Sequence[FrenetVehicle], t: float, fraction: float, max_time: float
) -> tuple[dict[str, Known], list[RemoteVehicle]]:
    """Return what is known now, and the vehicles that are no longer reported, dead-reckoned.

    A vehicle coasts for a fraction of the time for which it has been known. One that is reported under
    another id does not.
    """
    reported = {n.id: n.remote for n in vehicles}
    now = {
        name: Known(remote=remote, t=t, since=known[name].since if name in known else t)
        for name, remote in reported.items()
    }
    coasting = []
    for name, old in known.items():
        elapsed = t - old.t
        if name in now or not 0.0 < elapsed <= min(fraction * (old.t - old.since), max_time):
            continue
        moved = _moved(old.remote, elapsed)
        heir = next((other for other in reported.values() if _overlap(moved, other)), None)
        if heir is not None:
            now[heir.id] = replace(now[heir.id], since=min(now[heir.id].since, old.since))
            continue
        now[name] = old
        coasting.append(moved)
    return now, coasting


def _moved(remote: RemoteVehicle, elapsed: float) -> RemoteVehicle:
    x, y, psi = (float(value) for value in predict_ctra(remote, elapsed))
    v = remote.v_x + remote.a_x * elapsed
    if remote.a_x * remote.v_x < 0.0 and v * remote.v_x <= 0.0:
        v = 0.0
    return replace(remote, x=x, y=y, psi=psi, v_x=v, age=remote.age + elapsed)


def _overlap(a: RemoteVehicle, b: RemoteVehicle) -> bool:
    if math.hypot(a.x - b.x, a.y - b.y) > a.length + b.length:
        return False
    body_a, body_b = (boxes(r.x, r.y, r.psi, r.length, r.width) for r in (a, b))
    return float(box_gap(body_a, body_b)) < 0.3

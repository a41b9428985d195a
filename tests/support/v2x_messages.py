"""Messages of a car that drives along +x, for the tests of the tracker."""

from typing import Any

from cca_core import LocalFrame
from cca_core.v2x import Bsm, Tracker

FRAME = LocalFrame(41.0, -104.0)
T0 = 6000.0


def bsm(
    t: float, x: float = 0.0, y: float = 0.0, *, v: float = 20.0, n: int | None = None, **more: Any
) -> Bsm:
    """Message of a car at a position, measured at `t`, heading along +x."""
    lat, lon = FRAME.to_geodetic((x, y))
    values: dict[str, Any] = {
        "msg_count": round(t * 10.0) % 128 if n is None else n, "id": "00000001", "sec_mark": t % 60.0,
        "latitude_deg": float(lat), "longitude_deg": float(lon), "speed": v, "psi": 0.0, "a_x": 0.0, "r": 0.0,
        "length": 4.5, "width": 1.8,
    }  # fmt: skip
    return Bsm(**(values | more))


def feed(tracker: Tracker, seconds: float, *, t: float = T0, v: float = 20.0, **more: Any) -> float:
    """Feed a tracker 10 Hz messages of a car at constant speed; return the time of the last."""
    n = round(10 * seconds)
    for k in range(n + 1):
        at = t + 0.1 * k
        assert tracker.update(bsm(at, v * 0.1 * k, v=v, **more), at + 0.02).accepted
    return t + 0.1 * n

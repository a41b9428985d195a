"""Run times of the tracker, scaled by a reference timed in the same run; `make bench`."""

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from cca_core import LocalFrame, VehicleState
from cca_core.v2x import Bsm, Tracker, encode_bsm
from tests.bench.timing import Budget, median_us

FRAME = LocalFrame(41.0, -104.0)
EGO = VehicleState(x=0.0, y=-3.5, psi=0.0, v_x=20.0)  # no car of the messages is in its place
N, T0 = 100, 6000.0
Report = Callable[[str, object], None]


def _messages(t: float, senders: range) -> list[bytes]:
    """Messages of cars on four lanes, 40 m apart, that drive along +x at 20 m/s."""
    i = np.arange(senders.start, senders.stop)
    xy = np.column_stack((40.0 * (i // 4) + 20.0 * (t - T0), 3.5 * (i % 4)))
    lat, lon = FRAME.to_geodetic(xy)
    return [
        encode_bsm(
            Bsm(
                msg_count=round(10.0 * t) % 128, id=f"{k:08x}", sec_mark=round(t % 60.0, 3) % 60.0,
                latitude_deg=a, longitude_deg=o, speed=20.0, psi=0.0, a_x=0.0, r=0.0,
                length=4.5, width=1.8,
            )
        )
        for k, a, o in zip(i.tolist(), lat.tolist(), lon.tolist(), strict=True)
    ]  # fmt: skip


@pytest.mark.parametrize(("received", "limit_ms"), [(20, 2.0), (100, 4.0)])
def test_update_and_query(
    slowness: float, budget: Budget, record_property: Report, received: int, limit_ms: float
) -> None:
    """100 vehicles at 10 Hz: a cycle of 20 ms receives 20 messages, or in the worst case all of them."""
    rounds = 120
    parts = [range(k, k + received) for k in range(0, N, received)]
    times = [T0 + 0.1 * (1 + k // len(parts)) for k in range(rounds + 1)]
    cycles: Iterator[tuple[float, list[bytes]]] = iter(
        [(t, _messages(t, parts[k % len(parts)])) for k, t in enumerate(times)]
    )
    tracker = Tracker(FRAME)
    for data in _messages(T0, range(N)):
        tracker.update(data, T0)

    def cycle() -> None:
        t, messages = next(cycles)
        for data in messages:
            tracker.update(data, t + 0.02)
        assert len(tracker.vehicles(t + 0.02, EGO)) == N

    took = median_us(cycle, rounds)
    record_property("us", round(took))
    assert set(tracker.counts) == {"new", "updated"}
    budget(1e-3 * took, "ms", max_value=limit_ms * slowness)


def test_sybil_flood(slowness: float, budget: Budget, record_property: Report) -> None:
    """0.1 s of an attack with 1000 ids at 10 Hz."""
    tracker = Tracker(FRAME)
    tracker.vehicles(T0, EGO)
    batches = iter([_messages(T0 + 0.1 * k, range(1000)) for k in range(7)])
    t = T0

    def tenth() -> None:
        nonlocal t
        for data in next(batches):
            tracker.update(data, t + 0.02)
        assert len(tracker.vehicles(t + 0.02, EGO)) == 200
        t += 0.1

    took = median_us(tenth, 5)
    record_property("us", round(took))
    budget(1e-3 * took, "ms", max_value=60.0 * slowness)

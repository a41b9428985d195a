"""Run times of messages, scaled by a reference timed in the same run; `make bench`."""

import contextlib
from functools import partial
from typing import Any

import numpy as np

from cca_core.errors import InputError
from cca_core.v2x import decode_bsm, encode_bsm
from tests.bench.timing import Budget, median_us
from tests.support import asn1_peer as peer
from tests.support.spoiled_frames import spoiled_frames

_COUNT = 200  # calls per measurement


def frames(count: int) -> list[bytes]:
    """Messages of many senders, every second one with event flags."""
    rng = np.random.default_rng(0)
    flags = [int(rng.integers(1, 1 << 13)) if i % 2 else 0 for i in range(count)]
    return [peer.message(peer.random_core(rng), [peer.event_part(f)] if f else None) for f in flags]


def test_decode(benchmark: Any, slowness: float, budget: Budget) -> None:
    data = frames(_COUNT)
    benchmark(lambda: [decode_bsm(frame) for frame in data])
    budget(1e6 * benchmark.stats.stats.min / _COUNT, "µs per message", max_value=15.0 * 1.3 * slowness)


def test_encode(benchmark: Any, slowness: float, budget: Budget) -> None:
    messages = [decode_bsm(frame) for frame in frames(_COUNT)]
    benchmark(lambda: [encode_bsm(message) for message in messages])
    budget(1e6 * benchmark.stats.stats.min / _COUNT, "µs per message", max_value=20.0 * 1.3 * slowness)


def test_slowest_spoiled_frame(slowness: float, budget: Budget) -> None:
    """The slowest of 20 000 random, truncated, altered and joined frames."""

    def decode(data: bytes) -> None:
        with contextlib.suppress(InputError):
            decode_bsm(data)

    # the best of five: the machine may pause
    slowest = max(
        min(median_us(partial(decode, data), 1) for _ in range(5)) for data in spoiled_frames(0, 20_000)
    )
    budget(slowest, "µs", max_value=1000.0 * slowness)

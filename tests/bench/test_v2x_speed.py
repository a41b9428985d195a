"""Run times of messages, scaled by a reference timed in the same run; `make bench`."""

from typing import Any

import numpy as np

from cca_core.v2x import decode_bsm, encode_bsm
from tests.bench.conftest import median_us
from tests.v2x import peer

_ROUNDS = 200  # calls that are timed together


def frames(count: int) -> list[bytes]:
    """Messages of many senders, every second one with event flags."""
    rng = np.random.default_rng(0)
    flags = [int(rng.integers(1, 1 << 13)) if i % 2 else 0 for i in range(count)]
    return [peer.message(peer.random_core(rng), [peer.event_part(f)] if f else None) for f in flags]


def test_decode(benchmark: Any, slowness: float) -> None:
    data = frames(_ROUNDS)
    benchmark(lambda: [decode_bsm(frame) for frame in data])
    each = median_us(lambda: [decode_bsm(frame) for frame in data], 20) / _ROUNDS
    assert each < 15.0 * 1.3 * slowness


def test_encode(benchmark: Any, slowness: float) -> None:
    messages = [decode_bsm(frame) for frame in frames(_ROUNDS)]
    benchmark(lambda: [encode_bsm(message) for message in messages])
    each = median_us(lambda: [encode_bsm(message) for message in messages], 20) / _ROUNDS
    assert each < 20.0 * 1.3 * slowness

"""Frames of messages, whole and spoiled."""

from collections.abc import Iterator

import numpy as np

from cca_core.v2x import Bsm, encode_bsm
from cca_core.v2x.events import EVENTS
from tests.support import asn1_peer as peer


def whole_frames(rng: np.random.Generator) -> list[bytes]:
    """Frames of all kinds: short and long, with and without events, other parts and regional content."""
    frames = [encode_bsm(Bsm(msg_count=1, id="00c0ffee", events=frozenset(EVENTS[:n]))) for n in range(15)]
    for i in range(60):
        parts = [{"kind": int(rng.integers(3)), "content": b"\x01" + rng.bytes(30 * i)} for _ in range(i % 9)]
        regional = [{"kind": 1, "content": rng.bytes(i)}] * (i % 4)
        frames.append(peer.message(peer.random_core(rng), parts, regional))
    return frames


def spoiled_frames(seed: int, count: int) -> Iterator[bytes]:
    """Random, truncated, bit-flipped and spliced frames."""
    rng = np.random.default_rng(seed)
    whole = whole_frames(rng)
    for i in range(count):
        frame, other = whole[rng.integers(len(whole))], whole[rng.integers(len(whole))]
        cut = int(rng.integers(len(frame) + 1))
        match i % 6:
            case 0:
                yield rng.bytes(int(rng.integers(300)))
            case 1:
                body = rng.bytes(int(rng.integers(37, 127)))
                yield bytes((0, 20, len(body))) + body
            case 2:
                yield frame[:cut]
            case 3:
                flipped = bytearray(frame)
                for bit in rng.integers(8 * len(frame), size=rng.integers(1, 9)):
                    flipped[bit // 8] ^= 1 << bit % 8
                yield bytes(flipped)
            case 4:
                yield frame[:cut] + other[cut:]
            case _:
                yield frame[:40] + rng.bytes(int(rng.integers(len(frame))))

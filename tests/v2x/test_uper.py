"""Packed encoding: round trips, skipped parts, and bounded work on garbage."""

import os
import sys
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core.errors import InputError
from cca_core.v2x import Bsm, decode_bsm, encode_bsm
from cca_core.v2x.events import EVENTS, decode_events, encode_events
from cca_core.v2x.uper import BitFields, close_frame, open_frame, open_type, take, take_open_type
from tests.support import asn1_peer as peer
from tests.support.spoiled_frames import spoiled_frames

FULL = os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full"
FRAMES = 1_000_000 if FULL else 20_000


@given(fields=st.lists(st.integers(1, 64).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, 2**n - 1)))))
def test_fields_round_trip(fields: list[tuple[int, int]]) -> None:
    layout = BitFields([width for width, _ in fields])
    codes = [code for _, code in fields]
    assert layout.unpack(layout.pack(codes)) == codes
    assert layout.n_bits == sum(width for width, _ in fields)


def test_first_field_has_highest_bits() -> None:
    assert BitFields([1, 3, 4]).pack([1, 2, 3]) == 0b1_010_0011


@pytest.mark.parametrize("width", [1, 7, 8, 9, 1016])
def test_open_type_round_trip(width: int) -> None:
    content = (1 << width) - 1
    bits, n_bits = open_type(content, width)
    found, found_bits, left = take_open_type(bits, n_bits)
    assert (found >> found_bits - width, left) == (content, 0)
    assert found_bits == 8 * ((width + 7) // 8)


def test_long_open_type() -> None:
    content = b"\x55" * 300
    bits = int.from_bytes(b"\x81\x2c" + content + b"\x07", "big")
    assert take_open_type(bits, 8 * 303) == (int.from_bytes(content, "big"), 2400, 8)


def test_missing_bits_raise() -> None:
    with pytest.raises(InputError, match="ended 3 bits too early"):
        take(0, 2, 5)
    with pytest.raises(InputError, match="fragmented"):
        take_open_type(0xC1 << 8, 16)


@pytest.mark.parametrize("length", [0, 1, 127])
def test_frame_round_trip(length: int) -> None:
    body = bytes(range(length))
    data = close_frame(int.from_bytes(body, "big"), 8 * length, 20)
    assert open_frame(data, 20) == body
    assert open_frame(bytearray(data + b"more"), 20) == body
    assert open_frame(b"\x80" + data[1:], 20) == body  # with later additions


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\0",
        b"\0\x14",
        b"\0\x14\x80",
        b"\0\x14\xc1\0",
        b"\0\x14\x05abcd",
        b"\0\x13\x01a",
        b"\0\x14\x80\x05abcd",
    ],
)
def test_invalid_frame_raises(data: bytes) -> None:
    with pytest.raises(InputError, match="data must hold"):
        open_frame(data, 20)


@pytest.mark.parametrize("data", [None, 20, [0, 20, 0], memoryview(b"\0\x14\0")])
def test_non_bytes_raises(data: object) -> None:
    with pytest.raises(InputError, match="data must be bytes"):
        decode_bsm(data)  # type: ignore[arg-type]


@given(events=st.frozensets(st.sampled_from(EVENTS), min_size=1))
def test_events_round_trip(events: frozenset[str]) -> None:
    assert decode_events(*encode_events(events)) == events


def test_hard_braking_is_the_eighth_flag() -> None:
    bits, n_bits = encode_events({"hard_braking"})
    assert (bits & 0xFFFFFF, n_bits) == (0x400400, 3 + 6 + 8 + 24)


def test_flags_without_name_are_ignored() -> None:
    content = (0b01000_1 << 8 | 40) << 40 | 1 << 39 | 1  # forty flags, the first and the last are set
    bits, n_bits = open_type(content, 54)
    assert decode_events(bits, 9 + n_bits) == {"hazard_lights"}


def test_events_in_two_parts_are_joined() -> None:
    core = peer.random_core(np.random.default_rng(0))
    parts = [peer.event_part(1 << 12), {"kind": 2, "content": b"\xff" * 130}, peer.event_part(1 << 5)]
    assert decode_bsm(peer.message(core, parts)).events == {"hazard_lights", "hard_braking"}


@pytest.mark.parametrize("content", [b"", b"\x40", b"\x44\x20", b"\x46\x00\x00"])
def test_invalid_event_part_raises(content: bytes) -> None:
    core = peer.random_core(np.random.default_rng(0))
    with pytest.raises(InputError, match="data must"):
        decode_bsm(peer.message(core, [{"kind": 0, "content": content}]))


OUTSIDE = {"lat": 2**31 - 1, "long": 2**32 - 1, "heading": 28801, "angle": 254, "accelLong": 4002,
           "accelLat": 4002, "accelVert": 255, "yaw": 65535, "boost": 3}  # fmt: skip
WIDTHS = {
    "msgCnt": 7, "id": 32, "secMark": 16, "lat": 31, "long": 32, "elev": 16, "semiMajor": 8, "semiMinor": 8,
    "orientation": 16, "transmission": 3, "speed": 13, "heading": 15, "angle": 8, "accelLong": 12,
    "accelLat": 12, "accelVert": 8, "yaw": 16, "wheels": 5, "traction": 2, "abs": 2, "scs": 2, "boost": 2,
    "aux": 2, "width": 10, "length": 12,
}  # fmt: skip


@pytest.mark.parametrize("name", OUTSIDE)
def test_code_outside_range_raises(name: str) -> None:
    codes = dict.fromkeys(WIDTHS, 0) | {name: OUTSIDE[name]}
    data = close_frame(BitFields(WIDTHS.values()).pack(codes.values()), 293, 20)
    with pytest.raises(InputError, match="within their ranges"):
        decode_bsm(data)


@pytest.mark.parametrize(
    ("name", "code"), [("secMark", 61000), ("secMark", 65534), ("transmission", 4), ("aux", 3)]
)
def test_reserved_codes_are_unavailable(name: str, code: int) -> None:
    codes = dict.fromkeys(WIDTHS, 0) | {name: code}
    bsm = decode_bsm(close_frame(BitFields(WIDTHS.values()).pack(codes.values()), 293, 20))
    found = {"secMark": bsm.sec_mark, "transmission": bsm.transmission, "aux": bsm.brakes.aux}
    assert found[name] is None


def decoded(data: bytes) -> bool:
    try:
        decode_bsm(data)
    except InputError:
        return False
    return True


def calls(data: bytes) -> int:
    """Number of Python and C calls that decoding makes."""
    count = 0

    def profile(frame: object, event: str, arg: object) -> None:
        nonlocal count
        count += event.endswith("call")

    sys.setprofile(profile)
    try:
        decoded(data)
    finally:
        sys.setprofile(None)
    return count


def test_random_bytes_raise_input_error_only() -> None:
    usable = sum(decoded(data) for data in spoiled_frames(0, FRAMES))
    assert 0.02 * FRAMES < usable < 0.9 * FRAMES  # neither all garbage nor all whole


def test_work_of_decoding_is_bounded() -> None:
    """A message has at most 8 parts; each takes a few calls."""
    assert max(calls(data) for data in spoiled_frames(2, FRAMES // 20)) < 400


@pytest.mark.parametrize("length", [100_000, 10_000_000])
def test_work_does_not_grow_with_garbage(length: int) -> None:
    frame = encode_bsm(Bsm(msg_count=1, id="00c0ffee"))
    long = b"\0\x14\xbf\xff" + b"\xff" * length
    for data in (bytes(length), long[2:], long, b"\0\x14" * (length // 2), frame * (length // 40)):
        assert calls(data) < 400
        tracemalloc.start()
        try:
            decoded(data)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
        assert peak < 100_000  # the longest part has 16 kB


def test_garbage_leaves_no_memory() -> None:
    frames = list(spoiled_frames(1, FRAMES // 20))
    for data in frames:
        decoded(data)
    tracemalloc.start()
    try:
        for data in frames[:100]:
            decoded(data)
        before = tracemalloc.get_traced_memory()[0]
        for data in frames:
            decoded(data)
        assert tracemalloc.get_traced_memory()[0] - before < 10_000
    finally:
        tracemalloc.stop()

"""Messages: all values of the format, a second decoder, and invalid values."""

import math
import os
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import LocalFrame
from cca_core.errors import InputError
from cca_core.v2x import BrakeStatus, Bsm, PositionalAccuracy, Tracker, decode_bsm, encode_bsm
from cca_core.v2x.events import EVENTS
from tests.support import asn1_peer as peer
from tests.support.asn1_peer import assert_means, flat

FULL = os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full"
UNITS = {
    "sec_mark": 1e-3, "latitude_deg": 1e-7, "longitude_deg": 1e-7, "elevation": 0.1, "speed": 0.02,
    "psi": math.radians(0.0125), "steering_wheel_angle": math.radians(1.5), "a_x": 0.01, "a_y": 0.01,
    "a_z": 0.02 * 9.80665, "r": math.radians(0.01), "width": 0.01, "length": 0.01,
}  # fmt: skip
LIMITS = {
    "sec_mark": (0.0, 60.999), "latitude_deg": (-90.0, 90.0), "longitude_deg": (-180.0, 180.0),
    "elevation": (-409.5, 6143.9), "speed": (0.0, 163.8),
    "steering_wheel_angle": (-math.radians(189.0), math.radians(189.0)), "a_x": (-20.0, 20.0),
    "a_y": (-20.0, 20.0), "a_z": (-127 * 0.02 * 9.80665, 126 * 0.02 * 9.80665),
    "r": (-math.radians(327.67), math.radians(327.67)), "width": (0.01, 10.23), "length": (0.01, 40.95),
}  # fmt: skip
PLAIN = Bsm(msg_count=0, id="00000000")


@pytest.mark.parametrize("block", range(20))
def test_second_decoder_agrees(block: int) -> None:
    """Both decode the bytes of the other to the same values."""
    rng = np.random.default_rng(block)
    for _ in range(500 if FULL else 15):
        core = peer.random_core(rng)
        flags = int(rng.integers(1 << 13)) if rng.random() < 0.5 else 0
        parts = [
            {"kind": int(rng.integers(1, 64)), "content": rng.bytes(int(rng.integers(1, 200)))}
            for _ in range(rng.integers(4))
        ]
        if flags:
            more = {"history": rng.bytes(9)} if rng.random() < 0.5 else {}
            parts.insert(int(rng.integers(len(parts) + 1)), peer.event_part(flags, more))
        regional = [{"kind": 3, "content": rng.bytes(20)}] if rng.random() < 0.2 else None
        data = peer.message(core, parts, regional)
        assert_means(data, core)
        bsm = decode_bsm(data)
        assert bsm.events == {name for i, name in enumerate(EVENTS[:13]) if flags >> 12 - i & 1}
        again = peer.read(encode_bsm(bsm))
        assert again.pop("flags") == bsm.events
        assert again == core


def test_every_code_round_trip() -> None:
    """Each field through its whole range, the long ones in steps."""
    rng = np.random.default_rng(1)
    core = peer.random_core(rng, absent=0.0)
    names = list(peer.RANGES) if FULL else ["angle", "accelVert", "semiMajor", "transmission", "boost"]
    for name in names:
        low, high = peer.RANGES[name]
        for code in range(low, high + 1, max(1, (high - low) // 3000)):
            assert_means(peer.message(core | {name: code}), core | {name: code})


def reals(name: str) -> st.SearchStrategy[float | None]:
    return st.none() | st.floats(*LIMITS[name])


ANGLES = st.none() | st.floats(-math.pi, math.pi)
SYSTEMS = st.sampled_from([None, "off", "on", "engaged"])
BOOSTS = st.sampled_from([None, "off", "on"])
MESSAGES = st.builds(
    Bsm,
    msg_count=st.integers(0, 127),
    id=st.binary(min_size=4, max_size=4).map(bytes.hex),
    psi=ANGLES,
    accuracy=st.builds(
        PositionalAccuracy,
        semi_major=st.none() | st.floats(0.0, 12.7),
        semi_minor=st.none() | st.floats(0.0, 12.7),
        orientation=ANGLES,
    ),
    transmission=st.sampled_from([None, "neutral", "park", "forward", "reverse"]),
    brakes=st.builds(
        BrakeStatus,
        wheels=st.none() | st.tuples(*[st.booleans()] * 4),
        traction=SYSTEMS, abs=SYSTEMS, scs=SYSTEMS, boost=BOOSTS, aux=BOOSTS,
    ),
    events=st.frozensets(st.sampled_from(EVENTS)),
    **{name: reals(name) for name in LIMITS},
)  # fmt: skip


@given(sent=MESSAGES)
def test_encode_decode_round_trip(sent: Bsm) -> None:
    """Within half a unit at first; exactly once on the grid of the format."""
    received = decode_bsm(encode_bsm(sent))
    units = UNITS | {"semi_major": 0.05, "semi_minor": 0.05, "orientation": math.tau / 65535.0}
    before, after = flat(sent), flat(received)
    before["r"] = before["r"] or 0.0
    for name, unit in units.items():
        assert (before[name] is None) == (after[name] is None)
        if before[name] is not None:
            error = after[name] - before[name]
            turn = math.tau if name in ("psi", "orientation") else 360.0 if name == "longitude_deg" else None
            error = math.remainder(error, turn) if turn else error
            assert abs(error) <= 0.5 * unit * (1.0 + 1e-6)
    for name in before.keys() - units.keys():
        assert after[name] == before[name]
    assert received.events == sent.events
    assert decode_bsm(encode_bsm(received)) == received


@pytest.mark.parametrize("name", LIMITS)
def test_limits_round_trip(name: str) -> None:
    low, high = LIMITS[name]
    for value, outside in ((low, low - 0.51 * UNITS[name]), (high, high + 0.51 * UNITS[name])):
        found = getattr(decode_bsm(encode_bsm(replace(PLAIN, **{name: value}))), name)
        assert abs(found) == pytest.approx(abs(value))  # 180 degrees west is 180 degrees east
        with pytest.raises(InputError, match=name):
            encode_bsm(replace(PLAIN, **{name: outside}))


def test_minimal_message() -> None:
    data = encode_bsm(replace(PLAIN, events=frozenset({"hard_braking"})))
    assert len(encode_bsm(PLAIN)) == 40
    assert len(data) == 45
    assert data[:3].hex() == "00142a"
    assert decode_bsm(encode_bsm(PLAIN)) == replace(PLAIN, r=0.0)


def test_axes() -> None:
    """A left turn heading north-west: values that are negative in the message are positive here."""
    core = {name: 0 for name in peer.RANGES} | {"id": bytes(4), "wheels": b"\0"}
    core |= {"heading": 28800 - 3600, "yaw": -1000, "accelLat": -200, "angle": -20, "accelVert": -50}
    bsm = decode_bsm(peer.message(core))
    assert bsm.psi == pytest.approx(math.radians(135.0))
    assert bsm.r == pytest.approx(math.radians(10.0))
    assert bsm.a_y == 2.0
    assert bsm.steering_wheel_angle == pytest.approx(math.radians(30.0))
    assert bsm.a_z == pytest.approx(9.80665)


def test_heading_is_wrapped() -> None:
    for heading in range(0, 28800, 1 if FULL else 100):
        psi = decode_bsm(encode_bsm(replace(PLAIN, psi=math.radians(90.0 - 0.0125 * heading)))).psi
        assert psi is not None
        assert -math.pi <= psi < math.pi


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("msg_count", 128), ("msg_count", -1), ("msg_count", 1.0), ("msg_count", None), ("id", "0000000G"),
        ("id", "0000000"), ("id", "00 00 00"), ("id", "ABCDEF01"), ("id", b"1234"), ("id", "0000000\n"),
        ("speed", "12"), ("speed", math.nan), ("speed", math.inf), ("speed", [1.0]), ("speed", np.ones(2)),
        ("speed", 1j), ("psi", math.nan), ("psi", math.inf), ("psi", "north"), ("psi", 1j), ("r", 1e300),
        ("transmission", "drive"), ("transmission", ["park"]), ("brakes", None), ("accuracy", 1.0),
        ("brakes", BrakeStatus(wheels=(True, False))), ("brakes", BrakeStatus(wheels=[True])),
        ("brakes", BrakeStatus(traction="yes")), ("brakes", BrakeStatus(boost="engaged")),
        ("accuracy", PositionalAccuracy(semi_major=12.73)), ("accuracy", PositionalAccuracy(orientation="x")),
        ("events", ["hard_braking"]), ("events", "hard_braking"), ("events", {"braking"}), ("events", {1}),
        ("events", None),
    ],
)  # fmt: skip
def test_out_of_range_value_raises(name: str, value: Any) -> None:
    with pytest.raises(InputError):
        encode_bsm(replace(PLAIN, **{name: value}))


def test_encoding_other_types_raises() -> None:
    with pytest.raises(InputError, match="bsm must be"):
        encode_bsm(None)  # type: ignore[arg-type]


class Hostile:
    """A value whose methods raise."""

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        raise RuntimeError

    def __repr__(self) -> str:
        raise RuntimeError

    def __float__(self) -> float:
        raise RuntimeError

    def __mul__(self, other: object) -> float:
        raise RuntimeError


ODD = [
    10**400, 10**5000, -(10**5000), math.nan, math.inf, True, "x", "1.0", b"1", [], [1.0], (1.0,), {}, {1},
    frozenset(), frozenset({"hard_braking"}), frozenset({5}), np.float64(1.0), np.float32(1.5), np.int64(3),
    np.array(1.0), np.array([1.0]), np.array([1.0, 2.0]), np.str_("00c0ffee"), Decimal("1.5"),
    Fraction(1, 3), 1j, int, Hostile(), None, "00c0ffee\n", -1, 128, 2.5, "x" * 10**6,
    PositionalAccuracy(semi_major="x"), BrakeStatus(abs=[]),
]  # fmt: skip
DRIVING = replace(
    PLAIN, sec_mark=7.0, latitude_deg=45.0, longitude_deg=14.0, speed=10.0, psi=0.5, length=4.5, width=1.8
)


def odd_messages(name: str) -> list[Bsm]:
    """Messages with one value of an odd type."""
    for part, kind in (("accuracy", PositionalAccuracy), ("brakes", BrakeStatus)):
        if name in kind.__dataclass_fields__:
            return [replace(DRIVING, **{part: kind(**{name: value})}) for value in ODD]
    return [replace(DRIVING, **{name: value}) for value in ODD]


def error_of_encoding(bsm: Bsm) -> str:
    try:
        encode_bsm(bsm)
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", [*flat(PLAIN), "accuracy", "brakes", "events", "signed"])
def test_odd_values_raise_input_error_or_nothing(name: str) -> None:
    for bsm in odd_messages(name):
        assert len(error_of_encoding(bsm)) < 400
        tracker = Tracker(LocalFrame(45.0, 14.0))
        for i, sent in enumerate((bsm, DRIVING, bsm)):
            tracker.update(sent, 7.0 + 0.1 * i)
            for vehicle in tracker.vehicles(7.05 + 0.1 * i):
                assert type(vehicle.v_x) is float
                assert type(vehicle.events) is frozenset

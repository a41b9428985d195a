"""Second decoder: an ASN.1 compiler and a schema of ranges."""

import math
from functools import cache
from typing import Any

import asn1tools
import numpy as np
import pytest

from cca_core.v2x import Bsm, decode_bsm, encode_bsm

SCHEMA = """
Peer DEFINITIONS AUTOMATIC TAGS ::= BEGIN
Frame ::= SEQUENCE { kind INTEGER (0..32767), body OCTET STRING, ... }
Message ::= SEQUENCE {
    core Core,
    parts SEQUENCE (SIZE (1..8)) OF SEQUENCE { kind INTEGER (0..63), content OCTET STRING } OPTIONAL,
    regional SEQUENCE (SIZE (1..4)) OF SEQUENCE { kind INTEGER (0..255), content OCTET STRING } OPTIONAL,
    ... }
Core ::= SEQUENCE {
    msgCnt INTEGER (0..127), id OCTET STRING (SIZE (4)), secMark INTEGER (0..65535),
    lat INTEGER (-900000000..900000001), long INTEGER (-1799999999..1800000001),
    elev INTEGER (-4096..61439),
    semiMajor INTEGER (0..255), semiMinor INTEGER (0..255), orientation INTEGER (0..65535),
    transmission INTEGER (0..7), speed INTEGER (0..8191), heading INTEGER (0..28800),
    angle INTEGER (-126..127), accelLong INTEGER (-2000..2001), accelLat INTEGER (-2000..2001),
    accelVert INTEGER (-127..127), yaw INTEGER (-32767..32767),
    wheels BIT STRING (SIZE (5)), traction INTEGER (0..3), abs INTEGER (0..3), scs INTEGER (0..3),
    boost INTEGER (0..2), aux INTEGER (0..3), width INTEGER (0..1023), length INTEGER (0..4095) }
Safety ::= SEQUENCE { flags BIT STRING (SIZE (13, ...)) OPTIONAL, history OCTET STRING (SIZE (9)) OPTIONAL,
    prediction OCTET STRING (SIZE (3)) OPTIONAL, lights OCTET STRING (SIZE (2)) OPTIONAL, ... }
END
"""
RANGES = {
    "msgCnt": (0, 127), "secMark": (0, 60999), "lat": (-900000000, 900000000),
    "long": (-1799999999, 1800000000), "elev": (-4095, 61439), "semiMajor": (0, 254), "semiMinor": (0, 254),
    "orientation": (0, 65534), "transmission": (0, 3), "speed": (0, 8190), "heading": (0, 28799),
    "angle": (-126, 126), "accelLong": (-2000, 2000), "accelLat": (-2000, 2000), "accelVert": (-126, 127),
    "yaw": (-32767, 32767), "traction": (1, 3), "abs": (1, 3), "scs": (1, 3), "boost": (1, 2), "aux": (1, 2),
    "width": (1, 1023), "length": (1, 4095),
}  # fmt: skip
ABSENT = {
    "secMark": 65535, "lat": 900000001, "long": 1800000001, "elev": -4096, "semiMajor": 255,
    "semiMinor": 255, "orientation": 65535, "transmission": 7, "speed": 8191, "heading": 28800, "angle": 127,
    "accelLong": 2001, "accelLat": 2001, "accelVert": -127, "traction": 0, "abs": 0, "scs": 0, "boost": 0,
    "aux": 0, "width": 0, "length": 0,
}  # fmt: skip
FLAGS = (
    "hazard_lights stop_line_violation abs_activated traction_control_loss stability_control_activated "
    "hazardous_materials reserved hard_braking lights_changed wipers_changed flat_tire disabled_vehicle "
    "air_bag_deployment"
).split()
SYSTEM = (None, "off", "on", "engaged")


@cache
def compiled() -> Any:
    return asn1tools.compile_string(SCHEMA, "uper")


def random_core(rng: np.random.Generator, absent: float = 0.15) -> dict[str, Any]:
    """Random codes of Part I: in the range, at its ends, or unavailable."""
    core: dict[str, Any] = {}
    for name, (low, high) in RANGES.items():
        draw = rng.random()
        if name in ABSENT and draw < absent:
            core[name] = ABSENT[name]
        elif draw > 0.9:
            core[name] = (low, high)[int(rng.integers(2))]
        else:
            core[name] = int(rng.integers(low, high + 1))
    core["id"] = rng.bytes(4)
    core["wheels"] = b"\x80" if rng.random() < absent else bytes([int(rng.integers(16)) << 3])
    return core


def message(
    core: dict[str, Any],
    parts: list[dict[str, Any]] | None = None,
    regional: list[dict[str, Any]] | None = None,
) -> bytes:
    value: dict[str, Any] = {"core": core | {"wheels": (core["wheels"], 5)}}
    if parts:
        value["parts"] = parts
    if regional:
        value["regional"] = regional
    body = compiled().encode("Message", value)
    return bytes(compiled().encode("Frame", {"kind": 20, "body": body}))


def event_part(flags: int, more: dict[str, bytes] | None = None) -> dict[str, Any]:
    """Part II with 13 flags, the first of them the highest bit."""
    content = compiled().encode("Safety", {"flags": ((flags << 3).to_bytes(2, "big"), 13), **(more or {})})
    return {"kind": 0, "content": content}


def read(data: bytes) -> dict[str, Any]:
    """Decode: codes of Part I, and under ``flags`` the names of the event flags."""
    frame = compiled().decode("Frame", data)
    assert frame["kind"] == 20
    found = compiled().decode("Message", frame["body"])
    core: dict[str, Any] = found["core"]
    core["wheels"] = core["wheels"][0]
    core["flags"] = set()
    for part in found.get("parts", []):
        if part["kind"] == 0:
            flags = compiled().decode("Safety", part["content"]).get("flags", (b"", 0))
            core["flags"] |= {
                name for i, name in enumerate(FLAGS) if i < flags[1] and flags[0][i // 8] << i % 8 & 0x80
            }
    return core


def meaning(core: dict[str, Any]) -> dict[str, Any]:
    """Codes in SI units and ISO 8855 axes, as in the table of the documentation."""

    def scaled(name: str, unit: float) -> float | None:
        return None if core[name] == ABSENT.get(name) else core[name] * unit

    def direction(name: str, step_deg: float) -> float | None:
        turned = scaled(name, step_deg)
        return None if turned is None else math.radians((270.0 - turned) % 360.0 - 180.0)

    gear = {0: "neutral", 1: "park", 2: "forward", 3: "reverse"}
    wheels = core["wheels"][0]
    return {
        "msg_count": core["msgCnt"],
        "id": core["id"].hex(),
        "sec_mark": scaled("secMark", 1e-3),
        "latitude_deg": scaled("lat", 1e-7),
        "longitude_deg": scaled("long", 1e-7),
        "elevation": scaled("elev", 0.1),
        "speed": scaled("speed", 0.02),
        "psi": direction("heading", 0.0125),
        "steering_wheel_angle": scaled("angle", math.radians(-1.5)),
        "a_x": scaled("accelLong", 0.01),
        "a_y": scaled("accelLat", -0.01),
        "a_z": scaled("accelVert", -0.02 * 9.80665),
        "r": scaled("yaw", math.radians(-0.01)),
        "semi_major": scaled("semiMajor", 0.05),
        "semi_minor": scaled("semiMinor", 0.05),
        "orientation": direction("orientation", 360.0 / 65535.0),
        "transmission": gear.get(core["transmission"]),
        "wheels": None if wheels & 0x80 else tuple(bool(wheels & bit) for bit in (0x40, 0x20, 0x10, 8)),
        "traction": SYSTEM[core["traction"]],
        "abs": SYSTEM[core["abs"]],
        "scs": SYSTEM[core["scs"]],
        "boost": SYSTEM[core["boost"]],
        "aux": SYSTEM[core["aux"]],
        "width": scaled("width", 0.01),
        "length": scaled("length", 0.01),
    }


def flat(bsm: Bsm) -> dict[str, Any]:
    parts = (bsm, bsm.accuracy, bsm.brakes)
    return {
        name: getattr(part, name)
        for part in parts
        for name in part.__dataclass_fields__
        if name not in ("accuracy", "brakes", "events", "signed")
    }


def assert_means(data: bytes, core: dict[str, Any]) -> None:
    """Assert that data decode to the meaning of codes, and that Part I encodes to the same bits."""
    bsm = decode_bsm(data)
    found, meant = flat(bsm), meaning(core)
    assert found.keys() == meant.keys()
    for name, value in meant.items():
        same = pytest.approx(value, rel=1e-12, abs=1e-12) if isinstance(value, float) else value
        assert found[name] == same, name
    assert part_one(encode_bsm(bsm)) == part_one(data)


def part_one(data: bytes) -> int:
    begin = 3 if data[2] < 128 else 4
    return int.from_bytes(data[begin : begin + 37], "big") >> 3 & (1 << 290) - 1

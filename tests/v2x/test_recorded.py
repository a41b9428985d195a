"""Recorded messages: each decodes to its recorded values and encodes to the same bits."""

import csv
import json
import math
import re
from pathlib import Path
from typing import Any

import pytest

from cca_core.v2x import decode_bsm, encode_bsm
from tests.support.asn1_peer import assert_means, part_one

ENUMS = {
    "neutral": 0, "park": 1, "forwardGears": 2, "reverseGears": 3, "unavailable": 7,
}  # fmt: skip
XML_NAMES = {"brakeBoost": "boost", "auxBrakes": "aux", "wheelBrakes": "wheels"}


def part_one_of(text: str) -> dict[str, Any]:
    """Codes of Part I from its XML."""
    found = dict(re.findall(r"<(\w+)>\s*([-\w ]+?)\s*</\1>", text))
    found.update(re.findall(r"<(\w+)><(\w+)/></\1>", text))
    codes: dict[str, Any] = {}
    for name, value in found.items():
        name = XML_NAMES.get(name, name)
        if name == "id":
            codes[name] = bytes.fromhex(value)
        elif name == "wheels":
            codes[name] = bytes([int(value, 2) << 3])
        elif name in ("traction", "abs", "scs", "boost", "aux"):
            codes[name] = {"unavailable": 0, "off": 1, "on": 2, "engaged": 3}[value]
        elif name == "transmission":
            codes[name] = ENUMS[value]
        else:
            codes[name] = int(value)
    for short, axis in (("Long", "long"), ("Lat", "lat"), ("Vert", "vert")):
        (acceleration,) = re.findall(rf"<accelSet>.*?<{axis}>(-?\d+)</{axis}>", text, re.DOTALL)
        codes["accel" + short] = int(acceleration)
    ((codes["lat"], codes["long"]),) = (
        map(int, pair) for pair in re.findall(r"<lat>(.*?)</lat>\s*<long>(.*?)</long>", text)
    )
    del codes["vert"]
    return codes


def test_recorded_frames_equal_their_xml(data_dir: Path) -> None:
    data = (data_dir / "bsm" / "j2735.MessageFrame.128.bsms.uper").read_bytes()
    text = (data_dir / "bsm" / "j2735.MessageFrame.128.bsms.xer").read_text()
    cores = re.findall(r"<coreData>(.*?)</coreData>", text, re.DOTALL)
    for core in cores:
        end = 3 + data[2] if data[2] < 128 else 4 + (data[2] & 0x3F) * 256 + data[3]
        frame, data = data[:end], data[end:]
        assert_means(frame, part_one_of(core))
        assert decode_bsm(frame).events == frozenset()
    assert len(cores) == 128
    assert data == b""


def test_recorded_frames_of_several_senders(data_dir: Path) -> None:
    samples = json.loads((data_dir / "bsm" / "samples.json").read_text())["samples"]
    events = []
    for sample in samples:
        raw = sample["core_raw"]
        core = {XML_NAMES.get(name, name): value for name, value in raw.items()}
        core |= {"accel" + axis.title(): raw["accel_" + axis] for axis in ("long", "lat", "vert")}
        core |= {"yaw": raw["accel_yaw"], "id": bytes.fromhex(raw["id"])}
        core["wheels"] = bytes([int(raw["wheelBrakes"], 2) << 3])
        data = bytes.fromhex(sample["hex"])
        assert_means(data, core)
        events.append(decode_bsm(data).events)
    assert len(samples) == 13
    assert events.count(frozenset({"hard_braking"})) == 1
    assert events.count(frozenset({"jackknife"})) == 1


def test_event_flags_recorded_in_xml(data_dir: Path) -> None:
    text = (data_dir / "bsm" / "InputData.decoding.bsm.with.VehicleEventFlags.xml").read_text()
    (found,) = re.findall("<bytes>(.*?)</bytes>", text)
    assert decode_bsm(bytes.fromhex(found)).events == {"hard_braking"}


def test_recorded_drive_round_trip(data_dir: Path) -> None:
    with (data_dir / "bsm" / "wyoming_rx_decoded.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        data = bytes.fromhex(row["uper_hex"])
        bsm = decode_bsm(data)
        assert bsm.msg_count == int(row["msgCnt"])
        assert bsm.sec_mark == int(row["secMark_ms"]) / 1000.0
        found = (
            bsm.latitude_deg, bsm.longitude_deg, bsm.elevation, bsm.speed, bsm.a_x, bsm.accuracy.semi_major,
            bsm.accuracy.semi_minor, bsm.width, bsm.length, -math.degrees(bsm.r or 0.0),
        )  # fmt: skip
        names = (
            "lat_deg", "lon_deg", "elev_m", "speed_mps", "accel_long_mps2", "semiMajor_m", "semiMinor_m",
            "width_m", "length_m", "yaw_dps",
        )  # fmt: skip
        assert found == pytest.approx([float(row[name]) for name in names], rel=1e-12)
        assert bsm.psi is not None
        assert (90.0 - math.degrees(bsm.psi)) % 360.0 == pytest.approx(float(row["heading_deg"]))
        assert part_one(encode_bsm(bsm)) == part_one(data)
    assert len(rows) == 243

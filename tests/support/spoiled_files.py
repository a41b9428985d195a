"""Good files of every format that the library reads, and ways to spoil them."""

import io
import json
import random
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from cca_core.adapters import read_opendrive, read_sumo_net
from cca_core.path import read_waypoints
from cca_core.sim import eebl, load_log, read_bsm_log, read_commonroad, save_log, simulate
from cca_core.sim.study.store import Store
from cca_core.v2x import encode_bsm
from tests.support.commonroad_files import REGION, ROAD, document, goal, moving, problem, state
from tests.support.opendrive_files import crossing
from tests.support.sumo_files import write_net
from tests.support.v2x_messages import bsm


def open_store(path: Path) -> None:
    """Open a store of rows, and close it."""
    with Store(path, "x"):
        pass


def drive_opendrive(path: Path) -> None:
    """Read a map, and make a road of it."""
    read_opendrive(path).find_road(("1", 20.0, -1), ("2", 30.0, 1))


def drive_sumo_net(path: Path) -> None:
    """Read a net, and make a road of it."""
    read_sumo_net(path).road_along(["in", "on", "end"])


def _gpx() -> bytes:
    rows = "".join(
        f'<trkpt lat="{48 + 1e-4 * i}" lon="11"><ele>{i}</ele><time>2024-05-01T10:00:{i:02d}Z</time></trkpt>'
        for i in range(9)
    )
    return f'<?xml version="1.0"?><gpx xmlns="a:b"><trk><trkseg>{rows}</trkseg></trk></gpx>'.encode()


def _kml() -> bytes:
    line = " ".join(f"11,{48 + 1e-4 * i},5" for i in range(9))
    track = "".join(
        f"<when>2024-05-01T10:00:0{i}Z</when><gx:coord>11 {49 + i} 5</gx:coord>" for i in range(5)
    )
    return (
        f"<kml xmlns:gx='a:b'><Placemark><LineString><coordinates>{line}</coordinates></LineString>"
        f"</Placemark><gx:Track>{track}</gx:Track></kml>"
    ).encode()


def _geojson() -> bytes:
    line = [[11.0, 48.0 + 1e-4 * i, 5] for i in range(9)]
    geometries = [
        {"type": "LineString", "coordinates": line},
        {"type": "MultiLineString", "coordinates": [line, line]},
    ]
    features = [{"type": "Feature", "geometry": g, "properties": {"coordTimes": [1] * 9}} for g in geometries]
    return json.dumps({"type": "FeatureCollection", "features": features}).encode()


def _csv() -> bytes:
    return ("time;lat;lon;alt\n" + "".join(f"{i};{48 + 1e-4 * i};11,5;5\n" for i in range(9))).encode()


def _nmea() -> bytes:
    rows = (
        f"$GPGGA,12351{i},480{i}.038,N,01131.000,E,1,08,0.9,5.4,M,46.9,M,,\r\n"
        f"$GPRMC,12351{i},A,480{i}.038,N,01131.000,E,022.4,084.4,230394,003.1,W\r\n"
        for i in range(9)
    )  # fmt: skip
    return "".join(rows).encode()


def _commonroad() -> bytes:
    car = moving(31, [state("state", k, 40.0 + 1.2 * k, 0.0, 12.0) for k in range(5)])
    return document(ROAD, car, problem(goal((80, 100), REGION.format(y=0.0)))).encode()


def _messages(form: str) -> bytes:
    hexes = [encode_bsm(bsm(0.1 * i)).hex() for i in range(4)]
    if form == "json":
        return json.dumps({"samples": [{"hex": h, "t": i} for i, h in enumerate(hexes)]}).encode()
    lines = [json.dumps({"data": h, "t": i}) if form == "jsonl" else f"{i},{h}" for i, h in enumerate(hexes)]
    return "\n".join([*(["t,hex"] if form == "csv" else []), *lines]).encode()


def _log(folder: Path) -> bytes:
    save_log(simulate(eebl("A"), seed=3), folder / "good.npz")
    return (folder / "good.npz").read_bytes()


def _store(folder: Path) -> bytes:
    with Store(folder / "good.db", "x") as store:
        for i in range(20):
            store.add(i, {"value": 0.1 * i, "name": "a"})
    return (folder / "good.db").read_bytes()


def readers(folder: Path) -> dict[str, tuple[str, Callable[[Path], Any], bytes]]:
    """Return the ending, the reader and a good file of every format."""
    return {
        "gpx": (".gpx", read_waypoints, _gpx()),
        "kml": (".kml", read_waypoints, _kml()),
        "geojson": (".geojson", read_waypoints, _geojson()),
        "csv": (".csv", read_waypoints, _csv()),
        "nmea": (".nmea", read_waypoints, _nmea()),
        "commonroad": (".xml", read_commonroad, _commonroad()),
        "opendrive": (".xodr", drive_opendrive, crossing(folder).read_bytes()),
        "sumo": (".net.xml", drive_sumo_net, write_net(folder).read_bytes()),
        "messages": (".txt", read_bsm_log, _messages("lines")),
        "messages-json": (".json", read_bsm_log, _messages("json")),
        "messages-jsonl": (".json", read_bsm_log, _messages("jsonl")),
        "messages-csv": (".csv", read_bsm_log, _messages("csv")),
        "log": (".npz", load_log, _log(folder)),
        "store": (".db", open_store, _store(folder)),
    }


TOKENS = [
    b"1" * 400, b"1" * 5000, b"-1", b"1e400", b"nan", b"inf", b"1_0", "\u0663".encode(), b"", b"\0",
    b"\xff\xfe", b'"', b"'", b"<", b">", b"&a;", b"&#0;", b"<a>" * 200, b"</a>", b"<!DOCTYPE a>", b"<!--",
    b"<![CDATA[", b"[" * 200, b"]", b"{", b"}", b"[" * 100_000, b"null", b"true", b'{"a":', b",", b";", b"\n",
    b"\r", b"\t", b"$", b"*", b"PK\x03\x04", b"\x93NUMPY", b"(" * 300, b"9" * 40, b"2024-13-45T99:99:99Z",
    b"\\", b"\\u", b"\xed\xa0\x80", b"id=\"1\"", b"0.1", b" " * 5000,
]  # fmt: skip


def spoil_elements(data: bytes, rng: random.Random) -> bytes:
    """Return an XML file with one to three elements deleted, repeated, renamed or with other text."""
    root = ElementTree.fromstring(data)
    for _ in range(rng.randint(1, 3)):
        parent = rng.choice([element for element in root.iter() if len(element)] or [root])
        if not len(parent):
            break
        child = rng.choice(list(parent))
        kind = rng.randrange(5)
        if kind == 0:
            parent.remove(child)
        elif kind == 1:
            parent.append(child)
        elif kind == 2:
            child.text = rng.choice(("", "nan", "-inf", "1e400", "-1", "1_0", "\u0663", "x", "1" * 400))
        elif kind == 3:
            child.tag = rng.choice([element.tag for element in root.iter()])
        else:
            child.set(
                rng.choice(("id", "ref", "drivingDir", "lat", "lon")),
                rng.choice(("", "-1", "900", "1e3", "9" * 50)),
            )
    return ElementTree.tostring(root)


def spoil(data: bytes, rng: random.Random) -> bytes:
    """Return a file with one to four changes."""
    for _ in range(rng.randint(1, 4)):
        at, end = sorted(rng.randrange(len(data) + 1) for _ in range(2))
        end = min(end, at + rng.choice((1, 4, 40, 4000)))
        kind = rng.randrange(6)
        if kind == 0:
            data = data[:at] + bytes(rng.randrange(256) for _ in range(min(end - at, 8))) + data[end:]
        elif kind == 1:
            data = data[:at] + data[end:]
        elif kind == 2:
            data = data[:end] + data[at:end] * rng.choice((1, 3)) + data[end:]
        elif kind == 3:
            data = data[:at] + rng.choice(TOKENS) + data[at:]
        elif kind == 4:
            data = data[:at] + rng.choice(TOKENS) + data[end:]
        else:
            data = data[:at] if rng.random() < 0.3 else data[at:end] + data
    return data


def spoil_archive(data: bytes, rng: random.Random) -> bytes:
    """Return an archive with one member spoiled, dropped or exchanged, and valid checksums."""
    members = {}
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for name in archive.namelist():
            members[name] = archive.read(name)
    name = rng.choice(["meta.npy", *members])
    kind = rng.randrange(4)
    if kind == 0:
        members.pop(name)
    elif kind == 1:
        members[name] = members[rng.choice(list(members))]
    elif kind == 2 or name == "meta.npy":
        head = members[name][:128]
        body = spoil(members[name][128:4128], rng) + members[name][4128:]
        if name == "meta.npy" and rng.random() < 0.8:  # with a header that fits
            buffer = io.BytesIO()
            np.save(buffer, np.frombuffer(body, dtype=np.uint8))
            members[name] = buffer.getvalue()
        else:
            members[name] = head + body
    else:
        members[name] = spoil(members[name][:200], rng) + members[name][200:]
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return stream.getvalue()

"""Files and numbers from outside."""

import dataclasses
import sqlite3
import tempfile
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from cca_core import EvasionSettings, InputError, Lane, LocalFrame, Planner, VehicleState
from cca_core.path import read_waypoints
from cca_core.sim import load_log, read_bsm_log
from cca_core.sim.study.store import Store
from cca_core.v2x import TrackerSettings
from tests.trials.driving import CAR, straight
from tests.trials.faults.paths import WarningRecorder
from tests.trials.faults.table import Check, Table, cpu, raised

TABLE = Table()
FOLDER = tempfile.TemporaryDirectory()
POINTS = '<trkpt lat="48.000" lon="11.0"/><trkpt lat="48.001" lon="11.0"/>'


def file(name: str, content: str) -> Path:
    """Write a file into a folder that is removed at the end."""
    path = Path(FOLDER.name) / name
    path.write_text(content, encoding="utf-8")
    return path


@TABLE.case("files", "gpx-segments", "two track segments 215 m apart: the reader reports the break")
def _():
    rows = ["".join(f'<trkpt lat="{b + 1e-4 * i}" lon="11.0"/>' for i in range(20)) for b in (48.0, 48.0038)]
    name = file("two.gpx", "<gpx><trk>" + "".join(f"<trkseg>{r}</trkseg>" for r in rows) + "</trk></gpx>")
    points, reported = WarningRecorder().call(lambda: read_waypoints(name))
    for extra in {f.name for f in dataclasses.fields(points)} - {"lat", "lon", "duplicates"}:
        value = np.asarray(
            getattr(points, extra), dtype=object
        )  # two segments, or the row where the second begins
        reported = reported or 20 in value.ravel().tolist() or (value.ndim > 0 and len(value) == 2)
    return [("reported", reported, "==", True)]


@TABLE.case("files", "gpx-doctype", "a GPX file with a document type declaration is refused")
def _():
    text = f'<!DOCTYPE g [<!ENTITY x "41.5">]><gpx><trkpt lat="&x;" lon="1"/>{POINTS}</gpx>'
    name = file("doctype.gpx", text)
    return [("raises", raised(lambda: read_waypoints(name)), "==", "InputError")]


def reading_time(text: str) -> float:
    """CPU time of reading, or of refusing, a GPX file [s]."""
    name = file("long.gpx", text)
    return cpu(lambda: raised(lambda: read_waypoints(name), InputError))


@TABLE.case(
    "files", "gpx-long-attribute", "an attribute of 8 MB takes less than 1 s, not the square of its length"
)
def _():
    short, long = (reading_time(f'<gpx name="{"a" * n}">{POINTS}</gpx>') for n in (2_000_000, 8_000_000))
    return [("seconds", long, "<=", 1.0), ("growth", long / max(short, 0.02), "<=", 8.0)]


@TABLE.case("files", "gpx-deep", "1 500 000 nested elements are refused, or read in less than 1 s")
def _():
    text = "<gpx>" + "<a>" * 1_500_000 + POINTS + "</a>" * 1_500_000 + "</gpx>"
    return [("seconds", reading_time(text), "<=", 1.0)]


@TABLE.case("files", "csv-empty-row", "a row without a fix is skipped, the others are read")
def _():
    points = read_waypoints(file("a.csv", "lat,lon\n48.000,11\n,\n48.001,11\n48.002,11\n"))
    return [("points", len(points.lat), "==", 3)]


def only_input_error(*calls) -> list[Check]:
    """Check that no call raises anything but InputError."""
    return [
        ("other errors", sorted({name for call in calls if (name := raised(call, InputError))}), "==", [])
    ]


@TABLE.case("files", "log-bad-files", "load_log: an array, odd or deep contents, a header that claims 7 TB")
def _():
    folder = Path(FOLDER.name)
    names = [folder / "a.npy", *(folder / f"{i}.npz" for i in range(5))]
    np.save(names[0], np.zeros(3))
    for name, meta in zip(names[1:], (b"[1, 2]", b"1", b'{"version": 1}', b"[" * 100_000), strict=False):
        np.savez(name, meta=np.frombuffer(meta, dtype=np.uint8))
    with zipfile.ZipFile(names[-1], "w") as archive, archive.open("t.npy", "w") as member:
        np.lib.format.write_array_header_1_0(
            member, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)}
        )
    return only_input_error(*(lambda n=n: load_log(n) for n in names))


@TABLE.case(
    "files", "frames-bad-files", "read_bsm_log: commas alone, huge numbers, deep nesting, a long field"
)
def _():
    texts = {
        "a.txt": ",\n",
        "b.txt": "00\n,,,\n",
        "c.json": '[{"hex":"00","t":' + "1" * 400 + "}]",
        "d.json": '[{"hex":"00","t":' + "1" * 5000 + "}]",
        "e.json": "[" * 100_000,
        "f.csv": "t,hex\n1," + "0" * 200_000 + "\n",
    }
    return only_input_error(*(lambda n=n, t=t: read_bsm_log(file(n, t)) for n, t in texts.items()))


@TABLE.case("files", "study-bad-files", "Store: rows nested 100 000 deep, no object, no JSON, no text")
def _():
    rows = ["[" * 100_000, "[1]", "1", "{", b"\xff"]
    stores = [spoiled_store(f"store{i}.db", row) for i, row in enumerate(rows)]
    taken = sum(not raised(lambda path=path: Store(path, "x")) for path in stores)
    return [
        *only_input_error(*(lambda path=path: Store(path, "x") for path in stores)),
        ("bad rows taken", taken, "==", 0),
    ]


def spoiled_store(name: str, row: str | bytes) -> Path:
    """Write a store whose only row is replaced."""
    path = file(name, "")
    with Store(path, "x") as store:
        store.add(0, {})
    connection = sqlite3.connect(path)
    connection.execute("update rows set row = ?", (row,))
    connection.commit()
    connection.close()
    return path


@TABLE.case("files", "numbers-too-large", "10**400 in settings and states raises InputError")
def _():
    return only_input_error(
        lambda: replace(CAR, m=10**400),
        lambda: VehicleState(x=10**400, y=0.0, psi=0.0, v_x=0.0),
        lambda: Lane(d=10**400),
        lambda: LocalFrame(10**400, 0.0),
        lambda: EvasionSettings(clearance=10**400),
        lambda: TrackerSettings(approach_horizon=10**400),
        lambda: Planner(CAR, straight(), cruise_speed=10**400),
    )

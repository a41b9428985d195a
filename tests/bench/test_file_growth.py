"""CPU time of reading, or refusing, a file that is 8 times as large; `make bench`."""

import multiprocessing
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from cca_core.errors import InputError
from cca_core.path import read_waypoints
from cca_core.sim import read_bsm_log, read_commonroad
from tests.support.commonroad_files import ROAD, bound, document, goal, lanelet, moving, problem, state

POINTS = '<trkpt lat="48.000" lon="11.0"/><trkpt lat="48.001" lon="11.0"/>'


def _states(n: int) -> str:
    return moving(31, [state("state", k % 1000, 40.0, 0.0, 0.0) for k in range(n)])


def _long_lanelet(n: int, refs: int) -> str:
    wide = tuple(range(n))
    bounds = bound("leftBound", wide, 2.0) + bound("rightBound", wide, -2.0)
    goals = goal((0, 9), '<position><lanelet ref="7"/></position>') * refs
    return document(f'<lanelet id="7">{bounds}</lanelet>', problem(goals))


def _attributes(n: int) -> str:
    return " ".join(f'a{i}=""' for i in range(n))


GPX: dict[str, Callable[[int], str]] = {
    "attribute": lambda n: '<gpx name="' + "a" * 40 * n + '">' + POINTS + "</gpx>",
    "attributes": lambda n: "<gpx " + _attributes(2 * n) + ">" + POINTS + "</gpx>",
    "namespace": lambda n: '<gpx xmlns="' + "u" * 10 * n + '">' + POINTS + "<b/>" * n + "</gpx>",
    "comment": lambda n: "<gpx><!--" + "-<" * 20 * n + "--></gpx>",
    "text": lambda n: "<gpx>" + "a " * 20 * n + POINTS + "</gpx>",
    "elements": lambda n: "<gpx>" + "<a/>" * 10 * n + "</gpx>",
    "elevations": lambda n: (
        '<gpx><trkpt lat="1" ' + _attributes(n) + ">" + "<ele>1</ele>" * n + "</trkpt></gpx>"
    ),
    "segments": lambda n: "<gpx><trk>" + "<trkseg/>" * 2 * n + "</trk>" + POINTS + "</gpx>",
    "points": lambda n: "<gpx>" + '<trkpt lat="1" lon="2"><ele>1</ele><time>1</time></trkpt>' * n + "</gpx>",
    "digits": lambda n: (
        "<gpx>" + ('<trkpt lat="' + "1" * 2000 + '" lon="2"/>') * (n // 100) + POINTS + "</gpx>"
    ),
}
OTHERS: dict[str, tuple[str, Callable[[Path], Any], Callable[[int], str]]] = {
    "kml-line": (
        ".kml",
        read_waypoints,
        lambda n: "<LineString><coordinates>" + "1,2 " * 5 * n + "</coordinates></LineString>",
    ),
    "csv-rows": (".csv", read_waypoints, lambda n: "lat,lon\n" + "1,2\n" * 5 * n),
    "csv-commas": (".csv", read_waypoints, lambda n: "," * 20 * n),
    "csv-lines": (".csv", read_waypoints, lambda n: "a\n" * 20 * n),
    "csv-quotes": (".csv", read_waypoints, lambda n: 'lat,lon\n1,2\n"' + '""' * 20 * n),
    "csv-spaces": (".csv", read_waypoints, lambda n: "lat,lon\n" + " " * 40 * n + "\n1,2"),
    "json-text": (".json", read_waypoints, lambda n: '"' + '\\"' * 20 * n),
    "json-lists": (".json", read_waypoints, lambda n: '{"features":[' + "[]," * 20 * n + "[]]}"),
    "json-points": (
        ".json",
        read_waypoints,
        lambda n: '{"type":"LineString","coordinates":[' + "[1,2]," * 5 * n + "[3,4]]}",
    ),
    "nmea": (
        ".nmea",
        read_waypoints,
        lambda n: "".join(f"$GPGGA,{i},4807,N,0113,E,1,0,0,5,M\n" for i in range(n)),
    ),
    "nmea-line": (".nmea", read_waypoints, lambda n: "$GPGGA" + "," * 20 * n),
    "messages": (".txt", read_bsm_log, lambda n: "00\n" * n),
    "messages-json": (".json", read_bsm_log, lambda n: '{"hex": "00"}\n' * n),
    "messages-digits": (".txt", read_bsm_log, lambda n: "0" * 40 * n),
    "road-states": (".xml", read_commonroad, lambda n: document(ROAD, _states(n // 5))),
    "road-ids": (
        ".xml",
        read_commonroad,
        lambda n: document(ROAD, moving(1, [state("state", 0, 0, 0, 0)]) * (n // 10)),
    ),
    "road-lanelets": (".xml", read_commonroad, lambda n: document(lanelet(1, (0.0, 9.0), 0.0) * (n // 5))),
    "road-references": (
        ".xml",
        read_commonroad,
        lambda n: document(lanelet(1, (0.0, 9.0), 0.0, '<successor ref="5"/>' * n)),
    ),
    "road-goals": (".xml", read_commonroad, lambda n: _long_lanelet(n // 2, n // 10)),
}
CASES = {**{f"gpx-{name}": (".gpx", read_waypoints, make) for name, make in GPX.items()}, **OTHERS}


def seconds(file: Path, read: Callable[[Path], Any]) -> float:
    """CPU time of reading or refusing a file, the smaller of two [s]."""
    times = []
    for _ in range(2):
        begin = time.process_time()
        try:
            read(file)
        except InputError:
            pass
        times.append(time.process_time() - begin)
    return min(times)


@pytest.fixture(scope="module")
def other_process() -> Iterator[Executor]:
    """A new process: its memory does not hold what other benchmarks left."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        yield pool


@pytest.mark.parametrize("name", CASES)
def test_time_is_linear_in_size(tmp_path: Path, name: str, other_process: Executor) -> None:
    ending, read, make = CASES[name]
    found = []
    for n in (5_000, 40_000):
        file = tmp_path / f"{n}{ending}"
        file.write_text(make(n), encoding="utf-8")
        found.append(other_process.submit(seconds, file, read).result())
    short, long = found
    assert long <= 16.0 * max(short, 0.005)

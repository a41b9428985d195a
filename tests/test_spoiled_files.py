"""Every reader of files refuses spoiled ones with `InputError` alone, and keeps nothing of them."""

import gc
import random
import tracemalloc
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cca_core.errors import InputError
from tests.support.spoiled_files import readers, spoil, spoil_archive, spoil_elements

NAMES = [
    "gpx", "kml", "geojson", "csv", "nmea", "commonroad", "opendrive", "sumo", "messages",
    "messages-json", "messages-jsonl", "messages-csv", "log", "store",
]  # fmt: skip


@pytest.fixture(scope="module")
def formats(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[str, Callable[[Path], Any], bytes]]:
    return readers(tmp_path_factory.mktemp("good"))


def refused(file: Path, read: Callable[[Path], Any], data: bytes) -> bool:
    """Return whether a reader refuses a file; any other error than InputError is raised."""
    file.write_bytes(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            read(file)
    except InputError:
        return True
    return False


def spoiled(name: str, data: bytes, seed: int) -> bytes:
    rng = random.Random(f"{name} {seed}")
    if name in ("gpx", "kml", "commonroad", "opendrive", "sumo") and rng.random() < 0.5:
        return spoil_elements(data, rng)
    return spoil_archive(data, rng) if name == "log" and rng.random() < 0.7 else spoil(data, rng)


def check(folder: Path, formats: dict[str, Any], name: str, seeds: range) -> int:
    """Return the number of refused files among spoiled ones."""
    ending, read, data = formats[name]
    n, file = 0, folder / f"file{ending}"
    for seed in seeds:
        try:
            n += refused(file, read, spoiled(name, data, seed))
        except Exception as error:
            raise AssertionError(
                f"{name}, seed {seed}: {type(error).__name__}: {str(error)[:200]}"
            ) from error
    return n


@pytest.mark.parametrize("name", NAMES)
def test_spoiled_files_raise_input_error_alone(tmp_path: Path, formats: dict[str, Any], name: str) -> None:
    ending, read, data = formats[name]
    assert not refused(tmp_path / f"good{ending}", read, data)
    n = check(tmp_path, formats, name, range(50 if name in ("log", "store") else 300))
    assert n > 10


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_100_000_spoiled_files_leave_nothing(tmp_path: Path, formats: dict[str, Any], name: str) -> None:
    check(tmp_path, formats, name, range(300, 1000))
    gc.collect()
    tracemalloc.start()
    check(tmp_path, formats, name, range(1000, 2000))
    gc.collect()
    before = tracemalloc.get_traced_memory()[0]
    check(tmp_path, formats, name, range(2000, 3000))
    gc.collect()
    growth = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert growth < 200_000
    check(tmp_path, formats, name, range(3000, 100_300))


@pytest.mark.parametrize("name", ["gpx", "csv", "nmea", "commonroad", "messages"])
def test_truncated_files_raise_input_error_alone(tmp_path: Path, formats: dict[str, Any], name: str) -> None:
    ending, read, data = formats[name]
    for length in range(0, len(data), max(1, len(data) // 200)):
        refused(tmp_path / f"file{ending}", read, data[:length])

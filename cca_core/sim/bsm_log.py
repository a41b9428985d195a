"""Recorded Basic Safety Messages with their times of arrival."""

import csv
import gzip
import io
import math
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path as FilePath

from cca_core._checks import check_real, read_real, shown
from cca_core._files import parse_json, read_bytes
from cca_core.errors import InputError
from cca_core.v2x import Bsm, decode_bsm, encode_bsm
from cca_core.v2x.wrappers import split_records

__all__ = ["read_bsm_log"]

_MAX_BYTES = 200_000_000  # some two million messages
_MAX_TIME = 1e12  # [s]
_DATA_KEYS = "hex", "uper_hex", "data"


def read_bsm_log(
    path: str | FilePath, *, start: float = 0.0, latency: float = 0.0
) -> list[tuple[float, bytes]]:
    """Read a recorded log of Basic Safety Messages for `simulate`.

    Parameters
    ----------
    path : str or pathlib.Path
        Lines of hexadecimal digits (optionally a time [s] and a comma or blank before them), lines
        ``Payload=`` of immediate forward messages, lines of JSON objects, a JSON list of them (or one under
        ``"samples"``), or a CSV table with a header. Objects and tables have the bytes under ``hex``,
        ``uper_hex`` or ``data`` and may have a time [s] under ``t``, ``time`` or ``t_received``. Or a binary
        ODE log, such as ``rxMsg``. Each may be compressed by gzip. Messages may be in the wrappers that
        `cca_core.v2x.unwrap_message` removes.
    start : float
        Simulation time of the first message's measurement [s], not negative.
    latency : float
        From measurement to arrival [s], if no times are recorded; not negative.

    Returns
    -------
    bsm_log : list of (float, bytes)
        Time of arrival [s] and message, in order. Second marks are shifted to the simulation's time. For that
        the messages are encoded again, without wrappers and content beyond Part I and the event flags. Bytes
        that cannot be decoded, and other messages, stay as they are and arrive with the message before them.

    Raises
    ------
    InputError
        If the file cannot be read, has more than 200 MB, holds no message, or holds a line that is none.
    """
    start = check_real("start", start, ge=0.0)
    latency = check_real("latency", latency, ge=0.0)
    bsm_log: list[tuple[float, bytes]] = []
    t_measured, last_mark, first_recorded = start, None, None
    for recorded, data in _messages(path):
        bsm = _decoded(data)
        if bsm is not None and bsm.sec_mark is not None:
            # second marks count milliseconds within a minute
            if last_mark is not None:
                t_measured = max(t_measured + math.remainder(bsm.sec_mark - last_mark, 60.0), 0.0)
            last_mark = bsm.sec_mark
            mark = round(t_measured % 60.0 * 1000.0) % 60000 / 1000.0
            data = encode_bsm(replace(bsm, sec_mark=mark))
        t_arrival = t_measured + latency
        if recorded is not None:
            first_recorded = recorded if first_recorded is None else first_recorded
            t_arrival = start + latency + recorded - first_recorded
        bsm_log.append((max(t_arrival, bsm_log[-1][0] if bsm_log else 0.0), data))
    if not bsm_log:
        raise InputError(f"path must hold messages, {path} had none")
    return bsm_log


def _decoded(data: bytes) -> Bsm | None:
    try:
        return decode_bsm(data)
    except InputError:
        return None


def _messages(path: str | FilePath) -> Iterable[tuple[float | None, bytes]]:
    """Return the time, if recorded, and the bytes of each message of a file."""
    content = read_bytes(path, max_bytes=_MAX_BYTES, name="path")
    if content.startswith(b"\x1f\x8b"):
        try:
            content = gzip.GzipFile(fileobj=io.BytesIO(content)).read(_MAX_BYTES + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"path must be a whole gzip file if it begins like one: {error}") from None
        if len(content) > _MAX_BYTES:
            raise InputError(f"path must be at most {_MAX_BYTES // 1_000_000} MB long without compression")
    if records := split_records(content):
        return records
    try:
        return _from_text(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise InputError(f"path must be a text file or an ODE log, {path} was not: {error}") from None


def _from_text(text: str) -> Iterator[tuple[float | None, bytes]]:
    """Yield the time, if recorded, and the bytes of each message of a text."""
    for recorded, digits in _entries(text):
        try:
            yield recorded, bytes.fromhex(digits)
        except ValueError:
            raise InputError(f"path must hold hexadecimal digits, had {digits[:40]!r}") from None


def _entries(text: str) -> Iterator[tuple[float | None, str]]:
    """Yield the time, if recorded, and the hexadecimal digits of each message."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if not lines:
        return
    if lines[0][0] in "[{":
        yield from map(_entry, _objects(text, lines))
    elif "," in lines[0] and any(name in lines[0].split(",") for name in _DATA_KEYS):
        try:
            yield from map(_entry, csv.DictReader(lines))
        except csv.Error as error:
            raise InputError(f"path must hold a table, had: {error}") from None
    elif any(line.lower().startswith("payload=") for line in lines):
        for line in lines:
            key, _, digits = line.partition("=")
            if key.strip().lower() == "payload":
                yield None, digits
    else:
        for line in lines:
            *before, digits = line.replace(",", " ").split() or [","]
            yield (None if not before else _number(before[0])), digits


def _objects(text: str, lines: list[str]) -> Iterable[object]:
    try:
        whole = parse_json(text, "path")
    except InputError:
        if len(lines) == 1:
            raise
        return [parse_json(line, "path (a line in it)") for line in lines]
    if isinstance(whole, dict):
        whole = whole.get("samples", [whole])
    return whole if isinstance(whole, list) else [whole]


def _entry(record: object) -> tuple[float | None, str]:
    content = record if isinstance(record, dict) else {}
    digits = next((content[name] for name in _DATA_KEYS if name in content), None)
    if not isinstance(digits, str):
        raise InputError(f"path must hold {', '.join(_DATA_KEYS)} in each record, had {shown(record)}")
    t = next((content[name] for name in ("t", "time", "t_received") if name in content), None)
    return (None if t is None else _number(t)), digits


def _number(value: object) -> float:
    return read_real("path (a time in it)", value, ge=-_MAX_TIME, le=_MAX_TIME)

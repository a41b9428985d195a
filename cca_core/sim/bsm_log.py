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
from cca_core.v2x.capture import is_capture, split_capture
from cca_core.v2x.wrappers import split_frames, split_records

__all__ = ["SenderTimes", "read_bsm_log", "read_entries"]

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
        ODE log, such as ``rxMsg``, a capture of packets (pcap, pcapng), or bare messages one after another.
        Each may be compressed by gzip. Messages may be in the wrappers that `cca_core.v2x.unwrap_message`
        removes.
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
    times = SenderTimes(start, latency)
    for recorded, content in read_entries(path):
        data = content if isinstance(content, bytes) else _from_hexadecimal(content)
        bsm = _decoded(data)
        t_arrival = times.arrival(recorded, bsm)
        if bsm is not None and bsm.sec_mark is not None:
            mark = round(times.t_measured % 60.0 * 1000.0) % 60000 / 1000.0
            data = encode_bsm(replace(bsm, sec_mark=mark))
        bsm_log.append((t_arrival, data))
    if not bsm_log:
        raise InputError(f"path must hold messages, {path} had none")
    return bsm_log


class SenderTimes:
    """Times of arrival of a log's messages, which never decrease."""

    def __init__(self, start: float, latency: float) -> None:
        self.t_measured = start
        self._start, self._latency, self._t = start, latency, 0.0
        self._last_mark: float | None = None
        self._first_recorded: float | None = None

    def arrival(self, recorded: float | None, bsm: Bsm | None) -> float:
        """Return the time of arrival of the next message [s]."""
        if bsm is not None and bsm.sec_mark is not None:
            # second marks count milliseconds within a minute
            if self._last_mark is not None:
                step = math.remainder(bsm.sec_mark - self._last_mark, 60.0)
                self.t_measured = max(self.t_measured + step, 0.0)
            self._last_mark = bsm.sec_mark
        t_arrival = self.t_measured + self._latency
        if recorded is not None:
            self._first_recorded = recorded if self._first_recorded is None else self._first_recorded
            t_arrival = self._start + self._latency + recorded - self._first_recorded
        self._t = max(t_arrival, self._t)
        return self._t


def _decoded(data: bytes) -> Bsm | None:
    try:
        return decode_bsm(data)
    except InputError:
        return None


def _from_hexadecimal(digits: str) -> bytes:
    try:
        return bytes.fromhex(digits)
    except ValueError:
        raise InputError(f"path must hold hexadecimal digits, had {digits[:40]!r}") from None


def read_entries(path: str | FilePath) -> Iterable[tuple[float | None, bytes | str]]:
    """Return the time, if recorded, and the bytes or hexadecimal digits of each entry of a log."""
    content = read_bytes(path, max_bytes=_MAX_BYTES, name="path")
    if content.startswith(b"\x1f\x8b"):
        try:
            content = gzip.GzipFile(fileobj=io.BytesIO(content)).read(_MAX_BYTES + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(f"path must be a whole gzip file if it begins like one: {error}") from None
        if len(content) > _MAX_BYTES:
            raise InputError(f"path must be at most {_MAX_BYTES // 1_000_000} MB long without compression")
    if is_capture(content):
        return split_capture(content)
    if records := split_records(content):
        return records
    if frames := split_frames(content):
        return [(None, frame) for frame in frames]
    try:
        return _entries(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise InputError(
            f"path must be a text file, an ODE log or a capture, {path} was not: {error}"
        ) from None


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
            try:
                yield (None if not before else _number(before[0])), digits
            except InputError:  # no time and message: what cannot be read
                yield None, line


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

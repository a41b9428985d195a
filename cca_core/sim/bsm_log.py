"""Recorded messages as traffic: bytes with the times at which they arrived."""

import csv
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path as FilePath

from cca_core._checks import check_real, read_real
from cca_core.errors import InputError
from cca_core.v2x import Bsm, decode_bsm, encode_bsm

__all__ = ["read_bsm_log"]

_HEX = "hex", "uper_hex", "data"
_TIMES = "t", "time", "t_received"
_MINUTE = 60.0  # [s]


def read_bsm_log(
    path: str | FilePath, *, start: float = 0.0, latency: float = 0.0
) -> list[tuple[float, bytes]]:
    """Read a recorded log of Basic Safety Messages for `simulate`.

    Parameters
    ----------
    path : str or pathlib.Path
        Lines of hexadecimal digits (optionally a time [s] and a comma or blank before them), lines of JSON
        objects, a JSON list of them (or one under ``"samples"``), or a CSV table with a header. Objects and
        tables have the bytes under ``hex``, ``uper_hex`` or ``data`` and may have a time [s] under ``t``,
        ``time`` or ``t_received``.
    start : float
        When the first message was made, in the simulation's time [s], not negative.
    latency : float
        From there to its arrival, where no times are recorded [s].

    Returns
    -------
    frames : list of (float, bytes)
        Time of arrival [s] and content, in order. Second marks are moved to the simulation's time, for which
        messages are encoded again: content beyond Part I and the event flags is lost. What cannot be decoded
        arrives as it is, with the message before it.

    Raises
    ------
    InputError
        If the file cannot be read, has no message, or a line is none.
    """
    start = check_real("start", start, ge=0.0)
    latency = check_real("latency", latency, ge=0.0)
    try:
        text = FilePath(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"path must be a readable text file, {path} was not: {error}") from None
    frames: list[tuple[float, bytes]] = []
    made, mark_before, first_told = start, None, None
    for told, digits in _entries(text):
        try:
            data = bytes.fromhex(digits)
        except ValueError:
            raise InputError(f"path must hold hexadecimal digits, had {digits[:40]!r}") from None
        bsm = _decoded(data)
        if bsm is not None and bsm.sec_mark is not None:
            if mark_before is not None:
                made = max(made + math.remainder(bsm.sec_mark - mark_before, _MINUTE), 0.0)
            mark_before = bsm.sec_mark
            mark = round(made % _MINUTE * 1000.0) % 60000 / 1000.0
            data = encode_bsm(replace(bsm, sec_mark=mark))
        arrives = made + latency
        if told is not None:
            first_told = told if first_told is None else first_told
            arrives = start + latency + told - first_told
        frames.append((max(arrives, frames[-1][0] if frames else 0.0), data))
    if not frames:
        raise InputError(f"path must hold messages, {path} had none")
    return frames


def _decoded(data: bytes) -> Bsm | None:
    try:
        return decode_bsm(data)
    except InputError:
        return None


def _entries(text: str) -> Iterator[tuple[float | None, str]]:
    """Time, if there is one, and hexadecimal digits of each message."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if not lines:
        return
    if lines[0][0] in "[{":
        yield from map(_entry, _objects(text, lines))
    elif "," in lines[0] and any(name in lines[0].split(",") for name in _HEX):
        yield from map(_entry, csv.DictReader(lines))
    else:
        for line in lines:
            *before, digits = line.replace(",", " ").split()
            yield (None if not before else _number(before[0])), digits


def _objects(text: str, lines: list[str]) -> Iterable[object]:
    try:
        try:
            whole = json.loads(text)
        except json.JSONDecodeError:
            return [json.loads(line) for line in lines]
    except json.JSONDecodeError as error:
        raise InputError(f"path must hold JSON, had: {error}") from None
    if isinstance(whole, dict):
        whole = whole.get("samples", [whole])
    return whole if isinstance(whole, list) else [whole]


def _entry(record: object) -> tuple[float | None, str]:
    content = record if isinstance(record, dict) else {}
    digits = next((content[name] for name in _HEX if name in content), None)
    if not isinstance(digits, str):
        raise InputError(f"path must hold {', '.join(_HEX)} in each record, had {str(record)[:60]}")
    told = next((content[name] for name in _TIMES if name in content), None)
    return (None if told is None else _number(told)), digits


def _number(value: object) -> float:
    return read_real("path (a time in it)", value)

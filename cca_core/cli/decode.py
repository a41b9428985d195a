"""``cca decode``: recorded Basic Safety Messages as text or a table, and what was dropped."""

import argparse
import csv
import math
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path as FilePath
from typing import Any, TextIO

from cca_core.cli.arguments import STDOUT
from cca_core.cli.progress import ProgressBar
from cca_core.cli.words import counted
from cca_core.errors import InputError
from cca_core.path import LocalFrame
from cca_core.sim.bsm_log import SenderTimes, read_entries
from cca_core.v2x import Bsm, Tracker, decode_bsm, unwrap_message

__all__ = ["run"]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Entry:
    """One entry of a log: a message, or why it is none."""

    recorded: float | None
    bsm: Bsm | None
    name: str  # of the kind of message; empty if unreadable
    error: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Row:
    """An entry with its time since the first one [s], and what a tracker does with it."""

    t: float
    entry: _Entry
    kind: str
    accepted: bool


def run(given: argparse.Namespace) -> int:
    """List, count and write the messages; return the exit code."""
    entries = _read(given.log)
    rows = list(_track(entries))
    if given.csv == STDOUT:
        _write_csv(rows, sys.stdout)
        return 0
    if not given.quiet:
        print("time [s]  sender    latitude  longitude    speed  heading    a_x  events")
        for row in rows:
            print(_line(row))
    _print_counts(rows)
    if given.csv is not None:
        with given.csv.open("w", newline="", encoding="utf-8") as stream:
            _write_csv(rows, stream)
        print(f"table: {given.csv}")
    return 0


def _read(file: FilePath) -> list[_Entry]:
    entries = [_decode(recorded, data) for recorded, data in read_entries(file)]
    if not entries:
        raise InputError(f"{str(file)!r} must hold messages, had none")
    if not any(entry.name for entry in entries):
        raise InputError(
            f"{str(file)!r} must hold J2735 messages, none of its {len(entries)} entries is one: "
            f"{entries[0].error}"
        )
    return entries


def _decode(recorded: float | None, data: bytes | str) -> _Entry:
    name = ""
    try:
        name = unwrap_message(data).name
        bsm = decode_bsm(data) if name == "BSM" else None
        return _Entry(recorded=recorded, bsm=bsm, name=name, error="")
    except InputError as error:
        return _Entry(recorded=recorded, bsm=None, name=name, error=str(error))


def _track(entries: list[_Entry]) -> Iterator[_Row]:
    """Yield what a receiver at the first sender does with each message."""
    sent = [entry.bsm for entry in entries if entry.bsm is not None]
    marks = [bsm.sec_mark for bsm in sent if bsm.sec_mark is not None]
    origins = [
        (bsm.latitude_deg, bsm.longitude_deg)
        for bsm in sent
        if bsm.latitude_deg is not None and bsm.longitude_deg is not None and abs(bsm.latitude_deg) < 89.0
    ]
    tracker = Tracker(LocalFrame(*(origins or [(0.0, 0.0)])[0]))
    # tracks need times whose full minutes are those of the second marks
    begin = 60.0 + (marks or [0.0])[0]
    times, first = SenderTimes(begin, 0.0), None
    with ProgressBar("tracking", len(entries), "messages") as bar:
        for i, entry in enumerate(entries):
            t = times.arrival(entry.recorded, entry.bsm)
            first = t if first is None else first
            kind, accepted = ("other_message" if entry.name and not entry.error else "unreadable"), False
            if entry.bsm is not None:
                result = tracker.update(entry.bsm, t)
                kind, accepted = result.kind, result.accepted
            bar.advance(i + 1)
            yield _Row(t=t - first, entry=entry, kind=kind, accepted=accepted)


def _line(row: _Row) -> str:
    bsm, head = row.entry.bsm, f"{row.t:8.3f}"
    if row.kind == "other_message":
        return f"{head}  {row.entry.name}, not decoded"
    if bsm is None:
        return f"{head}  dropped, unreadable: {row.entry.error}"
    heading = None if bsm.psi is None else (90.0 - math.degrees(bsm.psi)) % 360.0
    values = (
        _number(bsm.latitude_deg, 9, 5), _number(bsm.longitude_deg, 10, 5), _number(bsm.speed, 8, 2),
        _number(heading, 8, 1), _number(bsm.a_x, 6, 2),
    )  # fmt: skip
    notes = [*sorted(bsm.events), *(() if row.accepted else (f"dropped: {_words(row.kind)}",))]
    return " ".join((f"{head}  {bsm.id}", *values, " " + ", ".join(notes))).rstrip()


def _number(value: float | None, width: int, digits: int) -> str:
    return "-".rjust(width) if value is None else f"{value:{width}.{digits}f}"


def _words(kind: str) -> str:
    return kind.replace("_", " ")


def _print_counts(rows: list[_Row]) -> None:
    sent = [row for row in rows if row.entry.bsm is not None]
    senders = {row.entry.bsm.id for row in sent if row.entry.bsm is not None}
    span = rows[-1].t - rows[0].t
    entries = f"{len(rows)} {'entry' if len(rows) == 1 else 'entries'}"
    sent_by = f"{counted(len(sent), 'Basic Safety Message')} of {counted(len(senders), 'sender')}"
    print(f"{entries} in {span:.1f} s, {sent_by}")
    _print_kinds("accepted", Counter(_words(row.kind) for row in rows if row.accepted))
    dropped = [row for row in rows if not row.accepted and row.kind != "other_message"]
    _print_kinds("dropped", Counter(_words(row.kind) for row in dropped))
    _print_kinds("others", Counter(row.entry.name for row in rows if row.kind == "other_message"))
    broken = next((row for row in dropped if row.kind == "unreadable"), None)
    if broken is not None:
        print(f"first unreadable entry, at {broken.t:.3f} s: {broken.entry.error}")


def _print_kinds(name: str, counts: Counter[str]) -> None:
    if counts:
        kinds = ", ".join(f"{kind} {n}" for kind, n in counts.most_common())
        print(f"{name}: {counts.total()} ({kinds})")


def _write_csv(rows: list[_Row], stream: TextIO) -> None:
    """Write the fields of each message in SI units and ISO 8855 axes, and the result."""
    names = ["t", "result", "message", *_flat(asdict(Bsm(msg_count=0, id="")))]
    writer = csv.DictWriter(stream, names, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        content = {} if row.entry.bsm is None else _flat(asdict(row.entry.bsm))
        head = {"t": f"{row.t:.3f}", "result": row.kind, "message": row.entry.name}
        writer.writerow(head | content)


def _flat(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of nested records under names with dots."""
    flat: dict[str, Any] = {}
    for name, value in content.items():
        if isinstance(value, Mapping):
            flat |= {f"{name}.{inner}": each for inner, each in _flat(value).items()}
        elif isinstance(value, frozenset):
            flat[name] = " ".join(sorted(value))
        elif isinstance(value, tuple):
            flat[name] = " ".join("1" if each else "0" for each in value)
        else:
            flat[name] = value
    return flat

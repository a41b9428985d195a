"""Measurements as rows of a file, added one by one so that an interrupted run keeps what it has."""

import csv
import math
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar

__all__ = ["append_row", "read_rows"]

R = TypeVar("R")


def append_row(path: Path | str, row: Any) -> None:
    """Add a row to a file, which is begun with the names of the columns.

    Parameters
    ----------
    path : path
        File of comma-separated values; folders that are missing are made.
    row : dataclass
        What is added, of numbers and words.
    """
    file = Path(path)
    file.parent.mkdir(parents=True, exist_ok=True)
    begins = not file.exists() or not file.stat().st_size
    if not begins:
        _mend(file)
    with file.open("a", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        if begins:
            writer.writerow(field.name for field in fields(row))
        writer.writerow(_written(value) for value in asdict(row).values())


def read_rows(path: Path | str, kind: type[R]) -> list[R]:
    """Read what was written.

    Parameters
    ----------
    path : path
        File of comma-separated values; it need not exist.
    kind : type
        Dataclass of a row.

    Returns
    -------
    rows : list
        All whole rows; one that was being written when a run was interrupted is left out.
    """
    file = Path(path)
    if not file.exists():
        return []
    text = file.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1].splitlines(keepends=True)
    kinds = {field.name: field.type for field in fields(kind)}  # type: ignore[arg-type]
    rows = []
    for given in csv.DictReader(whole):
        if None in given or None in given.values() or given.keys() != kinds.keys():
            continue
        try:
            rows.append(kind(**{name: _read(kinds[name], value) for name, value in given.items()}))
        except ValueError:
            continue
    return rows


def _mend(file: Path) -> None:
    """Take back a line that was interrupted."""
    data = file.read_bytes()
    if not data.endswith(b"\n"):
        file.write_bytes(data[: data.rfind(b"\n") + 1])


def _written(value: object) -> str:
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return " ".join(str(value).split())


def _read(kind: object, value: str) -> object:
    if kind is float:
        return float(value) if value else math.nan
    return bool(int(value)) if kind is bool else int(value) if kind is int else value

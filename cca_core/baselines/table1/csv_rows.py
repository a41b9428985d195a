"""Rows as files of comma-separated values."""

import csv
import math
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar

Row = TypeVar("Row")


def write_rows(path: Path, rows: Sequence[Any]) -> None:
    """Write dataclasses of numbers and text, at least one."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(field.name for field in fields(rows[0]))
        writer.writerows([_text(value) for value in asdict(row).values()] for row in rows)


def read_rows(path: Path, kind: type[Row]) -> list[Row]:
    """Read what was written."""
    types = {field.name: field.type for field in fields(kind)}  # type: ignore[arg-type]
    with path.open(encoding="utf-8", newline="") as stream:
        return [
            kind(**{name: _value(types[name], text) for name, text in row.items()})
            for row in csv.DictReader(stream)
        ]


def _text(value: object) -> str:
    """Text of a value; NaN is empty."""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.6g}"
    return " ".join(str(value).split())


def _value(kind: object, text: str) -> object:
    """Value of a text."""
    if kind is float:
        return float(text) if text else math.nan
    return bool(int(text)) if kind is bool else int(text) if kind is int else text

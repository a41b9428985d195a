"""Tables of TOML files; each error names the key."""

import math
import tomllib
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Any, TypeVar

from cca_core._checks import check_real, shown, unknown
from cca_core._files import read_bytes
from cca_core.errors import InputError
from cca_core.serial import from_dict, to_dict
from cca_core.serial.fields import field_types

__all__ = ["Table", "named", "parse_toml", "read_text", "read_toml"]

T = TypeVar("T")
_MAX_BYTES = 1_000_000


def read_toml(file: FilePath) -> "Table":
    """Read a TOML file."""
    return Table(parse_toml(read_text(file), file), "")


def read_text(file: FilePath) -> str:
    """Return the text of a file."""
    try:
        return read_bytes(file, max_bytes=_MAX_BYTES).decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"file {str(file)!r} must be a text in UTF-8, was not: {error}") from None


def parse_toml(text: str, file: FilePath) -> dict[str, Any]:
    """Return the content of a TOML text."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"file {str(file)!r} must be TOML, was not: {error}") from None


@contextmanager
def named(where: str) -> Iterator[None]:
    """Begin the message of an error with the position of its key."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{where}.{error}" if where else str(error)) from None


class Table:
    """A table of a file, with its position in it."""

    def __init__(self, content: object, where: str) -> None:
        if not isinstance(content, dict):
            raise InputError(f"{where} must be a table, was {shown(content)}")
        self.content: dict[str, Any] = content
        self.where = where

    def position(self, key: str) -> str:
        """Return the position of a key in the file."""
        return f"{self.where}.{key}" if self.where else key

    def check_keys(self, known: Collection[str]) -> None:
        """Raise if a key is not one of the known ones."""
        for key in self.content:
            if key not in known:
                raise InputError(f"{self.position(key)} is unknown; {unknown(key, known)}")

    def require(self, key: str) -> Any:
        """Return the value of a key that must be there."""
        if key not in self.content:
            raise InputError(f"{self.position(key)} must be given")
        return self.content[key]

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        gt: float = -math.inf,
        ge: float = -math.inf,
        le: float = math.inf,
    ) -> float:
        """Return a number; without default it must be there."""
        value = self.require(key) if default is None else self.content.get(key, default)
        if isinstance(value, bool):
            raise InputError(f"{self.position(key)} must be a number, was {shown(value)}")
        return check_real(self.position(key), value, gt=gt, ge=ge, le=le)

    def whole(self, key: str, default: int) -> int:
        """Return a whole number, not negative."""
        value = self.content.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise InputError(f"{self.position(key)} must be a whole number from 0, was {shown(value)}")
        return value

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text; without default it must be there."""
        value = self.require(key) if default is None else self.content.get(key, default)
        if not isinstance(value, str):
            raise InputError(f"{self.position(key)} must be a text, was {shown(value)}")
        return value

    def choice(self, key: str, choices: Collection[str], default: str | None = None) -> str:
        """Return one of several texts."""
        value = self.text(key, default)
        if value not in choices:
            raise InputError(f"{self.position(key)} must be one of {', '.join(choices)}, was {shown(value)}")
        return value

    def table(self, key: str) -> "Table":
        """Return an inner table, empty by default."""
        return Table(self.content.get(key, {}), self.position(key))

    def tables(self, key: str) -> list["Table"]:
        """Return the tables of an array, none by default."""
        value = self.content.get(key, [])
        if not isinstance(value, list):
            raise InputError(f"{self.position(key)} must be a list of tables, was {shown(value)}")
        return [Table(each, f"{self.position(key)}[{i}]") for i, each in enumerate(value)]

    def record(
        self,
        kind: type[T],
        presets: Mapping[str, Callable[[], T]] | None = None,
    ) -> T:
        """Return a record of these fields, on top of a preset if there are any."""
        self.check_keys([*(["preset"] if presets else []), *(field_types(kind) or {})])
        values = {key: value for key, value in self.content.items() if key != "preset"}
        if presets:
            preset = self.choice("preset", presets, next(iter(presets)))
            values = _merged(to_dict(presets[preset]()), values)
        with named(self.where):
            return from_dict(kind, values)


def _merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of `above` on top of those below, also in inner tables."""
    both = dict(below)
    for key, value in above.items():
        inner = both.get(key)
        is_table = isinstance(inner, Mapping) and isinstance(value, Mapping)
        both[key] = _merged(inner, value) if is_table else value  # type: ignore[arg-type]
    return both

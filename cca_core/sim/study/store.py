"""Rows of a long computation on disk, so that it can be resumed."""

import json
import sqlite3
from collections.abc import Mapping
from pathlib import Path as FilePath
from types import MappingProxyType, TracebackType
from typing import Any, Self

from cca_core._checks import shown
from cca_core._files import parse_json
from cca_core.errors import InputError
from cca_core.sim.study.changes import describe_changes

__all__ = ["Store"]

_MAX_BYTES = 1_000_000_000  # of all rows
_TABLES = (
    "CREATE TABLE meta (fingerprint text not null)",
    "CREATE TABLE rows (key primary key, row text not null)",
)


class Store:
    """Rows by key in an SQLite file; one process at a time opens it, in a ``with`` statement.

    `fingerprint` describes the computation that the file belongs to. Once `add` has returned, its row
    survives a kill of the process; numbers come back exactly.
    """

    def __init__(self, path: str | FilePath, fingerprint: str) -> None:
        try:
            self._connection = sqlite3.connect(path, timeout=0.0, isolation_level=None)
            try:
                found, self._rows = self._open(fingerprint)
            except BaseException:
                self._connection.close()
                raise
        except (sqlite3.Error, ValueError, TypeError, RecursionError, OverflowError, MemoryError) as error:
            raise InputError(f"path must be a file of rows, or new; {shown(path)} was not: {error}") from None
        if found != fingerprint:
            self._connection.close()
            changes = describe_changes(found, fingerprint)
            raise InputError(
                f"path must be of the same definition, with the same source code, or new; {shown(str(path))} "
                f"belongs to another one{changes and f', which differs in: {changes}'}; give another file "
                "name, or delete this one to begin anew"
            )

    def _open(self, fingerprint: str) -> tuple[str, dict[int | str, dict[str, Any]]]:
        """Return the fingerprint and the rows in the file, which is made if it is new."""
        run = self._connection.execute
        run("pragma trusted_schema = off")
        run("pragma locking_mode = exclusive")  # a second process is refused
        run("begin exclusive")
        if not run("select count(*) from sqlite_master").fetchone()[0]:
            for table in _TABLES:
                run(table)
            run("insert into meta values (?)", (fingerprint,))
        run("commit")
        broken = run("pragma quick_check").fetchone()[0]
        if broken != "ok":
            raise ValueError(broken)
        # a view would be computed, without end
        if {text for (text,) in run("select sql from sqlite_master where sql is not null")} != set(_TABLES):
            raise ValueError("it has other tables")
        size = run("select sum(length(row)) from rows").fetchone()[0] or 0
        if size > _MAX_BYTES:
            raise ValueError(f"its rows have {size} bytes, more than {_MAX_BYTES}")
        (found,) = run("select fingerprint from meta").fetchone()
        stored = run("select key, row from rows order by rowid").fetchall()
        return found, {key: {**parse_json(text, "row")} for key, text in stored}

    @property
    def rows(self) -> Mapping[int | str, dict[str, Any]]:
        """All rows by key, in the order in which they were added."""
        return MappingProxyType(self._rows)

    def add(self, key: int | str, row: Mapping[str, Any]) -> None:
        """Keep a row of numbers, text and None under a new key."""
        if key in self._rows:
            raise InputError(f"key must be new, was {key!r}")
        text = json.dumps(dict(row))
        self._connection.execute("insert into rows values (?, ?)", (key, text))
        self._rows[key] = json.loads(text)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connection.close()

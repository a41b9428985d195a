"""The file of a study: a line for each finished run, whole or not at all."""

import json
import os
import time
from pathlib import Path as FilePath
from types import TracebackType
from typing import Any, Self

from cca_core.errors import InputError

__all__ = ["StudyFile"]

_SYNC = 5.0  # longest time that a line is only in the operating system's memory while others follow [s]


class StudyFile:
    """Finished runs of a study, kept on disk; use it in a ``with`` statement.

    Parameters
    ----------
    path : str or pathlib.Path
        JSON lines: the study, then one run a line. A new file is begun if there is none.
    fingerprint : str
        The study that it must be of.

    Attributes
    ----------
    rows : dict
        Rows by the number of their run.

    Raises
    ------
    InputError
        If the file is of another study, or no such file.

    Notes
    -----
    A last line without its end was being written when the process was killed: it is dropped, and its run is
    driven again.
    """

    def __init__(self, path: str | FilePath, fingerprint: str) -> None:
        path = FilePath(path)
        self._header = json.dumps({"study": fingerprint})
        self.rows: dict[int, dict[str, Any]] = {}
        data = path.read_bytes() if path.exists() else b""
        whole = data.rfind(b"\n") + 1
        if whole:
            self._read(path, data[:whole].decode("utf-8", errors="replace").splitlines())
        elif not self._header.encode().startswith(data):
            raise InputError(f"path must be the file of a study, {path} was not")
        self._file = path.open("r+b" if path.exists() else "x+b")
        self._file.truncate(whole)
        self._file.seek(whole)
        self._synced = time.monotonic()
        if not whole:
            self._write(self._header)

    def _read(self, path: FilePath, lines: list[str]) -> None:
        try:
            header, *rows = (json.loads(line) for line in lines)
            said = header["study"]
            self.rows = {row["index"]: row for row in rows}
        except (ValueError, KeyError, TypeError) as error:
            raise InputError(f"path must be the file of a study, {path} was not: {error}") from None
        if json.dumps({"study": said}) != self._header:
            raise InputError(
                f"path must be of the same study, seed and source code as before; {path} is of another one: "
                f"{said[:200]}"
            )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._sync()
        self._file.close()

    def add(self, row: dict[str, Any]) -> None:
        """Keep a finished run.

        Parameters
        ----------
        row : dict
            With its number as ``"index"``; numbers, text and None.
        """
        text = json.dumps(row)
        self.rows[row["index"]] = json.loads(text)
        self._write(text)

    def _write(self, line: str) -> None:
        self._file.write(line.encode() + b"\n")
        self._file.flush()
        if time.monotonic() - self._synced > _SYNC:
            self._sync()

    def _sync(self) -> None:
        os.fsync(self._file.fileno())
        self._synced = time.monotonic()

"""Logs as files: arrays and JSON in one npz, without pickle."""

import json
from dataclasses import fields
from pathlib import Path as FilePath
from typing import Any
from zipfile import BadZipFile

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.errors import InputError
from cca_core.serial import from_dict, to_dict
from cca_core.sim.log import Log
from cca_core.sim.scenarios.scenario import Scenario

__all__ = ["load_log", "save_log"]

_VERSION = 2
_ARRAYS = tuple(field.name for field in fields(Log) if field.type in (Array, Mask))
_VERSION_1 = {
    "place": "ego_frenet", "users": "road_users", "user_places": "user_frenet", "seen": "visible",
    "heard": "tracked", "held": "gap_held", "fallback": "degraded", "missed": "missed_deadlines",
    "event contact": "collision", "event heard": "first_received", "event seen": "first_visible",
    "event hazard_heard": "hazard_received", "event stands": "stopped", "event swerves": "lateral_shift",
    "event released": "gap_released",
}  # fmt: skip
"""Names of fields and events in files of version 1, with today's."""


def save_log(log: Log, path: str | FilePath) -> None:
    """Write a log to a file.

    Parameters
    ----------
    log : Log
        The run.
    path : str or pathlib.Path
        File to write, as a rule ``.npz``, in a folder that exists.

    Notes
    -----
    Every number is kept exactly. The scenario is JSON as by `to_dict`, and so are decisions and events.
    """
    rest = {f.name: getattr(log, f.name) for f in fields(log) if f.name not in (*_ARRAYS, "received")}
    text = json.dumps({"version": _VERSION, **rest, "scenario": to_dict(log.scenario)}, allow_nan=False)
    rows = [row for row, _ in log.received]
    data = [message for _, message in log.received]
    with FilePath(path).open("wb") as file:
        np.savez_compressed(
            file, meta=np.frombuffer(text.encode(), dtype=np.uint8),
            received_rows=np.array(rows, dtype=np.int64),
            received_sizes=np.array([len(message) for message in data], dtype=np.int64),
            received_bytes=np.frombuffer(b"".join(data), dtype=np.uint8),
            **{name: getattr(log, name) for name in _ARRAYS},
        )  # fmt: skip


def load_log(path: str | FilePath) -> Log:
    """Read a log that `save_log` has written.

    Parameters
    ----------
    path : str or pathlib.Path
        File to read.

    Returns
    -------
    log : Log
        Equal to the one saved, bit for bit. Names of version 1 are replaced by today's.

    Raises
    ------
    InputError
        If the file is not a log of version 1 or 2.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            content = {name: file[name] for name in file.files}
        meta = json.loads(content.pop("meta").tobytes())
        version = meta.pop("version", None)
        if version not in (1, _VERSION):
            raise InputError(f"path must be a log of version 1 or {_VERSION}, {path} was of {version!r}")
        if version == 1:
            content, meta = _renamed(content), _renamed(meta)
            meta["events"] = [(t, _VERSION_1.get(f"event {e}", e), name) for t, e, name in meta["events"]]
        ends = np.cumsum(content.pop("received_sizes")).tolist()
        blob, rows = content.pop("received_bytes").tobytes(), content.pop("received_rows").tolist()
        meta["received"] = tuple(
            (row, blob[begin:end]) for row, begin, end in zip(rows, [0, *ends][:-1], ends, strict=True)
        )
        meta["reasons"] = tuple(map(tuple, meta.get("reasons", ())))
        meta["scenario"] = from_dict(Scenario, meta["scenario"])
        meta |= {name: tuple(map(tuple, meta[name])) for name in ("decisions", "events")}
        return Log(**content, **meta)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, BadZipFile) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"path must be a file written by save_log, {path} was not: {error}") from None


def _renamed(content: dict[str, Any]) -> dict[str, Any]:
    return {_VERSION_1.get(name, name): value for name, value in content.items()}

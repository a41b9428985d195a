"""Logs as files: arrays and JSON in one npz, without pickle."""

import json
from dataclasses import fields
from pathlib import Path as FilePath
from zipfile import BadZipFile

import numpy as np

from cca_core.errors import InputError
from cca_core.serial import from_dict, to_dict
from cca_core.sim.log import Log
from cca_core.sim.scenarios.scenario import Scenario

__all__ = ["load_log", "save_log"]

_VERSION = 1
_ARRAYS = tuple(
    "t ego a_y command place tracking users user_motion user_frenet seen heard held fallback cycle_us".split()
)


def save_log(log: Log, path: str | FilePath) -> None:
    """Write a log to a file.

    Parameters
    ----------
    log : Log
        The run.
    path : str or pathlib.Path
        File to write, as a rule ``.npz``; its folder exists.

    Notes
    -----
    Every number is kept exactly; the scenario is JSON as by `to_dict`, and so are decisions and events.
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
        Equal to the one saved, bit for bit.

    Raises
    ------
    InputError
        If the file is no log, or one of another version.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            content = {name: file[name] for name in file.files}
        meta = json.loads(content.pop("meta").tobytes())
    except (OSError, ValueError, KeyError, AttributeError, EOFError, BadZipFile) as error:
        raise InputError(f"path must be a file written by save_log, {path} was not: {error}") from None
    if meta.pop("version", None) != _VERSION:
        raise InputError(f"path must be a log of version {_VERSION}, {path} was not")
    ends = np.cumsum(content.pop("received_sizes")).tolist()
    blob, rows = content.pop("received_bytes").tobytes(), content.pop("received_rows").tolist()
    received = tuple(
        (row, blob[begin:end]) for row, begin, end in zip(rows, [0, *ends][:-1], ends, strict=True)
    )
    meta["scenario"] = from_dict(Scenario, meta["scenario"])
    meta |= {name: tuple(map(tuple, meta[name])) for name in ("decisions", "events")}
    return Log(received=received, **content, **meta)

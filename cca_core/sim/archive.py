"""Logs as files: arrays and JSON in one npz, without pickle."""

import json
from dataclasses import fields, is_dataclass
from pathlib import Path as FilePath
from typing import Any
from zipfile import BadZipFile

import numpy as np

from cca_core.errors import InputError
from cca_core.evasion_settings import EvasionSettings
from cca_core.follow import SpeedSettings
from cca_core.path import Lane, Path, Road
from cca_core.sim.log import Log
from cca_core.sim.road_user import Brakes, Follows, RoadUser, Swerves
from cca_core.sim.scenario import PinnedGap, Scenario
from cca_core.v2x import ChannelSettings, SenderSettings
from cca_core.vehicle import VehicleParams

__all__ = ["load_log", "save_log"]

_VERSION = 1
_KINDS: dict[str, Any] = {
    kind.__name__: kind
    for kind in (
        Scenario, RoadUser, Brakes, Follows, Swerves, PinnedGap, VehicleParams, EvasionSettings,
        SpeedSettings, ChannelSettings, SenderSettings, Lane,
    )
}  # fmt: skip
_ARRAYS = tuple(
    "t ego a_y command place tracking users user_motion user_places seen heard held fallback cycle_us".split()
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
    Every number is kept exactly; scenario, decisions and events are JSON, in which infinity is ``Infinity``.
    """
    rest = {f.name: getattr(log, f.name) for f in fields(log) if f.name not in (*_ARRAYS, "received")}
    text = json.dumps({"version": _VERSION, **{name: _pack(value) for name, value in rest.items()}})
    rows = [row for row, _ in log.received]
    data = [message for _, message in log.received]
    with FilePath(path).open("wb") as file:
        np.savez_compressed(
            file, allow_pickle=False, meta=np.frombuffer(text.encode(), dtype=np.uint8),
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
    return Log(received=received, **content, **{name: _unpack(value) for name, value in meta.items()})


def _pack(value: Any) -> Any:
    """Describe a value in what JSON has."""
    if isinstance(value, Path):
        return {"Path": [value.breaks.tolist(), value.coefficients.tolist()]}
    if isinstance(value, Road):
        return {"Road": [_pack(value.path), _pack(value.lanes), value.speed_limit, list(value.stop_lines)]}
    if is_dataclass(value) and not isinstance(value, type):
        return {type(value).__name__: {f.name: _pack(getattr(value, f.name)) for f in fields(value)}}
    if isinstance(value, tuple):
        return {"tuple": [_pack(v) for v in value]}
    if isinstance(value, frozenset):
        return {"frozenset": sorted(value)}
    if isinstance(value, dict):
        return {"dict": {name: _pack(v) for name, v in value.items()}}
    return value.item() if isinstance(value, np.generic) else value


def _unpack(value: Any) -> Any:
    """Make a value of its description."""
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    if kind == "Path":
        return Path(*content)
    if kind == "Road":
        path, lanes, limit, lines = content
        return Road(_unpack(path), _unpack(lanes), limit, lines)
    if kind == "tuple":
        return tuple(_unpack(v) for v in content)
    if kind == "frozenset":
        return frozenset(content)
    made = {name: _unpack(v) for name, v in content.items()}
    return made if kind == "dict" else _KINDS[kind](**made)

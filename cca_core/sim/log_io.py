"""Logs as files: arrays and JSON in one npz, without pickle."""

import io
import json
import math
import struct
import tokenize
import warnings
import zlib
from dataclasses import fields
from pathlib import Path as FilePath
from typing import Any
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile

import numpy as np

from cca_core._checks import Array, Mask, shown
from cca_core._files import parse_json
from cca_core.errors import InputError
from cca_core.serial import from_dict, to_dict
from cca_core.sim.log import Log
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.vehicle import RemoteVehicle

__all__ = ["load_log", "save_log"]

_VERSION = 2
_MAX_BYTES = 1_000_000_000  # of the arrays: some 50 hours of driving
_ARRAYS = tuple(field.name for field in fields(Log) if field.type in (Array, Mask, Array | None))
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
    remotes = None if log.remotes is None else [list(map(to_dict, each)) for each in log.remotes]
    rest |= {"version": _VERSION, "scenario": to_dict(log.scenario), "remotes": remotes}
    text = json.dumps(rest, allow_nan=False)
    rows = [row for row, _ in log.received]
    data = [message for _, message in log.received]
    with FilePath(path).open("wb") as file:
        np.savez_compressed(
            file, meta=np.frombuffer(text.encode(), dtype=np.uint8),
            received_rows=np.array(rows, dtype=np.int64),
            received_sizes=np.array([len(message) for message in data], dtype=np.int64),
            received_bytes=np.frombuffer(b"".join(data), dtype=np.uint8),
            **{name: array for name in _ARRAYS if (array := getattr(log, name)) is not None},
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
        If the file is not a log of version 1 or 2, or its arrays have more than 1 GB.
    """
    try:
        content = _read_arrays(path)
        meta = parse_json(content.pop("meta").tobytes(), "meta")
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
        meta["overlaps"] = tuple(
            (float(t), str(one), str(other), float(v)) for t, one, other, v in meta.get("overlaps", ())
        )
        meta["cycle_reasons"] = tuple(map(str, meta.get("cycle_reasons", ())))
        meta["scenario"] = from_dict(Scenario, meta["scenario"])
        if meta.get("remotes") is not None:
            meta["remotes"] = tuple(
                tuple(from_dict(RemoteVehicle, remote) for remote in cycle) for cycle in meta["remotes"]
            )
        meta |= {name: tuple(map(tuple, meta[name])) for name in ("decisions", "events")}
        log = Log(**({"cycle_us": None} | content), **meta)
        _check_shapes(log)
        return log
    except InputError:
        raise
    except (
        OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, EOFError, BadZipFile,
        SyntaxError, OverflowError, RuntimeError, MemoryError, zlib.error, struct.error, tokenize.TokenError,
    ) as error:  # fmt: skip
        raise InputError(f"path must be a file written by save_log, {shown(path)} was not: {error}") from None


def _read_arrays(path: str | FilePath) -> dict[str, Any]:
    """Return the arrays of an archive of bounded size."""
    with ZipFile(path) as archive:
        members = archive.infolist()
        if sum(member.file_size for member in members) > _MAX_BYTES:
            raise InputError(f"path must be a log of at most {_MAX_BYTES // 1_000_000} MB")
        content = {}
        for member in members:
            if member.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
                raise ValueError(f"{member.filename} is compressed in another way")
            with archive.open(member) as stream:
                content[member.filename.removesuffix(".npy")] = _array(stream.read(member.file_size))
        return content


def _array(data: bytes) -> Array:
    """Return the array in the content of an npy file."""
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    if version not in ((1, 0), (2, 0)):
        raise ValueError(f"an array has format {version}")
    read_header = (
        np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of headers as Python 2 wrote them
        shape, is_fortran, dtype = read_header(stream)
    begin = stream.tell()
    if min(shape, default=0) < 0 or math.prod(shape) * dtype.itemsize != len(data) - begin or dtype.hasobject:
        raise ValueError(f"an array of {len(data) - begin} bytes cannot have shape {shape}")
    flat = np.frombuffer(data, dtype, offset=begin) if begin < len(data) else np.empty(0, dtype)
    array: Array = flat.reshape(shape, order="F" if is_fortran else "C").copy()
    return array


def _check_shapes(log: Log) -> None:
    """Raise if the arrays of a log do not fit each other."""
    n, users = len(log.t), len(log.scenario.road_users)
    per_user = {"road_users": (4,), "user_motion": (2,), "user_frenet": (2,), "visible": (), "tracked": ()}
    per_cycle = {"ego": (8,), "command": (2,), "ego_frenet": (2,)}
    for name in _ARRAYS:
        array = getattr(log, name)
        if array is None:
            continue
        inner = (users, *per_user[name]) if name in per_user else per_cycle.get(name, ())
        if array.shape != (n, *inner) or array.dtype.kind not in "bf" or not n:
            raise ValueError(f"{name} has shape {array.shape} and type {array.dtype}, t has {n} times")
    if len(log.cycle_reasons) not in (0, n):
        raise ValueError(f"cycle_reasons has {len(log.cycle_reasons)} cycles, t has {n} times")
    if log.remotes is not None and len(log.remotes) != n:
        raise ValueError(f"remotes has {len(log.remotes)} cycles, t has {n} times")


def _renamed(content: dict[str, Any]) -> dict[str, Any]:
    return {_VERSION_1.get(name, name): value for name, value in content.items()}

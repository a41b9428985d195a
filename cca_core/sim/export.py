"""Rows of a run as files for other programs: CSV, Parquet (extra ``parquet``), MCAP (extra ``mcap``)."""

import csv
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array, Index, shown
from cca_core._optional import require_extra
from cca_core.errors import InputError

if TYPE_CHECKING:
    from cca_core.sim.log import Log

Columns = dict[str, "np.ndarray[Any, Any]"]
"""Values of each column, one for each cycle."""

Message = tuple[str, str, float, dict[str, Any]]
"""Topic, name of the schema, time [s] and content."""

_EGO = "x", "y", "psi", "v_x", "v_y", "r", "delta", "a_x"
_USER = "x", "y", "psi", "v_x", "a_x", "r", "s", "d"
_DIAGNOSTICS = (
    "v_x", "v_y", "r", "a_x", "a_y", "delta", "s", "d", "tracking_error", "gap", "degraded", "action",
)  # fmt: skip


def decision_index(log: "Log") -> Index:
    """Return the index of the decision of each cycle."""
    return np.searchsorted([t for t, _, _ in log.decisions], log.t, side="right") - 1


def reasons_of_cycles(log: "Log") -> Sequence[str]:
    """Return the reason of each cycle; in a log of a file without them, that of its decision."""
    return log.cycle_reasons or [log.decisions[i][2] for i in decision_index(log)]


def run_columns(log: "Log") -> Columns:
    """Return everything that changes from cycle to cycle; the numbers of absent vehicles are NaN."""
    gaps, present, index = log.gaps(), log.present, decision_index(log)
    columns: Columns = {
        "t": log.t, **dict(zip(_EGO, log.ego.T, strict=True)), "a_y": log.a_y,
        "delta_command": log.command[:, 0], "a_x_command": log.command[:, 1],
        "s": log.ego_frenet[:, 0], "d": log.ego_frenet[:, 1], "tracking_error": log.tracking,
        "gap": gaps.min(axis=1, initial=np.inf), "degraded": log.degraded,
        "action": np.array([action for _, action, _ in log.decisions])[index],
        "reason": np.array(reasons_of_cycles(log)),
    }  # fmt: skip
    for i, user in enumerate(log.scenario.road_users):
        motion = np.column_stack((log.road_users[:, i], log.user_motion[:, i], log.user_frenet[:, i]))
        columns |= {f"{user.id}.{name}": values for name, values in zip(_USER, motion.T, strict=True)}
        columns[f"{user.id}.gap"] = np.where(present[:, i], gaps[:, i], np.nan)
        columns |= {f"{user.id}.visible": log.visible[:, i], f"{user.id}.tracked": log.tracked[:, i]}
    return columns


def write_table(columns: Columns, path: str | FilePath) -> None:
    """Write columns to a file that ends with .csv or .parquet."""
    ending = FilePath(path).suffix.lower()
    if ending == ".parquet":
        table = require_extra("pyarrow", "parquet").table(columns)
        require_extra("pyarrow.parquet", "parquet").write_table(table, str(path))
    elif ending == ".csv":
        with FilePath(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            cells = ([_cell(value) for value in column.tolist()] for column in columns.values())
            writer.writerows(zip(*cells, strict=True))
    else:
        raise InputError(f"path must end with .csv or .parquet, was {shown(str(path))}")


def _cell(value: Any) -> Any:
    """Return a value as text that reads back exactly; empty if it is unknown."""
    if isinstance(value, bool):
        return int(value)
    return "" if isinstance(value, float) and math.isnan(value) else value


def write_mcap(log: "Log", path: str | FilePath, start_time: float) -> None:
    """Write a run as JSON messages with a schema for each channel; t = 0 is the start time [s]."""
    writer_module = require_extra("mcap.writer", "mcap")
    messages = sorted(_messages(log, start_time), key=lambda message: message[2])
    channels: dict[str, int] = {}
    with FilePath(path).open("wb") as file:
        writer = writer_module.Writer(file)
        writer.start(library="cca_core")
        for topic, name, t, content in messages:
            if topic not in channels:
                schema = json.dumps({"title": name, **_schema(content)}).encode()
                schema_id = writer.register_schema(name, "jsonschema", schema)
                channels[topic] = writer.register_channel(topic, "json", schema_id)
            stamp = _nanoseconds(t + start_time)
            data = json.dumps(content, allow_nan=False).encode()
            writer.add_message(channels[topic], log_time=stamp, data=data, publish_time=stamp)
        writer.finish()


def _messages(log: "Log", start_time: float) -> Iterator[Message]:
    """Yield pose, vehicles, command and diagnostics of each cycle, then decisions and events."""
    columns = run_columns(log)
    bodies = _bodies(log)
    present_before: set[str] = set()
    for k, values in enumerate(zip(*(column.tolist() for column in columns.values()), strict=True)):
        row = dict(zip(columns, values, strict=True))
        t, stamp = row["t"], _stamp(row["t"] + start_time)
        pose = {"timestamp": stamp, "frame_id": "map", "pose": _pose(row["x"], row["y"], row["psi"])}
        yield "/ego/pose", "foxglove.PoseInFrame", t, pose
        boxes = {name: box[k].tolist() for name, box in bodies.items() if math.isfinite(box[k, 0])}
        gone = sorted(present_before - boxes.keys())
        scene = {
            "deletions": [{"timestamp": stamp, "type": 0, "id": name} for name in gone],
            "entities": [_entity(name, box, stamp) for name, box in boxes.items()],
        }
        present_before = set(boxes)
        yield "/vehicles", "foxglove.SceneUpdate", t, scene
        command = {"timestamp": stamp, "delta": row["delta_command"], "a_x": row["a_x_command"]}
        yield "/command", "cca.Command", t, command
        diagnostics = {"timestamp": stamp, **{name: _finite(row[name]) for name in _DIAGNOSTICS}}
        yield "/diagnostics", "cca.Diagnostics", t, diagnostics
    for t, action, reason in log.decisions:
        yield "/decisions", "foxglove.Log", t, _log(t + start_time, "planner", f"{action}: {reason}")
    for t, kind, vehicle_id in log.events:
        yield "/events", "foxglove.Log", t, _log(t + start_time, vehicle_id, kind.replace("_", " "))


def _bodies(log: "Log") -> dict[str, Array]:
    """Return x, y [m], psi [rad], length and width [m] of each body by cycle, the ego first."""
    stacked = []
    for box in log.bodies():
        fields = np.broadcast_arrays(box.x, box.y, box.psi, box.length, box.width)
        stacked.append(np.stack(fields, axis=-1))
    names = ["ego", *(user.id for user in log.scenario.road_users)]
    return dict(zip(names, np.concatenate(stacked, axis=1).swapaxes(0, 1), strict=True))


def _nanoseconds(t: float) -> int:
    if not 0.0 <= t < 1.8e10:  # 2^64 ns, as MCAP stores times
        raise InputError(f"start_time must be such that times are from 0 to 1.8e10 s, one was {t:g} s")
    return round(1e9 * t)


def _stamp(t: float) -> dict[str, int]:
    seconds, nanoseconds = divmod(_nanoseconds(t), 1_000_000_000)
    return {"sec": seconds, "nsec": nanoseconds}


def _pose(x: float, y: float, psi: float, z: float = 0.0) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(0.5 * psi), "w": math.cos(0.5 * psi)}
    return {"position": {"x": x, "y": y, "z": z}, "orientation": turn}


def _entity(name: str, box: Sequence[float], stamp: dict[str, int], *, height: float = 1.5) -> dict[str, Any]:
    """Return a vehicle as a scene entity; its height [m] is that of the drawing."""
    x, y, psi, length, width = box
    red, green, blue = (0.0, 0.45, 0.70) if name == "ego" else (0.90, 0.45, 0.0)
    color = {"r": red, "g": green, "b": blue, "a": 1.0}
    size = {"x": length, "y": width, "z": height}
    cube = {"pose": _pose(x, y, psi, 0.5 * height), "size": size, "color": color}
    text = {
        "pose": _pose(x, y, 0.0, height + 0.5), "billboard": True, "font_size": 1.0, "scale_invariant": False,
        "color": color, "text": name,
    }  # fmt: skip
    empty: dict[str, list[Any]] = {
        kind: [] for kind in ("metadata", "arrows", "spheres", "cylinders", "lines", "triangles", "models")
    }
    return {
        "timestamp": stamp, "frame_id": "map", "id": name, "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": False, "cubes": [cube], "texts": [text], **empty,
    }  # fmt: skip


def _log(t: float, name: str, message: str) -> dict[str, Any]:
    """Return an entry of level 2, information."""
    return {"timestamp": _stamp(t), "level": 2, "message": message, "name": name, "file": "", "line": 0}


def _finite(value: Any) -> Any:
    """Return a value, or None if it is a number that JSON does not know."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _schema(value: Any) -> dict[str, Any]:
    """Return the JSON schema of a value like this one."""
    if isinstance(value, dict):
        return {"type": "object", "properties": {name: _schema(each) for name, each in value.items()}}
    if isinstance(value, list):
        return {"type": "array", "items": _schema(value[0]) if value else {"type": "object"}}
    kinds = {bool: "boolean", int: "integer", str: "string", float: ["number", "null"]}
    return {"type": kinds.get(type(value), ["number", "null"])}

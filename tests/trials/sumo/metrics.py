"""Measures of an episode: gaps, deceleration needed, comfort, and the row of the table."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cca_core import Path, RemoteVehicle, VehicleState
from cca_core.geometry import box_gap, boxes
from tests.trials.sumo.glue import CAR

HARD = -4.0  # command from which braking is hard [m/s^2]
UNNEEDED = 2.0  # hard braking is unneeded if less deceleration suffices [m/s^2]
COLUMNS = (
    *("scenario", "n", "min", "collisions", "min gap", "v/desired", "SUMO's v", "KEEP/FOLLOW/EVADE/BRAKE %"),
    *(
        "maneuvers",
        "hard (unneeded)",
        "a_y rms/max",
        "j_x rms/max",
        "j_y rms/max",
        "reversals/min",
        "DEGRADED %",
    ),
    "cycle CPU ms median/p99/worst",
)


def min_gap(x: float, y: float, psi: float, near: Sequence[RemoteVehicle]) -> float:
    """Least distance between the ego's box and those near it [m]."""
    near = [o for o in near if abs(o.x - x) + abs(o.y - y) < 60.0]
    if not near:
        return 99.0
    table = np.array([(o.x, o.y, o.psi, o.length, o.width) for o in near]).T
    return float(np.min(box_gap(boxes(x, y, psi, CAR.length, CAR.width), boxes(*table))))


def needed_deceleration(
    path: Path, s: float, d: float, ego: VehicleState, near: Sequence[RemoteVehicle]
) -> float:
    """Deceleration that keeps 0.5 m to all vehicles ahead in the ego's corridor, if they brake on [m/s^2]."""
    needed = 0.0
    for other in near:
        distance = math.hypot(other.x - ego.x, other.y - ego.y)
        ahead = math.cos(ego.psi) * (other.x - ego.x) + math.sin(ego.psi) * (other.y - ego.y)
        if distance > 200.0:
            continue
        s_o, d_o, heading, _ = path.foot_point(other.x, other.y, s + math.copysign(distance, ahead))
        if s_o < s or abs(d_o - d) > 0.5 * (CAR.width + other.width) + 0.2:
            continue
        gap, v_o = (
            s_o - s - 0.5 * (CAR.length + other.length) - 0.5,
            other.v_x * math.cos(other.psi - heading),
        )
        needed = max(needed, _needed_for(gap, ego.v_x, v_o, other.a_x))
    return needed


def _needed_for(gap: float, v: float, v_o: float, a_o: float) -> float:
    """Deceleration that keeps a gap to a vehicle of a speed and acceleration [m/s^2]."""
    if gap <= 0.0:
        return 9.9 if v > v_o - 0.1 else 0.0
    if v_o < 0.0:
        return 0.5 * v * v / gap
    needed = 0.5 * (v - v_o) ** 2 / gap if v > v_o else 0.0
    return max(needed, 0.5 * v * v / (gap - 0.5 * v_o * v_o / a_o)) if a_o < -0.5 else needed


def reversals(delta: np.ndarray, threshold: float = 0.002) -> int:
    """Number of reversals of the steering by at least 2 degrees at the steering wheel."""
    count, direction, extreme = 0, 0.0, delta[0]
    for now in delta:
        if direction * (now - extreme) >= 0.0 and direction:
            extreme = now
        elif abs(now - extreme) > threshold:
            count, direction, extreme = count + bool(direction), math.copysign(1.0, now - extreme), now
    return count


def hard_brakings(commands: np.ndarray, needed: np.ndarray) -> list[float]:
    """Deceleration needed around each hard braking [m/s^2]."""
    found, i = [], 0
    while i < len(commands):
        if commands[i] < HARD:
            end = i
            while end + 1 < len(commands) and commands[end + 1] < HARD + 1.0:
                end += 1
            found.append(float(needed[max(0, i - 15) : end + 26].max()))
            i = end
        i += 1
    return found


def summarize(rows: list[dict[str, Any]], cpu: list[float]) -> dict[str, Any]:
    """Figures of one episode from its cycles of 20 ms."""
    column = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    a_mean, y_mean = (np.convolve(column[name], np.ones(5) / 5.0, "valid") for name in ("a_x", "a_y"))
    hard = hard_brakings(column["command"], column["needed"])
    evades = np.array([name.startswith("EVADE") for name in column["action"]])
    return {
        "minutes": len(rows) * 0.02 / 60.0,
        "collided": bool(column["gap"].min() < 0.0),
        "gap": column["gap"].min(),
        "v": column["v"].mean(),
        "hard": len(hard),
        "unneeded": sum(need < UNNEEDED for need in hard),
        "maneuvers": int((np.diff(evades.astype(int)) > 0).sum() + evades[0]),
        "reversals": reversals(column["delta"]),
        "fractions": [np.mean(column["action"] == name) for name in ("KEEP", "FOLLOW")] + [evades.mean()],
        "a_y": column["a_y"],
        "j_x": np.diff(a_mean) / 0.02,
        "j_y": np.diff(y_mean) / 0.02,
        "degraded": np.mean(column["status"] == "DEGRADED"),
        "cpu": 1e3 * np.array(cpu),
    }


def table_row(name: str, episodes: list[dict[str, Any]], desired: float, baseline: list[float]) -> str:
    """Row of the table for a scenario."""

    def mean(key: str) -> float:
        return float(np.mean([e[key] for e in episodes]))

    def total(key: str) -> float:
        return sum(e[key] for e in episodes)

    def rms_max(key: str) -> str:
        whole = np.concatenate([e[key] for e in episodes])
        return f"{np.sqrt(np.mean(whole**2)):.2f}/{np.abs(whole).max():.1f}"

    percent = 100.0 * np.mean([e["fractions"] for e in episodes], axis=0)
    cycles = np.percentile(np.concatenate([e["cpu"] for e in episodes]), [50, 99, 100])
    cells = (
        name,
        len(episodes),
        f"{total('minutes'):.1f}",
        total("collided"),
        f"{min(e['gap'] for e in episodes):.2f}",
        f"{mean('v'):.1f}/{desired:.0f}",
        f"{np.mean(baseline):.1f}" if baseline else "-",
        "/".join(f"{v:.0f}" for v in [*percent, 100.0 - percent.sum()]),
        total("maneuvers"),
        f"{total('hard')} ({total('unneeded')})",
        rms_max("a_y"),
        rms_max("j_x"),
        rms_max("j_y"),
        f"{total('reversals') / total('minutes'):.1f}",
        f"{100.0 * mean('degraded'):.2f}",
        f"{cycles[0]:.2f}/{cycles[1]:.1f}/{cycles[2]:.0f}",
    )
    return " | ".join(map(str, cells))

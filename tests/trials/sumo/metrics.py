"""Measures of an episode: gaps, deceleration needed, comfort, and the row of the table."""

# fmt: off

import math

import numpy as np

from cca_core import Path, VehicleState
from cca_core.geometry import box_gap, boxes
from tests.trials.sumo.glue import CAR, Other

COLUMNS = (
    "scenario", "n", "min", "contacts", "least gap", "v/wished", "SUMO's v", "KEEP/FOLLOW/EVADE/BRAKE %", "evasions",
    "hard (unneeded)", "a_y rms/max", "j_x rms/max", "j_y rms/max", "reversals/min", "FALLBACK %",
    "cycle CPU ms median/p99/worst",
)


def min_gap(x: float, y: float, psi: float, near: list[Other]) -> float:
    """Least distance between the ego's box and those near it [m]."""
    near = [o for o in near if abs(o.x - x) + abs(o.y - y) < 60.0]
    if not near:
        return 99.0
    table = np.array([(o.x, o.y, o.psi, o.length, o.width) for o in near]).T
    return float(np.min(box_gap(boxes(x, y, psi, CAR.length, CAR.width), boxes(*table))))


def needed(path: Path, s: float, d: float, ego: VehicleState, near: list[Other]) -> float:
    """Deceleration that keeps 0.5 m off who is ahead in the ego's corridor and brakes on to a stand [m/s^2]."""
    most = 0.0
    for o in near:
        away = math.hypot(o.x - ego.x, o.y - ego.y)
        ahead = math.cos(ego.psi) * (o.x - ego.x) + math.sin(ego.psi) * (o.y - ego.y)
        if away > 200.0:
            continue
        s_o, d_o, heading, _ = path.foot_point(o.x, o.y, s + math.copysign(away, ahead))
        if s_o < s or abs(d_o - d) > 0.5 * (CAR.width + o.width) + 0.2:
            continue
        room, v, v_o = s_o - s - 0.5 * (CAR.length + o.length) - 0.5, ego.v_x, o.v * math.cos(o.psi - heading)
        if room <= 0.0:
            most = max(most, 9.9 if v > v_o - 0.1 else 0.0)
        elif v_o < 0.0:
            most = max(most, 0.5 * v * v / room)
        else:
            most = max(most, 0.5 * (v - v_o) ** 2 / room if v > v_o else 0.0)
            if o.a < -0.5:
                most = max(most, 0.5 * v * v / (room - 0.5 * v_o * v_o / o.a))
    return most


def reversals(delta: np.ndarray, least: float = 0.002) -> int:
    """Turns of the steering by at least 2 degrees of the wheel in the driver's hands."""
    count, direction, extreme = 0, 0, delta[0]
    for now in delta:
        if direction * (now - extreme) >= 0.0 and direction:
            extreme = now
        elif abs(now - extreme) > least:
            count, direction, extreme = count + bool(direction), math.copysign(1.0, now - extreme), now
    return count


def summarize(rows: list[dict], cpu: list[float]) -> dict:
    """Figures of one episode from its cycles of 20 ms."""
    column = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    a_mean, y_mean = (np.convolve(column[name], np.ones(5) / 5.0, "valid") for name in ("a_x", "a_y"))
    hard, wanted, i = [], column["wanted"], 0
    while i < len(rows):
        if wanted[i] < -4.0:
            end = i
            while end + 1 < len(rows) and wanted[end + 1] < -3.0:
                end += 1
            hard.append(column["needed"][max(0, i - 15) : end + 26].max())
            i = end
        i += 1
    evades = np.array([name.startswith("EVADE") for name in column["action"]])
    return {
        "minutes": len(rows) * 0.02 / 60.0, "contact": bool(column["gap"].min() < 0.0), "gap": column["gap"].min(),
        "v": column["v"].mean(), "hard": len(hard), "unneeded": sum(need < 2.0 for need in hard),
        "evasions": int((np.diff(evades.astype(int)) > 0).sum() + evades[0]), "reversals": reversals(column["delta"]),
        "shares": [np.mean(column["action"] == name) for name in ("KEEP", "FOLLOW")] + [evades.mean()],
        "a_y": column["a_y"], "j_x": np.diff(a_mean) / 0.02, "j_y": np.diff(y_mean) / 0.02,
        "fallback": np.mean(column["status"] == "FALLBACK"), "cpu": 1e3 * np.array(cpu),
    }


def table_row(name: str, episodes: list[dict], wished: float, baseline: list[float]) -> str:
    """Row of the table for a scenario."""
    def mean(key):
        return np.mean([e[key] for e in episodes])

    def rms_max(key):
        whole = np.concatenate([e[key] for e in episodes])
        return f"{np.sqrt(np.mean(whole**2)):.2f}/{np.abs(whole).max():.1f}"

    shares = 100.0 * np.mean([e["shares"] for e in episodes], axis=0)
    minutes = sum(e["minutes"] for e in episodes)
    cycles = np.percentile(np.concatenate([e["cpu"] for e in episodes]), [50, 99, 100])
    return " | ".join((
        name, str(len(episodes)), f"{minutes:.1f}", str(sum(e["contact"] for e in episodes)),
        f"{min(e['gap'] for e in episodes):.2f}", f"{mean('v'):.1f}/{wished:.0f}",
        f"{np.mean(baseline):.1f}" if baseline else "-", "/".join(f"{v:.0f}" for v in [*shares, 100.0 - shares.sum()]),
        str(sum(e["evasions"] for e in episodes)),
        f"{sum(e['hard'] for e in episodes)} ({sum(e['unneeded'] for e in episodes)})", rms_max("a_y"), rms_max("j_x"),
        rms_max("j_y"), f"{sum(e['reversals'] for e in episodes) / minutes:.1f}", f"{100.0 * mean('fallback'):.2f}",
        f"{cycles[0]:.2f}/{cycles[1]:.1f}/{cycles[2]:.0f}",
    ))

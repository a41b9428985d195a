"""The statements of the paper's Table 1: figures for and against each, and the result by a fixed rule."""

import math
from collections.abc import Sequence
from pathlib import Path

from cca_core.baselines.table1.closed_loop import ClosedLoop
from cca_core.baselines.table1.experiment import (
    BAND,
    BANDS,
    EQ9,
    FATROP,
    IPOPT,
    LATTICE,
    LINEAR,
    SEEDS,
    SMOOTH,
    STAR,
    TREE,
)
from cca_core.baselines.table1.scaling import ScalingResult
from cca_core.baselines.table1.statistics import Statistics, code_lines, number

_CYCLE_MS = 20.0  # cycle of the controller: a method below it is fast [ms]
_MODULES = {
    BAND: (
        "band/*.py",
        "kernel/band_*.py",
        "kernel/equilibrium*.py",
        "kernel/stiffness.py",
        "baselines/methods/band_methods.py",
    ),
    LATTICE: tuple(f"baselines/methods/{name}.py" for name in ("primitive*", "free_space")),
    TREE: tuple(f"baselines/methods/{name}.py" for name in ("rrt", "road_space", "free_space")),
    LINEAR: tuple(
        f"baselines/methods/mpc/{name}.py"
        for name in ("horizon", "side_choice", "trajectory", "linear", "lateral_qp")
    ),
    FATROP: ("baselines/methods/mpc/[!_p]*.py",),
}


def statement_values(
    m: Statistics, scaling: Sequence[ScalingResult], drives: Sequence[ClosedLoop]
) -> dict[str, str]:
    """Values of the placeholders in the table of statements."""
    fastest = min(m.time(name) for name in BANDS)
    return {
        "band_ms": number(fastest), "cycle_ms": f"{_CYCLE_MS:.0f}",
        **_code_values(m), **_lattice_values(m), **_tree_values(m, scaling, fastest),
        **_mpc_values(m, drives, fastest), **_band_values(m),
    }  # fmt: skip


def result(confirmed: bool, refuted: bool = False) -> str:
    """Return the result of a rule."""
    return "confirmed" if confirmed else "refuted" if refuted else "qualified"


def _code_values(m: Statistics) -> dict[str, str]:
    """Lines of code, and what follows from them."""
    package = Path(__file__).resolve().parents[2]
    lines = {
        name: sum(code_lines(file) for pattern in patterns for file in package.glob(pattern))
        for name, patterns in _MODULES.items()
    }
    fewest = min(lines.values())
    fast = max(m.time(LATTICE, 99), m.time(LATTICE, field="first_ms")) < _CYCLE_MS
    return {
        "lines": ", ".join(f"{name} {count}" for name, count in lines.items()),
        "tree_lines": f"{lines[TREE]}", "lattice_lines": f"{lines[LATTICE]}",
        "simple_result": result(lines[LATTICE] <= fewest and fast),
        "easy_result": result(lines[TREE] <= fewest),
    }  # fmt: skip


def _lattice_values(m: Statistics) -> dict[str, str]:
    """Values of motion primitives."""
    gaps = m.solved(LATTICE, "narrow gap")
    a_y, jerk = m.ratio(LATTICE, LINEAR, "a_y"), m.ratio(LATTICE, LINEAR, "driven_jerk")
    return {
        "lattice_ms": number(m.time(LATTICE)), "lattice_p99": number(m.time(LATTICE, 99)),
        "lattice_first": number(m.time(LATTICE, field="first_ms")),
        "lattice_gaps": f"{gaps:.0f}", "band_gaps": f"{m.solved(BAND, 'narrow gap'):.0f}",
        "lattice_a_y": number(a_y), "lattice_jerk": number(jerk),
        "flexible_result": result(
            gaps < 90.0 and max(a_y, jerk) > 1.1, gaps >= 90.0 and max(a_y, jerk) < 1.1
        ),
        "unnatural_result": result(jerk > 1.5, jerk < 1.1),
    }  # fmt: skip


def _tree_values(m: Statistics, scaling: Sequence[ScalingResult], fastest: float) -> dict[str, str]:
    """Values of random trees."""
    jerk, factor = m.ratio(TREE, LINEAR, "driven_jerk"), m.time(TREE) / fastest
    peaks = [r.peak for r in scaling if r.axis == SEEDS and math.isfinite(r.peak)]
    spread = max(peaks) - min(peaks) if peaks else math.nan
    return {
        "tree_solved": f"{m.solved(TREE):.0f}", "star_solved": f"{m.solved(STAR):.0f}",
        "tree_tracking": number(max((r.tracking for r in m.solvable(TREE, "solved")), default=math.nan)),
        "band_tracking": number(max((r.tracking for r in m.solvable(BAND, "solved")), default=math.nan)),
        "tree_ms": number(m.time(TREE)), "tree_p99": number(m.time(TREE, 99)), "tree_factor": number(factor),
        "star_ms": number(m.time(STAR)), "star_p99": number(m.time(STAR, 99)),
        "slow_tree_result": result(factor > 3.0, factor < 1.0),
        "tree_spread": number(spread), "tree_jerk": number(jerk),
        "tree_reversals": number(m.mean(TREE, "a_y_reversals")),
        "linear_reversals": number(m.mean(LINEAR, "a_y_reversals")),
        "random_result": result(jerk > 1.5 and spread > 0.3, jerk < 1.1 and spread < 0.1),
    }  # fmt: skip


def _mpc_values(m: Statistics, drives: Sequence[ClosedLoop], fastest: float) -> dict[str, str]:
    """Values of model predictive control."""
    mpc = [drive for drive in drives if drive.planner != "band"]
    completed = sum(drive.completed for drive in mpc)
    linear, fatrop = m.time(LINEAR) / fastest, m.time(FATROP) / fastest
    return {
        "mpc_completed": f"{completed}", "mpc_drives": f"{len(mpc)}",
        "online_result": result(completed == len(mpc)),
        "linear_ms": number(m.time(LINEAR)), "linear_factor": number(linear),
        "fatrop_ms": number(m.time(FATROP)), "fatrop_factor": number(fatrop),
        "ipopt_ms": number(m.time(IPOPT)), "ipopt_factor": number(m.time(IPOPT) / fastest),
        "slow_mpc_result": result(linear > 3.0 and fatrop > 3.0, linear < 1.0 and fatrop < 1.0),
    }  # fmt: skip


def _band_values(m: Statistics) -> dict[str, str]:
    """Values of the elastic bands."""
    wrong = len(m.of(EQ9, "false OK"))
    relaxed_wrong = len(m.of(BAND, "false OK")) + len(m.of(SMOOTH, "false OK"))
    return {
        "eq9_result": result(wrong == 0, wrong > 0), "relaxed_result": result(relaxed_wrong == 0),
        "eq9_wrong": f"{wrong}", "eq9_plans": f"{len(m.of(EQ9))}",
        "eq9_collisions": f"{m.collisions(EQ9)}",
        "relaxed_wrong": f"{relaxed_wrong}", "relaxed_plans": f"{len(m.of(BAND)) + len(m.of(SMOOTH))}",
        "relaxed_ms": number(m.time(BAND)), "smoothed_ms": number(m.time(SMOOTH)),
    }  # fmt: skip

"""What was measured, with the numbers that the page quotes."""

import ast
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cca_core.baselines.closed_loop import ClosedLoop
from cca_core.baselines.compare import ComparisonRow
from cca_core.baselines.scaling import ScalingResult

AXES = ("nodes or intervals on 120 m", "length [m]", "cars on 300 m")
SEEDS = "seed of the tree"
EQ9, BAND, SMOOTH = "band, eq 9", "band, relaxed", "band, QP"
LATTICE, TREE, STAR = "primitives", "RRT", "RRT*"
LINEAR, FATROP, IPOPT = "LTV MPC", "NMPC, FATROP", "NMPC, IPOPT"
OURS = (BAND, SMOOTH)
FAST = 20.0  # a cycle of the controller [ms]
MODULES = {
    BAND: ("band/*.py", "baselines/ours.py"),
    LATTICE: ("baselines/primitives.py", "baselines/shifts.py", "baselines/free_space.py"),
    TREE: ("baselines/rrt.py", "baselines/rrt_corridor.py", "baselines/free_space.py"),
    LINEAR: tuple(f"baselines/mpc/{name}.py" for name in ("horizon", "sides", "trajectory", "linear*")),
    FATROP: ("baselines/mpc/[!_p]*.py",),
}  # fmt: skip
Lines = list[str]


class Measured:
    """What was measured, with the numbers that the page quotes."""

    def __init__(
        self,
        rows: Sequence[ComparisonRow],
        growth: Sequence[ScalingResult],
        drives: Sequence[ClosedLoop],
        modules: Path,
    ) -> None:
        self.rows, self.growth, self.drives = rows, growth, drives
        self.methods = list(dict.fromkeys(row.method for row in rows))
        self.lines = {
            name: sum(code_lines(file) for pattern in patterns for file in modules.glob(pattern))
            for name, patterns in MODULES.items()
        }

    def of(self, method: str, *outcomes: str, kind: str | None = None) -> list[ComparisonRow]:
        return [
            row for row in self.rows
            if row.method == method and (not outcomes or row.outcome in outcomes)
            and (kind is None or row.kind == kind)
        ]  # fmt: skip

    def open(self, method: str, *outcomes: str) -> list[ComparisonRow]:
        return [row for row in self.of(method, *outcomes) if row.kind != "blocked"]

    def solved(self, method: str, kind: str | None = None) -> float:
        """Share of the solvable problems that are solved [%]."""
        every = [row for row in self.of(method, kind=kind) if kind is not None or row.kind != "blocked"]
        return 100.0 * sum(row.outcome == "solved" for row in every) / max(len(every), 1)

    def time(self, method: str, share: float = 50.0, field: str = "time_ms") -> float:
        values = [getattr(row, field) for row in self.of(method)]
        finite = [value for value in values if math.isfinite(value)]
        return float(np.percentile(finite, share)) if finite else math.nan

    def ratio(self, method: str, other: str, field: str) -> float:
        """Median ratio of a figure on the problems that both have solved."""
        mine = {(r.kind, r.seed): getattr(r, field) for r in self.open(method, "solved")}
        theirs = {(r.kind, r.seed): getattr(r, field) for r in self.open(other, "solved")}
        both = [mine[key] / theirs[key] for key in mine.keys() & theirs.keys() if theirs[key]]
        return float(np.median(both)) if both else math.nan

    def median(self, method: str, field: str) -> float:
        values = [getattr(row, field) for row in self.open(method, "solved")]
        return float(np.median(values)) if values else math.nan


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def num(value: float, digits: int = 2) -> str:
    if not math.isfinite(value):
        return "-"
    if abs(value) >= 10.0:
        return f"{value:.0f}"
    return f"{value:.{digits - 1}f}" if abs(value) >= 1.0 or not value else f"{value:.{digits}g}"


def code_lines(file: Path) -> int:
    """Lines of a module without docstrings, comments and blank lines."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [  # type: ignore[attr-defined]
                each for each in body
                if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))
            ] or [ast.Pass()]  # fmt: skip
    return len(ast.unparse(tree).splitlines())

"""Statistics of the measured rows, and their format in tables."""

import ast
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cca_core.baselines.problems.compare import ComparisonRow


class Statistics:
    """Rows of the comparison by method, outcome and kind."""

    def __init__(self, rows: Sequence[ComparisonRow]) -> None:
        self.rows = rows
        self.methods = list(dict.fromkeys(row.method for row in rows))

    def of(self, method: str, *outcomes: str, kind: str | None = None) -> list[ComparisonRow]:
        """Rows of a method with one of the outcomes, and of a kind."""
        return [
            row for row in self.rows
            if row.method == method and (not outcomes or row.outcome in outcomes)
            and (kind is None or row.kind == kind)
        ]  # fmt: skip

    def solvable(self, method: str, *outcomes: str) -> list[ComparisonRow]:
        """Rows of a method on the solvable problems."""
        return [row for row in self.of(method, *outcomes) if row.kind != "blocked"]

    def solved(self, method: str, kind: str | None = None) -> float:
        """Fraction of the solvable problems that a method solves [%]."""
        rows = self.solvable(method) if kind is None else self.of(method, kind=kind)
        return 100.0 * sum(row.outcome == "solved" for row in rows) / max(len(rows), 1)

    def time(self, method: str, percentile: float = 50.0, field: str = "time_ms") -> float:
        """Percentile of the time of a plan [ms]."""
        values = [getattr(row, field) for row in self.of(method)]
        finite = [value for value in values if math.isfinite(value)]
        return float(np.percentile(finite, percentile)) if finite else math.nan

    def ratio(self, method: str, other: str, field: str) -> float:
        """Median ratio of a figure on the problems that both methods solve."""
        one = {(r.kind, r.seed): getattr(r, field) for r in self.solvable(method, "solved")}
        two = {(r.kind, r.seed): getattr(r, field) for r in self.solvable(other, "solved")}
        both = [one[key] / two[key] for key in one.keys() & two.keys() if two[key]]
        return float(np.median(both)) if both else math.nan

    def median(self, method: str, field: str) -> float:
        """Median of a figure over the solved problems."""
        values = [getattr(row, field) for row in self.solvable(method, "solved")]
        return float(np.median(values)) if values else math.nan

    def mean(self, method: str, field: str) -> float:
        """Mean of a figure over the solved problems."""
        values = [getattr(row, field) for row in self.solvable(method, "solved")]
        return float(np.mean(values)) if values else math.nan

    def collisions(self, method: str) -> int:
        """Count the driven plans that end in a collision."""
        return sum(row.driven_clearance <= 0.0 for row in self.of(method))


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Table in Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def number(value: float, digits: int = 2) -> str:
    """Format a number with a few digits, "-" if it is not finite."""
    if not math.isfinite(value):
        return "-"
    if abs(value) >= 10.0:
        return f"{value:.0f}"
    return f"{value:.{digits - 1}f}" if abs(value) >= 1.0 or not value else f"{value:.{digits}g}"


def code_lines(file: Path) -> int:
    """Count the lines of a module without docstrings, comments and blank lines."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [  # type: ignore[attr-defined]
                each for each in body
                if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))
            ] or [ast.Pass()]  # fmt: skip
    return len(ast.unparse(tree).splitlines())

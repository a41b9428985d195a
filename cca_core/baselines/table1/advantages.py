"""Figures in which another method is better than the bands."""

from collections.abc import Callable, Iterator, Sequence

from cca_core.baselines.problems.sampling import KINDS
from cca_core.baselines.table1.closed_loop import ClosedLoop
from cca_core.baselines.table1.experiment import BANDS, EQ9
from cca_core.baselines.table1.statistics import Statistics, number

_FIGURES = {  # words, and 1 if less is better
    "a_y": ("Lateral acceleration as planned", 1.0), "driven_jerk": ("Jerk when driven", 1.0),
    "length": ("Length", 1.0), "driven_clearance": ("Clearance when driven", -1.0),
    "tracking": ("Tracking error", 1.0),
}  # fmt: skip
_DRIVE_FIGURES: dict[str, Callable[[ClosedLoop], float]] = {  # less is better
    "passes all vehicles sooner than the band": lambda drive: drive.time,
    "less lateral acceleration than the band": lambda drive: drive.a_y,
    "less jerk than the band": lambda drive: drive.jerk,
    "more clearance than the band": lambda drive: -drive.clearance,
    "less time per cycle than the band": lambda drive: drive.cycle_us,
}


def advantages_over_bands(m: Statistics, drives: Sequence[ClosedLoop]) -> str:
    """List of the figures; a ratio counts on problems that both methods solve."""
    others = [name for name in m.methods if name not in (*BANDS, EQ9)]
    lines = [*_solved(m, others), *_times(m, others), *_ratios(m, others), *_closed_loop(drives)]
    return "\n".join(lines)


def _solved(m: Statistics, others: Sequence[str]) -> Iterator[str]:
    """Methods that solve more problems."""
    best = max(m.solved(name) for name in BANDS)
    ahead = [f"{n} ({m.solved(n):.0f} %)" for n in others if m.solved(n) > best]
    yield f"- Problems solved (bands {best:.0f} %): {'; '.join(ahead) or 'none'}."
    for kind in KINDS[:-1]:
        best = max(m.solved(name, kind) for name in BANDS)
        ahead = [f"{n} ({m.solved(n, kind):.0f} %)" for n in others if m.solved(n, kind) > best]
        if ahead:
            yield f"- Problems solved of the kind *{kind}* (bands {best:.0f} %): {'; '.join(ahead)}."


def _times(m: Statistics, others: Sequence[str]) -> Iterator[str]:
    """Methods that are faster."""
    for words, percentile in (("Median time of a plan", 50), ("99th percentile of this time", 99)):
        best = min(m.time(name, percentile) for name in BANDS)
        ahead = [f"{n} ({number(m.time(n, percentile))} ms)" for n in others if m.time(n, percentile) < best]
        yield f"- {words} (bands {number(best)} ms): {'; '.join(ahead) or 'none'}."


def _ratios(m: Statistics, others: Sequence[str]) -> Iterator[str]:
    """Methods whose plans are better than those of both bands."""
    for field, (words, sign) in _FIGURES.items():
        ahead = []
        for name in others:
            ratios = [m.ratio(name, band, field) for band in BANDS]
            worst = max(ratios) if sign > 0.0 else min(ratios)
            if sign * worst < sign * (1.0 - sign * (1e-4 if field == "length" else 0.02)):
                ahead.append(f"{name} ({worst:.3g} times the bands)")
        yield f"- {words}: {'; '.join(ahead) or 'none'}."


def _closed_loop(drives: Sequence[ClosedLoop]) -> Iterator[str]:
    """Planners that are better in closed loop."""
    bands = {drive.case: drive for drive in drives if drive.planner == "band"}
    for words, figure in _DRIVE_FIGURES.items():
        cases: dict[str, list[str]] = {}
        for drive in drives:
            is_better = drive.planner != "band" and figure(drive) < figure(bands[drive.case]) - 1e-9
            if drive.completed and is_better:
                cases.setdefault(drive.planner, []).append(drive.case)
        found = "; ".join(f"{planner} in {', '.join(names)}" for planner, names in cases.items())
        yield f"- Closed loop, {words}: {found or 'none'}."

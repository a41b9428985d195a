"""The page of the comparison: the template `page.md` filled with what was measured."""

import math
from collections.abc import Sequence
from pathlib import Path
from string import Template

from cca_core.baselines.problems.compare import ComparisonRow
from cca_core.baselines.problems.sampling import KINDS
from cca_core.baselines.table1.advantages import advantages_over_bands
from cca_core.baselines.table1.closed_loop import ClosedLoop
from cca_core.baselines.table1.experiment import AXES
from cca_core.baselines.table1.scaling import ScalingResult
from cca_core.baselines.table1.statements import statement_values
from cca_core.baselines.table1.statistics import Statistics, number, table


def page(
    rows: Sequence[ComparisonRow],
    scaling: Sequence[ScalingResult],
    drives: Sequence[ClosedLoop],
    *,
    measured: str,
) -> str:
    """Text of the page; `measured` names date and machine."""
    m = Statistics(rows)
    template = Template(Path(__file__).with_name("page.md").read_text(encoding="utf-8"))
    return template.substitute(
        measured=measured,
        main_table=main_table(m),
        failed=sum(row.outcome in ("TIMEOUT", "ERROR") for row in rows),
        kinds_table=_kinds_table(m),
        scaling_table=_scaling_table(scaling),
        closed_loop_table=_closed_loop_table(drives),
        advantages=advantages_over_bands(m, drives),
        **statement_values(m, scaling, drives),
    )


def main_table(m: Statistics) -> str:
    """Outcomes, times and figures of all methods."""
    rows = []
    for name in m.methods:
        good, claimed = m.solvable(name, "solved"), m.solvable(name, "solved", "false OK")
        driven = [r for r in claimed if math.isfinite(r.driven_clearance)]
        blocked = m.of(name, kind="blocked")
        rows.append([
            name,
            f"{len(good)} / {len(m.solvable(name, 'false OK'))} / {len(m.solvable(name, 'refused'))}",
            f"{sum(r.outcome == 'rightly refused' for r in blocked)} of {len(blocked)}",
            " / ".join(number(m.time(name, percentile)) for percentile in (50, 99, 100)),
            number(m.time(name, field="first_ms")),
            number(m.median(name, "length"), 4),
            f"{number(m.median(name, 'a_y'))} / {number(max((r.a_y for r in claimed), default=math.nan))}",
            number(m.median(name, "driven_jerk")),
            number(min((r.driven_clearance for r in driven), default=math.nan)),
            f"{sum(r.driven_clearance <= 0.0 for r in driven)}",
            number(max((r.tracking for r in driven), default=math.nan)),
        ])  # fmt: skip
    head = (
        "method", "solved / false OK / refused", "blocked: refused", "plan: median / p99 / worst [ms]",
        "first plan [ms]", "length [m]", "planned a_y: median / largest [m/s²]", "driven jerk [m/s³]",
        "driven: smallest clearance [m]", "collisions", "largest tracking error [m]",
    )  # fmt: skip
    return table(head, rows)


def _kinds_table(m: Statistics) -> str:
    """Solved problems by kind."""
    rows = []
    for name in m.methods:
        cells = [f"{m.solved(name, kind):.0f}" for kind in KINDS if kind != "blocked"]
        refused, blocked = m.of(name, "rightly refused", kind="blocked"), m.of(name, kind="blocked")
        reasons = [r.message.split(";")[0] for r in m.of(name, "false OK", "refused")]
        frequent = max(set(reasons), key=lambda r: (reasons.count(r), r)) if reasons else ""
        rows.append([name, *cells, f"{100 * len(refused) // max(len(blocked), 1)}", frequent])
    head = ("method", *(k for k in KINDS if k != "blocked"), "blocked", "most frequent reason of failure")
    return table(head, rows)


def _scaling_table(scaling: Sequence[ScalingResult]) -> str:
    """Tabulate the times at the ends of each axis, with the exponent of their growth."""
    rows = []
    for name in dict.fromkeys(r.method for r in scaling):
        cells = []
        for axis in AXES:
            points = sorted(
                (r for r in scaling if r.method == name and r.axis == axis), key=lambda r: r.value
            )
            cells.append(_growth(points[0], points[-1]) if len(points) > 1 else "-")
        rows.append([name, *cells])
    return table(("method", *AXES), rows)


def _growth(first: ScalingResult, last: ScalingResult) -> str:
    """Format the times of two points and the exponent between them."""
    exponent = math.log(last.time_ms / first.time_ms) / math.log(last.value / first.value)
    shown = abs(exponent) if abs(exponent) < 0.05 else exponent
    status = "" if last.status == "OK" else f", {last.status}"
    times = f"{number(first.time_ms)} to {number(last.time_ms)} ms"
    return f"{times} at {first.value:g} to {last.value:g} ({shown:.1f}{status})"


def _closed_loop_table(drives: Sequence[ClosedLoop]) -> str:
    """Figures of the drives."""
    rows = [
        [
            d.case, d.planner, "yes" if d.completed else "no", number(d.time, 3), number(d.clearance, 3),
            number(d.a_y, 3), number(d.jerk, 3), number(d.braking, 3), number(d.tracking),
            f"{number(d.cycle_us, 3)} / {number(d.p99_us, 3)}", number(100.0 * d.degraded),
        ]
        for d in drives
    ]  # fmt: skip
    head = (
        "case", "planner", "completed", "all vehicles passed after [s]", "smallest clearance [m]",
        "a_y [m/s²]", "jerk [m/s³]", "braking [m/s²]", "tracking error [m]", "cycle: mean / p99 [us]",
        "cycles without solution [%]",
    )  # fmt: skip
    return table(head, rows)

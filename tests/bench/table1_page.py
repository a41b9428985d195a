"""The page of the comparison, written from what was measured."""

import datetime
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cca_core.baselines.closed_loop import ClosedLoop
from cca_core.baselines.compare import ComparisonRow
from cca_core.baselines.sampled_problems import KINDS
from cca_core.baselines.scaling import ScalingResult
from tests.bench.table1_numbers import AXES, Lines, Measured, num, table
from tests.bench.table1_text import CONDITIONS, DIFFERS, HEAD
from tests.bench.table1_verdicts import better, sentences


def page(
    rows: Sequence[ComparisonRow],
    growth: Sequence[ScalingResult],
    drives: Sequence[ClosedLoop],
    *,
    machine: str,
    modules: Path,
) -> tuple[str, str]:
    """The page, and its main table alone."""
    m = Measured(rows, growth, drives, modules)
    main = _main(m)
    today = datetime.datetime.now(tz=datetime.UTC).date()
    parts = [
        HEAD, f"Measured on {today}: {machine}.\n", CONDITIONS,
        "## What came of it", main, "![time against quality](table1/quality.svg)", *_kinds(m),
        "## How time grows", "![growth of the time of a plan](table1/growth.svg)", *_grows(m),
        "## In closed loop", *_closed(m),
        "## The sentences of the paper's Table 1", *sentences(m),
        "## Where another method beats ours", *better(m),
        DIFFERS,
    ]  # fmt: skip
    return "\n\n".join(part.strip() for part in parts) + "\n", main


def _main(m: Measured) -> str:
    rows = []
    for name in m.methods:
        good, claimed = m.open(name, "solved"), m.open(name, "solved", "false OK")
        driven = [r for r in claimed if math.isfinite(r.driven_clearance)]
        blocked = m.of(name, kind="blocked")
        rows.append([
            name,
            f"{len(good)} / {len(m.open(name, 'false OK'))} / {len(m.open(name, 'refused'))}",
            f"{sum(r.outcome == 'rightly refused' for r in blocked)} of {len(blocked)}",
            " / ".join(num(m.time(name, share)) for share in (50, 99, 100)),
            num(m.time(name, field="first_ms")),
            num(float(np.median([r.length for r in good])) if good else math.nan, 4),
            f"{num(m.median(name, 'a_y'))} / {num(max((r.a_y for r in claimed), default=math.nan))}",
            f"{num(m.median(name, 'driven_jerk'))}",
            f"{num(min((r.driven_clearance for r in driven), default=math.nan))}",
            f"{sum(r.driven_clearance <= 0.0 for r in driven)}",
            f"{num(max((r.tracking for r in driven), default=math.nan))}",
        ])  # fmt: skip
    failed = sum(row.outcome in ("TIMEOUT", "ERROR") for row in m.rows)
    head = (
        "method", "solved / false OK / refused", "blocked: refused", "plan: median / p99 / worst [ms]",
        "first plan [ms]", "length [m]", "planned a_y: median / largest [m/s²]", "driven jerk [m/s³]",
        "driven: least clearance [m]", "contacts", "largest tracking error [m]",
    )  # fmt: skip
    note = (
        "\n\nOf 100 solvable problems and 20 blocked ones. *False OK* is a plan that is claimed and "
        "that the "
        f"judge refutes. Length, a_y and jerk are medians over the solved problems; what is driven is every "
        f"plan that was claimed. Plans that raised or ran out of time: {failed}."
    )
    return table(head, rows) + note


def _kinds(m: Measured) -> Lines:
    rows = []
    for name in m.methods:
        cells = [f"{m.solved(name, kind):.0f}" for kind in KINDS if kind != "blocked"]
        refused = m.of(name, "rightly refused", kind="blocked")
        faults = [r.message.split(";")[0] for r in m.of(name, "false OK", "refused")]
        often = max(set(faults), key=lambda f: (faults.count(f), f)) if faults else ""
        rows.append([name, *cells, f"{100 * len(refused) // max(len(m.of(name, kind='blocked')), 1)}", often])
    head = ("method", *(k for k in KINDS if k != "blocked"), "blocked", "most frequent reason for failing")
    return ["Solved, and rightly refused where the road is blocked [%]:", table(head, rows)]


def _grows(m: Measured) -> Lines:
    rows = []
    for name in dict.fromkeys(g.method for g in m.growth):
        cells = []
        for axis in AXES:
            own = sorted((g for g in m.growth if g.method == name and g.axis == axis), key=lambda g: g.value)
            if len(own) < 2:
                cells.append("-")
                continue
            a, b = own[0], own[-1]
            power = math.log(b.time_ms / a.time_ms) / math.log(b.value / a.value)
            end = "" if b.status == "OK" else f", {b.status}"
            span = f"{num(a.time_ms)} to {num(b.time_ms)} ms at {a.value:g} to {b.value:g}"
            cells.append(f"{span} ({abs(power) if abs(power) < 0.05 else power:.1f}{end})")
        rows.append([name, *cells])
    return [
        "In brackets the power of growth; hollow marks and words stand for plans that are not OK.",
        table(("method", *AXES), rows),
    ]


def _closed(m: Measured) -> Lines:
    rows = [
        [
            d.case, d.planner, "yes" if d.completed else "no", num(d.time, 3), num(d.clearance, 3),
            num(d.a_y, 3), num(d.jerk, 3), num(d.braking, 3), num(d.tracking),
            f"{num(d.cycle_us, 3)} / {num(d.p99_us, 3)}", num(100.0 * d.fallback),
        ]
        for d in m.drives
    ]  # fmt: skip
    head = (
        "case", "planner", "completed", "past all after [s]", "least clearance [m]", "a_y [m/s²]",
        "jerk [m/s³]", "braking [m/s²]", "tracking error [m]", "cycle: mean / p99 [us]",
        "cycles without solution [%]",
    )  # fmt: skip
    return [
        "The maneuvering scenario of the paper, driven from the beginning to the end on the friction-limited "
        "plant, with messages over its lossy channel; a cycle is 20 ms, and a new solution is asked "
        "for in every fifth. *Band* "
        "is the "
        "whole planner of this library; it decides who may be on the lane beside (danger zone, occlusion, "
        "age of messages), which the others do not: they see the prediction alone.",
        table(head, rows),
    ]  # fmt: skip

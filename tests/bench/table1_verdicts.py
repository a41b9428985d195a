"""The sentences of the paper's Table 1, each with a verdict by a rule stated beside it; who beats ours."""

import math
from collections.abc import Callable

import numpy as np

from cca_core.baselines.closed_loop import ClosedLoop
from cca_core.baselines.sampled_problems import KINDS
from tests.bench.table1_numbers import (
    BAND,
    EQ9,
    FAST,
    FATROP,
    IPOPT,
    LATTICE,
    LINEAR,
    OURS,
    SEEDS,
    SMOOTH,
    STAR,
    TREE,
    Lines,
    Measured,
    num,
    table,
)


def _verdict(confirmed: bool, refuted: bool = False) -> str:
    return "confirmed" if confirmed else "refuted" if refuted else "qualified"


def sentences(m: Measured) -> Lines:
    fastest = min(m.time(name) for name in OURS)
    p99, first = m.time(LATTICE, 99), m.time(LATTICE, field="first_ms")
    simple = m.lines[LATTICE] <= min(m.lines.values())
    gap, gap_band = m.solved(LATTICE, "narrow gap"), m.solved(BAND, "narrow gap")
    a_y, jerk = m.ratio(LATTICE, LINEAR, "a_y"), m.ratio(LATTICE, LINEAR, "driven_jerk")
    tree_jerk = m.ratio(TREE, LINEAR, "driven_jerk")
    peaks = [g.peak for g in m.growth if g.axis == SEEDS and math.isfinite(g.peak)]
    spread = max(peaks) - min(peaks) if peaks else math.nan
    slow = m.time(TREE) / fastest
    swings = [float(np.mean([r.swings for r in m.open(n, "solved")] or [math.nan])) for n in (TREE, LINEAR)]
    mpc = [d for d in m.drives if d.planner != "band"]
    done = sum(d.completed for d in mpc)
    lin, non = m.time(LINEAR) / fastest, m.time(FATROP) / fastest
    wrong = len(m.open(EQ9, "false OK")) + len(m.of(EQ9, "false OK", kind="blocked"))
    hits = sum(r.driven_clearance <= 0.0 for r in m.of(EQ9) if math.isfinite(r.driven_clearance))
    kept = len(m.of(BAND, "false OK")) + len(m.of(SMOOTH, "false OK"))
    lines = ", ".join(f"{name} {count}" for name, count in m.lines.items())
    rows = [
        [
            "Motion primitives: “Very simple and very fast.”", _verdict(simple and max(p99, first) < FAST),
            f"Once its primitives for a speed and a road are computed, {num(m.time(LATTICE))} ms (p99 "
            f"{num(p99)}; "
            f"ours {num(fastest)}); at a new speed the first plan takes {num(first)} ms. Lines of code: "
            f"{lines}. "
            f"(Confirmed if it has the fewest lines and both times are below {FAST:.0f} ms.)",
        ],
        [
            "“Route is neither optimal nor flexible.”",
            _verdict(gap < 90.0 and max(a_y, jerk) > 1.1, gap >= 90.0 and max(a_y, jerk) < 1.1),
            f"Its grid finds {gap:.0f} % of the narrow gaps, the band {gap_band:.0f} %. On the same problems "
            f"it needs {num(a_y)} times the lateral acceleration of the linear MPC and {num(jerk)} times its "
            "jerk. (Flexible from 90 % on; optimal up to 1.1 times both.)",
        ],
        [
            "“Behavior can be unnatural for a car.”", _verdict(jerk > 1.5, jerk < 1.1),
            f"{num(jerk)} times the jerk of the linear MPC when driven. (Confirmed from 1.5 on, refuted "
            "below 1.1.)",
        ],
        [
            "Random tree: “Easy to implement.”", _verdict(m.lines[TREE] <= min(m.lines.values())),
            f"The tree itself is OMPL's; what a road, moving boxes and the limits need beside it is "
            f"{m.lines[TREE]} lines of code against {m.lines[LATTICE]} for the lattice. "
            "(Confirmed if it has the fewest lines.)",
        ],
        [
            "“Suitable for holonomic kinematics.”", "qualified",
            f"Holonomic kinematics were not tried: a car has none. Over Dubins curves it solves "
            f"{m.solved(TREE):.0f} % (RRT*: {m.solved(STAR):.0f} %); their curvature jumps, which the "
            "car cannot "
            f"follow: it is up to {num(max(r.tracking for r in m.open(TREE, 'solved')))} m off the plan, "
            "against "
            f"{num(max(r.tracking for r in m.open(BAND, 'solved')))} m for the band.",
        ],
        [
            "“Multiple random searches are relatively time consuming.”", _verdict(slow > 3.0, slow < 1.0),
            f"{num(m.time(TREE))} ms in the median, {num(slow)} times ours; p99 {num(m.time(TREE, 99))} ms "
            f"(RRT*: {num(m.time(STAR))} and {num(m.time(STAR, 99))} ms). (Confirmed from 3 times on.)",
        ],
        [
            "“Can cause unnatural behavior for a car due to randomness.”",
            _verdict(tree_jerk > 1.5 and spread > 0.3, tree_jerk < 1.1 and spread < 0.1),
            f"The largest offset for one and the same problem spreads over {num(spread)} m between 10 seeds; "
            f"{num(tree_jerk)} times the jerk of the linear MPC when driven, {num(swings[0])} changes of "
            "side of "
            f"the lateral acceleration a plan against {num(swings[1])}. (Confirmed above 1.5 and 0.3 m.)",
        ],
        [
            "Model predictive control: “On-line path generation and modification are combined.”",
            _verdict(done == len(mpc)),
            f"In closed loop the controllers complete {done} of {len(mpc)} maneuvering drives without any "
            "path given. (Confirmed if all.)",
        ],
        [
            "“With constraints and weights, calculation of optimization is relatively slow.”",
            _verdict(lin > 3.0 and non > 3.0, lin < 1.0 and non < 1.0),
            f"True of the nonlinear one, {num(m.time(FATROP))} ms with FATROP and {num(m.time(IPOPT))} ms "
            "with IPOPT, "
            f"{num(non)} and {num(m.time(IPOPT) / fastest)} times ours. The linear one with the same "
            "limits takes "
            f"{num(m.time(LINEAR))} ms, {num(lin)} times ours. (Confirmed if both take 3 times as long.)",
        ],
        [
            "Elastic band (text): “a collision free deformed path is obtained in natural manner”; real-time "
            "capability", f"eq 9 as printed: {_verdict(wrong == 0, wrong > 0)}; relaxed: "
            f"{_verdict(kept == 0)}",
            f"As printed, {wrong} of {len(m.of(EQ9))} plans break a limit, and {hits} of those driven end in "
            f"contact. Relaxed and smoothed, {kept} of {len(m.of(BAND)) + len(m.of(SMOOTH))} do, in "
            f"{num(m.time(BAND))} and {num(m.time(SMOOTH))} ms. (Confirmed if none does.)",
        ],
    ]  # fmt: skip
    return [table(("sentence", "verdict", "why, and by which rule"), rows)]


def better(m: Measured) -> Lines:
    """Figures of others that are better than the better one of ours, on problems that both have solved."""
    best = max(m.solved(name) for name in OURS)
    others = [name for name in m.methods if name not in (*OURS, EQ9)]
    lines = []
    ahead = [f"{n} ({m.solved(n):.0f} %)" for n in others if m.solved(n) > best]
    lines.append(f"- Solved, ours {best:.0f} %: {', '.join(ahead) or 'nobody'}.")
    for kind in KINDS[:-1]:
        own = max(m.solved(name, kind) for name in OURS)
        ahead = [f"{n} ({m.solved(n, kind):.0f} %)" for n in others if m.solved(n, kind) > own]
        if ahead:
            lines.append(f"- {kind.capitalize()} solved, ours {own:.0f} %: {', '.join(ahead)}.")
    fastest = min(m.time(name) for name in OURS)
    ahead = [f"{n} ({num(m.time(n))} ms)" for n in others if m.time(n) < fastest]
    lines.append(f"- Median time, ours {num(fastest)} ms: {', '.join(ahead) or 'nobody'}.")
    p99 = min(m.time(name, 99) for name in OURS)
    ahead = [f"{n} ({num(m.time(n, 99))} ms)" for n in others if m.time(n, 99) < p99]
    lines.append(f"- 99th percentile of the time, ours {num(p99)} ms: {', '.join(ahead) or 'nobody'}.")
    figures = (
        ("a_y", "Lateral acceleration as planned", 1.0), ("driven_jerk", "Jerk when driven", 1.0),
        ("length", "Length", 1.0), ("driven_clearance", "Clearance when driven", -1.0),
        ("tracking", "Tracking error", 1.0),
    )  # fmt: skip
    for field, words, sign in figures:
        ahead = []
        for name in others:
            ratios = [m.ratio(name, own, field) for own in OURS]
            worst = max(ratios) if sign > 0.0 else min(ratios)
            if sign * worst < sign * (1.0 - sign * (1e-4 if field == "length" else 0.02)):
                ahead.append(f"{name} ({worst:.3g} times ours)")
        lines.append(f"- {words}: {', '.join(ahead) or 'nobody'}.")
    picks: list[tuple[str, Callable[[ClosedLoop], float]]] = [
        ("is past all sooner", lambda d: d.time), ("less lateral acceleration", lambda d: d.a_y),
        ("less jerk", lambda d: d.jerk), ("more clearance", lambda d: -d.clearance),
        ("less time a cycle", lambda d: d.cycle_us),
    ]  # fmt: skip
    for words, pick in picks:
        cases = []
        for d in m.drives:
            ours = next(o for o in m.drives if o.case == d.case and o.planner == "band")
            if d.completed and d.planner != "band" and pick(d) < pick(ours) - 1e-9:
                cases.append(f"{d.planner} in {d.case}")
        lines.append(f"- Closed loop, {words} than ours: {', '.join(cases) or 'nobody'}.")
    return ["\n".join(lines)]

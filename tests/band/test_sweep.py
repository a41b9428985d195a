"""Seeded sweep over random cases: measured limits of OK bands, and the fraction of solvable cases solved.

With the full profile 10 000 cases are measured and 1 000 solvable ones counted, otherwise a few of them.
"""

import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from cca_core.band import Band, relax_band, smooth_band
from tests.support.band_cases import Case, case
from tests.support.band_measure import curvature_excess, edge_excess, remeasure

FULL = os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full"
COUNTS = range(1, 7)  # obstacles
MEASURED = 1667 if FULL else 10  # cases for each count, solvable or not
SOLVABLE = 167 if FULL else 8  # solvable cases for each count
SHORTFALL = 0.01  # of clearance and edges, allowed [m]
CURVATURE_EXCESS = 0.02  # allowed [-]

pytestmark = [pytest.mark.requires(module) for module in ("qpsolvers", "piqp")]


@dataclass
class Tally:
    """Counts of a sweep."""

    cases: int = 0
    ok: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    short: dict[str, list[float]] = field(default_factory=dict)
    unsolved: list[str] = field(default_factory=list)

    def fraction(self, *by: str) -> float:
        """Fraction of the cases solved by any of these."""
        return sum(self.ok[name] for name in by) / max(self.cases, 1)


def sample(count: int, number: int) -> Case:
    """Return the case of a number, with so many obstacles."""
    return case(np.random.default_rng([4, count, number]), count)


def bands(problem: Case) -> Iterator[tuple[str, Band]]:
    """Band alone, and smoothed."""
    band = relax_band(
        problem.nodes, problem.obstacles, vehicle=problem.vehicle, clearance=problem.clearance,
        corridor=problem.corridor, curvature_limit=problem.curvature_limit,
    )  # fmt: skip
    yield "band", band
    yield "smooth", smooth_band(band)


def measured(count: int, numbers: range) -> Tally:
    """Measure every band that is called OK."""
    tally = Tally(short={name: [-1.0, -1.0, -1.0] for name in ("band", "smooth")})
    for number in numbers:
        problem = sample(count, number)
        tally.cases += 1
        for name, band in bands(problem):
            if not band.ok:
                continue
            tally.ok[name] += 1
            short = (
                problem.clearance - remeasure(band.nodes, problem),
                edge_excess(band.nodes, problem),
                curvature_excess(band.nodes, problem),
            )
            tally.short[name] = [max(pair) for pair in zip(tally.short[name], short, strict=True)]
            if short[0] > SHORTFALL or short[1] > SHORTFALL or short[2] > CURVATURE_EXCESS:
                tally.wrong.append(
                    f"{count} obstacles, case {number}, {problem.kind}, {name}: lacks {short[0]:.4f} m, "
                    f"crosses an edge by {short[1]:.4f} m, bends {short[2]:.2%} too much"
                )
    return tally


def counted(count: int, solvable_cases: int) -> Tally:
    """Solve cases until so many solvable ones are found."""
    from tests.support.band_oracle import solvable

    tally, number = Tally(), 0
    while tally.cases < solvable_cases:
        problem = sample(count, number)
        number += 1
        found = dict(bands(problem))
        possible, sides, _ = solvable(problem)
        if not possible:
            continue
        tally.cases += 1
        if found["band"].ok:
            tally.ok["band"] += 1
        elif found["smooth"].ok:
            tally.ok["smoothed only"] += 1
        else:
            reason = found["smooth"]
            tally.unsolved.append(
                f"{count} obstacles, case {number - 1}, {problem.kind}, h {reason.spacing:.1f}, possible "
                f"{' '.join(sides)}, tried {' '.join(reason.sides)}: {reason.message} "
                f"[{reason.active_constraint}]"
            )
    return tally


@pytest.fixture
def say(
    request: pytest.FixtureRequest, capsys: pytest.CaptureFixture[str]
) -> Callable[[Sequence[str]], None]:
    """Write lines to the terminal, whether the test passes or not."""
    terminal = request.config.pluginmanager.get_plugin("terminalreporter")

    def write(lines: Sequence[str]) -> None:
        with capsys.disabled():
            for line in ("", *lines):
                terminal.write_line(line)

    return write


@pytest.mark.parametrize("count", COUNTS)
def test_ok_bands_satisfy_measured_limits(count: int, say: Callable[[Sequence[str]], None]) -> None:
    tally = measured(count, range(MEASURED))
    say(
        [
            f"{count} obstacles, {tally.cases} cases, {name}: {tally.ok[name]} OK, worst lacks {gap:.5f} m, "
            f"crosses an edge by {edge:.5f} m, bends {bent:.3%} too much"
            for name, (gap, edge, bent) in tally.short.items()
        ]
    )
    assert tally.ok["band"] > 0.2 * tally.cases  # else nothing was tested
    assert not tally.wrong, "\n".join(tally.wrong)


@pytest.mark.parametrize(
    ("counts", "solvable"),
    [pytest.param((1, 2, 3), 2, id="few"), pytest.param(COUNTS, SOLVABLE, id="all", marks=pytest.mark.slow)],
)
def test_solvable_cases_are_solved(
    counts: Sequence[int], solvable: int, say: Callable[[Sequence[str]], None]
) -> None:
    tallies = {count: counted(count, solvable) for count in counts}
    total = Tally(
        cases=sum(t.cases for t in tallies.values()), ok=sum((t.ok for t in tallies.values()), Counter())
    )
    report = [
        f"{n} obstacles: {t.cases} solvable, band alone {t.fraction('band'):.1%}, "
        f"band or smoothed {t.fraction('band', 'smoothed only'):.1%}"
        for n, t in [*tallies.items(), ("all", total)]
    ]
    report += [line for t in tallies.values() for line in t.unsolved]
    say(report)
    assert total.fraction("band") >= 0.80, "\n".join(report)
    assert total.fraction("band", "smoothed only") >= 0.95, "\n".join(report)

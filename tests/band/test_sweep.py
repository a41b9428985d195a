"""Seeded sweep over random cases: no OK that is wrong, and the share of solvable cases that are solved.

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
MEASURED = 1667 if FULL else 10  # cases for each count, on the way or not, solvable or not
SOLVABLE = 167 if FULL else 8  # solvable cases for each count
SHORT = 0.01  # clearance and edges may be missed by [m]
BENT = 0.02  # curvature may be missed by [-]

pytestmark = [pytest.mark.requires(module) for module in ("qpsolvers", "piqp")]


@dataclass
class Tally:
    """What a sweep found."""

    cases: int = 0
    ok: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    short: dict[str, list[float]] = field(default_factory=dict)
    unsolved: list[str] = field(default_factory=list)

    def share(self, *by: str) -> float:
        """Share of the cases solved by any of these."""
        return sum(self.ok[name] for name in by) / max(self.cases, 1)


def drawn(count: int, number: int) -> Case:
    """Return case of that number with so many obstacles."""
    return case(np.random.default_rng([4, count, number]), count)


def bands(asked: Case) -> Iterator[tuple[str, Band]]:
    """Band alone, and smoothed."""
    band = relax_band(
        asked.nodes, asked.obstacles, vehicle=asked.vehicle, clearance=asked.clearance,
        corridor=asked.corridor, curvature_limit=asked.curvature_limit,
    )  # fmt: skip
    yield "band", band
    yield "smooth", smooth_band(band)


def measured(count: int, numbers: range) -> Tally:
    """Measure every band that is called OK."""
    tally = Tally(short={name: [-1.0, -1.0, -1.0] for name in ("band", "smooth")})
    for number in numbers:
        asked = drawn(count, number)
        tally.cases += 1
        for name, band in bands(asked):
            if not band.ok:
                continue
            tally.ok[name] += 1
            short = (
                asked.clearance - remeasure(band.nodes, asked),
                edge_excess(band.nodes, asked),
                curvature_excess(band.nodes, asked),
            )
            tally.short[name] = [max(pair) for pair in zip(tally.short[name], short, strict=True)]
            if short[0] > SHORT or short[1] > SHORT or short[2] > BENT:
                tally.wrong.append(
                    f"{count} obstacles, case {number}, {asked.kind}, {name}: lacks {short[0]:.4f} m, "
                    f"crosses an edge by {short[1]:.4f} m, bends {short[2]:.2%} too much"
                )
    return tally


def counted(count: int, solvable_cases: int) -> Tally:
    """Solve cases until so many solvable ones are found."""
    from tests.support.band_oracle import solvable

    tally, number = Tally(), 0
    while tally.cases < solvable_cases:
        asked = drawn(count, number)
        number += 1
        found = dict(bands(asked))
        possible, sides, _ = solvable(asked)
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
                f"{count} obstacles, case {number - 1}, {asked.kind}, h {reason.spacing:.1f}, possible "
                f"{' '.join(sides)}, tried {' '.join(reason.sides)}: {reason.message} [{reason.active_constraint}]"
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
def test_no_ok_is_wrong(count: int, say: Callable[[Sequence[str]], None]) -> None:
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


def test_most_solvable_cases_are_solved(say: Callable[[Sequence[str]], None]) -> None:
    tallies = {count: counted(count, SOLVABLE) for count in COUNTS}
    total = Tally(
        cases=sum(t.cases for t in tallies.values()), ok=sum((t.ok for t in tallies.values()), Counter())
    )
    report = [
        f"{n} obstacles: {t.cases} solvable, band alone {t.share('band'):.1%}, "
        f"band or smoothed {t.share('band', 'smoothed only'):.1%}"
        for n, t in [*tallies.items(), ("all", total)]
    ]
    report += [line for t in tallies.values() for line in t.unsolved]
    say(report)
    assert total.share("band") >= 0.80, "\n".join(report)
    assert total.share("band", "smoothed only") >= 0.95, "\n".join(report)

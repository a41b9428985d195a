"""Loss and latency in the maneuvering cases: the ego may wait but must not collide.

``python tests/v2x/test_loss.py [case [seeds]]`` runs the whole grid. It prints one row per run and
a table of the mean waiting time.
"""

import itertools
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from cca_core.path import Path, fit_path
from cca_core.sim import Log, overtaking, simulate
from cca_core.v2x import ChannelSettings

FULL = os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full"
CASES = ("2", "3", "1-smooth")
LOSSES = tuple(round(0.1 * i, 1) for i in range(9))
LATENCIES = tuple(round(0.1 * i, 1) for i in range(6))  # [s]
BURST = 5.0  # messages lost in succession; 80 % loss needs bursts of at least 4
CELLS = (
    list(itertools.product(CASES, LOSSES, LATENCIES))
    if FULL
    else [*itertools.product(CASES, (0.8,), (0.4, 0.5)), ("2", 0.8, 0.0), ("2", 0.0, 0.5), ("3", 0.8, 0.0)]
)
SEEDS = range(1, 11) if FULL else (1, pytest.param(6, marks=pytest.mark.slow))


@dataclass(frozen=True)
class Cell:
    """Result of one run."""

    collided: bool
    gap: float  # least between bodies [m]
    waiting: float  # time spent following or braking [s]
    done: float  # begin of the last KEEP [s]; infinite if the run ends otherwise


def straight() -> Path:
    """Road of all runs."""
    s = np.arange(0.0, 1501.0, 10.0)
    return fit_path(np.column_stack((s, np.zeros_like(s))), tolerance=0.05)


def drive(case: str, loss: float, latency: float, seed: int = 1) -> tuple[Log, Cell]:
    """Run a case through a lossy and slow channel."""
    channel = ChannelSettings(latency=latency, loss_probability=loss, mean_burst_length=BURST)
    log = simulate(replace(overtaking(case, straight()), channel=channel), seed=seed)
    ends = [t for t, _, _ in log.decisions[1:]] + [float(log.t[-1])]
    waits = [
        end - t for (t, name, _), end in zip(log.decisions, ends, strict=True) if name in ("FOLLOW", "BRAKE")
    ]
    t, name, _ = log.decisions[-1]
    gap = float(log.gaps().min())
    return log, Cell(gap <= 0.0, gap, sum(waits), t if name == "KEEP" else np.inf)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("case", "loss", "latency"), CELLS)
def test_loss_and_latency_cause_no_collision(
    case: str, loss: float, latency: float, seed: int, record_property: Callable[[str, object], None]
) -> None:
    log, cell = drive(case, loss, latency, seed)
    for name in ("collided", "waiting", "done"):
        record_property(name, getattr(cell, name))
    assert np.isfinite(log.ego).all()
    assert np.isfinite(log.command).all()
    assert not cell.collided, cell


def main(case: str = "2", seeds: str = "3") -> None:
    """Print the grid of a case."""
    out, rows = sys.stdout, []
    for loss in LOSSES:
        waiting = []
        for latency in LATENCIES:
            cells = [drive(case, loss, latency, seed)[1] for seed in range(1, int(seeds) + 1)]
            for seed, cell in enumerate(cells, 1):
                out.write(f"{case} loss {loss:.0%} latency {latency:g} s seed {seed}: {cell}\n")
            out.flush()
            waiting.append(np.mean([cell.waiting for cell in cells]))
        rows.append(f"| {loss:.0%} | " + " | ".join(f"{w:.1f}" for w in waiting) + " |")
    out.write("\n| loss | " + " | ".join(f"{t:g} s" for t in LATENCIES) + " |\n")
    out.write("|---" * (len(LATENCIES) + 1) + "|\n" + "\n".join(rows) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])

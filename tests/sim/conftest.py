"""Roads, and runs of the maneuvering cases, each simulated once for all tests."""

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from cca_core.path import Path, fit_path
from cca_core.sim import Log, make_planner, overtaking, simulate
from tests.support.lead_only import LeadOnly

START = 20.0


@cache
def _road(name: str) -> Path:
    s = np.arange(0.0, 1501.0, 10.0)
    if name == "straight":
        return fit_path(np.column_stack((s, np.zeros_like(s))), tolerance=0.05)
    radius = 1500.0
    return fit_path(
        radius * np.column_stack((np.sin(s / radius), 1.0 - np.cos(s / radius))), tolerance=0.05
    )  # fmt: skip


@cache
def _run(case: str, road: str, seed: int, v2v: bool, lead_only: bool) -> Log:
    scenario = overtaking(case, _road(road), start=START, v2v=v2v)
    planner = LeadOnly(make_planner(scenario)) if lead_only else None
    return simulate(scenario, seed=seed, planner=planner)


@pytest.fixture(scope="session")
def road() -> Callable[[str], Path]:
    """Route by name: "straight", or "curved" to the left with a radius of 1500 m."""
    return _road


@pytest.fixture(scope="session")
def run() -> Callable[..., Log]:
    """Log of a case; equal arguments are simulated once."""

    def get(
        case: str, road: str = "straight", seed: int = 1, *, v2v: bool = True, lead_only: bool = False
    ) -> Log:
        return _run(case, road, seed, v2v, lead_only)

    return get

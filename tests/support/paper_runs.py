"""Runs of the paper's scenarios, each simulated once per process, and fixtures that give them to tests."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from cca_core import fit_path
from cca_core.sim import Log, curbside, eebl, ima, overtaking, simulate

Run = Callable[[str, str, str], Log]

HOSTILE_ID = "</script><script>alert('&\"')</script>\x00\ud800$\\x$"


@cache
def simulated(name: str, case: str, ego: str, seed: int = 1, plant: str = "single_track") -> Log:
    """Log of a scenario, case and ego type (the cases of EEBL imply it)."""
    if name == "eebl":
        return simulate(eebl(case), seed=seed, plant=plant)
    if name == "maneuver":
        x = np.arange(0.0, 1500.0, 15.0)
        road = fit_path(np.column_stack((x, x**2 / 2000.0)), tolerance=0.3)
        return simulate(overtaking(case, road, start=210.0, v2v=ego == "v2v"), seed=seed, plant=plant)
    return simulate({"ima": ima, "curbside": curbside}[name](case, ego_type=ego), seed=seed, plant=plant)


def gap(log: Log, ahead: int, behind: int | None) -> Any:
    """Bumper gap along the road between two road users, None being the ego [m]."""
    rear = log.user_frenet[:, ahead, 0] - 2.25
    return rear - (log.ego_frenet[:, 0] if behind is None else log.user_frenet[:, behind, 0]) - 2.25


@pytest.fixture(scope="session")
def run() -> Run:
    """Log of a scenario, case and ego type."""
    return simulated


@pytest.fixture(scope="session")
def alone() -> Log:
    """A run without other road users."""
    log = simulated("maneuver", "1-smooth", "sensor")
    return replace(
        log, scenario=replace(log.scenario, road_users=()), road_users=log.road_users[:, :0],
        user_motion=log.user_motion[:, :0], user_frenet=log.user_frenet[:, :0],
        visible=log.visible[:, :0], tracked=log.tracked[:, :0],
        decisions=((0.0, "KEEP", "keeping lane at 20.0 m/s: no vehicle ahead"),),
        reasons=(("keeping lane at 20.0 m/s", ""),),
    )  # fmt: skip


@pytest.fixture(scope="session")
def hostile() -> Log:
    """A run with a road user whose id is meant to break the page."""
    log = simulated("maneuver", "2", "sensor")
    users = tuple(replace(u, id=HOSTILE_ID) if u.id == "R1" else u for u in log.scenario.road_users)
    decisions = tuple((t, action, reason.replace("R1", HOSTILE_ID)) for t, action, reason in log.decisions)
    return replace(log, scenario=replace(log.scenario, road_users=users), decisions=decisions)

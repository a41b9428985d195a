"""Runs of the paper's scenarios, each simulated once per process, and fixtures that give them to tests."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cca_core import fit_path
from cca_core.sim import Log, curbside, eebl, ima, overtaking, simulate

Run = Callable[[str, str, str], Log]

HOSTILE_ID = "</script><script>alert('&\"')</script>\x00\ud800$\\x$"


@cache
def simulated(name: str, case: str, ego: str) -> Log:
    """Log of a scenario, case and ego type (the cases of EEBL say it)."""
    if name == "eebl":
        return simulate(eebl(case))
    if name == "maneuver":
        x = np.arange(0.0, 1500.0, 15.0)
        road = fit_path(np.column_stack((x, x**2 / 2000.0)))
        return simulate(overtaking(case, road, start=210.0, v2v=ego == "v2v"))
    return simulate({"ima": ima, "curbside": curbside}[name](case, ego_type=ego))


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
        decisions=((0.0, "KEEP", "keeping lane at 20.0 m/s: no blocking vehicle"),),
    )  # fmt: skip


@pytest.fixture(scope="session")
def hostile() -> Log:
    """A run with a road user whose id is meant to break the page."""
    log = simulated("maneuver", "2", "sensor")
    users = tuple(replace(u, id=HOSTILE_ID) if u.id == "R1" else u for u in log.scenario.road_users)
    decisions = tuple((t, action, reason.replace("R1", HOSTILE_ID)) for t, action, reason in log.decisions)
    return replace(log, scenario=replace(log.scenario, road_users=users), decisions=decisions)

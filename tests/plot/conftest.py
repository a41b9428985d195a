"""Runs of the paper's scenarios, each driven once for all tests."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cca_core import fit_path
from cca_core.sim import Log, curbside, eebl, ima, overtaking, simulate


@cache
def _run(name: str, case: str, ego: str) -> Log:
    if name == "eebl":
        return simulate(eebl(case))
    if name == "maneuver":
        x = np.arange(0.0, 1500.0, 15.0)
        road = fit_path(np.column_stack((x, x**2 / 2000.0)))
        return simulate(overtaking(case, road, start=210.0, v2v=ego == "v2v"))
    return simulate({"ima": ima, "curbside": curbside}[name](case, ego=ego))


@pytest.fixture(scope="session")
def run() -> Callable[[str, str, str], Log]:
    """Log of a scenario and case by who drives (EEBL's cases say it)."""
    return _run


@pytest.fixture(scope="session")
def alone(run: Callable[[str, str, str], Log]) -> Log:
    """A run without other road users."""
    log = run("maneuver", "1-smooth", "sensor")
    return replace(
        log, scenario=replace(log.scenario, road_users=()), road_users=log.road_users[:, :0],
        user_motion=log.user_motion[:, :0], user_frenet=log.user_frenet[:, :0],
        visible=log.visible[:, :0], tracked=log.tracked[:, :0],
        decisions=((0.0, "KEEP", "the lane ahead is free"),),
    )  # fmt: skip


@pytest.fixture(scope="session")
def hostile(run: Callable[[str, str, str], Log]) -> Log:
    """A run with a road user whose id is meant to break the page."""
    log = run("maneuver", "2", "sensor")
    name = "</script><script>alert('&\"')</script>\x00\ud800$\\x$"
    users = tuple(replace(u, id=name) if u.id == "R1" else u for u in log.scenario.road_users)
    decisions = tuple((t, action, reason.replace("R1", name)) for t, action, reason in log.decisions)
    return replace(log, scenario=replace(log.scenario, road_users=users), decisions=decisions)

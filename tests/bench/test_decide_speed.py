"""Run times of the decision and of the warnings with twenty other vehicles."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cca_core import Lane, Planner, RemoteVehicle, Road, VehicleState
from cca_core.decide import Action, Candidate, LeadVehicle, choose_action
from cca_core.path import fit_path
from cca_core.warnings import warn
from tests.bench.timing import Budget, median_us
from tests.support.planner_drives import ALL_KNOWN, BLOCKED, CAR

Report = Callable[[str, object], None]


def traffic() -> tuple[Planner, VehicleState, list[RemoteVehicle]]:
    """Twenty cars on three lanes of a curve; the ego approaches the first one in its lane."""
    s = np.arange(0.0, 1501.0, 10.0)
    path = fit_path(1500.0 * np.column_stack((np.sin(s / 1500.0), 1.0 - np.cos(s / 1500.0))), tolerance=0.05)
    planner = Planner(
        CAR, Road(path, (Lane(d=0.0), Lane(d=3.5), Lane(d=-3.5))), cruise_speed=20.0, evasion=ALL_KNOWN
    )
    others = []
    for i in range(20):
        lane = (0.0, 3.5, -3.5)[i % 3]
        at = 235.0 + 40.0 * (i // 3) if lane == 0.0 else 120.0 + 45.0 * (i // 3)
        x, y = path.to_cartesian(at, lane).tolist()
        v = 12.0 if lane == 0.0 else 18.0
        others.append(RemoteVehicle(id=f"R{i}", x=x, y=y, psi=float(path.heading(at)), v_x=v))
    x, y = path.position(200.0).tolist()
    return planner, VehicleState(x=x, y=y, psi=float(path.heading(200.0)), v_x=20.0), others


@pytest.mark.parametrize("free", [True, False])
def test_choose_action(slowness: float, budget: Budget, record_property: Report, free: bool) -> None:
    lead = LeadVehicle(id="R0", gap=30.0, v_x=12.0, required_deceleration=1.0, follow_acceleration=-1.0)
    candidates = [
        Candidate(
            side="left" if i % 2 else "right", rejection=None if free else BLOCKED,
            available_distance=20.0, required_distance=50.0, t_maneuver=6.0, danger_zone=(-40.0, 10.0),
            cost=3.0 + i,
        )
        for i in range(20)
    ]  # fmt: skip
    action = choose_action(lead, candidates).action
    assert action is (Action.EVADE_RIGHT if free else Action.FOLLOW)
    took = median_us(lambda: choose_action(lead, candidates), 500)
    record_property("us", round(took, 1))
    budget(took, "µs", max_value=15.0 * slowness)


def test_decision_cycle_of_planner(slowness: float, budget: Budget, record_property: Report) -> None:
    """Every cycle decides: both adjacent lanes are checked and blocked."""
    planner, ego, others = traffic()
    clock = [0.0]

    def step() -> Any:
        clock[0] += 0.1
        return planner.step(clock[0], ego, others)

    assert step().decision.action is Action.FOLLOW
    took = median_us(step, 40)
    record_property("us", round(took))
    budget(1e-3 * took, "ms", max_value=6.0 * slowness)


def test_warnings(slowness: float, budget: Budget, record_property: Report) -> None:
    planner, ego, others = traffic()
    took = median_us(lambda: warn(ego, CAR, planner.road, others, s_guess=200.0), 100)
    record_property("us", round(took))
    budget(1e-3 * took, "ms", max_value=3.0 * slowness)

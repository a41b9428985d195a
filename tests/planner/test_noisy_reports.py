"""The errors of headings and positions in messages are no lane changes: neighbors do not brake the ego."""

from dataclasses import replace

import numpy as np
import pytest

from cca_core import Lane, RemoteVehicle
from tests.support.planner_drives import ClosedLoop, Reception, ScriptedVehicle, make_planner
from tests.support.sweeps import sweep

OPPOSING = (Lane(d=0.0), Lane(d=3.5, direction=-1))


def noisy(seed: int) -> Reception:
    """Give each message the errors of a receiver: along, across, of speed and heading."""
    random, sent = np.random.default_rng(seed), {}

    def receive(t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
        found = []
        for r in remotes:
            if r.age == 0.0 or r.id not in sent:
                sent[r.id] = random.normal(0.0, (0.3, 0.15, 0.1, 0.01))
            along, across, v, psi = sent[r.id]
            found.append(
                replace(
                    r, x=r.x + along, y=r.y + across, v_x=r.v_x + v, psi=r.psi + psi, sigma_along=0.5,
                    sigma_across=0.2,
                )
            )  # fmt: skip
        return found

    return receive


@pytest.mark.parametrize(
    ("v", "d", "seed"), sweep((30.0, 3.2, 0), (20.0, 3.2, 1), (30.0, 3.5, 2), (25.0, 3.3, 3), quick=2)
)
def test_oncoming_cars_in_their_lane_are_not_braked_for(v: float, d: float, seed: int) -> None:
    traffic = [ScriptedVehicle(f"O{i}", 130.0 + 60.0 * i, d, v, psi=np.pi) for i in range(10)]
    run = ClosedLoop(make_planner(OPPOSING, cruise=v), traffic, 12.0, v=v, receive=noisy(seed))
    assert run.collided_with is None
    assert min(run.a_x) > -2.1
    assert min(run.v) > v - 4.0
    assert max(map(abs, run.y)) < 0.1


@pytest.mark.parametrize("seed", sweep(0, 1, 2))
def test_cars_alongside_are_not_evaded(seed: int) -> None:
    lanes = (Lane(d=0.0), Lane(d=3.5), Lane(d=-3.5))
    traffic = [
        ScriptedVehicle("L", 10.0, 3.25, 33.0), ScriptedVehicle("M", -12.0, 3.6, 33.5),
        ScriptedVehicle("R", 4.0, -3.3, 31.0), ScriptedVehicle("Q", 25.0, -3.5, 32.0),
    ]  # fmt: skip
    run = ClosedLoop(make_planner(lanes, cruise=33.0), traffic, 12.0, v=33.0, receive=noisy(seed))
    assert run.collided_with is None
    assert min(run.a_x) > -1.5
    assert max(map(abs, run.y)) < 0.3

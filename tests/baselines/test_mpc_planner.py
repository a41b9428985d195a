"""Predictive control in closed loop: it passes, follows, waits, and never raises."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from cca_core import Command, InputError, Lane, Path, RemoteVehicle, Road, Status, VehicleParams, VehicleState
from cca_core.baselines.methods.mpc.horizon import MpcSettings
from cca_core.baselines.methods.mpc.planner import MpcPlanner
from cca_core.sim import Log, RoadUser, simulate
from cca_core.sim.scenarios.scenario import Scenario

pytestmark = pytest.mark.requires("casadi", "piqp")

CAR = dataclasses.replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
LINE = Path([0.0, 2000.0], [[[0, 0, 2000, 0], [0, 0, 0, 0]]])
ROAD = Road(LINE, (Lane(d=0.0), Lane(d=3.5)))
METHODS = pytest.mark.parametrize("method", ["linear", "nonlinear"])
STATE = VehicleState(x=100.0, y=0.0, psi=0.0, v_x=20.0)


def drive(method: Any, *users: RoadUser, duration: float, road: Road = ROAD) -> Log:
    scenario = Scenario(
        name="test", case=None, road=road, vehicle=CAR, start=20.0, v_x=20.0, cruise_speed=20.0,
        road_users=users,
        duration=duration,
    )  # fmt: skip
    planner = MpcPlanner(CAR, road, cruise_speed=20.0, method=method)
    return simulate(scenario, planner=planner)


def is_usable(command: Command) -> bool:
    return math.isfinite(command.delta) and math.isfinite(command.a_x) and bool(command.decision.reason)


@METHODS
@pytest.mark.parametrize(
    ("s", "v"),
    [pytest.param(100.0, 0.0, id="stationary", marks=pytest.mark.slow), pytest.param(60.0, 10.0, id="slow")],
)
def test_planner_passes_one_car_without_collision(method: str, s: float, v: float) -> None:
    log = drive(method, RoadUser(id="a", s=20.0 + s, d=0.0, v_x=v), duration=14.0)
    assert log.t[-1] == pytest.approx(14.0)
    assert log.gaps().min() > 0.3
    assert log.ego_frenet[-1, 0] > log.user_frenet[-1, 0, 0] + 5.0
    assert abs(log.ego_frenet[-1, 1]) < 0.3
    assert np.abs(log.a_y).max() < 3.5
    assert np.abs(log.tracking).max() < 0.3
    assert "EVADE_LEFT" in log.actions


@METHODS
def test_planner_follows_on_single_lane(method: str) -> None:
    log = drive(method, RoadUser(id="a", s=80.0, d=0.0, v_x=12.0), duration=12.0, road=Road(LINE))
    assert log.gaps().min() > 2.0
    assert np.abs(log.ego_frenet[:, 1]).max() < 0.2
    assert abs(log.ego[-1, 3] - 12.0) < 2.0
    assert "FOLLOW" in log.actions


@METHODS
def test_planner_waits_for_oncoming_vehicle(method: str) -> None:
    road = Road(LINE, (Lane(d=0.0), Lane(d=3.5, direction=-1)))
    slow = RoadUser(id="a", s=70.0, d=0.0, v_x=10.0)
    other = RoadUser(id="o", s=300.0, d=3.5, v_x=20.0, direction=-1)
    log = drive(method, slow, other, duration=8.0, road=road)
    assert log.t[-1] == pytest.approx(8.0)
    assert log.gaps().min() > 0.3


@METHODS
def test_empty_road_needs_no_control(method: str) -> None:
    log = drive(method, duration=2.0)
    assert np.abs(log.ego_frenet[:, 1]).max() < 1e-2
    assert np.abs(log.ego[:, 3] - 20.0).max() < 0.05
    assert log.actions == ["KEEP"]


@METHODS
def test_invalid_input_brakes(method: Any) -> None:
    planner = MpcPlanner(CAR, ROAD, cruise_speed=20.0, method=method)
    assert planner.step(0.0, STATE, []).status is Status.OK
    bad: list[tuple[Any, Any]] = [
        (0.0, STATE), (math.nan, STATE), ("1", STATE), (1.0, None),
        (2.0, dataclasses.replace(STATE, y=500.0)), (3.0, dataclasses.replace(STATE, psi=math.pi)),
    ]  # fmt: skip
    for t, state in bad:
        command = planner.step(t, state, [])
        assert command.status is Status.INVALID_INPUT
        assert is_usable(command)
        assert command.a_x < -1.0
    remotes: Any = [None, RemoteVehicle(id="x", x=math.nan, y=0.0, psi=0.0, v_x=0.0)]
    command = planner.step(4.0, STATE, remotes)
    assert command.status is Status.OK
    assert len(command.dropped) == 2


@METHODS
def test_missing_solution_continues_last_one_then_brakes(method: Any) -> None:
    planner = MpcPlanner(CAR, ROAD, cruise_speed=20.0, method=method, settings=MpcSettings(iterations=1))
    command = planner.step(0.0, STATE, [RemoteVehicle(id="a", x=150.0, y=0.0, psi=0.0, v_x=5.0)])
    assert command.status is Status.DEGRADED
    assert command.a_x < -1.0
    planner = MpcPlanner(CAR, ROAD, cruise_speed=20.0, method=method)
    planner.step(0.0, STATE, [])
    wall = [RemoteVehicle(id=str(y), x=110.0, y=y, psi=0.0, v_x=0.0) for y in (0.0, 2.0, 3.5)]
    for k in range(1, 20):
        x = 100.0 + 20.0 * 0.1 * k
        command = planner.step(0.1 * k, dataclasses.replace(STATE, x=x), wall)
        assert is_usable(command)
        if k < 3:
            assert command.status is not Status.OK


@pytest.mark.parametrize(
    ("wrong", "name"),
    [({"vehicle": 1}, "vehicle"), ({"road": 1}, "road"), ({"cruise_speed": 0.0}, "cruise_speed"),
     ({"method": "other"}, "method")],
)  # fmt: skip
def test_error_names_argument(wrong: dict[str, Any], name: str) -> None:
    given: dict[str, Any] = {"vehicle": CAR, "road": ROAD, "cruise_speed": 20.0, **wrong}
    with pytest.raises(InputError, match=name):
        MpcPlanner(**given)

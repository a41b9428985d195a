"""The planner in closed loop is invariant to rotation, shift and reflection of the world."""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import RemoteVehicle, VehicleState
from cca_core.path import Lane, Path, Road, fit_path
from cca_core.planner import CostSettings
from cca_core.sim import Log, Scenario, SingleTrackPlant, make_planner, overtaking, simulate
from cca_core.sim.loop import CYCLE_TIME
from cca_core.sim.world.traffic import Traffic

NUMBER = re.compile(r"(?<![A-Za-z])\d+(?:\.\d+)?")
ONE_CYCLE = 0.021  # [s]
GRID = 5e-3  # messages round speeds, headings and positions; both worlds round differently

DURATION = 13.0  # of case 1-fast, until its first maneuver is complete [s]


def waypoints(kind: str) -> np.ndarray[Any, Any]:
    s = np.arange(0.0, 901.0, 10.0)
    if kind == "straight":
        return np.column_stack((s, np.zeros_like(s)))
    return 1500.0 * np.column_stack((np.sin(s / 1500.0), 1.0 - np.cos(s / 1500.0)))


def moved(xy: np.ndarray[Any, Any], angle: float, shift: tuple[float, float]) -> np.ndarray[Any, Any]:
    c, s = math.cos(angle), math.sin(angle)
    return xy @ np.array([[c, s], [-s, c]]) + shift


def path_of(xy: np.ndarray[Any, Any]) -> Path:
    return fit_path(xy, tolerance=0.05)


def scenario_on(path: Path, case: str = "1-fast") -> Scenario:
    return replace(overtaking(case, path), duration=DURATION)


def mirrored(scenario: Scenario, path: Path) -> Scenario:
    """The reflected scenario: the passing lane is on the right."""
    lanes = tuple(replace(lane, d=-lane.d) for lane in scenario.road.lanes)
    return replace(
        scenario,
        road=Road(path, lanes, speed_limit=scenario.road.speed_limit),
        road_users=tuple(replace(u, d=-u.d) for u in scenario.road_users),
    )


def mirrored_text(reason: str) -> str:
    """A reason with left and right exchanged."""
    sides = {"left": "right", "right": "left"}
    return re.sub(r"\b(left|right)\b", lambda found: sides[found[0]], reason)


@pytest.fixture(scope="module", params=["straight", "curved"])
def plain(request: pytest.FixtureRequest) -> tuple[str, Log]:
    return request.param, simulate(scenario_on(path_of(waypoints(request.param))))


def test_reference_run_has_a_maneuver(plain: tuple[str, Log]) -> None:
    _, log = plain
    assert log.actions == ["KEEP", "EVADE_LEFT", "KEEP"]
    assert np.abs(log.command[:, 0]).max() > 0.005
    assert log.ego_frenet[:, 1].max() > 2.5


@pytest.mark.parametrize(("angle", "shift"), [(2.1, (300.0, -120.0)), (-math.pi / 2.0, (-5000.0, 8000.0))])
def test_rotated_world_gives_same_run(
    plain: tuple[str, Log], angle: float, shift: tuple[float, float]
) -> None:
    kind, log = plain
    other = simulate(scenario_on(path_of(moved(waypoints(kind), angle, shift))))
    assert np.abs(other.command - log.command).max() < GRID
    assert other.actions == log.actions
    assert [t for t, _, _ in other.decisions] == pytest.approx(
        [t for t, _, _ in log.decisions], abs=ONE_CYCLE
    )
    assert moved(log.ego[:, :2], angle, shift) == pytest.approx(other.ego[:, :2], abs=0.03)
    assert other.gaps() == pytest.approx(log.gaps(), abs=0.05)


def exactly(scenario: Scenario) -> tuple[np.ndarray[Any, Any], list[str]]:
    """Commands and actions with exact records of the other vehicles."""
    planner, traffic = make_planner(scenario), Traffic(scenario)
    path, start = scenario.road.path, scenario.start
    x, y = path.position(start).tolist()
    plant = SingleTrackPlant(
        scenario.vehicle, VehicleState(x=x, y=y, psi=float(path.heading(start)), v_x=scenario.v_x)
    )
    commands, actions = [], []
    for k in range(round(scenario.duration / CYCLE_TIME)):
        t, state = k * CYCLE_TIME, plant.state
        remotes = [
            RemoteVehicle(id=u.id, x=x, y=y, psi=psi, v_x=v, a_x=a, r=r, length=u.length, width=u.width)
            for u, (x, y, psi, v, a, r) in zip(scenario.road_users, traffic.rows(), strict=True)
        ]
        command = planner.step(t, state, remotes)
        commands.append((command.delta, command.a_x))
        actions.append(command.decision.action.value)
        plant.step(command.delta, command.a_x, CYCLE_TIME)
        traffic.step(t, state)
    return np.array(commands), actions


@pytest.mark.parametrize("kind", ["straight", "curved"])
def test_exact_records_give_same_commands(kind: str) -> None:
    commands, actions = exactly(scenario_on(path_of(waypoints(kind))))
    assert "EVADE_LEFT" in actions
    assert np.abs(commands[:, 0]).max() > 0.005
    turned, same = exactly(scenario_on(path_of(moved(waypoints(kind), 2.1, (300.0, -120.0)))))
    assert np.abs(turned - commands).max() < 1e-6
    assert same == actions
    path = path_of(waypoints(kind) * (1.0, -1.0))
    flipped, other = exactly(mirrored(scenario_on(path), path))
    assert np.abs(flipped * (-1.0, 1.0) - commands).max() < 1e-6
    assert [a.replace("RIGHT", "LEFT") for a in other] == actions


def test_mirrored_world_gives_mirrored_run(plain: tuple[str, Log]) -> None:
    kind, log = plain
    path = path_of(waypoints(kind) * (1.0, -1.0))
    other = simulate(mirrored(scenario_on(path), path))
    assert np.abs(other.command[:, 0] + log.command[:, 0]).max() < GRID
    assert np.abs(other.command[:, 1] - log.command[:, 1]).max() < GRID
    swap = {"EVADE_LEFT": "EVADE_RIGHT", "EVADE_RIGHT": "EVADE_LEFT"}
    assert [swap.get(name, name) for name in other.actions] == log.actions
    assert [t for t, _, _ in other.decisions] == pytest.approx(
        [t for t, _, _ in log.decisions], abs=ONE_CYCLE
    )
    assert other.ego_frenet[:, 1] == pytest.approx(-log.ego_frenet[:, 1], abs=0.02)
    for (_, _, reason), (_, _, expected) in zip(other.decisions, log.decisions, strict=True):
        assert NUMBER.split(mirrored_text(reason)) == NUMBER.split(expected)
        figures = [float(x) for x in NUMBER.findall(expected)]
        assert [float(x) for x in NUMBER.findall(reason)] == pytest.approx(figures, abs=1.01)


def test_mirrored_world_waits_for_oncoming_car() -> None:
    """Case 3 until the ego follows, and the same in left-hand traffic."""
    logs = []
    for sign in (1.0, -1.0):
        path = path_of(waypoints("curved") * (1.0, sign))
        s = overtaking("3", path, start=0.0)
        s = replace(s, duration=18.0)
        logs.append(simulate(s if sign > 0.0 else mirrored(s, path)))
    left, right = logs
    assert left.actions == ["KEEP", "EVADE_LEFT", "KEEP", "FOLLOW"]
    assert right.actions == ["KEEP", "EVADE_RIGHT", "KEEP", "FOLLOW"]
    assert np.abs(left.command[:, 0] + right.command[:, 0]).max() < GRID
    assert np.abs(left.command[:, 1] - right.command[:, 1]).max() < GRID


def test_cheaper_side_is_mirrored() -> None:
    """Three lanes, no preferred side, a slow car off its lane's middle: the ego passes on the wider side."""
    seen = []
    for sign in (1.0, -1.0):
        path = path_of(waypoints("straight"))
        base = scenario_on(path)
        lanes = (Lane(d=-3.5), Lane(d=0.0), Lane(d=3.5))
        user = replace(base.road_users[0], d=0.5 * sign)
        evasion = replace(base.evasion, cost=CostSettings(right=0.0))
        log = simulate(replace(base, road=Road(path, lanes), road_users=(user,), evasion=evasion))
        seen.append((log.actions, log.command))
    assert seen[0][0] == ["KEEP", "EVADE_RIGHT", "KEEP"]
    assert seen[1][0] == ["KEEP", "EVADE_LEFT", "KEEP"]
    assert np.abs(seen[0][1][:, 0] + seen[1][1][:, 0]).max() < GRID

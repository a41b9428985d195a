"""The planner in closed loop does not care how the world is turned, shifted or mirrored."""

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import RemoteVehicle, VehicleState
from cca_core.path import Lane, Path, Road, fit_path
from cca_core.sim import Log, Scenario, SingleTrackPlant, make_planner, overtaking, simulate
from cca_core.sim.loop import CYCLE_TIME
from cca_core.sim.world.traffic import Traffic

NUMBER = re.compile(r"(?<![A-Za-z])\d+(?:\.\d+)?")
ONE_CYCLE = 0.021  # [s]
GRID = 5e-3  # speeds, headings and places in messages are rounded; both worlds round differently

LONG = 13.0  # the first swerve of case 1-fast and its end [s]


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
    return replace(overtaking(case, path), duration=LONG)


def mirrored(scenario: Scenario, path: Path) -> Scenario:
    """Everything on the other side: the passing lane is on the right."""
    lanes = tuple(replace(lane, d=-lane.d) for lane in scenario.road.lanes)
    return replace(
        scenario, road=Road(path, lanes, speed_limit=scenario.road.speed_limit),
        road_users=tuple(replace(u, d=-u.d) for u in scenario.road_users),
    )  # fmt: skip


@pytest.fixture(scope="module", params=["straight", "curved"])
def plain(request: pytest.FixtureRequest) -> tuple[str, Log]:
    return request.param, simulate(scenario_on(path_of(waypoints(request.param))))


def test_the_run_is_worth_comparing(plain: tuple[str, Log]) -> None:
    _, log = plain
    assert log.actions == ["KEEP", "EVADE_LEFT", "KEEP"]
    assert np.abs(log.command[:, 0]).max() > 0.005
    assert log.ego_frenet[:, 1].max() > 2.5


@pytest.mark.parametrize(("angle", "shift"), [(2.1, (300.0, -120.0)), (-math.pi / 2.0, (-5000.0, 8000.0))])
def test_turned_and_shifted(plain: tuple[str, Log], angle: float, shift: tuple[float, float]) -> None:
    kind, log = plain
    other = simulate(scenario_on(path_of(moved(waypoints(kind), angle, shift))))
    assert np.abs(other.command - log.command).max() < GRID
    assert other.actions == log.actions
    assert [t for t, _, _ in other.decisions] == pytest.approx(
        [t for t, _, _ in log.decisions], abs=ONE_CYCLE
    )
    # what early, rounded messages said of a bend stays in what has been driven
    apart = 0.05 if kind == "straight" else 0.085
    assert moved(log.ego[:, :2], angle, shift) == pytest.approx(other.ego[:, :2], abs=apart)
    assert other.gaps() == pytest.approx(log.gaps(), abs=0.05)


def exactly(scenario: Scenario) -> tuple[np.ndarray[Any, Any], list[str]]:
    """Commands and actions with records of the others that nobody has rounded."""
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
def test_without_rounding_nothing_changes_at_all(kind: str) -> None:
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


def test_mirrored(plain: tuple[str, Log]) -> None:
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
    words = {"left": "right", "right": "left"}
    for (_, _, said), (_, _, meant) in zip(other.decisions, log.decisions, strict=True):
        assert NUMBER.split(" ".join(words.get(w, w) for w in said.split())) == NUMBER.split(meant)
        figures = [float(x) for x in NUMBER.findall(meant)]
        assert [float(x) for x in NUMBER.findall(said)] == pytest.approx(figures, abs=1.01)


def test_mirrored_wait_for_an_oncoming_car() -> None:
    """Case 3 up to its wait, the whole world mirrored: left-hand traffic."""
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


def test_both_sides_legal_the_cheaper_one_is_mirrored_too() -> None:
    """Three lanes, the slow car off the middle: it is passed where it leaves more room, in both worlds."""
    seen = []
    for sign in (1.0, -1.0):
        path = path_of(waypoints("straight"))
        base = scenario_on(path)
        lanes = (Lane(d=-3.5), Lane(d=0.0), Lane(d=3.5))
        user = replace(base.road_users[0], d=0.5 * sign)
        log = simulate(replace(base, road=Road(path, lanes), road_users=(user,)))
        seen.append((log.actions, log.command))
    assert seen[0][0] == ["KEEP", "EVADE_RIGHT", "KEEP"]
    assert seen[1][0] == ["KEEP", "EVADE_LEFT", "KEEP"]
    assert np.abs(seen[0][1][:, 0] + seen[1][1][:, 0]).max() < GRID

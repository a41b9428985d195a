"""Stability of the decision under noisy messages: at most one change of the action in ten seconds."""

import itertools
import math

import numpy as np
import pytest

from cca_core import Action, Lane, Planner, RemoteVehicle, Road, Status, VehicleState
from cca_core.path import interpolate_path
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import (
    ALL_KNOWN,
    CAR,
    CYCLE,
    ClosedLoop,
    CrossingVehicle,
    LaneLeavingVehicle,
    Reception,
    ScriptedVehicle,
    make_planner,
    straight,
)

SEEDS = range(3)


def noisy(seed: int) -> Reception:
    """Ten messages a second, with errors of 0.5 m along the road and 0.2 m/s; dead-reckoned between."""
    rng = np.random.default_rng(seed)
    error: dict[str, tuple[float, float]] = {}

    def receive(t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
        if round(t / CYCLE) % 5 == 0:
            error.update({r.id: (rng.normal(0.0, 0.5), rng.normal(0.0, 0.2)) for r in remotes})
        received = []
        for r in remotes:
            x, v = error[r.id]
            off = x + v * r.age
            received.append(
                RemoteVehicle(
                    id=r.id, x=r.x + off * math.cos(r.psi), y=r.y + off * math.sin(r.psi), psi=r.psi,
                    v_x=r.v_x + v, a_x=r.a_x, age=r.age, sigma_along=0.5,
                )
            )  # fmt: skip
        return received

    return receive


def changes(run: ClosedLoop, since: float = 0.0, until: float = math.inf) -> list[Action]:
    """Actions after the first one within ten seconds, of a run without collision."""
    assert run.collided_with is None
    actions = [
        c.decision.action for i, c in enumerate(run.commands) if since <= i * CYCLE < min(until, since + 10.0)
    ]
    return [b for a, b in itertools.pairwise(actions) if a is not b]


@pytest.mark.parametrize("seed", SEEDS)
class TestActionChanges:
    def test_following_in_one_lane_is_stable(self, seed: int) -> None:
        run = ClosedLoop(
            make_planner(None), [ScriptedVehicle("R", 25.5, 0.0, 12.0)], 10.0, v=12.0, receive=noisy(seed)
        )
        assert len(changes(run)) <= 1

    def test_following_with_blocked_adjacent_lane_is_stable(self, seed: int) -> None:
        traffic = [ScriptedVehicle("R", 25.5, 0.0, 12.0), ScriptedVehicle("L", 0.0, 3.5, 12.0)]
        run = ClosedLoop(make_planner(), traffic, 10.0, v=12.0, receive=noisy(seed))
        assert len(changes(run)) <= 1

    def test_approach_without_adjacent_lane_is_stable(self, seed: int) -> None:
        run = ClosedLoop(
            make_planner(None), [ScriptedVehicle("R", 100.0, 0.0, 12.0)], 12.0, receive=noisy(seed)
        )
        assert len(changes(run)) <= 1
        assert len(changes(run, 2.0)) <= 1

    def test_approach_with_clear_lane_evades_once(self, seed: int) -> None:
        run = ClosedLoop(make_planner(), [ScriptedVehicle("R", 90.0, 0.0, 12.0)], 10.0, receive=noisy(seed))
        assert changes(run) == [Action.EVADE_LEFT]

    def test_lead_at_speed_advantage_limit_is_stable(self, seed: int) -> None:
        """At the speed advantage from which on a car is passed."""
        traffic = [ScriptedVehicle("R", 40.0, 0.0, 18.0), ScriptedVehicle("L", 0.0, 3.5, 18.0)]
        run = ClosedLoop(make_planner(), traffic, 10.0, v=18.0, receive=noisy(seed))
        assert len(changes(run)) <= 1

    def test_waiting_for_oncoming_traffic_is_stable(self, seed: int) -> None:
        road = Road(straight(2000.0), (Lane(d=0.0), Lane(d=3.5, direction=-1)))
        planner = Planner(CAR, road, cruise_speed=20.0, evasion=ALL_KNOWN)
        column = [ScriptedVehicle(f"O{i}", 60.0 + 110.0 * i, 3.5, 20.0, psi=math.pi) for i in range(6)]
        run = ClosedLoop(
            planner, [ScriptedVehicle("R", 25.5, 0.0, 12.0), *column], 10.0, v=12.0, receive=noisy(seed)
        )
        assert len(changes(run)) <= 1

    def test_waiting_behind_stationary_car_is_stable(self, seed: int) -> None:
        run = ClosedLoop(
            make_planner(None), [ScriptedVehicle("R", 7.5, 0.0, 0.0)], 10.0, v=0.0, receive=noisy(seed)
        )
        assert len(changes(run)) <= 1

    def test_braking_for_downstream_stationary_car_is_stable(self, seed: int) -> None:
        traffic = [ScriptedVehicle("Y", 45.0, 0.0, 13.9), ScriptedVehicle("R", 170.0, -1.05, 0.0)]
        run = ClosedLoop(make_planner(cruise=13.9), traffic, 10.0, v=13.9, receive=noisy(seed))
        assert len(changes(run)) <= 1

    def test_yielding_to_crossing_car_is_stable(self, seed: int) -> None:
        crossing = CrossingVehicle("X", 120.0, -60.0, 10.0, psi=0.5 * math.pi)
        run = ClosedLoop(make_planner(None), [crossing], 10.0, receive=noisy(seed))
        # it comes and goes: wait, and drive on
        assert len(changes(run, until=5.0)) <= 1
        assert len(changes(run)) <= 2


@pytest.mark.parametrize("seed", SEEDS)
def test_reference_is_continuous_at_ego(seed: int) -> None:
    """Replanned ten times a second, the reference continues at the position and heading of the ego."""
    traffic = [ScriptedVehicle("R", 80.0, 0.0, 12.0), ScriptedVehicle("L", 140.0, 3.5 + 3.4, 12.0)]
    run = ClosedLoop(make_planner(), traffic, 22.0, receive=noisy(seed))
    assert run.collided_with is None
    assert max(run.y) > 2.5
    moved, turned = [], []
    for i, (before, now) in enumerate(itertools.pairwise(run.commands)):
        if before.decision.action is now.decision.action is Action.EVADE_LEFT:
            position = (run.x[i], run.y[i])
            (s, d), (s_1, d_1) = (c.reference.project(position) for c in (before, now))
            moved.append(abs(float(d_1 - d)))
            turned.append(abs(float(now.reference.heading(s_1) - before.reference.heading(s))))
    assert len(moved) > 300
    assert max(moved) < 5e-3
    assert max(turned) < 2e-3
    steering = np.diff([c.delta for c in run.commands]) / CYCLE
    assert np.abs(steering).max() < math.radians(12.0)


@pytest.mark.parametrize(("radius", "v"), [(60.0, 9.0), (100.0, 14.0), (-150.0, 15.0), (-400.0, 24.0)])
def test_reference_is_continuous_at_ego_on_curve(radius: float, v: float) -> None:
    """Past a parked car without noise: replanning adds no steering."""
    phi = np.arange(0.0, 451.0, 2.0) / abs(radius)
    path = interpolate_path(
        np.column_stack((np.sin(phi), math.copysign(1.0, radius) * (1.0 - np.cos(phi)))) * abs(radius)
    )
    planner = Planner(CAR, Road(path, (Lane(d=0.0), Lane(d=3.5))), cruise_speed=v, evasion=ALL_KNOWN)
    x, y = path.position(60.0).tolist()
    plant = SingleTrackPlant(CAR, VehicleState(x=x, y=y, psi=float(path.heading(60.0)), v_x=v))
    x, y = path.position(180.0).tolist()
    parked = RemoteVehicle(id="P", x=x, y=y, psi=float(path.heading(180.0)), v_x=0.0)
    deltas, statuses = [], []
    for k in range(round(150.0 / v / CYCLE)):
        command = planner.step(k * CYCLE, plant.state, [parked])
        plant.step(command.delta, command.a_x, CYCLE)
        if command.decision.action.is_evading:
            deltas.append(command.delta)
            statuses.append(command.status)
    assert len(deltas) > 100
    steps = np.diff(deltas)
    turns = np.sign(steps[np.abs(steps) > 1e-5])
    assert np.count_nonzero(np.diff(turns)) <= 8
    assert np.abs(steps).max() / CYCLE < math.radians(8.0)
    assert statuses.count(Status.OK) >= len(statuses) - 10


def test_downstream_stationary_car_without_noise_is_stable() -> None:
    """At 50 km/h the ego passes it, after the vehicle directly ahead has left the lane."""
    v, station = 13.9, 125.1
    yellow = LaneLeavingVehicle(1.5 * v + 4.5, v, station=station, range=1.1 * v + 4.5, offset=3.0)
    red = ScriptedVehicle("R", station, -1.05, 0.0)
    run = ClosedLoop(make_planner(cruise=v), [yellow, red], 22.0, v=v, done=lambda ego: ego.x > 200.0)
    assert run.collided_with is None
    assert len(changes(run)) <= 3

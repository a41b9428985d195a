"""Commands end in an overtaking maneuver: the kit drives the certified stop, and touches nothing."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from cca_core import Path, VehicleParams, fit_path
from cca_core.follow import steady_turn
from cca_core.planner import SafeStop
from cca_core.rig import KitState, plan_safe_stop
from cca_core.sim import SingleTrackPlant, paper_scenarios
from tests.support.rig_world import CYCLE, RigWorld

CAR = VehicleParams.bmw_320i()
SCENARIOS = {s.case: s for s in paper_scenarios() if s.name == "maneuver" and s.ego_type == "v2v"}


def world_of(case: str) -> RigWorld:
    """A maneuver among drivers who react to an ego that stops ahead of them."""
    users = tuple(replace(user, reaction_time=1.15) for user in SCENARIOS[case].road_users)
    return RigWorld(replace(SCENARIOS[case], road_users=users))


def check_stop(running: RigWorld) -> None:
    """End the commands now; compare what the kit drives with the last safe stop of the planner."""
    world, begin = copy.deepcopy(running), len(running.plant.rows) - 1
    assert running.vehicle.last is not None
    stop = running.vehicle.last.command.safe_stop
    assert stop is not None
    world.dead = True
    world.run(lambda w: w.state.v_x == 0.0, 1100)
    assert world.plant.rows[-1].collided_with == ""
    assert world.state.v_x == 0.0
    states = world.states[len(running.states) :]
    assert states.index(KitState.SAFE_STOP) <= round(world.plant.kit.settings.timeout / CYCLE) + 2
    driven = np.array([(row.state.x, row.state.y) for row in world.plant.rows[begin:]])
    t = CYCLE * np.arange(len(driven))
    certified = np.column_stack([np.interp(t, stop.t, stop.poses[:, i]) for i in (0, 1)])
    path = stop.path()
    if path is None:
        return
    (s, d), (s_certified, _) = path.project(driven), path.project(certified)
    assert np.abs(d).max() < 0.6
    assert abs(d[-1]) < 0.2
    assert np.abs(s - s_certified).max() < 2.0
    road, state = world.scenario.road, world.state
    corners = world.scenario.vehicle.body_at(state.x, state.y, state.psi).corners().reshape(-1, 2)
    lateral = road.path.project(corners)[1]
    assert road.right_edge <= lateral.min()
    assert lateral.max() <= road.left_edge


@pytest.mark.parametrize(
    ("case", "every"),
    [("2", 110), *(pytest.param(case, 13, marks=pytest.mark.slow) for case in SCENARIOS)],
)  # fmt: skip
def test_kit_follows_certified_stop_anywhere(case: str, every: int) -> None:
    """Some moments lie alongside the overtaken vehicle, or just ahead of it on the way back."""
    world, alongside = world_of(case), 0
    world.run(lambda w: len(w.plant.rows) > 150)
    while len(world.plant.rows) + 650 < world.scenario.duration / CYCLE:
        check_stop(world)
        near = [np.hypot(x - world.state.x, y - world.state.y) for x, y, *_ in world.plant.rows[-1].users]
        alongside += abs(world.d) > 1.8 and min(near) < 8.0
        world.run(cycles=every)
    assert alongside > 0
    assert world.vehicle.counts["plans"] > 10 * world.vehicle.counts["braking_plans"]


def bend(radius: float) -> Path:
    angle = np.linspace(0.0, 600.0 / radius, 161)
    return fit_path(np.column_stack((radius * np.sin(angle), radius * (1.0 - np.cos(angle)))))


def stop_along(path: Path, s: float, v: float, a_x: float, time: float) -> SafeStop:
    """A safe stop that drives on along a path, with one acceleration."""
    t = np.arange(0.0, time + 0.05, 0.1)
    speed = np.maximum(v + a_x * t, 0.0)
    at = s + np.concatenate(([0.0], np.cumsum(0.05 * (speed[1:] + speed[:-1]))))
    poses = np.column_stack((path.position(at), path.heading(at)))
    return SafeStop(t=t, delta=0.0 * t, a_x=np.where(speed > 0.0, a_x, 0.0), v=speed, poses=poses)


@pytest.mark.parametrize("radius", [250.0, 5000.0])
@pytest.mark.parametrize("v", [8.0, 22.0])
def test_stop_that_drives_on_rests_where_its_poses_end(radius: float, v: float) -> None:
    """Longer than the horizon it must end by braking, inside the lane."""
    path = bend(radius)
    stop = stop_along(path, 30.0, v, 0.0, 20.0)
    car = SingleTrackPlant(CAR, steady_turn(path, 30.0, v, CAR))
    plan = plan_safe_stop(CAR, path, car.state, stop=stop)
    distance = 0.0
    for _ in range(1250):
        delta, a_x = plan.at(distance)
        distance += car.state.v_x * CYCLE
        car.step(delta, a_x, CYCLE)
    s, d = path.project((car.state.x, car.state.y))
    assert car.state.v_x == 0.0
    assert 0.8 * 20.0 * v < s - 30.0 < 20.0 * v + 1.5
    assert abs(d) < 0.5


def test_stop_without_motion_brakes_along_reference() -> None:
    path = bend(250.0)
    state = steady_turn(path, 30.0, 8.0, CAR)
    standing = stop_along(path, 30.0, 0.0, 0.0, 5.0)
    assert plan_safe_stop(CAR, path, state, stop=standing) == plan_safe_stop(CAR, path, state)

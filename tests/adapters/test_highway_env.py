"""The planner in highway-env: axes, roads, actions; by a small fake and by highway-env itself."""

import math
from types import SimpleNamespace
from typing import Any

import pytest

from cca_core import InputError
from cca_core.adapters import HighwayAgent, configure_highway, highway_vehicle, read_highway_road
from cca_core.follow import steady_steering
from tests.support.fake_highway import FakeLane, fake_env, fake_vehicle


def two_lanes(y: float = 0.0) -> list[FakeLane]:
    """Lanes of 400 m to the east, at y and 4 m to the right of it."""
    return [FakeLane((0.0, y), (400.0, y)), FakeLane((0.0, y + 4.0), (400.0, y + 4.0))]


def env_of(ego: Any, *others: Any) -> Any:
    return fake_env({"a": {"b": two_lanes()}}, ego, ("a", "b", 1), *others)


# --- roads --------------------------------------------------------------------------------------------


def test_lane_on_left_has_positive_offset() -> None:
    road = read_highway_road(env_of(fake_vehicle(100.0, 4.0)))
    assert [(round(lane.d, 6), lane.width, lane.direction) for lane in road.lanes] == [(0, 4, 1), (4, 4, 1)]
    assert road.speed_limit == 30.0
    assert road.path.position(road.path.start) == pytest.approx((50.0, -4.0), abs=1e-6)


def test_road_goes_on_behind_last_lane() -> None:
    path = read_highway_road(env_of(fake_vehicle(100.0, 4.0))).path
    assert path.position(path.end) == pytest.approx((700.0, -4.0), abs=10.0)


def test_road_of_given_length_ends_there() -> None:
    path = read_highway_road(env_of(fake_vehicle(100.0, 4.0)), length=200.0).path
    assert path.position(path.end) == pytest.approx((300.0, -4.0), abs=1e-6)


def test_road_continues_in_next_lane_with_its_limit() -> None:
    ahead = [FakeLane((400.0, y), (800.0, y), speed_limit=20.0) for y in (0.0, 4.0, 8.0)]
    env = fake_env({"a": {"b": two_lanes()}, "b": {"c": ahead}}, fake_vehicle(100.0, 4.0), ("a", "b", 1))
    road = read_highway_road(env, length=600.0)
    assert road.path.length == pytest.approx(650.0, abs=1e-3)
    assert [road.highest_limit(s, s) for s in (100.0, 349.0, 351.0, 600.0)] == [30.0, 30.0, 20.0, 20.0]
    assert [round(lane.d, 6) for lane in road.lanes] == [0, 4]  # the third one begins later


def test_lane_of_both_directions_is_opposing() -> None:
    graph = {"a": {"b": two_lanes()}, "b": {"a": [FakeLane((400.0, 0.0), (0.0, 0.0))]}}
    road = read_highway_road(fake_env(graph, fake_vehicle(100.0, 4.0), ("a", "b", 1)))
    assert [(round(lane.d, 6), lane.direction) for lane in road.lanes] == [(0, 1), (4, -1)]
    assert road.path.min_radius > 1e3  # it does not turn back


def test_forbidden_lane_is_left_out() -> None:
    env = env_of(fake_vehicle(100.0, 4.0))
    env.unwrapped.road.network.graph["a"]["b"][0].forbidden = True
    assert len(read_highway_road(env).lanes) == 1


# --- vehicles and actions -----------------------------------------------------------------------------


def test_ego_state_has_y_to_the_left() -> None:
    ego = fake_vehicle(100.0, 4.0, heading=0.1, action={"steering": 0.2, "acceleration": -1.0})
    agent = HighwayAgent(env := env_of(ego))
    state = agent.ego_state(env)
    slip = math.atan(0.5 * math.tan(0.2))
    assert (state.x, state.y, state.psi, state.delta, state.a_x) == (100.0, -4.0, -0.1, -0.2, -1.0)
    assert (state.v_x, state.v_y) == pytest.approx((20.0 * math.cos(slip), -20.0 * math.sin(slip)))
    assert state.r == pytest.approx(-20.0 * math.sin(slip) / 2.5)
    assert state.t == 2.0


def test_remotes_keep_their_ids_when_one_leaves() -> None:
    cars = [fake_vehicle(100.0 + 30.0 * k, 0.0, speed=-5.0) for k in range(3)]
    agent = HighwayAgent(env := env_of(fake_vehicle(50.0, 4.0), *cars))
    assert [other.id for other in agent.remotes(env)] == ["v0", "v1", "v2"]
    env.unwrapped.road.vehicles.remove(cars[0])
    assert [(other.id, other.x, other.y, other.v_x) for other in agent.remotes(env)] == [
        ("v1", 130.0, 0.0, -5.0),
        ("v2", 160.0, 0.0, -5.0),
    ]


def test_only_solid_objects_are_remotes() -> None:
    agent = HighwayAgent(env := env_of(fake_vehicle(50.0, 4.0)))
    for solid in (True, False):
        env.unwrapped.road.objects.append(
            fake_vehicle(90.0, 4.0, speed=0.0, LENGTH=2.0, action=None, solid=solid)
        )
    (wall,) = agent.remotes(env)
    assert (wall.length, wall.width, wall.v_x, wall.invalid_reason) == (2.0, 2.0, 0.0, None)


def test_action_is_scaled_and_steers_to_the_right_of_the_screen() -> None:
    agent = HighwayAgent(env := env_of(fake_vehicle(100.0, 3.0)))  # 1 m left of its lane
    a_x, steering = agent.act(env)
    assert agent.command is not None
    assert (8.0 * a_x, -0.5 * steering) == pytest.approx((agent.command.a_x, agent.command.delta))
    assert steering > 0.0


def test_braking_ends_at_standstill() -> None:
    wall = fake_vehicle(58.0, 4.0, speed=0.0)
    agent = HighwayAgent(env := env_of(fake_vehicle(50.0, 4.0, speed=0.1), wall))
    a_x, _ = agent.act(env)
    assert 8.0 * a_x >= -0.1 * 15.0 - 1e-9


def test_vehicle_turns_as_that_of_highway_env() -> None:
    car = highway_vehicle(fake_vehicle(0.0, 0.0))
    assert (car.length, car.width, car.front, car.l_f) == (5.0, 2.0, 2.5, 2.5)
    v, delta = 20.0, 0.02
    kappa = math.sin(math.atan(0.5 * math.tan(delta))) / 2.5
    assert steady_steering(kappa, v, car) == pytest.approx(delta, rel=0.01)


def test_discrete_actions_raise() -> None:
    env = env_of(fake_vehicle(100.0, 4.0))
    del env.unwrapped.action_type.steering_range
    with pytest.raises(InputError, match="env must be reset and have continuous actions"):
        HighwayAgent(env)


@pytest.mark.parametrize("env", [None, SimpleNamespace(unwrapped=SimpleNamespace())])
@pytest.mark.parametrize("call", [HighwayAgent, configure_highway, read_highway_road])
def test_other_environments_raise(call: Any, env: Any) -> None:
    with pytest.raises(InputError, match=r"^env must be an environment of highway-env, was "):
        call(env)


def test_environment_before_its_reset_raises() -> None:
    env = env_of(fake_vehicle(100.0, 4.0))
    env.unwrapped.vehicle = None
    for call in (HighwayAgent, read_highway_road):
        with pytest.raises(InputError, match=r"^env must be reset"):
            call(env)


# --- highway-env --------------------------------------------------------------------------------------


@pytest.mark.requires("highway_env")
@pytest.mark.filterwarnings("ignore")  # of Gymnasium, about versions
@pytest.mark.parametrize(("name", "lanes"), [("highway-v0", 4), ("merge-v0", 2), ("two-way-v0", 2)])
def test_first_seconds_pass_without_contact(name: str, lanes: int) -> None:
    gymnasium, highway_env = pytest.importorskip("gymnasium"), pytest.importorskip("highway_env")
    gymnasium.register_envs(highway_env)
    env = gymnasium.make(name, max_episode_steps=100_000)
    configure_highway(env)
    env.reset(seed=3)
    agent = HighwayAgent(env)
    assert len(agent.planner.road.lanes) == lanes
    for _ in range(30):
        _, _, _, _, info = env.step(agent.act(env))
        assert not info["crashed"]
    assert info["speed"] > 10.0
    env.close()

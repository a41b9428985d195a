"""Print contacts and mean speeds: ``python -m tests.trials.highway --seeds 0:10``."""

import argparse
import math
import warnings
from typing import Any

import gymnasium
import highway_env
import numpy as np
from highway_env.vehicle.behavior import IDMVehicle

from cca_core.adapters import HighwayAgent, configure_highway
from tests.trials import highway

DURATIONS = {"highway-v0": 40.0, "merge-v0": 40.0, "two-way-v0": 40.0}  # [s]; merge ends behind the ramp
FULL_SPEED = 30.0  # of highway-env's own driver, within the speed limit of its lane [m/s]


def begin(name: str, seed: int) -> Any:
    """Return an environment at the start of an episode."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that there is a newer version of some environments
        env = gymnasium.make(name, max_episode_steps=100_000)
    configure_highway(env, duration=DURATIONS[name])
    env.reset(seed=seed)
    return env


def drive(name: str, seed: int, *, by_planner: bool) -> tuple[list[float], str]:
    """Return the speeds of an episode, and a text about its contact if there is one."""
    env = begin(name, seed)
    world = env.unwrapped
    if by_planner:
        agent = HighwayAgent(env)
    else:
        old = world.vehicle
        world.vehicle = own = IDMVehicle(
            world.road, old.position, old.heading, old.speed, target_speed=FULL_SPEED
        )
        world.road.vehicles[world.road.vehicles.index(old)] = own
    speeds, over = [], False
    while not over and len(speeds) < DURATIONS[name] * world.config["policy_frequency"]:
        action = agent.act(env) if by_planner else None
        _, _, terminated, truncated, _ = env.step(action)
        speeds.append(float(world.vehicle.speed))
        over = terminated or truncated
    contact = ""
    if world.vehicle.crashed:
        contact = f"  {name} seed {seed}: {len(speeds) / world.config['policy_frequency']:.1f} s, "
        contact += contact_text(world) + (f"; {agent.command.decision.reason}" if by_planner else "")
    env.close()
    return speeds, contact


def contact_text(world: Any) -> str:
    """Describe the vehicle that is nearest to the ego, in the axes of highway-env."""
    ego = world.vehicle
    others = [other for other in (*world.road.vehicles, *world.road.objects) if other is not ego]
    other = min(others, key=lambda o: float(np.linalg.norm(o.position - ego.position)))
    dx, dy = other.position - ego.position
    ahead = dx * math.cos(ego.heading) + dy * math.sin(ego.heading)
    right = dy * math.cos(ego.heading) - dx * math.sin(ego.heading)
    turned = math.degrees(other.heading - ego.heading)
    lanes = f"lane {other.lane_index}, target {getattr(other, 'target_lane_index', None)}"
    return (
        f"{type(other).__name__} {ahead:+.1f} m ahead, {right:+.1f} m right, turned by {turned:+.0f} deg, "
        f"{other.speed:.1f} m/s, {lanes}; ego {ego.speed:.1f} m/s, {ego.lane_index}, y {ego.position[1]:.1f}"
    )


def main() -> None:
    """Run the environments and seeds that the command line names."""
    parser = argparse.ArgumentParser(prog="python -m tests.trials.highway", description=highway.__doc__)
    parser.add_argument("--env", default=",".join(DURATIONS), help="names, separated by commas")
    parser.add_argument("--seeds", default="0:10", help="first:last, without the last")
    given = parser.parse_args()
    seeds = range(*map(int, given.seeds.split(":")))
    gymnasium.register_envs(highway_env)
    print("environment | episodes | contacts | v | contacts of its driver | v of its driver")
    for name in given.env.split(","):
        cells: list[str] = []
        for by_planner in (True, False):
            driven = [drive(name, seed, by_planner=by_planner) for seed in seeds]
            contacts = [text for _, text in driven if text]
            if contacts:
                print(*contacts, sep="\n", flush=True)
            cells += [str(len(contacts)), f"{np.mean([np.mean(v) for v, _ in driven]):.1f}"]
        print(" | ".join((name, str(len(seeds)), *cells)), flush=True)


main()

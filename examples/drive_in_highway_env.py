"""Drive in highway-env: ``python drive_in_highway_env.py [ENVIRONMENT]``."""

import sys

import gymnasium
import highway_env

from cca_core.adapters import HighwayAgent, configure_highway

gymnasium.register_envs(highway_env)
name = sys.argv[1] if len(sys.argv) > 1 else "highway-fast-v0"
env = gymnasium.make(name, max_episode_steps=100_000)  # some environments end after 15 steps
configure_highway(env, duration=20)
env.reset(seed=1)
agent = HighwayAgent(env)
speeds, over = [], False
while not over and len(speeds) < 20 * env.unwrapped.config["policy_frequency"]:
    _, _, terminated, truncated, info = env.step(agent.act(env))
    over = terminated or truncated
    speeds.append(info["speed"])
    if len(speeds) % 15 == 0:
        print(f"{len(speeds):4} steps, {speeds[-1]:5.1f} m/s: {agent.command.decision.reason}")
print(f"contact: {info['crashed']}, mean speed {sum(speeds) / len(speeds):.1f} m/s")
env.close()

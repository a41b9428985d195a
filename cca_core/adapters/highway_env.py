"""The planner as agent of highway-env, in Gymnasium (extra ``highway``)."""

import math
from typing import Any

import numpy as np

from cca_core._checks import Array, check_real, shown
from cca_core.adapters.conversions import flip_axes
from cca_core.adapters.highway_net import read_highway_road, world_of
from cca_core.errors import InputError
from cca_core.follow import PreviewController, shipped_gains
from cca_core.planner.command import Command
from cca_core.planner.planner import Planner
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

_MAX_STEERING = 0.25 * math.pi  # [rad]
_MAX_ACCELERATION = 8.0  # [m/s^2]


def configure_highway(env: Any, **config: Any) -> None:
    """Prepare an environment for continuous actions of the planner; `env.reset` makes them count.

    Parameters
    ----------
    env : gymnasium.Env
        An environment of highway-env.
    **config : Any
        Further entries of its configuration.

    Raises
    ------
    InputError
        If it is no environment of highway-env.

    Notes
    -----
    Actions are accelerations up to 8 m/s^2 and road-wheel angles up to 45 deg, at the frequency of the
    simulation. The rewards of some environments, such as merge and two-way, exist for discrete actions only;
    they are 0 then.
    """
    world = world_of(env)
    limits = {
        "acceleration_range": (-_MAX_ACCELERATION, _MAX_ACCELERATION),
        "steering_range": (-_MAX_STEERING, _MAX_STEERING),
    }
    own = {"action": {"type": "ContinuousAction", **limits}, "observation": {"type": "Kinematics"}}
    config = own | config
    config.setdefault("policy_frequency", (world.config | config)["simulation_frequency"])
    world.configure(config)
    if not hasattr(world, "_rewards_of_discrete_actions"):
        world._rewards_of_discrete_actions = world._rewards
        world._rewards = lambda action: _rewards(world, action)


def _rewards(world: Any, action: Any) -> dict[str, float]:
    """Return the rewards of an action; none where they need a discrete one."""
    try:
        rewards: dict[str, float] = world._rewards_of_discrete_actions(action)
    except (AttributeError, ValueError):
        return {}
    return rewards


class HighwayAgent:
    """Agent that drives an environment of highway-env by the planner.

    Parameters
    ----------
    env : gymnasium.Env
        The environment, after `configure_highway` and `env.reset`. Make a new agent after each reset.
    cruise_speed : float, optional
        Target speed [m/s]; the default is the highest speed limit of the road.
    length : float
        Length of the road ahead that is read [m].
    **planner : Any
        Further arguments of `Planner`, such as ``evasion``.

    Attributes
    ----------
    planner : Planner
        The planner, with its road.
    command : Command or None
        The last command, with its reason.

    Raises
    ------
    InputError
        If the environment has no continuous actions or is not reset, or an argument is out of range.

    Notes
    -----
    The y axis of highway-env points down, so headings and steering angles are clockwise. Its vehicle is a
    kinematic bicycle of 5 m x 2 m with the axles at the ends of the body, at the center of which is its
    speed.
    """

    def __init__(
        self, env: Any, *, cruise_speed: float | None = None, length: float = 2000.0, **planner: Any
    ) -> None:
        world = world_of(env)
        check_real("length", length, gt=0.0)
        action: Any = getattr(world, "action_type", None)
        names = ("acceleration_range", "steering_range")
        if world.vehicle is None or not all(hasattr(action, name) for name in names) or action.size != 2:
            words = "must be reset and have continuous actions: call configure_highway and reset"
            raise InputError(f"env {words}, was {shown(world)}")
        self._ranges: list[tuple[float, float]] = [getattr(action, name) for name in names]
        road = read_highway_road(env, length=length)
        speed = road.speed_limit if cruise_speed is None else cruise_speed
        vehicle = highway_vehicle(world.vehicle)
        # without slip and lag it needs no gains of its own
        planner.setdefault("controller", PreviewController(vehicle, shipped_gains(vehicle)))
        self.planner = Planner(vehicle, road, cruise_speed=speed, **planner)
        self.command: Command | None = None
        self._names: dict[int, str] = {}  # of vehicles, in the order in which they appear

    def act(self, env: Any) -> Array:
        """Return the action of the next step.

        Parameters
        ----------
        env : gymnasium.Env
            The environment.

        Returns
        -------
        action : ndarray, shape (2,)
            Acceleration and steering angle, each from -1 to 1 in its range [-].
        """
        world = env.unwrapped
        state = self.ego_state(env)
        self.command = self.planner.step(state.t or 0.0, state, self.remotes(env))
        # highway-env would go on braking into reverse
        a_x = max(self.command.a_x, -max(world.vehicle.speed, 0.0) * world.config["policy_frequency"])
        values = zip((a_x, -self.command.delta), self._ranges, strict=True)
        scaled = [2.0 * (value - low) / (high - low) - 1.0 for value, (low, high) in values]
        return np.array(scaled).clip(-1.0, 1.0)

    def ego_state(self, env: Any) -> VehicleState:
        """Motion of the ego.

        Parameters
        ----------
        env : gymnasium.Env
            The environment.

        Returns
        -------
        state : VehicleState
            Center of the body now.
        """
        world = env.unwrapped
        x, y, psi, v, beta, r, a_x = _motion(world.vehicle)
        delta = -float(world.vehicle.action["steering"])
        v_x, v_y = max(v, 0.0) * math.cos(beta), max(v, 0.0) * math.sin(beta)
        t = world.steps / world.config["simulation_frequency"]
        return VehicleState(x=x, y=y, psi=psi, v_x=v_x, v_y=v_y, r=r, delta=delta, a_x=a_x, t=t)

    def remotes(self, env: Any) -> tuple[RemoteVehicle, ...]:
        """Other vehicles and obstacles.

        Parameters
        ----------
        env : gymnasium.Env
            The environment.

        Returns
        -------
        vehicles : tuple of RemoteVehicle
            All that can collide, with the ids ``"v0"``, ``"v1"`` ... in the order in which they appeared.
        """
        road, found = env.unwrapped.road, []
        for other in (*road.vehicles, *road.objects):
            if other is env.unwrapped.vehicle or not other.solid:
                continue
            name = self._names.setdefault(id(other), f"v{len(self._names)}")
            x, y, psi, v, beta, r, a_x = _motion(other)
            length, width = float(other.LENGTH), float(other.WIDTH)
            # its course is its heading: it slips, and predictions go straight ahead
            found.append(
                RemoteVehicle(
                    id=name, x=x, y=y, psi=psi + beta, v_x=v, a_x=a_x, r=r, length=length, width=width
                )
            )
        return tuple(found)


def highway_vehicle(vehicle: Any) -> VehicleParams:
    """Parameters of a vehicle of highway-env.

    Parameters
    ----------
    vehicle : highway_env.vehicle.kinematics.Vehicle
        The ego.

    Returns
    -------
    params : VehicleParams
        A car with its size and axles, on tires so stiff that it hardly slips.
    """
    half = 0.5 * float(vehicle.LENGTH)
    return VehicleParams(
        m=1500.0, I_z=1500.0 * half * half, l_f=half, l_r=half, C_f=1e6, C_r=1e6, length=2.0 * half,
        width=float(vehicle.WIDTH), delta_max=_MAX_STEERING, delta_rate_max=100.0, steering_lag=0.0,
    )  # fmt: skip


def _motion(thing: Any) -> tuple[float, float, float, float, float, float, float]:
    """Return position, heading, speed, sideslip, yaw rate and acceleration in the axes of the library."""
    action = getattr(thing, "action", None) or {}
    # its slip angle and yaw rate are those of highway-env's vehicle (Polack et al. 2017)
    slip = math.atan(0.5 * math.tan(float(action.get("steering", 0.0))))
    v = float(thing.speed)
    rate = v * math.sin(slip) / (0.5 * float(thing.LENGTH))
    x, y, psi = flip_axes(float(thing.position[0]), float(thing.position[1]), float(thing.heading))
    return x, y, psi, v, -slip, -rate, float(action.get("acceleration", 0.0))

"""Logical scenarios: ranges of parameters around the paper's scenarios, and samples of them."""

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from cca_core._checks import check_array, check_real, shown
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.sim.scenarios.road_user import (
    LateralShiftAction,
    ReactToLeadAction,
    RoadUser,
    RoadUserAction,
    SpeedAction,
)
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.study.sampling import SAMPLERS, STUDY_SCENARIOS, Sample, ScenarioMaker
from cca_core.sim.study.source import check_definition
from cca_core.v2x import ChannelSettings, SenderSettings
from cca_core.vehicle import GRAVITY, VehicleParams


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterRanges:
    """Bounds of uniformly sampled parameters; equal bounds fix a value.

    Parameters
    ----------
    scenario : str or callable
        ``"eebl"``, ``"ima"``, ``"curbside"`` or ``"maneuver"``, with further parameters of its own (Notes);
        or a function at the top level of a module that makes a `Scenario` with messages from a `Sample`, or
        an instance of a dataclass there, with a field `name`, that is called like one. Channel, friction,
        mass, seed and the reaction time of the ego's driver are then set as sampled.
    friction : tuple of float
        Friction of the road under all vehicles [-], known to the planner; 0.3 to 1.2.
    mass : tuple of float
        True mass and yaw inertia of the ego, divided by those that the planner assumes [-]; 0.5 to 2.
    latency : tuple of float
        Minimum time from a message's measurement to its arrival [s]; 0 to 5.
    jitter : tuple of float
        Mean of the exponentially distributed time on top of that [s]; 0 to 1.
    loss : tuple of float
        Loss probability [-], 0 to 0.9; the mean burst length is 1 / (1 - loss) to 10 messages.
    radio_range : tuple of float, optional
        Radio range [m], 1 to 10 000; the default is 50 to 400 m, in maneuver 300 to 1000 m.
    position_noise : tuple of float
        Standard deviation of each sender's position in x and y [m], correlated over 30 s; 0 to 10.
    reaction_time : tuple of float
        Reaction time of each driver [s]; 0 to 1.6.

    Raises
    ------
    InputError
        If the scenario is unknown, or bounds are out of range or in the wrong order.

    Notes
    -----
    - eebl: speed 15 to 33 m/s, gaps 0.4 to 1.2 s and 1.7 to 2.5 s, deceleration of the first car 4 to
      7 m/s^2, at most what the friction allows; the second car is connected in half of the runs.
    - ima: turn or crossing, speeds 4.5 to 7 or 8 to 14 m/s and 10 to 22 m/s, arrivals -1 to 1 s apart, truck
      7 to 10 m long.
    - curbside: speed 10 to 34 m/s, lane intrusion 1.2 to 2.2 m, radius 1000 to 5000 m.
    - maneuver: cases 1-smooth, 1-fast, 2 and 3, speed 18 to 26 m/s, slow cars at 50 to 75 % of it, the others
      within 60 m of their positions in the paper's timing; the road is straight or has a radius of at least
      1000 m.
    """

    scenario: str | ScenarioMaker
    friction: tuple[float, float] = (0.6, 1.0)
    mass: tuple[float, float] = (0.95, 1.35)
    latency: tuple[float, float] = (0.0, 0.5)
    jitter: tuple[float, float] = (0.0, 0.03)
    loss: tuple[float, float] = (0.0, 0.8)
    radio_range: tuple[float, float] | None = None
    position_noise: tuple[float, float] = (0.0, 0.5)
    reaction_time: tuple[float, float] = (0.7, 1.5)

    __repr__ = short_repr

    def __post_init__(self) -> None:
        if not isinstance(self.scenario, str):
            check_definition("scenario", self.scenario)
        elif self.scenario not in STUDY_SCENARIOS:
            raise InputError(f"scenario must be one of {', '.join(STUDY_SCENARIOS)}, was {self.scenario!r}")
        for field in fields(self)[1:]:
            lower, upper = _LIMITS[field.name]
            bounds = self.radio_range_bounds if field.name == "radio_range" else getattr(self, field.name)
            low, high = check_array(field.name, bounds, (2,)).tolist()
            if not lower <= low <= high <= upper:
                raise InputError(
                    f"{field.name} must be two numbers from {lower:g} to {upper:g} in increasing order, "
                    f"was ({low:g}, {high:g})"
                )

    @property
    def name(self) -> str:
        """Name of the scenario, or of the function that makes it."""
        given: Any = self.scenario
        if isinstance(given, str):
            return given
        return str(getattr(given, "__name__", "") or given.name)

    @property
    def radio_range_bounds(self) -> tuple[float, float]:
        """Bounds of the radio range [m], with the default of the scenario."""
        open_road = self.scenario == "maneuver"
        return self.radio_range or ((300.0, 1000.0) if open_road else (50.0, 400.0))


_LIMITS = {
    "friction": (0.3, 1.2), "mass": (0.5, 2.0), "latency": (0.0, 5.0), "jitter": (0.0, 1.0),
    "loss": (0.0, 0.9), "radio_range": (1.0, 1e4), "reaction_time": (0.0, 1.6), "position_noise": (0.0, 10.0),
}  # fmt: skip


def sample_scenario(
    parameters: ParameterRanges, seed: int, index: int
) -> tuple[Scenario, VehicleParams, dict[str, float | int | str]]:
    """Sample run `index` of a study: its scenario, the ego that the planner assumes, all samples by name."""
    if seed < 0 or index < 0:
        raise InputError(f"seed and index must be at least 0, were {seed} and {index}")
    # a run depends on the seed and its number alone
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    samples: dict[str, float | int | str] = {"index": index}

    def uniform(name: str, low: float, high: float) -> float:
        low, high = check_real("low", low), check_real("high", high)
        if name in samples:
            raise InputError(f"name must be new, was {name!r}")
        samples[name] = value = float(low + (high - low) * rng.random())
        return value

    # the order of these lines is part of what a seed means
    samples["seed"] = int(rng.integers(2**31))
    friction = uniform("friction", *parameters.friction)
    mass = uniform("mass", *parameters.mass)
    latency, jitter = uniform("latency", *parameters.latency), uniform("jitter", *parameters.jitter)
    loss = uniform("loss", *parameters.loss)
    channel = ChannelSettings(
        latency=latency, jitter=jitter, loss_probability=loss,
        mean_burst_length=uniform("mean_burst_length", 1.0 / (1.0 - loss), 10.0),
        range=uniform("radio_range", *parameters.radio_range_bounds),
    )  # fmt: skip
    reaction_time = uniform("reaction_time", *parameters.reaction_time)
    ego_reaction_time = uniform("ego_reaction_time", *parameters.reaction_time)
    noise = uniform("position_noise", *parameters.position_noise)
    sample = Sample(uniform=uniform, case=int(rng.integers(4)), channel=channel, reaction_time=reaction_time)
    given = parameters.scenario
    scenario: object = (SAMPLERS[given] if isinstance(given, str) else given)(sample)
    if not isinstance(scenario, Scenario) or not scenario.v2v:
        raise InputError(f"scenario must return a Scenario of ego type v2v, returned {shown(scenario)}")
    samples["case"] = str(scenario.case)
    nominal = replace(scenario.vehicle, mu=friction)
    return replace(
        scenario, vehicle=replace(nominal, m=mass * nominal.m, I_z=mass * nominal.I_z),
        reaction_time=ego_reaction_time, seed=int(samples["seed"]), channel=channel,
        sender=SenderSettings(position_noise=noise, noise_time_constant=30.0),
        road_users=tuple(_limit_to_friction(user, friction) for user in scenario.road_users),
    ), nominal, samples  # fmt: skip


def without_v2v(scenario: Scenario, ego_type: str) -> Scenario:
    """Return a scenario for an ego without messages, in which no road user receives warnings."""

    def unwarned(action: RoadUserAction) -> RoadUserAction:
        return replace(action, warning_delay=math.inf) if isinstance(action, ReactToLeadAction) else action

    users = tuple(replace(user, actions=tuple(map(unwarned, user.actions))) for user in scenario.road_users)
    return replace(scenario, ego_type=ego_type, road_users=users)


def _limit_to_friction(user: RoadUser, friction: float) -> RoadUser:
    """Limit all decelerations of a road user to what the friction allows."""
    limit = friction * GRAVITY

    def limited(action: RoadUserAction) -> RoadUserAction:
        if isinstance(action, LateralShiftAction):
            return action
        if isinstance(action, SpeedAction):
            return replace(action, acceleration=min(action.acceleration, limit))
        return replace(action, deceleration=min(action.deceleration, limit))

    actions = tuple(map(limited, user.actions))
    return replace(user, actions=actions, deceleration=min(user.deceleration, limit))

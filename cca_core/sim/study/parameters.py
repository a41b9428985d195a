"""Scenarios drawn by chance around the paper's: one seed and one number give one scenario."""

import math
from dataclasses import dataclass, fields, replace

import numpy as np

from cca_core._checks import check_array
from cca_core.errors import InputError
from cca_core.sim.scenarios.road_user import BrakeAction, ReactToLeadAction, RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.study.sampling import SAMPLERS, STUDY_SCENARIOS
from cca_core.v2x import ChannelSettings, SenderSettings
from cca_core.vehicle import GRAVITY, VehicleParams

__all__ = ["ParameterRanges", "nominal_scenario", "sample_scenario", "without_v2v"]

_MESSAGES = 10.0  # longest mean burst of loss [-]
_NOISE_TIME = 30.0  # [s]
_REACH, _FAR_REACH = (50.0, 400.0), (300.0, 1000.0)  # among houses and cars; on an open road [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterRanges:
    """What is drawn, each evenly between two bounds; equal bounds hold a value.

    Parameters
    ----------
    scenario : {"eebl", "ima", "curbside", "maneuver"}
        Which one; `sample_scenario` tells what else of it is drawn.
    friction : tuple of float
        Friction of the road under everybody [-]. The planner knows it.
    mass : tuple of float
        The ego's mass and yaw inertia, as a share of what the planner takes them to be [-].
    latency : tuple of float
        From a message's measurement to its arrival [s], at least.
    jitter : tuple of float
        Mean of what is added to that [s], exponentially distributed.
    loss : tuple of float
        Share of messages lost [-], in bursts of 1 / (1 - loss) to 10 messages in the mean.
    radio_range : tuple of float, optional
        Distance beyond which nobody is heard [m]; the default is 50 to 400 m, in maneuver 300 to 1000 m.
    position_noise : tuple of float
        Standard deviation of each sender's position in x and y [m], which forgets itself in 30 s.
    reaction_time : tuple of float
        Reaction time of each driver [s].

    Raises
    ------
    InputError
        If the scenario is unknown, or bounds are out of range or in the wrong order.
    """

    scenario: str
    friction: tuple[float, float] = (0.6, 1.0)
    mass: tuple[float, float] = (0.95, 1.35)
    latency: tuple[float, float] = (0.0, 0.5)
    jitter: tuple[float, float] = (0.0, 0.03)
    loss: tuple[float, float] = (0.0, 0.8)
    radio_range: tuple[float, float] | None = None
    position_noise: tuple[float, float] = (0.0, 0.5)
    reaction_time: tuple[float, float] = (0.7, 1.5)

    def __post_init__(self) -> None:
        if self.scenario not in STUDY_SCENARIOS:
            raise InputError(f"scenario must be one of {', '.join(STUDY_SCENARIOS)}, was {self.scenario!r}")
        for field in fields(self)[1:]:
            least, most = _RANGES[field.name]
            bounds = self.radio_range_bounds if field.name == "radio_range" else getattr(self, field.name)
            low, high = check_array(field.name, bounds, (2,)).tolist()
            if not least <= low <= high <= most:
                raise InputError(
                    f"{field.name} must be two numbers from {least:g} to {most:g}, the lesser first, "
                    f"was ({low:g}, {high:g})"
                )

    @property
    def radio_range_bounds(self) -> tuple[float, float]:
        """Bounds of the reach [m], the given or the default ones."""
        return self.radio_range or (_FAR_REACH if self.scenario == "maneuver" else _REACH)


_RANGES = {
    "friction": (0.3, 1.2), "mass": (0.5, 2.0), "latency": (0.0, 5.0), "jitter": (0.0, 1.0),
    "loss": (0.0, 0.9), "radio_range": (1.0, 1e4), "reaction_time": (0.0, 1.6), "position_noise": (0.0, 10.0),
}  # fmt: skip


def sample_scenario(
    variation: ParameterRanges, seed: int, index: int
) -> tuple[Scenario, dict[str, float | int | str]]:
    """Draw one scenario, with messages.

    Parameters
    ----------
    variation : Variation
        What is drawn.
    seed, index : int
        The study's seed, and the number of the run in it, from 0. A run depends on nothing else: neither on
        the other runs nor on where and in which order they are driven.

    Returns
    -------
    scenario : Scenario
        The ego is what it is; its planner takes it to be `nominal`.
    drawn : dict
        Every drawn value by name, in SI units.

    Raises
    ------
    InputError
        If `seed` or `index` is negative.

    Notes
    -----
    eebl: speed 15 to 33 m/s, gaps 0.4 to 1.2 s and 1.7 to 2.5 s, the first car brakes with 4 to 7 m/s^2 (no
    more than the road gives), the second is connected or not, by halves. ima: turn or crossing, speeds of
    4.5 to 7 or 8 to 14 m/s and 10 to 22 m/s, arrival -1 to 1 s apart, truck 7 to 10 m. curbside: speed 10 to
    34 m/s, 1.2 to 2.2 m of the lane occupied, radius 1000 to 5000 m. maneuver: cases 1-smooth, 1-fast, 2 and
    3, speed 18 to 26 m/s, the slow cars at 50 to 75 % of it, the others within 60 m of where the paper's
    timing has them; road straight or bent with 1000 m or more.
    """
    if seed < 0 or index < 0:
        raise InputError(f"seed and index must be at least 0, were {seed} and {index}")
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    drawn: dict[str, float | int | str] = {"index": index}

    def number(name: str, low: float, high: float) -> float:
        drawn[name] = value = float(low + (high - low) * rng.random())
        return value

    drawn["seed"] = int(rng.integers(2**31))
    friction = number("friction", *variation.friction)
    mass = number("mass", *variation.mass)
    latency, jitter = number("latency", *variation.latency), number("jitter", *variation.jitter)
    loss = number("loss", *variation.loss)
    burst = number("burst", 1.0 / (1.0 - loss), _MESSAGES)
    channel = ChannelSettings(
        latency=latency,
        jitter=jitter,
        loss_probability=loss,
        mean_burst_length=burst,
        range=number("radio_range", *variation.radio_range_bounds),
    )
    others, own = (
        number("reaction_time", *variation.reaction_time),
        number("own_reaction_time", *variation.reaction_time),
    )
    sender = SenderSettings(
        position_noise=number("position_noise", *variation.position_noise), noise_time_constant=_NOISE_TIME
    )
    case = int(rng.integers(4))
    scenario = SAMPLERS[variation.scenario](case, number, channel, others)
    drawn["case"] = str(scenario.case)
    car = scenario.vehicle
    car = replace(car, m=mass * car.m, I_z=mass * car.I_z, mu=friction)
    scenario = replace(
        scenario, vehicle=car, reaction_time=own, seed=int(drawn["seed"]), channel=channel, sender=sender,
        road_users=tuple(_limit_to_friction(user, friction) for user in scenario.road_users),
    )  # fmt: skip
    return scenario, drawn


def nominal_scenario(scenario: Scenario) -> Scenario:
    """Scenario as the planner takes it to be: the car weighs what is written, the friction is known.

    Parameters
    ----------
    scenario : Scenario
        A drawn one.

    Returns
    -------
    scenario : Scenario
        The same with the nominal mass and yaw inertia.
    """
    car = VehicleParams.bmw_320i()
    return replace(scenario, vehicle=replace(scenario.vehicle, m=car.m, I_z=car.I_z))


def without_v2v(scenario: Scenario, ego: str) -> Scenario:
    """Let nobody send.

    Parameters
    ----------
    scenario : Scenario
        One with messages.
    ego : {"driver", "sensor"}
        Who drives the ego instead.

    Returns
    -------
    scenario : Scenario
        The same without messages; who was warned by them reacts to what he sees.
    """
    users = tuple(
        replace(
            user,
            actions=tuple(
                replace(act, warning_delay=math.inf) if isinstance(act, ReactToLeadAction) else act
                for act in user.actions
            ),
        )
        for user in scenario.road_users
    )
    return replace(scenario, ego_type=ego, road_users=users)


def _limit_to_friction(user: RoadUser, friction: float) -> RoadUser:
    """Let nobody mean to brake harder than the road gives."""
    most = friction * GRAVITY
    acts = tuple(
        replace(act, deceleration=min(act.deceleration, most))
        if isinstance(act, BrakeAction | ReactToLeadAction)
        else act
        for act in user.actions
    )
    return replace(user, actions=acts, deceleration=min(user.deceleration, most))

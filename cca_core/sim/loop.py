"""Closed loop of controller, plant, road users, messages and sensor."""

import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Protocol

import numpy as np

from cca_core._checks import check_bool
from cca_core.follow import steady_turn
from cca_core.planner.command import Command
from cca_core.planner.planner import Planner
from cca_core.real_time import RealTimeLoop, RealTimeSettings, real_time_process
from cca_core.sim.human_driver import Driver
from cca_core.sim.log import Log
from cca_core.sim.log_builder import LogBuilder, bodies_of, find_collision
from cca_core.sim.overlaps import warn_of_overlaps
from cca_core.sim.plants.build import PlantMaker, plant_name, start_plant
from cca_core.sim.plants.plant import Plant
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.perception import Perception
from cca_core.sim.world.radio import Radio
from cca_core.sim.world.tailgating import LeadMotion, Tailgating
from cca_core.sim.world.traffic import CYCLE_TIME, Traffic
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["CYCLE_TIME", "EgoController", "make_controller", "make_driver", "make_planner", "simulate"]


class EgoController(Protocol):
    """Controller of the ego: a `Planner`, a `Driver`, or any object with this method."""

    def step(
        self, t: float, state: VehicleState, remotes: Iterable[RemoteVehicle], *, awareness_range: float = ...
    ) -> Command:
        """Return the command of one cycle, as `Planner.step` does."""


def simulate(
    scenario: Scenario,
    *,
    plant: str | Plant | PlantMaker = "single_track",
    seed: int | None = None,
    planner: EgoController | None = None,
    progress: Callable[[float], None] | None = None,
    bsm_log: Iterable[tuple[float, bytes]] = (),
    real_time: bool = False,
) -> Log:
    """Drive a scenario to its end or to the first collision.

    Parameters
    ----------
    scenario : Scenario
        Road, ego and road users.
    plant : str, Plant or callable
        The ego's plant: ``"single_track"``, ``"multi_body"``, or any object with `state`, `step` and `a_y` as
        `SingleTrackPlant` has them, at the scenario's start. A class or function is called with the ego's
        `VehicleParams` and its `VehicleState` at the start, and returns such an object.
    seed : int, optional
        Seed of the senders' phases and of the radio channel; the default is the scenario's.
    planner : EgoController, optional
        Controller of the ego, such as a `Planner`, a `Driver` or an `MpcPlanner`. The default is made from
        the scenario.
    progress : callable, optional
        Called with the simulated time [s] after each cycle.
    bsm_log : iterable of (float, bytes)
        Messages of further senders with the time of arrival at the ego [s], in order of time, such as a
        recorded log. An ego without V2V ignores them.
    real_time : bool
        Whether to run against the wall clock, one cycle every 20 ms (`RealTimeLoop`). A cycle that ends late
        is counted in `Log.missed_deadlines` and delays the rest; nothing else in the log depends on it.

    Returns
    -------
    log : Log
        Every cycle. Equal seeds give equal logs, bit for bit, but for the wall-clock times.

    Raises
    ------
    InputError
        If the plant is unknown, lacks a member or is not at the scenario's start, or `real_time` is no bool.
    MissingExtraError
        If the plant's package is not installed.

    Warns
    -----
    UserWarning
        If road users drive into each other (`Log.overlaps`): they do not collide.
    """
    log = run_loop(
        scenario, plant=plant, seed=seed, planner=planner, progress=progress, bsm_log=bsm_log,
        real_time=real_time,
    )  # fmt: skip
    warn_of_overlaps(log.overlaps)
    return log


def run_loop(
    scenario: Scenario,
    *,
    plant: str | Plant | PlantMaker = "single_track",
    seed: int | None = None,
    planner: EgoController | None = None,
    progress: Callable[[float], None] | None = None,
    bsm_log: Iterable[tuple[float, bytes]] = (),
    real_time: bool = False,
) -> Log:
    """Do what `simulate` does, without its warning: a study counts the runs that it would warn of."""
    check_bool("real_time", real_time)
    seed = scenario.seed if seed is None else seed
    controller = planner or make_controller(scenario)
    path = scenario.road.path
    start = steady_turn(path, scenario.start, scenario.v_x, scenario.vehicle)
    car = start_plant(plant, scenario.vehicle, start, scenario.evasion.decision.max_route_distance)
    traffic, perception = Traffic(scenario), Perception(scenario)
    radio, recorded = Radio(scenario, np.random.default_rng(seed)), deque(bsm_log)
    tailgating = None if scenario.fixed_gap is None else Tailgating(scenario, scenario.fixed_gap)
    log = LogBuilder(scenario, plant_name(plant), seed)
    s, visible = scenario.start, [False] * len(traffic.agents)
    pace = RealTimeLoop(CYCLE_TIME, clock=time.perf_counter, sleep=time.sleep)
    begin = time.perf_counter()
    with real_time_process(RealTimeSettings(freeze_gc=real_time)):
        for k in range(log.max_cycles):
            t, state, rows = k * CYCLE_TIME, car.state, traffic.rows()
            s, d, _, _ = path.foot_point(state.x, state.y, s)
            if perception.needs_every_cycle or k % 5 == 0:  # 10 Hz suffices where messages come first
                visible = perception.visible(rows, state)
            messages: list[bytes] = []
            if scenario.v2v or radio.is_needed:
                messages = radio.exchange(t, traffic, state, ego_sends=scenario.v2v)
            while recorded and recorded[0][0] <= t + 1e-9:
                messages.append(recorded.popleft()[1])
            remotes = perception.remotes(t, rows, visible, messages, state)
            tick = time.perf_counter()
            command = controller.step(t, state, remotes, awareness_range=perception.awareness_range(t))
            cycle_us = 1e6 * (time.perf_counter() - tick)
            a_x, gap_held = command.a_x, False
            if tailgating is not None and scenario.fixed_gap is not None:
                agent = traffic.by_id[scenario.fixed_gap.lead_id]
                lead = LeadMotion(agent.s - 0.5 * agent.user.length, agent.v, agent.a)
                a_x = tailgating.acceleration(remotes, command, s, state.v_x, lead)
                gap_held = not tailgating.released
            collided_with = find_collision(scenario.vehicle, state, bodies_of(scenario, rows))
            log.write(
                t, state, car.a_y, (s, d), command, traffic, remotes, visible,
                messages if scenario.v2v else (),
                collided_with=collided_with, gap_held=gap_held, cycle_us=cycle_us,
            )  # fmt: skip
            if progress is not None:
                progress(t)
            if real_time:
                pace.wait()
            if collided_with:
                break
            car.step(command.delta, a_x, CYCLE_TIME)
            traffic.step(t, state)
    return log.finish(radio.counts, wall_s=time.perf_counter() - begin, missed_deadlines=pace.missed)


def make_controller(scenario: Scenario) -> EgoController:
    """Make the controller that a scenario's ego type names."""
    return make_driver(scenario) if scenario.ego_type == "driver" else make_planner(scenario)


def make_planner(scenario: Scenario) -> Planner:
    """Make the planner that a scenario asks for.

    Parameters
    ----------
    scenario : Scenario
        Vehicle, road, speeds and settings. Without V2V the awareness range is 0: no adjacent lane is known
        to be free.

    Returns
    -------
    planner : Planner
        A fresh planner.
    """
    evasion = scenario.evasion if scenario.v2v else replace(scenario.evasion, awareness_range=0.0)
    return Planner(
        scenario.vehicle, scenario.road, cruise_speed=scenario.cruise_speed, evasion=evasion,
        speed=scenario.speed,
    )  # fmt: skip


def make_driver(scenario: Scenario) -> Driver:
    """Make the human driver that a scenario asks for.

    Parameters
    ----------
    scenario : Scenario
        Vehicle, road, speeds and reaction time.

    Returns
    -------
    driver : Driver
        A fresh driver.
    """
    return Driver(
        scenario.vehicle, scenario.road, cruise_speed=scenario.cruise_speed, speed=scenario.speed,
        reaction_time=scenario.reaction_time,
    )  # fmt: skip

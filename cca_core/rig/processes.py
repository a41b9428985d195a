"""Processes of plant and vehicle: their loops on real interfaces."""

from collections import Counter
from collections.abc import Callable
from functools import cache

from cca_core.errors import InputError
from cca_core.real_time import RealTimeLoop, RealTimeSettings, real_time_process
from cca_core.rig.bus import BusLink
from cca_core.rig.clocks import ClockMap, RigClock
from cca_core.rig.control import ControlPort
from cca_core.rig.kit import KitSettings
from cca_core.rig.messages import Codec
from cca_core.rig.plant import PlantNode
from cca_core.rig.records import ProcessRecord
from cca_core.rig.settings import RigSettings, VehicleSettings
from cca_core.rig.telemetry import encode_telemetry
from cca_core.rig.udp import UdpLink
from cca_core.rig.vehicle import VehicleNode
from cca_core.sim.scenarios.paper import paper_scenarios
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.traffic import CYCLE_TIME

PAUSE = 0.1
"""Time since the last pass of a loop from which on frames that have queued up are not fresh [s]."""


def scenario_id(scenario: Scenario) -> str:
    """Name of a scenario on the command line.

    Parameters
    ----------
    scenario : Scenario
        Any scenario.

    Returns
    -------
    name : str
        Such as ``"maneuver/2/v2v"``.
    """
    return "/".join(filter(None, (scenario.name, scenario.case, scenario.ego_type)))


def find_scenario(name: str) -> Scenario:
    """Find one of the paper's scenarios.

    Parameters
    ----------
    name : str
        Name as `scenario_id` returns it.

    Returns
    -------
    scenario : Scenario
        One of `cca_core.sim.paper_scenarios`.

    Raises
    ------
    InputError
        If there is none of this name.
    """
    known = _paper_scenarios()
    if name not in known:
        raise InputError(f"scenario must be one of {', '.join(known)}, was {name!r}")
    return known[name]


@cache
def _paper_scenarios() -> dict[str, Scenario]:
    """All of the paper's scenarios by name; a second is needed to make them."""
    return {scenario_id(each): each for each in paper_scenarios()}


def run_plant(
    scenario: Scenario,
    settings: RigSettings,
    clock: RigClock,
    *,
    plant: str = "single_track",
    seed: int | None = None,
    real_time: RealTimeSettings | None = None,
    start_within: float = 30.0,
    is_stopped: Callable[[], bool] = lambda: False,
    records: bool = True,
) -> ProcessRecord:
    """Run the plant computer to the end of a scenario.

    Parameters
    ----------
    scenario : Scenario
        Road, ego and road users.
    settings : RigSettings
        Interfaces.
    clock : RigClock
        Time.
    plant : {"single_track", "multi_body"}
        The ego's plant.
    seed : int, optional
        Seed of the run; the default is the scenario's.
    real_time : RealTimeSettings, optional
        What to ask of the operating system.
    start_within : float
        Time within which the vehicle has to enable the kit [s].
    is_stopped : callable
        Whether to end now.
    records : bool
        Whether every row is kept.

    Returns
    -------
    record : ProcessRecord
        Every cycle; no rows if the kit was not enabled.

    Raises
    ------
    InputError
        If an interface cannot be opened.
    """
    car = scenario.vehicle
    bus = BusLink(settings.bus)
    radio = UdpLink(settings.radio_to_plant, [settings.radio_to_vehicle])
    sensor, control = UdpLink(None, [settings.sensor_address]), ControlPort(settings.plant_control)
    node = PlantNode(
        scenario, bus, radio, sensor, Codec(settings.steering), plant=plant, seed=seed,
        wrapper=settings.radio_wrapper, records=records,
        kit=KitSettings(delta_max=car.delta_max, delta_rate_max=car.delta_rate_max),
    )  # fmt: skip
    clocks = ClockMap(clock.now(), clock.utc())
    with real_time_process(real_time) as refused:
        loop = RealTimeLoop(CYCLE_TIME, clock=clock.now, sleep=clock.sleep)
        begin, steps = clock.now(), 1
        while not (is_stopped() or node.is_over):
            t = clock.now()
            if not node.is_running and t - begin > start_within:
                break
            control.poll(t)
            node.cycle(t, lambda: clocks.utc(clock.now()), steps=steps, driver_override=control.has_driver)
            steps = 1 + loop.wait()
    for link in (bus, radio, sensor, control):
        link.close()
    counts = {
        "bus": dict(bus.counts), "commands": dict(node.receiver.counts),
        "kit": dict(Counter(row.kit.name for row in node.rows)),
    }  # fmt: skip
    return ProcessRecord(
        rows=node.rows, loop=loop.summary(), refused=refused, messages=dict(node.messages), counts=counts
    )


def run_vehicle(
    scenario: Scenario,
    settings: RigSettings,
    clock: RigClock,
    *,
    real_time: RealTimeSettings | None = None,
    vehicle: VehicleSettings | None = None,
    is_stopped: Callable[[], bool] = lambda: False,
    records: bool = True,
) -> ProcessRecord:
    """Run the vehicle computer until it is stopped.

    Parameters
    ----------
    scenario : Scenario
        Road, vehicle and settings.
    settings : RigSettings
        Interfaces.
    clock : RigClock
        Time.
    real_time : RealTimeSettings, optional
        What to ask of the operating system.
    vehicle : VehicleSettings, optional
        Cycle of the vehicle computer.
    is_stopped : callable
        Whether to end now.
    records : bool
        Whether every row is kept.

    Returns
    -------
    record : ProcessRecord
        Every command.

    Raises
    ------
    InputError
        If an interface cannot be opened.
    """
    bus = BusLink(settings.bus)
    radio = UdpLink(settings.radio_to_vehicle, [settings.radio_to_plant])
    sensor, telemetry = UdpLink(settings.sensor_address), UdpLink(None, [settings.telemetry_address])
    control, clocks = ControlPort(settings.vehicle_control), ClockMap(clock.now(), clock.utc())
    node = VehicleNode(
        scenario, bus, radio, sensor, Codec(settings.steering), clocks, wrapper=settings.radio_wrapper,
        settings=vehicle, records=records,
    )  # fmt: skip
    counts: Counter[str] = Counter()
    with real_time_process(real_time) as refused:
        loop = RealTimeLoop(CYCLE_TIME, clock=clock.now, sleep=lambda _: None)
        last = t_reported = clock.now()
        while not is_stopped():
            frame = bus.receive(CYCLE_TIME / clock.rate)
            t = clock.now()
            if t - last > PAUSE:
                counts["pauses"] += 1
                for queue in (bus, radio, sensor):
                    queue.drain()
                last = clock.now()
                continue
            last = t
            is_complete = frame is not None and node.take([frame], t)
            if is_complete:
                node.take(bus.drain(200), t)  # the newest state counts
                loop.restart()
                node.answer(t, lambda: clocks.utc(clock.now()))
                loop.wait()
            else:
                node.watch(t)
            if t - t_reported >= 0.1:
                t_reported = t
                control.poll(t)
                now = clock.now()  # the work of this cycle took time
                clocks.compare(now, clock.utc() + control.utc_error(now))
                telemetry.send(encode_telemetry(node, t, loop))
    for link in (bus, radio, sensor, telemetry, control):
        link.close()
    counts.update(node.counts)
    counts["clock_steps"] = clocks.steps
    return ProcessRecord(
        rows=node.rows, loop=loop.summary(), refused=refused,
        messages={"ego_sent": node.counts["ego_sent"]},
        counts={"bus": dict(bus.counts), "state": dict(node.receiver.counts), "vehicle": dict(counts)},
    )  # fmt: skip

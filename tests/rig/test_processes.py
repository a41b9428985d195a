"""Real processes on the bus in software: vehicle killed, stopped, restarted; driver; system clock.

Judged by counts and stations, never by latency. All run in slow motion, so that a busy machine is fast
enough.
"""

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cca_core.rig import KitState, RigOptions, find_scenario, read_bus_log, run_scenario
from cca_core.sim import Scenario, simulate
from tests.support.rig_processes import (
    RIG_MARKS,
    Rig,
    assert_at_rest_in_lanes,
    assert_kit_acts_in_time,
    corners,
    is_driving,
)

pytestmark = RIG_MARKS
EEBL, MANEUVER = find_scenario("eebl/C/v2v"), find_scenario("maneuver/2/v2v")


def test_killed_vehicle_process_stops_in_lane(start: Callable[[Scenario], Rig]) -> None:
    rig = start(EEBL)
    rig.until(is_driving)
    rig.vehicle.send_signal(signal.SIGKILL)
    rig.until(lambda r: r.kit is KitState.SAFE_STOP)
    rig.until(lambda r: r.v < 0.05)
    record = rig.finish()
    assert_at_rest_in_lanes(rig, record)
    assert_kit_acts_in_time(record)
    kits = [row.kit for row in record.rows]  # type: ignore[union-attr]
    assert set(kits[kits.index(KitState.SAFE_STOP) :]) == {KitState.SAFE_STOP}


@pytest.mark.slow
def test_driver_override_ends_control(start: Callable[[Scenario], Rig]) -> None:
    """The wheels stay and the car coasts; control does not come back by itself."""
    rig = start(EEBL)
    rig.until(is_driving)
    rig.control(rig.settings.plant_control, "driver", "on")
    rig.until(lambda r: r.kit is KitState.OVERRIDE)
    rig.control(rig.settings.plant_control, "driver", "off")
    rig.count(100)
    rows: Any = rig.finish().rows
    kits = [row.kit for row in rows]
    first = kits.index(KitState.OVERRIDE)
    assert set(kits[first:]) == {KitState.OVERRIDE}
    assert len(kits) - first > 90
    assert {row.actuation[1] for row in rows[first:]} == {0.0}
    assert rows[-1].state.v_x > 10.0


@pytest.mark.slow
def test_steps_and_drift_of_clock_change_nothing(start: Callable[[Scenario], Rig]) -> None:
    """The vehicle's system clock steps by 5 s, then by -10 s, and drifts: messages are used all the time."""
    rig = start(EEBL)
    rig.until(is_driving)
    for words in (("utc", "5.0"), ("utc", "-5.0"), ("drift", "0.002")):
        rig.control(rig.settings.vehicle_control, *words)
        rig.count(40)
    rig.until(lambda r: r.v < 0.05)
    record, vehicle = rig.finish(), rig.finish("vehicle")
    assert_at_rest_in_lanes(rig, record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]
    assert vehicle.counts["vehicle"]["clock_steps"] >= 2
    known: Any = [{remote.source for remote in row.remotes} for row in vehicle.rows]  # type: ignore[union-attr]
    begin = next(i for i, sources in enumerate(known) if sources)
    assert sum("v2v" in sources for sources in known[begin:]) > 0.9 * len(known[begin:]) > 100


@pytest.mark.slow
def test_run_through_processes_equals_simulation(tmp_path: Path) -> None:
    for rate in (0.25, 0.1):
        file = tmp_path / f"bus_{rate}.blf"
        run = run_scenario(EEBL, RigOptions(number=39, rate=rate), bus_log=file)
        rows: Any = run.plant.rows
        if all(row.kit is KitState.ENABLED for row in rows):
            break
    else:
        pytest.skip("the machine interrupted the processes")
    simulated = simulate(EEBL)
    assert run.log.collided_with == ""
    assert run.log.gaps().min() == pytest.approx(simulated.gaps().min(), abs=0.3)
    assert run.log.actions[:2] == simulated.actions[:2]
    frames = list(read_bus_log(file))
    n = sum(frame.id == 0x203 for frame in frames)
    assert n >= 0.99 * len(run.log.t)
    assert sum(frame.id == 0x100 for frame in frames) >= 0.99 * len(run.vehicle.rows)


@pytest.mark.slow
def test_stopped_vehicle_process_is_cleared(start: Callable[[Scenario], Rig]) -> None:
    rig = start(MANEUVER)
    rig.until(lambda r: is_driving(r) and abs(r.d) > 1.0)
    rig.vehicle.send_signal(signal.SIGSTOP)
    rig.until(lambda r: r.kit is KitState.SAFE_STOP)
    rig.count(24)
    rig.vehicle.send_signal(signal.SIGCONT)
    rig.until(lambda r: r.kit is KitState.ENABLED)
    rig.until(lambda r: abs(r.d) < 0.3)
    record = rig.finish()
    assert_kit_acts_in_time(record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]


@pytest.mark.slow
def test_restarted_vehicle_process_takes_over(start: Callable[[Scenario], Rig]) -> None:
    rig = start(MANEUVER)
    rig.until(lambda r: is_driving(r) and abs(r.d) > 1.0)
    rig.vehicle.kill()
    rig.vehicle.wait()
    rig.vehicle = rig.start("vehicle")
    rig.until(lambda r: r.kit is KitState.SAFE_STOP)
    rig.until(lambda r: r.kit is KitState.ENABLED)
    rig.until(lambda r: r.v > 3.0 or abs(r.d) < 0.3)
    record = rig.finish()
    assert_kit_acts_in_time(record)
    assert all(row.collided_with == "" for row in record.rows)  # type: ignore[union-attr]
    assert abs(corners(rig, record)).max() < 5.3

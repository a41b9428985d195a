"""Reasons: they agree with the acceleration, name vehicles that are there, and show true figures."""

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cca_core import Lane, Planner, RemoteVehicle, Road, VehicleState, fit_path
from cca_core.planner import EvasionSettings
from cca_core.sim import Scenario, curbside, eebl, ima, make_planner, overtaking, simulate
from tests.support.crowds import CROWDS, drive
from tests.support.planner_drives import (
    ALL_KNOWN,
    CAR,
    CYCLE,
    TWO_LANES,
    ClosedLoop,
    CrossingVehicle,
    LaneLeavingVehicle,
    ScriptedVehicle,
    straight,
)
from tests.support.reason_checks import CheckedPlanner

ONE_LANE = (Lane(d=0.0),)
TURN = np.linspace(0.0, 1.5, 80)
BEND = np.vstack((
    np.column_stack((np.arange(0.0, 200.0, 5.0), np.zeros(40))),
    np.column_stack((200.0 + 40.0 * np.sin(TURN), 40.0 * (1.0 - np.cos(TURN)))),
))  # fmt: skip


class Reasons:
    """A drive on a straight road or another one, with its reasons, checked in every cycle."""

    def __init__(
        self, *traffic: ScriptedVehicle, road: Road | None = None, lanes: tuple[Lane, ...] = ONE_LANE,
        seconds: float = 12.0, evasion: EvasionSettings = ALL_KNOWN,
        event: Callable[[Planner, float], None] = lambda planner, t: None,
    ) -> None:  # fmt: skip
        planner = Planner(CAR, road or Road(straight(), lanes), cruise_speed=20.0, evasion=evasion)
        checked = CheckedPlanner(planner)

        def receive(t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
            event(planner, t)
            return remotes

        self.run = ClosedLoop(checked, traffic, seconds, receive=receive)  # type: ignore[arg-type]
        self.texts = checked.reasons
        assert checked.wrong == []

    def begin(self, words: str) -> int:
        """First cycle whose reason begins with words."""
        return next(k for k, text in enumerate(self.texts) if text.startswith(words))


def brakes(t: float) -> float:
    return -6.0 if 2.0 < t < 5.0 else 3.0 if 8.0 < t < 12.0 else 0.0


def test_end_of_route_is_named_until_standstill() -> None:
    drive = Reasons(road=Road(straight(200.0)), seconds=18.0)
    begin = drive.begin("stopping: the route ends in ")
    assert all(re.match(r"stopp(ing|ed): the route ends in \d+ m$", text) for text in drive.texts[begin:])
    assert drive.texts[-1] == "stopped: the route ends in 0 m"


def test_curve_is_named_with_its_distance() -> None:
    drive = Reasons(road=Road(fit_path(BEND, tolerance=0.05)), seconds=10.0)
    k = drive.begin("slowing to ")
    found = re.match(r"slowing to ([\d.]+) m/s: curve in (\d+) m$", drive.texts[k])
    assert found is not None
    assert float(found[2]) + drive.run.x[k] == pytest.approx(205.0, abs=10.0)
    assert float(found[1]) < 11.0


def test_speed_limit_and_cruise_speed_are_named() -> None:
    def slower(planner: Planner, t: float) -> None:
        if t > 1.0:
            planner.cruise_speed = 12.0

    cruise = Reasons(seconds=5.0, event=slower)
    assert "slowing to 12.0 m/s: cruise speed" in cruise.texts
    posted = Reasons(road=Road(straight(), speed_limits=[(0.0, 20.0), (200.0, 12.0)]), seconds=6.0)
    k = posted.begin("slowing to 1")
    found = re.match(r"slowing to 11.9 m/s: speed limit in (\d+) m$", posted.texts[k])
    assert found is not None
    assert float(found[1]) + posted.run.x[k] == pytest.approx(200.0, abs=1.0)


def slowing_reason(road: Road, s: float, v: float) -> str:
    """Reason of an ego that is too fast, after half a second."""
    planner, path = Planner(CAR, road, cruise_speed=40.0), road.path
    for k in range(25):
        ds = k * CYCLE * v
        (x, y), psi = path.position(s + ds), float(path.heading(s + ds))
        command = planner.step(k * CYCLE, VehicleState(x=float(x), y=float(y), psi=psi, v_x=v), [])
    return command.decision.reason


def test_limit_that_holds_already_is_here() -> None:
    assert slowing_reason(Road(straight()), 20.0, 40.0) == "slowing to 36.0 m/s: speed limit here"
    signs = Road(straight(), speed_limits=[(0.0, 25.0), (700.0, 15.0)])
    assert slowing_reason(signs, 20.0, 33.0) == "slowing to 25.0 m/s: speed limit here"
    assert re.match(r"slowing to 14.9 m/s: speed limit in \d+ m$", slowing_reason(signs, 570.0, 24.0))


def test_curve_that_the_ego_is_in_is_here() -> None:
    angle = np.linspace(0.0, 3.0, 300)
    arc = Road(fit_path(80.0 * np.column_stack((np.sin(angle), 1.0 - np.cos(angle))), tolerance=0.05))
    text = slowing_reason(arc, 60.0, 17.0)
    assert re.match(r"slowing to [\d.]+ m/s: curve here$", text), text


def test_figures_of_following_are_those_of_the_cycle() -> None:
    drive = Reasons(
        ScriptedVehicle("R1", 70.0, 0.0, 12.0), lanes=TWO_LANES, evasion=EvasionSettings(awareness_range=0.0)
    )
    form = re.compile(
        r"following R1: gap (\d+) m, wants (\d+) m(, closing at [\d.]+ m/s)?; not passing on the left: "
    )
    shown = [(k, form.match(text)) for k, text in enumerate(drive.texts)]
    followed = [(k, float(m[1]), float(m[2])) for k, m in shown if m is not None]
    assert len(followed) > 200
    for k, gap, wanted in followed:
        assert gap == pytest.approx(20.0 + 70.0 + 12.0 * 0.02 * k - drive.run.x[k] - 4.5, abs=1.3)
        assert wanted == pytest.approx(3.0 + 1.5 * drive.run.v[k], abs=0.6)


def test_braking_names_vehicle_force_and_distance() -> None:
    drive = Reasons(ScriptedVehicle("R1", 40.0, 0.0, 20.0, a=brakes))
    k = drive.begin("braking for R1")
    assert re.match(r"braking for R1: \d\.\d m/s², \d+ m ahead at [\d.]+ m/s", drive.texts[k])


def test_release_of_brakes_names_former_cause() -> None:
    drive = Reasons(LaneLeavingVehicle(60.0, 5.0, station=90.0, range=20.0, offset=-4.5), seconds=8.0)
    assert "releasing the brakes: Y no longer limits the speed" in drive.texts
    assert drive.begin("braking for Y") < drive.begin("releasing") < drive.begin("speeding up to 20.0 m/s")


def test_released_brakes_do_not_slow_the_ego() -> None:
    drive = Reasons(
        ScriptedVehicle("P", 100.0, 0.0, 0.0),
        ScriptedVehicle("R1", 140.0, 0.0, 12.0, a=lambda t: -3.0 if t > 5.0 else 0.0),
        lanes=TWO_LANES,
        seconds=10.0,
    )
    braking = [k for k, text in enumerate(drive.texts) if "braking" in text]
    released = [k for k, text in enumerate(drive.texts) if "releasing the brakes" in text]
    assert braking
    assert released
    assert all(drive.run.v[k + 25] > drive.run.v[k] - 0.7 for k in released)  # in half a second


def test_stop_behind_parked_car_gives_cause_of_not_passing() -> None:
    drive = Reasons(ScriptedVehicle("R1", 100.0, 0.0, 0.0), seconds=20.0)
    assert drive.texts[-1] == "stopped behind R1: gap 3 m; not passing on the left or right: no lane"


def test_crossing_vehicle_is_yielded_to_by_name() -> None:
    drive = Reasons(CrossingVehicle("R1", 80.0, -40.0, 10.0, psi=0.5 * math.pi), seconds=6.0)
    assert drive.begin("yielding to R1: it crosses the route") < drive.begin("releasing the brakes: R1")


def test_lane_change_names_vehicle_that_it_waits_for() -> None:
    def ask(planner: Planner, t: float) -> None:
        if t == 1.0:
            planner.request_lane(3.5)

    drive = Reasons(ScriptedVehicle("R2", 0.0, 3.5, 20.0), lanes=TWO_LANES, seconds=16.0, event=ask)
    assert drive.begin("waiting for the left lane: R2 ") < drive.begin("changing to the left lane: ")


def check_crowd(name: str, cycles: int) -> None:
    checked: list[CheckedPlanner] = []

    def call(planner: Planner, t: float, state: Any, remotes: Any) -> Any:
        if not checked:
            checked.append(CheckedPlanner(planner))
        return checked[0].step(t, state, remotes)

    drive(CROWDS[name](), cycles, call)
    assert checked[0].wrong == []


@pytest.mark.parametrize("name", ["queue", "crossing", "oncoming", "weaving"])
def test_reason_agrees_with_command_in_a_crowd(name: str) -> None:
    check_crowd(name, 100)


@pytest.mark.slow
@pytest.mark.parametrize("name", CROWDS)
def test_reason_agrees_with_command_in_long_crowds(name: str) -> None:
    check_crowd(name, 700)


def check_scenario(scenario: Scenario) -> None:
    checked = CheckedPlanner(make_planner(scenario))
    simulate(scenario, planner=checked)
    assert checked.wrong == []
    assert len(checked.reasons) > 100


def maneuver(case: str, *, v2v: bool = True) -> Scenario:
    x = np.arange(0.0, 1500.0, 15.0)
    return overtaking(
        case, fit_path(np.column_stack((x, x**2 / 2000.0)), tolerance=0.3), start=210.0, v2v=v2v
    )


SCENARIOS: dict[str, Callable[[], Scenario]] = {
    "eebl B": lambda: eebl("B"), "eebl C": eebl, "eebl D": lambda: eebl("D"),
    "eebl sensor": lambda: eebl("sensor"),
    "ima": ima, "ima crossing": lambda: ima("crossing"), "ima sensor": lambda: ima(ego_type="sensor"),
    "curbside": curbside, "curbside sensor": lambda: curbside(ego_type="sensor"),
    "1-fast": lambda: maneuver("1-fast"), "1-smooth": lambda: maneuver("1-smooth"),
    "2": lambda: maneuver("2"), "3": lambda: maneuver("3"), "2 sensor": lambda: maneuver("2", v2v=False),
}  # fmt: skip


def test_reason_agrees_with_command_at_the_curbside() -> None:
    check_scenario(curbside())


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENARIOS)
def test_reason_agrees_with_command_in_the_paper(name: str) -> None:
    check_scenario(SCENARIOS[name]())

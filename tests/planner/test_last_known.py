"""Vehicles that are no longer reported because the list, a record or the radio failed: they may be there."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import Command, Lane, RemoteVehicle
from cca_core.frenet import FrenetVehicle
from cca_core.geometry import box_gap, boxes
from cca_core.planner import DecisionSettings
from cca_core.planner.last_known import Known, Memory, dead_reckoned, recall
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import (
    CAR,
    CYCLE,
    START,
    assert_valid,
    car,
    ego_state,
    frenet_car,
    make_planner,
)

TWO_LANES = (Lane(d=0.0), Lane(d=3.5, direction=-1))


class Health:
    """What a receiver says of itself."""

    def __init__(self, trusted: Any) -> None:
        self.trusted, self.reason = trusted, "no message accepted"


def failing(records: list[RemoteVehicle]) -> Iterator[RemoteVehicle]:
    """A list that fails before its last record."""
    yield from records[:-1]
    raise OSError


FAULTS: dict[str, Any] = {
    "none": lambda true: (None, None),
    "number": lambda true: (7, None),
    "mapping": lambda true: ({n.id: n for n in true}, None),
    "failing": lambda true: (failing(true[:1]), None),
    "half": lambda true: (failing(true), None),
    "blind": lambda true: ([], Health(False)),
    "text": lambda true: ([], Health("no")),
    "broken-radio": lambda true: ([], object()),
    "not-a-number": lambda true: ([replace(n, x=math.nan) for n in true], None),
    "foreign": lambda true: ([{"id": n.id} for n in true], None),
}


QUICK = ("none", "half", "blind", "not-a-number")
CASES = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in FAULTS]
LOST = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in list(FAULTS)[:-2]]


class Drive:
    """Behind a stationary van, with an oncoming car, and a fault of the list from a time on."""

    def __init__(
        self,
        fault: str,
        begin: float,
        seconds: float,
        *,
        far: float = 300.0,
        until: float = 14.0,
        forget_oncoming: bool = False,
    ) -> None:
        v, gap = 15.0, 120.0
        planner, plant = make_planner(TWO_LANES, cruise=v), SingleTrackPlant(CAR, ego_state(v_x=v))
        self.commands: list[Command] = []
        self.speeds: list[float] = []
        self.min_gap = math.inf
        for k in range(round(until / CYCLE)):
            t, state = CYCLE * k, plant.state
            true = [car(START + gap, v_x=0.0, id="van")]
            if far:
                true.append(RemoteVehicle(id="oncoming", x=START + far - v * t, y=3.5, psi=math.pi, v_x=v))
            listed: Any = true
            radio = None
            if begin <= t < begin + seconds:
                listed, radio = FAULTS[fault](true)
            elif t >= begin and forget_oncoming and t < begin + seconds + 0.5:
                listed = true[:1]
            command = planner.step(t, state, listed, radio=radio)
            assert_valid(command)
            self.commands.append(command)
            self.speeds.append(state.v_x)
            ego = boxes(state.x, state.y, state.psi, CAR.length, CAR.width)
            for n in true:
                body = boxes(n.x, n.y, n.psi, n.length, n.width)
                self.min_gap = min(self.min_gap, float(box_gap(ego, body)))
            plant.step(command.delta, command.a_x, CYCLE)

    def evading_during(self, begin: float, end: float) -> bool:
        """Whether a maneuver began between two times."""
        evading = [c.decision.action.is_evading for c in self.commands]
        first, last = round(begin / CYCLE), round(end / CYCLE)
        return any(
            now and not before for before, now in zip(evading[first - 1 :], evading[first:last], strict=False)
        )


@pytest.mark.parametrize("fault", CASES)
def test_known_vehicles_stay_while_list_fails(fault: str) -> None:
    run = Drive(fault, 3.0, 4.0, until=10.0)
    assert run.min_gap > 0.3
    assert "dead-reckoned" in str(run.commands[round(3.5 / CYCLE)].input_faults)


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("begin", [0.5, 1.0, 2.0, 4.0, 5.0, 6.0])
def test_known_vehicles_stay_whenever_list_fails(fault: str, begin: float) -> None:
    for seconds in (0.5, 4.0, 9.0):
        assert Drive(fault, begin, seconds).min_gap > 0.3


@pytest.mark.parametrize("fault", LOST)
def test_ego_waits_behind_last_known_vehicle(fault: str) -> None:
    """The list fails for as long as the drive lasts."""
    run = Drive(fault, 1.0, 30.0, far=0.0, until=16.0)
    assert run.min_gap > 0.3
    assert run.speeds[-1] < 0.2


@pytest.mark.parametrize("fault", LOST)
def test_no_maneuver_begins_while_vehicles_are_unknown(fault: str) -> None:
    assert Drive("none", 99.0, 0.0, far=0.0, until=6.0).evading_during(1.0, 6.0)
    assert not Drive(fault, 1.0, 5.0, far=0.0, until=6.0).evading_during(1.0, 6.0)


@pytest.mark.parametrize("fault", ["none", pytest.param("blind", marks=pytest.mark.slow)])
def test_vehicle_not_yet_received_again_blocks(fault: str) -> None:
    """After the fault the list lacks the oncoming car for half a second more."""
    run = Drive(fault, 1.5, 2.0, far=220.0, forget_oncoming=True, until=10.0)
    assert run.min_gap > 0.3
    faults = str(run.commands[round(3.7 / CYCLE)].input_faults)
    assert "just heard again" in faults
    assert "oncoming not reported" in faults


@pytest.mark.parametrize("fault", CASES)
def test_one_failed_list_costs_no_speed(fault: str) -> None:
    plain = Drive("none", 99.0, 0.0, until=2.0)
    run = Drive(fault, 1.0, CYCLE, until=2.0)
    assert np.abs(np.subtract(run.speeds, plain.speeds)).max() < 0.1


def test_complete_list_forgets_and_releases_brakes() -> None:
    """What was known for 0.2 s coasts for less than 0.1 s; the brakes are released within a second."""
    planner = make_planner(None)
    for k in range(60):
        command = planner.step(CYCLE * k, ego_state(START + 0.4 * k), [car(70.0, v_x=0.0)] if k < 10 else [])
    assert command.input_faults == ()
    assert command.a_x == pytest.approx(0.0, abs=1e-9)
    fresh = make_planner(None).step(0.0, ego_state(START + 0.4 * 59), [])
    assert command.decision.action is fresh.decision.action


class Recall:
    """A memory over several cycles."""

    def __init__(self) -> None:
        self.memory = Memory()

    def __call__(self, t: float, ids: list[str], *, lost: bool = False, blind: bool = False) -> set[str]:
        """Ids of the vehicles that are recalled in a cycle with vehicles of some ids."""
        vehicles = [frenet_car(50.0, 0.0, 10.0, name) for name in ids]
        self.memory, records, _ = recall(
            self.memory, t, vehicles, (), DecisionSettings(), lost=lost, blind=blind
        )
        return {record.id for record in records}


def test_memory_of_untrusted_radio_ends() -> None:
    """What was known before the distrust is remembered for 30 s, what was first heard during it for 1 s."""
    recalled = Recall()
    assert recalled(0.0, ["before"]) == set()
    assert recalled(0.5, ["during"], blind=True) == {"before"}
    for t, expected in ((1.4, {"before", "during"}), (1.6, {"before"}), (29.9, {"before"}), (30.1, set())):
        assert recalled(t, [], blind=True) == expected, t


def test_lost_list_forgets_nothing() -> None:
    recalled = Recall()
    recalled(0.0, ["a", "b"])
    for t in (1.0, 50.0, 1000.0):
        assert recalled(t, [], lost=True) == {"a", "b"}
    assert recalled(1000.5, ["a"]) == {"b"}  # not yet heard again
    assert recalled(1001.5, ["a"]) == set()


def test_memory_does_not_grow() -> None:
    """New ids in each cycle of an untrusted radio, and of a list that fails."""
    recalled = Recall()
    for k in range(400):
        found = recalled(0.1 * k, [f"{k}-{i}" for i in range(3)], lost=k % 2 == 1, blind=True)
        assert len(found) < 50


@pytest.mark.parametrize(("age", "a_x"), [(0.0, -8.0), (0.5, -3.0), (0.9, 2.0), (3.0, 0.0), (0.2, 0.0)])
@pytest.mark.parametrize("time", [0.02, 0.4, 1.0, 3.0, 20.0])
@pytest.mark.parametrize("v", [0.0, 9.0, 30.0])
def test_remembered_vehicle_covers_all_motions(v: float, age: float, a_x: float, time: float) -> None:
    """Braking and accelerating between -8 and 3 m/s^2 since the measurement, at the ends of the limits."""
    measured = max(v - a_x * age, 0.0) if age <= 1.0 else v
    known = age * measured + 0.5 * a_x * age * age if age <= 1.0 else 0.0
    remote = car(known, v_x=v, a_x=a_x, age=age)
    later = dead_reckoned(remote, time)
    vehicle = FrenetVehicle.from_remote(later, later.x, later.y, 0.0, 0.0)
    ahead = np.linspace(0.0, 5.0, 11)
    rear, front = vehicle.occupied_interval(ahead, braking=8.0, acceleration=3.0)
    since = age + time + ahead if age <= 1.0 else time + ahead
    stop = np.minimum(since, measured / 8.0)
    error = 1.1 + 0.5 * 4.5  # [m], of a stop within the second, and half a body
    assert (rear <= measured * stop - 4.0 * stop * stop + error).all()
    assert (front >= measured * since + 1.5 * since * since - error).all()
    assert later.invalid_reason is None
    assert later.age == age + time


def coasting(
    since: float, elapsed: float, vehicles: list[FrenetVehicle]
) -> tuple[Memory, list[RemoteVehicle]]:
    """Memory and recalled vehicles if a complete list lacks one that was reported from a time until 10 s."""
    remote = car(50.0, v_x=10.0, a_x=-5.0, id="old")
    memory = Memory(
        known={
            "old": Known(
                remote=remote,
                t=10.0,
                since=since,
                confirmed=True,
                d=0.0,
                angle=0.0,
                measured=10.0,
                before=0.0,
            )
        }
    )
    found = recall(memory, 10.0 + elapsed, vehicles, (), DecisionSettings(), lost=False, blind=False)
    assert found[2] == ()
    return found[:2]


@pytest.mark.parametrize(
    ("since", "elapsed", "coasts"), [(0.0, 0.5, True), (0.0, 1.1, False), (9.5, 0.1, True), (9.5, 0.3, False)]
)
def test_vehicle_coasts_for_fraction_of_known_time(since: float, elapsed: float, coasts: bool) -> None:
    assert bool(coasting(since, elapsed, [])[1]) is coasts


def test_flickering_vehicle_is_recognized() -> None:
    """It was forgotten and is reported again where it was: it is known as long as it has been seen at all."""
    settings, memory = DecisionSettings(), Memory()
    steps = [(0.02 * k, 0.02 * k < 1.0 or 1.6 <= 0.02 * k < 2.0) for k in range(140)]
    seen = []
    for t, is_on in steps:
        vehicles = [frenet_car(60.0, 0.0, 0.0)] if is_on else []
        memory, recalled, _ = recall(memory, t, vehicles, [], settings, lost=False, blind=False)
        seen.append(is_on or bool(recalled))
    assert not all(seen[50:80])  # the first gap was too long for the time that it was known
    assert all(seen[80:135])  # the second one is not
    assert len(memory.known) + len(memory.former) <= 1


def test_coasting_vehicle_moves_and_ages() -> None:
    (moved,) = coasting(0.0, 0.4, [])[1]
    assert moved.x == pytest.approx(53.6)
    assert moved.v_x == pytest.approx(8.0)
    assert moved.age == pytest.approx(0.4)


def test_vehicle_under_new_id_does_not_coast() -> None:
    memory, moved = coasting(0.0, 0.4, [frenet_car(34.0, 0.0, 10.0, "new")])
    assert moved == []
    assert set(memory.known) == {"new"}
    assert memory.known["new"].since == 0.0  # it inherits the time for which it is known


def test_reported_vehicle_is_not_doubled() -> None:
    memory, moved = coasting(0.0, 0.1, [frenet_car(31.0, 0.0, 10.0, "old")])
    assert moved == []
    assert memory.known["old"].t == 10.1


def test_measured_offset_is_not_kept_on_another_route() -> None:
    def seen(memory: Memory, t: float, age: float, d: float) -> Memory:
        vehicle = FrenetVehicle.from_remote(car(50.0, age=age, id="old"), 50.0, d, 0.0, 0.0)
        return recall(memory, t, [vehicle], (), DecisionSettings(), lost=False, blind=False)[0]

    memory = seen(Memory(), 10.0, 0.0, 3.5)
    assert seen(memory, 10.3, 0.3, 3.2).known["old"].d == 3.5  # it was only dead-reckoned
    assert seen(memory, 10.3, 0.1, 3.2).known["old"].d == 3.2
    memory = memory.on_other_route()
    assert math.isnan(seen(memory, 10.3, 0.3, 0.1).known["old"].d)
    assert seen(memory, 10.3, 0.1, 0.1).known["old"].d == 0.1

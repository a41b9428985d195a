"""Coasting of vehicles whose reports have ended."""

import pytest

from cca_core import RemoteVehicle
from cca_core.frenet import FrenetVehicle
from cca_core.planner.coast import Known, coast
from tests.support.planner_drives import car, frenet_car


def known(remote: RemoteVehicle, t: float, since: float) -> dict[str, Known]:
    return {remote.id: Known(remote=remote, t=t, since=since)}


def vehicle(gap: float, name: str) -> FrenetVehicle:
    return frenet_car(gap, 0.0, 10.0, name)


@pytest.mark.parametrize(
    ("since", "elapsed", "coasts"), [(0.0, 0.5, True), (0.0, 1.1, False), (9.5, 0.1, True), (9.5, 0.3, False)]
)
def test_vehicle_coasts_for_fraction_of_known_time(since: float, elapsed: float, coasts: bool) -> None:
    _, coasting = coast(known(car(50.0, v_x=10.0), 10.0, since), [], 10.0 + elapsed, 0.4, 1.0)
    assert bool(coasting) is coasts


def test_coasting_vehicle_moves_and_ages() -> None:
    _, (moved,) = coast(known(car(50.0, v_x=10.0, a_x=-5.0), 10.0, 0.0), [], 10.4, 0.4, 1.0)
    assert moved.x == pytest.approx(53.6)
    assert moved.v_x == pytest.approx(8.0)
    assert moved.age == pytest.approx(0.4)


def test_vehicle_under_new_id_does_not_coast() -> None:
    heir = vehicle(34.0, "new")
    now, coasting = coast(known(car(50.0, v_x=10.0, id="old"), 10.0, 0.0), [heir], 10.4, 0.4, 1.0)
    assert coasting == []
    assert set(now) == {"new"}
    assert now["new"].since == 0.0  # it inherits the time for which it is known


def test_reported_vehicle_is_not_doubled() -> None:
    now, coasting = coast(known(car(50.0, v_x=10.0), 10.0, 0.0), [vehicle(31.0, "R")], 10.1, 0.4, 1.0)
    assert coasting == []
    assert now["R"].t == 10.1

"""Heights: a body on another level than the route does not block it, one of unknown height does."""

import math
from typing import Any

import numpy as np
import pytest

from cca_core import Command, InputError, Planner, RemoteVehicle, Road, Status
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import ALL_KNOWN, CAR, CYCLE, START, car, ego_state, straight

HILL = np.column_stack((np.arange(0.0, 1201.0, 20.0), 0.05 * np.arange(0.0, 1201.0, 20.0)))  # 5 % up


def step(other: RemoteVehicle, **road: Any) -> Command:
    planner = Planner(CAR, Road(straight(), **road), cruise_speed=20.0, evasion=ALL_KNOWN)
    command = planner.step(0.0, ego_state(), [other])
    assert command.status is Status.OK
    return command


def is_blocking(other: RemoteVehicle, **road: Any) -> bool:
    command = step(other, **road)
    assert bool(command.dropped) == (command.a_x >= 0.0)
    return command.a_x < 0.0


class TestLevelRoad:
    @pytest.mark.parametrize(
        ("z", "expected"),
        [(None, True), (math.nan, True), (math.inf, True), ("high", True), (0.0, True), (3.9, True),
         (-3.9, True), (4.1, False), (8.0, False), (-6.0, False), (45.0, True), (-200.0, True)],
    )  # fmt: skip
    def test_body_blocks_by_height(self, z: Any, expected: bool) -> None:
        assert is_blocking(car(60.0, v_x=0.0, z=z)) is expected

    @pytest.mark.parametrize(
        ("sigma", "expected"), [(0.0, False), (1.9, False), (2.1, True), (math.nan, True), (-1.0, True)]
    )
    def test_body_of_uncertain_height_blocks(self, sigma: float, expected: bool) -> None:
        assert is_blocking(car(60.0, v_x=0.0, z=8.0, sigma_z=sigma)) is expected

    def test_reason_names_height_and_limit(self) -> None:
        assert step(car(60.0, z=8.0)).dropped == (("R", "8.0 m above the route (limit 4.0 m)"),)
        assert step(car(60.0, z=-6.0)).dropped == (("R", "6.0 m below the route (limit 4.0 m)"),)

    def test_impossible_height_is_reported(self) -> None:
        assert "47.0 m above the route" in step(car(60.0, z=47.0)).input_faults[0]

    def test_vehicle_off_route_may_be_higher_by_grade(self) -> None:
        """It may come down a road that meets the route."""
        crossing = {"psi": -0.5 * math.pi, "v_x": 15.0, "z": 7.0}
        assert step(car(100.0, 40.0, **crossing)).dropped
        assert not step(car(100.0, 60.0, **crossing)).dropped


class TestElevation:
    @pytest.mark.parametrize(
        ("z", "expected"), [(3.0, True), (6.9, True), (7.5, False), (-1.5, False), (0.0, True)]
    )
    def test_height_counts_from_the_route_there(self, z: float, expected: bool) -> None:
        """The route is 2.9 to 3.1 m high at the body."""
        assert is_blocking(car(60.0, v_x=0.0, z=z), elevation=HILL) is expected

    def test_grade_counts_over_the_extent_of_the_body(self) -> None:
        tram = {"v_x": 0.0, "length": 60.0, "z": 10.0}  # the route is 3.0 to 6.0 m high
        assert not is_blocking(car(90.0, v_x=0.0, z=10.0), elevation=HILL)
        assert is_blocking(car(110.0, **(tram | {"z": 10.0})), elevation=HILL)
        assert is_blocking(car(90.0, v_x=0.0, z=10.0, sigma_along=20.0), elevation=HILL)

    @pytest.mark.parametrize(("sigma", "expected"), [(0.0, False), (1.0, False), (3.0, True)])
    def test_body_over_uncertain_route_blocks(self, sigma: float, expected: bool) -> None:
        assert is_blocking(car(60.0, v_x=0.0, z=10.0), elevation=HILL, sigma_elevation=sigma) is expected

    @pytest.mark.parametrize(
        "elevation", [[(0.0, 0.0), (50.0, math.nan), (80.0, 0.0)], [(0.0, 0.0), (50.0, 0.0)], [(70.0, 0.0)]]
    )
    def test_body_over_unknown_height_of_route_blocks(self, elevation: Any) -> None:
        assert is_blocking(car(60.0, v_x=0.0, z=10.0), elevation=elevation)

    @pytest.mark.parametrize(
        "wrong", [7.0, "hill", [], [(0.0, 1.0, 2.0)], [(0.0, 1.0), (0.0, 2.0)], [(5.0, 1.0), (0.0, 2.0)],
                  [(math.nan, 1.0)], [(0.0, math.inf)], [(0.0, 10**400)]], ids=str,
    )  # fmt: skip
    def test_invalid_elevation_raises(self, wrong: Any) -> None:
        with pytest.raises(InputError, match=r"^elevation must be"):
            Road(straight(), elevation=wrong)
        with pytest.raises(InputError, match=r"^sigma_elevation must be"):
            Road(straight(), sigma_elevation=-1.0)

    def test_road_of_file_has_its_heights(self, tmp_path: Any) -> None:
        points = "".join(
            f'<trkpt lat="{45.0 + 1e-4 * i}" lon="14.0"><ele>{300.0 + 0.5 * i}</ele></trkpt>'
            for i in range(60)
        )
        file = tmp_path / "hill.gpx"
        file.write_text(f"<gpx><trk><trkseg>{points}</trkseg></trk></gpx>")
        road = Road.from_file(file)
        assert road.elevation is not None
        assert road.height_range(road.path.start + 0.1, 111.2) == pytest.approx((0.0, 5.0), abs=0.1)
        assert road.sigma_elevation > 0.0


def test_ego_passes_below_a_bridge_with_traffic() -> None:
    planner = Planner(CAR, Road(straight()), cruise_speed=20.0, evasion=ALL_KNOWN)
    plant = SingleTrackPlant(CAR, ego_state())
    for k in range(500):
        t = CYCLE * k
        traffic = [
            car(START + 150.0, 0.0, 0.0, id="parked", psi=0.5 * math.pi, z=7.0, sigma_z=0.5),
            car(START + 155.0, -60.0 + 15.0 * t, 15.0, id="crossing", psi=0.5 * math.pi, z=7.0, sigma_z=0.5),
        ]
        command = planner.step(t, plant.state, traffic)
        plant.step(command.delta, command.a_x, CYCLE)
        assert plant.state.v_x > 18.0

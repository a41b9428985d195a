"""Runs in CommonRoad scenarios, hand-written and recorded."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cca_core import InputError, VehicleParams
from cca_core.follow import SpeedSettings
from cca_core.geometry import box_gap, boxes
from cca_core.path import Lane
from cca_core.planner import CertificateSettings, EvasionSettings
from cca_core.sim.commonroad.drive import CommonRoadRun, drive_commonroad
from cca_core.sim.commonroad.lanelets import find_route
from cca_core.sim.commonroad.read import read_commonroad
from cca_core.sim.commonroad.scenario import CommonRoadScenario
from tests.support.commonroad_files import BOX, REGION, ROAD, document, goal, moving, problem, state, written
from tests.support.sweeps import sweep

PLANTS = ["single_track", pytest.param("multi_body", marks=pytest.mark.requires("vehiclemodels"))]


def scenario_of(folder: Path, *inner: str) -> CommonRoadScenario:
    return read_commonroad(written(folder, document(ROAD, *inner)))


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize(("window", "cruise"), sweep(((80, 100), 15.0), ((110, 120), 12.5), ((70, 75), 20.0)))
def test_goal_on_empty_road_is_reached_in_time(
    tmp_path: Path, plant: str, window: tuple[int, int], cruise: float
) -> None:
    """140 m at 15 m/s take 9.3 s; 140 m in 11.0 and 7.5 s are about 12.5 and 20 m/s on average."""
    scenario = scenario_of(tmp_path, problem(goal(window, REGION.format(y=0.0))))
    run = drive_commonroad(scenario, plant=plant)
    summary = run.summary()
    assert summary["reached"]
    assert window[0] - 1e-6 <= 10.0 * summary["t_goal_s"] <= window[1] + 1e-6
    assert run.cruise_speed == pytest.approx(cruise, abs=1.5)
    assert summary["max_offset_m"] < 0.05
    assert summary["min_gap_m"] is None


def test_long_goal_region_does_not_change_the_speed(tmp_path: Path) -> None:
    """From 10 m at 15 m/s the ego is in it from 6 to 12 s; its center at 150 m would ask for 17.5 m/s."""
    region = REGION.format(y=0.0).replace("<length>10<", "<length>90<")
    run = drive_commonroad(scenario_of(tmp_path, problem(goal((75, 80), region))))
    assert run.summary()["reached"]
    assert run.cruise_speed == pytest.approx(15.0, abs=0.1)


def test_goal_speed_is_met(tmp_path: Path) -> None:
    wish = "<velocity><intervalStart>10</intervalStart><intervalEnd>11</intervalEnd></velocity>"
    scenario = scenario_of(tmp_path, problem(goal((50, 200), REGION.format(y=0.0) + wish)))
    summary = drive_commonroad(scenario).summary()
    assert summary["reached"]
    assert 10.0 <= summary["final_speed_mps"] <= 11.0


def test_adjacent_lanes_of_route(tmp_path: Path) -> None:
    scenario = scenario_of(tmp_path, problem(goal((80, 100), REGION.format(y=0.0))))
    lanes = drive_commonroad(scenario).road.lanes
    expected = [
        Lane(d=-3.5, width=3.5, direction=-1), Lane(d=0.0, width=3.5), Lane(d=3.5, width=3.5),
    ]  # fmt: skip
    for found, lane in zip(lanes, expected, strict=True):
        assert (found.d, found.width) == pytest.approx((lane.d, lane.width), abs=1e-3)
        assert found.direction == lane.direction


def test_goal_in_adjacent_lane_is_reached(tmp_path: Path) -> None:
    scenario = scenario_of(tmp_path, problem(goal((80, 100), REGION.format(y=3.5))))
    assert find_route(scenario.lanelets, 1, [4]) == (1, 3, 4)  # as early as possible
    assert find_route(scenario.lanelets, 4, [1]) == ()
    run = drive_commonroad(scenario)
    assert run.summary()["reached"]
    assert run.ego[-1, 1] == pytest.approx(3.5, abs=0.1)
    assert np.abs(run.a_y).max() < 1.5  # 3.5 m in 4 s: 5.77 h / T^2 = 1.26 m/s^2


def test_route_without_goal_region_goes_straight_on(tmp_path: Path) -> None:
    run = drive_commonroad(scenario_of(tmp_path, problem(goal((50, 50)))))
    assert run.summary()["t_goal_s"] == pytest.approx(5.0)
    assert run.ego[-1, 0] == pytest.approx(10.0 + 5.0 * 15.0, abs=0.1)
    assert len(run.t) == 251


def test_gaps_equal_box_gaps(tmp_path: Path) -> None:
    slow = moving(31, [state("state", k, 40.0 + 0.8 * k, 0.0, 8.0) for k in range(20, 121)])
    scenario = scenario_of(tmp_path, slow, problem(goal((0, 100), REGION.format(y=0.0))))
    run, car = drive_commonroad(scenario), VehicleParams.bmw_320i()
    assert not run.summary()["collided_with"]
    there = 0
    for t, (x, y, psi), (gap,) in zip(run.t, run.ego[:, :3], run.gaps, strict=True):
        if t < 2.0 - 1e-9:
            assert gap == math.inf
        else:
            other = boxes(40.0 + 8.0 * t, 0.0, 0.0, 4.5, 1.8)
            assert gap == pytest.approx(float(box_gap(boxes(x, y, psi, car.length, car.width), other)))
            there += 1
    assert there > 100


def test_stop_behind_obstacle_spanning_road(tmp_path: Path) -> None:
    wall = "".join(
        f'<staticObstacle id="{40 + i}"><type>x</type>{BOX}{state("initialState", 0, 90.0, y, 0.0)}'
        "</staticObstacle>"
        for i, y in enumerate((-3.5, 0.0, 3.5))
    )
    scenario = scenario_of(tmp_path, wall, problem(goal((80, 150), REGION.format(y=0.0))))
    summary = drive_commonroad(scenario).summary()
    assert not summary["reached"]
    assert summary["t_goal_s"] is None
    assert 1.0 < summary["min_gap_m"] < 5.0
    assert summary["final_speed_mps"] < 0.5


def test_dropped_obstacles_are_listed(tmp_path: Path) -> None:
    wide = BOX.replace("<width>1.8", "<width>25")
    wall = (
        f'<staticObstacle id="40"><type>x</type>{wide}{state("initialState", 0, 90.0, 40.0, 0.0)}'
        "</staticObstacle>"
    )
    run = drive_commonroad(scenario_of(tmp_path, wall, problem(goal((10, 10)))))
    assert len(run.dropped) == 1
    assert run.dropped[0].startswith("40: length and width must be")


OWN = {"x": 10.0, "y": 0.0, "v": 15.0, "psi": 0.0}


@pytest.mark.parametrize(
    ("change", "own"),
    [
        pytest.param({}, True, id="equal"),
        pytest.param({"x": 8.6}, True, id="rear axle"),
        pytest.param({"psi": 0.05, "v": 15.4, "y": 0.2}, True, id="noise"),
        pytest.param({"first": 1, "x": 11.5}, True, id="one step later"),
        pytest.param({"y": 3.5}, False, id="adjacent lane"),
        pytest.param({"x": 30.0}, False, id="ahead"),
        pytest.param({"psi": math.pi}, False, id="oncoming"),
        pytest.param({"v": 5.0}, False, id="slower"),
    ],
)
@pytest.mark.parametrize("name", [8, 900])
def test_own_recording_is_left_out(tmp_path: Path, change: dict[str, float], own: bool, name: int) -> None:
    at = {**OWN, "first": 0, **change}
    states = [
        state(
            "state",
            int(at["first"]) + k,
            at["x"] + 0.1 * at["v"] * k * math.cos(at["psi"]),
            at["y"],
            at["v"],
            at["psi"],
        )
        for k in range(100)
    ]
    scenario = scenario_of(tmp_path, moving(name, states), problem(goal((80, 100), REGION.format(y=0.0))))
    run = drive_commonroad(scenario)
    named = [text for text in run.dropped if text.startswith(f"{name}: recording of planningProblem 900")]
    assert bool(named) == own
    assert len(run.scenario.obstacles) == (0 if own else 1)
    assert len(scenario.obstacles) == 1
    if own:
        assert run.summary()["reached"]
        assert run.summary()["min_gap_m"] is None


def test_invalid_argument_raises(tmp_path: Path) -> None:
    scenario = scenario_of(tmp_path, problem(goal((10, 10))))
    with pytest.raises(InputError, match="problem must be 0 to 0, was 1"):
        drive_commonroad(scenario, problem=1)
    with pytest.raises(InputError, match="plant must be"):
        drive_commonroad(scenario, plant="train")
    with pytest.raises(InputError, match="toward must be the id of a lanelet, was 99"):
        drive_commonroad(scenario, toward=99)
    with pytest.raises(InputError, match="vehicle must be the BMW"):
        drive_commonroad(scenario, plant="multi_body", vehicle=VehicleParams.vw_vanagon())
    with pytest.raises(InputError, match="scenario must be"):
        drive_commonroad("scenario.xml")  # type: ignore[arg-type]


def test_unreachable_goal_raises(tmp_path: Path) -> None:
    aside = problem(goal((10, 10))).replace("<y>0.0</y>", "<y>50.0</y>")
    with pytest.raises(InputError, match="planningProblem 900 must start on a lanelet"):
        drive_commonroad(scenario_of(tmp_path, aside))
    behind = REGION.format(y=0.0).replace("<x>150</x>", "<x>3</x>")
    with pytest.raises(InputError, match="goalState of planningProblem 900 must be reachable"):
        drive_commonroad(scenario_of(tmp_path, problem(goal((80, 100), behind))))


def recorded(data_dir: Path, name: str) -> CommonRoadScenario:
    return read_commonroad(data_dir / "commonroad" / f"{name}.xml")


def test_recorded_files_are_read(data_dir: Path) -> None:
    """Figures read from the XML by hand."""
    road = recorded(data_dir, "DEU_Gar-1_1_T-1")
    assert (len(road.lanelets), len(road.obstacles)) == (5, 4)
    assert road.lanelets[47240].on_right == (47238, 1)
    assert road.lanelets[47244].successors == (47246,)
    car = next(o for o in road.obstacles if o.id == "201").at(2.0)
    assert car is not None
    assert (car.x, car.y, car.psi, car.v_x) == (33.6279, 1.0459, 0.0018862, 10.0)
    turn = recorded(data_dir, "BEL_Putte-10_2_T-1")
    assert (len(turn.lanelets), len(turn.obstacles)) == (7, 9)
    assert turn.lanelets[12158].on_left == (12157, -1)
    assert turn.problems[0].goals[0].t == pytest.approx((3.3, 3.3))
    assert turn.problems[0].state.v_x == 13.576714


def assert_unhurt(run: CommonRoadRun) -> None:
    assert run.gaps.min() > 0.0, run.summary()
    assert run.dropped == ()
    assert np.isfinite(run.ego).all()


@pytest.mark.parametrize("plant", PLANTS)
def test_turn_behind_bicycle(data_dir: Path, plant: str) -> None:
    run = drive_commonroad(recorded(data_dir, "BEL_Putte-10_2_T-1"), plant=plant, toward=12231)
    assert_unhurt(run)
    assert run.summary()["reached"]
    assert run.t_goal == pytest.approx(3.3)


@pytest.mark.parametrize("plant", PLANTS)
def test_straight_on_past_car_entering_lane(data_dir: Path, plant: str) -> None:
    run = drive_commonroad(recorded(data_dir, "BEL_Putte-10_2_T-1"), plant=plant)
    assert_unhurt(run)
    assert run.summary()["reached"]


@pytest.mark.parametrize("plant", PLANTS)
def test_goal_at_bumper_is_reached_with_small_gaps(data_dir: Path, plant: str) -> None:
    """With late braking, gaps of 0.1 m and cars that keep their motion the goal is reached."""
    close = SpeedSettings(
        b_comfort=4.0, standstill_gap=0.2, time_gap=0.01, approach_rate=3.0, jerk=12.0,
    )  # fmt: skip
    trusting = replace(EvasionSettings.paper(), certificate=CertificateSettings(touch=0.1, margin=0.0))
    scenario = recorded(data_dir, "DEU_Gar-1_1_T-1")
    run = drive_commonroad(scenario, plant=plant, speed=close, evasion=trusting)
    assert_unhurt(run)
    summary = run.summary()
    assert summary["reached"]
    assert summary["t_goal_s"] <= 2.0


@pytest.mark.parametrize("plant", PLANTS)
def test_goal_at_bumper_is_not_forced_by_default(data_dir: Path, plant: str) -> None:
    """The ego must be at 28.59 m by 2.0 s, when the rear of car 201 is at 31.23 m: the gap is 0.39 m."""
    scenario = recorded(data_dir, "DEU_Gar-1_1_T-1")
    run = drive_commonroad(scenario, plant=plant)
    assert_unhurt(run)
    (region,) = scenario.problems[0].goals[0].regions
    other = next(o for o in scenario.obstacles if o.id == "201").at(2.0)
    assert other is not None
    gap = other.x - 0.5 * other.length - float(region[:, 0].min()) - 0.5 * run.vehicle.length
    assert gap == pytest.approx(0.39, abs=0.01)
    assert not run.summary()["reached"]
    assert run.t[-1] == pytest.approx(2.0)
    assert run.decisions[-1][1] == "BRAKE"

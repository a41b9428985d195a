"""The brute force of the trial in recorded scenarios: closed forms, and what it and the library solve."""

import math
from pathlib import Path

import numpy as np
import pytest

from cca_core.sim import CommonRoadRun, drive_commonroad, read_commonroad
from tests.support.commonroad_files import REGION, ROAD, document, goal, moving, problem, state, written
from tests.trials.boxes import box_distance, corners
from tests.trials.commonroad.brute_force import Profile, solve


def run_of(folder: Path, *inner: str, window: tuple[int, int] = (0, 120)) -> CommonRoadRun:
    """Drive 140 m from 15 m/s to the center of a goal 10 m long."""
    task = problem(goal(window, REGION.format(y=0.0)))
    return drive_commonroad(read_commonroad(written(folder, document(ROAD, *inner, task))))


def min_gap(run: CommonRoadRun, profile: Profile) -> float:
    """Minimum gap of a profile to all obstacles, ten times in a step."""
    gaps, path, car = [math.inf], run.road.path, run.vehicle
    for t in np.arange(profile.t[0], profile.t[-1], 0.01):
        s = float(np.interp(t, profile.t, profile.s))
        x, y = path.position(s)
        psi = float(path.heading(s))
        x, y = car.center_at(float(x), float(y), psi)
        ego = corners(x, y, psi, car.length, car.width)
        found = [o.at(float(t)) for o in run.scenario.obstacles]
        gaps += [
            box_distance(ego, corners(r.x, r.y, r.psi, r.length, r.width)) for r in found if r is not None
        ]
    return min(gaps)


def test_earliest_arrival_is_that_of_full_acceleration(tmp_path: Path) -> None:
    profile = solve(run_of(tmp_path))
    assert profile is not None
    t = (-15.0 + math.sqrt(15.0**2 + 2.0 * 2.0 * 135.0)) / 2.0  # 135 m at 2 m/s²
    assert profile.t[-1] == pytest.approx(t, abs=0.11)


def test_late_goal_is_reached_within_its_time(tmp_path: Path) -> None:
    profile = solve(run_of(tmp_path, window=(110, 120)))
    assert profile is not None
    assert 11.0 - 1e-6 <= profile.t[-1] <= 12.0 + 1e-6


def test_stationary_car_is_not_passed_on_the_lane(tmp_path: Path) -> None:
    wall = moving(7, [state("state", k, 80.0, 0.0, 0.0) for k in range(161)])
    assert solve(run_of(tmp_path, wall)) is None


def test_crossing_car_is_let_past_without_contact(tmp_path: Path) -> None:
    states = [state("state", k, 60.0, -32.0 + k, 10.0, 0.5 * math.pi) for k in range(161)]
    run = run_of(tmp_path, moving(7, states))
    profile = solve(run)
    assert profile is not None
    assert min_gap(run, profile) > 0.0
    assert profile.t[-1] > 7.0  # without the car it is 6.3 s


def test_recorded_turn_is_solved_by_both(data_dir: Path) -> None:
    run = drive_commonroad(read_commonroad(data_dir / "commonroad" / "BEL_Putte-10_2_T-1.xml"))
    profile = solve(run)
    assert profile is not None
    assert min_gap(run, profile) > 0.0
    assert run.summary()["reached"]


def test_goal_at_the_bumper_is_solved_close_to_the_lead(data_dir: Path) -> None:
    """The library does not: it would have to end 0.39 m behind the lead vehicle."""
    run = drive_commonroad(read_commonroad(data_dir / "commonroad" / "DEU_Gar-1_1_T-1.xml"))
    profile = solve(run)
    assert profile is not None
    assert 0.0 < min_gap(run, profile) < 0.4

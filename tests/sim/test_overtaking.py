"""The paper's maneuvering scenario, cases 1 to 3: properties of every run."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.path import Path
from cca_core.sim import OVERTAKING_CASES, Log, make_planner, overtaking, simulate
from tests.support.lead_only import LeadOnly
from tests.support.sweeps import sweep

Run = Callable[..., Log]
ROADS = ("straight", "curved")
RUNS = list(itertools.product(ROADS, (1, 2, 3)))


def runs(*cases: str) -> list[Any]:
    """Cases with every road and seed; all but the first seed, on one road for each case, are slow."""
    quick = [(case, ROADS[i % 2], 1) for i, case in enumerate(cases)] or [(road, 1) for road in ROADS]
    every = [(*case, *rest) for case in (((c,) for c in cases) if cases else [()]) for rest in RUNS]
    return [pytest.param(*run, marks=[] if run in quick else pytest.mark.slow) for run in every]


def index(log: Log, name: str) -> int:
    return [u.id for u in log.scenario.road_users].index(name)


def begins(log: Log, name: str) -> list[float]:
    return [t for t, action, _ in log.decisions if action == name]


def front(log: Log) -> Any:
    return log.ego_frenet[:, 0] + log.scenario.vehicle.box_offset + 0.5 * log.scenario.vehicle.length


@pytest.mark.parametrize(("case", "road", "seed"), runs(*OVERTAKING_CASES))
class TestEveryRun:
    def test_gap_stays_above_half_a_meter(self, run: Run, case: str, road: str, seed: int) -> None:
        log = run(case, road, seed)
        assert log.t[-1] == pytest.approx(log.scenario.duration)  # not ended by a collision
        assert log.gaps().min() >= 0.5
        assert log.summary()["collided"] is False
        assert not any("internal error" in reason for _, _, reason in log.decisions)

    def test_lateral_acceleration_is_limited(self, run: Run, case: str, road: str, seed: int) -> None:
        log = run(case, road, seed)
        assert np.abs(log.a_y).max() <= (4.0 if case == "1-fast" else 2.5)
        # the log's a_y is that of the motion: v r + dv_y/dt
        v_x, v_y, r = log.ego[:, 3], log.ego[:, 4], log.ego[:, 5]
        a_y = np.gradient(v_y, log.t) + v_x * r
        assert np.abs(a_y - log.a_y)[2:-2].max() < 0.15

    def test_tracking_error_is_small(self, run: Run, case: str, road: str, seed: int) -> None:
        assert np.abs(run(case, road, seed).tracking).max() <= 0.4

    def test_no_cycle_is_degraded(self, run: Run, case: str, road: str, seed: int) -> None:
        assert not run(case, road, seed).degraded.any()

    def test_run_ends_ahead_of_slow_cars_at_cruise_speed(
        self, run: Run, case: str, road: str, seed: int
    ) -> None:
        log = run(case, road, seed)
        slow = [i for i, u in enumerate(log.scenario.road_users) if u.id.startswith("R")]
        rear = log.ego_frenet[-1, 0] + log.scenario.vehicle.box_offset - 0.5 * log.scenario.vehicle.length
        assert (rear > log.user_frenet[-1, slow, 0] + 0.5 * 4.5 + 5.0).all()
        assert abs(log.ego_frenet[-1, 1]) < 0.1
        assert abs(log.ego[-1, 3] - log.scenario.cruise_speed) < 0.3
        assert log.decisions[-1][1] == "KEEP"

    def test_slow_cars_are_passed_outside_their_bodies(
        self, run: Run, case: str, road: str, seed: int
    ) -> None:
        """The first and last slow car are passed on the left, outside their bodies."""
        log = run(case, road, seed)
        for name in ("R1", "R3" if case.startswith("1") else "R2"):
            i = index(log, name)
            alongside = np.abs(log.user_frenet[:, i, 0] - log.ego_frenet[:, 0]) < 4.0
            assert alongside.any()
            assert (log.ego_frenet[alongside, 1] > 1.8).all()

    def test_ego_stays_on_road(self, run: Run, case: str, road: str, seed: int) -> None:
        log = run(case, road, seed)
        corners = log.bodies()[0].corners()[:, 0]
        _, d = log.scenario.road.path.project(corners.reshape(-1, 2), np.repeat(log.ego_frenet[:, 0], 4))
        assert d.min() > log.scenario.road.right_edge
        assert d.max() < log.scenario.road.left_edge

    def test_decisions_have_reasons(self, run: Run, case: str, road: str, seed: int) -> None:
        assert all(reason.strip() for _, _, reason in run(case, road, seed).decisions)


@pytest.mark.parametrize(("road", "seed"), runs())
class TestCase1:
    def test_two_maneuvers_without_waiting(self, run: Run, road: str, seed: int) -> None:
        for case in ("1-fast", "1-smooth"):
            log = run(case, road, seed)
            assert log.actions == ["KEEP", "EVADE_LEFT", "KEEP", "EVADE_LEFT", "KEEP"]
            assert log.ego[:, 3].min() > 19.5

    def test_second_car_is_passed_on_its_right(self, run: Run, road: str, seed: int) -> None:
        for case in ("1-fast", "1-smooth"):
            log = run(case, road, seed)
            alongside = np.abs(log.user_frenet[:, index(log, "R2"), 0] - log.ego_frenet[:, 0]) < 4.0
            assert alongside.any()
            assert (np.abs(log.ego_frenet[alongside, 1]) < 0.8).all()

    def test_fast_lane_change_is_shorter_and_harder(self, run: Run, road: str, seed: int) -> None:
        """Distance from 5 % to 95 % of the first lane change, and from there back to 5 %."""
        out, back, a_y = {}, {}, {}
        for case in ("1-fast", "1-smooth"):
            log = run(case, road, seed)
            s, d = log.ego_frenet[:, 0], log.ego_frenet[:, 1]
            first = log.t < begins(log, "KEEP")[1] + 2.0
            s, d = s[first], d[first]
            offset = d.max()
            above = np.flatnonzero(d >= 0.95 * offset)
            left_at = np.flatnonzero(d[: above[0]] <= 0.05 * offset)[-1]
            back_at = above[-1] + np.flatnonzero(d[above[-1] :] <= 0.05 * offset)[0]
            out[case] = s[above[0]] - s[left_at]
            back[case] = s[back_at] - s[above[-1]]
            a_y[case] = np.abs(log.a_y).max()
        assert out["1-fast"] < 0.85 * out["1-smooth"]
        assert back["1-fast"] < 0.85 * back["1-smooth"]
        assert a_y["1-fast"] > 1.3 * a_y["1-smooth"]


@pytest.mark.parametrize(("case", "road", "seed"), runs("2", "3"))
class TestCases2And3:
    def test_actions_of_cases_2_and_3(self, run: Run, case: str, road: str, seed: int) -> None:
        actions = run(case, road, seed).actions
        assert actions == ["KEEP", "EVADE_LEFT", "KEEP", "FOLLOW", "EVADE_LEFT", "KEEP"]

    def test_speed_while_waiting_converges_to_lead(self, run: Run, case: str, road: str, seed: int) -> None:
        """The speed falls to a quarter of the difference until car A passes; then the ego speeds up."""
        log = run(case, road, seed)
        begin, end = begins(log, "FOLLOW")[0], begins(log, "EVADE_LEFT")[1]
        wait = (log.t >= begin) & (log.t <= end)
        v, lead, a = log.ego[wait, 3], log.road_users[wait, index(log, "R2"), 3], index(log, "A")
        slowest = int(v.argmin())
        assert np.diff(v[: slowest + 1]).max() < 1e-3
        assert np.diff(v[slowest:], append=v[-1]).min() > -1e-3
        apart = np.abs(log.user_frenet[wait, a, 0] - log.ego_frenet[wait, 0])
        assert apart.argmin() <= slowest
        assert v[slowest] > lead[slowest] - 0.3  # no undershoot
        assert v[slowest] - lead[slowest] < 0.25 * (v[0] - lead[0])
        assert v[0] - lead[0] > 4.0  # a difference to converge from

    def test_gap_is_kept_while_waiting(self, run: Run, case: str, road: str, seed: int) -> None:
        log = run(case, road, seed)
        wait = (log.t >= begins(log, "FOLLOW")[0]) & (log.t <= begins(log, "EVADE_LEFT")[1])
        assert log.gaps()[wait, index(log, "R2")].min() >= 3.0
        assert (-log.ego[wait, 7]).max() <= 3.0

    def test_second_maneuver_begins_after_car_a_passed(
        self, run: Run, case: str, road: str, seed: int
    ) -> None:
        """Its rear is then ahead of the ego's front (case 2, from behind) or behind it (3, oncoming)."""
        log = run(case, road, seed)
        k = int(np.searchsorted(log.t, begins(log, "EVADE_LEFT")[1] - 1e-9))
        a = index(log, "A")
        direction = log.scenario.road_users[a].direction
        rear = log.user_frenet[k, a, 0] - direction * 0.5 * 4.5
        assert direction == (1 if case == "2" else -1)
        assert direction * (rear - front(log)[k]) > 0.0

    def test_reason_of_waiting_names_car_a(self, run: Run, case: str, road: str, seed: int) -> None:
        log = run(case, road, seed)
        reason = next(r for _, name, r in log.decisions if name == "FOLLOW")
        assert "A" in reason.split()
        begin = int(np.searchsorted(log.t, begins(log, "FOLLOW")[0]))
        a = index(log, "A")
        ahead = log.user_frenet[begin, a, 0] - log.ego_frenet[begin, 0]
        assert (ahead < 0.0) if case == "2" else (ahead > 0.0)

    def test_car_a_never_reacts(self, run: Run, case: str, road: str, seed: int) -> None:
        log = run(case, road, seed)
        a = index(log, "A")
        assert (log.road_users[:, a, 3] == log.scenario.road_users[a].v_x).all()


@pytest.mark.parametrize(
    ("case", "road"), [("1-fast", "straight"), ("2", "straight"), ("3", "straight"), ("3", "curved")]
)
class TestWithoutMessages:
    def test_ego_without_messages_follows_first_slow_car(self, run: Run, case: str, road: str) -> None:
        log = run(case, road, v2v=False)
        assert set(log.actions) == {"KEEP", "FOLLOW"}
        assert log.actions[-1] == "FOLLOW"
        assert np.abs(log.ego_frenet[:, 1]).max() < 0.1
        slow = [i for i, u in enumerate(log.scenario.road_users) if u.d == 0.0]
        assert log.gaps()[:, slow].min() >= 2.5
        r1 = index(log, "R1")
        assert (log.ego_frenet[:, 0] < log.user_frenet[:, r1, 0]).all()
        assert log.ego[-1, 3] == pytest.approx(log.road_users[-1, r1, 3], abs=0.3)
        assert (-log.ego[:, 7]).max() <= 3.0


@pytest.mark.parametrize("case", ["2", "3"])
@pytest.mark.parametrize(
    ("road", "seed"),
    [
        ("straight", 1),
        *(pytest.param("straight", seed, marks=pytest.mark.slow) for seed in range(2, 6)),
        ("curved", 1),
    ],
)
def test_without_gap_acceptance_ego_hits_car_a(run: Run, case: str, road: str, seed: int) -> None:
    log = run(case, road, seed, lead_only=True)
    summary = log.summary()
    assert summary["collided"] is True
    assert summary["collided_with"] == "A"
    assert log.decisions[-1][1] == "EVADE_LEFT"
    assert "FOLLOW" not in log.actions
    # in the lane of A, not hit in its own
    assert log.ego_frenet[-1, 1] > 0.8


def test_gap_acceptance_changes_second_maneuver_only(run: Run) -> None:
    """Until the first maneuver ends both planners do the same; the second is then chosen."""
    for case in ("2", "3"):
        with_zone, without = run(case), run(case, lead_only=True)
        same = int(np.searchsorted(with_zone.t, begins(with_zone, "KEEP")[1]))
        assert np.array_equal(with_zone.ego[:same], without.ego[:same])


@pytest.mark.parametrize("shift", sweep(-8.0, 8.0))
@pytest.mark.parametrize("case", ["2", "3"])
def test_collision_does_not_depend_on_start_of_car_a(
    road: Callable[[str], Path], case: str, shift: float
) -> None:
    scenario = overtaking(case, road("straight"))
    users = tuple(replace(u, s=u.s + shift) if u.id == "A" else u for u in scenario.road_users)
    scenario = replace(scenario, road_users=users)
    summary = simulate(scenario, planner=LeadOnly(make_planner(scenario))).summary()
    assert summary["collided_with"] == "A"


class TestScenario:
    @pytest.mark.parametrize("case", ["", "4", 1, None])
    def test_unknown_case_raises(self, road: Callable[[str], Path], case: Any) -> None:
        with pytest.raises(InputError, match="case"):
            overtaking(case, road("straight"))

    def test_short_road_raises(self, road: Callable[[str], Path]) -> None:
        with pytest.raises(InputError, match="path"):
            overtaking("2", road("straight"), start=800.0)

"""Planner in closed loop: the route alone, and a lead vehicle."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cca_core import Planner, Road, Status, VehicleState
from cca_core.follow import steady_sideslip
from cca_core.path import fit_path
from cca_core.planner import EvasionSettings
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import (
    CAR,
    CYCLE,
    START,
    TWO_LANES,
    ClosedLoop,
    ScriptedVehicle,
    ego_state,
    make_planner,
    straight,
)


class TestRoute:
    def test_closed_route_is_followed(self) -> None:
        angle = np.linspace(0.0, 2.0 * math.pi, 100, endpoint=False)
        ring = fit_path(150.0 * np.column_stack((np.cos(angle), np.sin(angle))), tolerance=0.05, closed=True)
        planner = Planner(CAR, ring, cruise_speed=15.0)
        x, y = ring.position(0.0)
        beta = float(steady_sideslip(1.0 / 150.0, 15.0, CAR))
        psi = float(ring.heading(0.0)) - beta
        ego = VehicleState(x=x, y=y, psi=psi, v_x=15.0, v_y=15.0 * beta, r=15.0 / 150.0)
        command = planner.step(0.0, ego, [])
        assert command.status is Status.OK
        assert command.delta == pytest.approx(CAR.wheelbase / 150.0, rel=0.2)

    def test_ego_stops_at_end_of_route(self) -> None:
        planner = Planner(CAR, Road(straight(300.0), TWO_LANES), cruise_speed=20.0)
        run = ClosedLoop(planner, [], 40.0)
        assert run.v[-1] < 0.05
        assert run.x[-1] == pytest.approx(300.0, abs=2.0)
        assert min(run.a_x) > -2.5

    @pytest.mark.parametrize("x", [1200.0, 1201.0, 1300.0])
    def test_ego_beyond_end_of_route_stops(self, x: float) -> None:
        run = ClosedLoop(make_planner(), [], 15.0, start=x, v=10.0)
        assert run.v[-1] < 0.1

    def test_cruise_speed_and_lane_are_kept(self) -> None:
        run = ClosedLoop(make_planner(), [], 10.0, v=12.0)
        assert run.v[-1] == pytest.approx(20.0, abs=0.1)
        assert max(run.v) < 20.1
        assert max(map(abs, run.y)) < 1e-9
        assert run.actions == ["KEEP"]

    def test_speed_limit_caps_cruise_speed(self) -> None:
        planner = Planner(CAR, Road(straight(), TWO_LANES, speed_limit=15.0), cruise_speed=20.0)
        assert ClosedLoop(planner, [], 20.0, v=10.0).v[-1] == pytest.approx(15.0, abs=0.1)

    def test_ego_slows_for_curve(self) -> None:
        """A 90 degree curve of 40 m radius: lateral acceleration up to the 2.5 m/s^2 that limit the speed."""
        angle = np.linspace(0.0, math.pi / 2.0, 40)
        arc = np.column_stack((200.0 + 40.0 * np.sin(angle), 40.0 * (1.0 - np.cos(angle))))
        before = np.column_stack((np.arange(0.0, 199.0, 2.0), np.zeros(100)))
        after = np.column_stack((np.full(100, 240.0), np.arange(42.0, 241.0, 2.0)))
        path = fit_path(np.vstack((before, arc, after)), tolerance=0.05)
        planner = Planner(CAR, path, cruise_speed=20.0)
        plant = SingleTrackPlant(CAR, ego_state(2.0))
        a_y, v, station = [], [], 2.0
        for k in range(1600):
            s = plant.state
            station, d, _, _ = path.foot_point(s.x, s.y, station)
            assert abs(d) < 0.5
            plant.step(*(lambda c: (c.delta, c.a_x))(planner.step(CYCLE * k, s, [])), CYCLE)
            a_y.append(abs(plant.a_y))
            v.append(s.v_x)
            if station > path.end - 120.0:
                break
        assert min(v) == pytest.approx(10.0, abs=1.0)
        assert max(a_y) < 2.5 * 1.25
        assert v[-1] > 12.0

    def test_ego_starts_from_standstill(self) -> None:
        assert ClosedLoop(make_planner(), [], 6.0, v=0.0).v[-1] > 8.0

    @pytest.mark.parametrize("d", [0.35, 0.45, 0.5, 0.7, 0.9, 1.2, 2.0, 3.0])
    @pytest.mark.parametrize("side", [-1.0, 1.0])
    def test_ego_next_to_its_lane_center_returns_at_once(self, d: float, side: float) -> None:
        """However small the offset is."""
        planner, plant = make_planner(), SingleTrackPlant(CAR, replace(ego_state(START, 20.0), y=side * d))
        for k in range(150):
            command = planner.step(CYCLE * k, plant.state, [])
            plant.step(command.delta, command.a_x, CYCLE)
            assert side * plant.state.y > -0.2
        assert abs(plant.state.y) < 0.1


class TestLead:
    def test_following_gap_converges_without_adjacent_lane(self) -> None:
        run = ClosedLoop(make_planner(None), [ScriptedVehicle("R", 70.0, 0.0, 12.0)], 40.0)
        assert run.actions == ["KEEP", "FOLLOW"]
        assert run.v[-1] == pytest.approx(12.0, abs=0.05)
        gap = START + 70.0 + 12.0 * 40.0 - run.x[-1] - 4.5
        assert gap == pytest.approx(3.0 + 1.5 * 12.0, abs=1.0)
        assert min(run.v) > 11.5
        assert min(run.a_x) > -3.0

    def test_bare_path_is_never_left(self) -> None:
        run = ClosedLoop(make_planner(None), [ScriptedVehicle("R", 70.0, 0.0, 5.0)], 25.0)
        assert not any(name.startswith("EVADE") for name in run.actions)
        assert run.collided_with is None
        assert max(abs(y) for y in run.y) + 0.9 < 1.75

    def test_stationary_car_is_stopped_behind(self) -> None:
        run = ClosedLoop(make_planner(None), [ScriptedVehicle("R", 120.0, 0.0, 0.0)], 25.0)
        assert run.collided_with is None
        assert run.v[-1] < 0.1
        assert run.gaps["R"] == pytest.approx(3.0, abs=1.0)

    def test_late_stationary_car_is_braked_for(self) -> None:
        """38 m before it, at 20 m/s: 5.5 m/s^2."""
        run = ClosedLoop(make_planner(None), [ScriptedVehicle("R", 42.0, 0.0, 0.0)], 12.0)
        assert "BRAKE" in run.actions
        assert run.collided_with is None
        assert run.v[-1] < 0.1

    def test_lead_braking_to_standstill_is_not_hit(self) -> None:
        run = ClosedLoop(
            make_planner(None),
            [ScriptedVehicle("R", 60.0, 0.0, 18.0, a=lambda t: -6.0 if t > 8.0 else 0.0)],
            30.0,
        )
        assert run.collided_with is None
        assert run.v[-1] < 0.1

    def test_slow_lead_is_passed_in_clear_lane(self) -> None:
        run = ClosedLoop(make_planner(), [ScriptedVehicle("R", 70.0, 0.0, 12.0)], 20.0)
        assert run.actions == ["KEEP", "EVADE_LEFT", "KEEP"]
        assert run.gaps["R"] >= 0.9
        assert max(map(abs, run.a_y)) < 2.5

    def test_zero_awareness_range_blocks_adjacent_lane(self) -> None:
        planner = make_planner(evasion=EvasionSettings(awareness_range=0.0))
        run = ClosedLoop(planner, [ScriptedVehicle("R", 70.0, 0.0, 12.0)], 25.0)
        assert run.actions == ["KEEP", "FOLLOW"]
        assert run.collided_with is None

    def test_short_awareness_range_blocks_adjacent_lane(self) -> None:
        near = ClosedLoop(
            make_planner(evasion=EvasionSettings(awareness_range=40.0)),
            [ScriptedVehicle("R", 70.0, 0.0, 12.0)],
            20.0,
        )
        assert near.actions == ["KEEP", "FOLLOW"]

    def test_lead_almost_as_fast_is_not_passed(self) -> None:
        run = ClosedLoop(make_planner(), [ScriptedVehicle("R", 40.0, 0.0, 18.5)], 30.0)
        assert not any(name.startswith("EVADE") for name in run.actions)
        assert run.v[-1] == pytest.approx(18.5, abs=0.1)

    def test_reference_is_route_after_maneuver(self) -> None:
        planner = make_planner()
        run = ClosedLoop(planner, [ScriptedVehicle("R", 70.0, 0.0, 12.0)], 20.0)
        assert run.commands[-1].reference is planner.road.path
        assert run.commands[-1].band is None
        evading = [c for c in run.commands if c.decision.action.is_evading]
        assert all(c.band is not None and c.reference is not planner.road.path for c in evading)

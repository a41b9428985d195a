"""Planner in hazards: what must not happen on a straight road."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cca_core import Lane, Planner, RemoteVehicle, Road, VehicleState
from cca_core.path import fit_path
from cca_core.planner import EvasionSettings, Grade
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import (
    ALL_KNOWN,
    CAR,
    CYCLE,
    TWO_LANES,
    ClosedLoop,
    CrossingVehicle,
    CutInVehicle,
    ReturningVehicle,
    ScriptedVehicle,
    TurningVehicle,
    make_planner,
    straight,
)
from tests.support.sweeps import sweep


class TestHazards:
    """Hazards on a straight road; each was once tried as an attack."""

    def test_stale_lead_is_followed(self) -> None:
        """Dead-reckoned with growing age, as by a tracker."""
        kept: dict[str, tuple[float, RemoteVehicle]] = {}

        def silent(t: float, remotes: list[RemoteVehicle]) -> list[RemoteVehicle]:
            if t <= 1.0:
                kept.update({r.id: (t, r) for r in remotes})
            return [
                replace(r, x=r.x + r.v_x * (t - since), age=r.age + t - since) for since, r in kept.values()
            ]

        run = ClosedLoop(make_planner(None), [ScriptedVehicle("R", 120.0, 0.0, 10.0)], 20.0, receive=silent)
        assert run.collided_with is None
        assert "FOLLOW" in run.actions

    def test_car_across_lane_is_not_hit(self) -> None:
        run = ClosedLoop(make_planner(None), [ScriptedVehicle("X", 150.0, 2.3, 0.0, psi=math.pi / 2.0)], 20.0)
        assert run.collided_with is None

    def test_truck_across_road_is_not_hit(self) -> None:
        truck = ScriptedVehicle("X", 150.0, 6.2, 0.0, psi=math.pi / 2.0, length=12.0, width=2.5)
        assert ClosedLoop(make_planner(), [truck], 20.0).collided_with is None

    @pytest.mark.parametrize("gap", sweep(90.0, 75.0, 110.0))
    @pytest.mark.parametrize("radius", [8.0, 14.0, 25.0])
    @pytest.mark.parametrize("speed", [4.0, 5.0])
    def test_car_that_turns_in_far_ahead_is_not_braked_for_hard(
        self, gap: float, radius: float, speed: float
    ) -> None:
        """It seems to come towards the ego in its lane for a moment; the ego drives at 10 m/s."""
        road = Road(straight(), [Lane(d=0.0), Lane(d=3.5, direction=-1)])
        planner = Planner(CAR, road, cruise_speed=10.5, evasion=ALL_KNOWN)
        other = TurningVehicle(gap, speed, radius=radius, begin=0.3)
        run = ClosedLoop(planner, [other], 8.0, v=10.0)
        assert run.gaps["O"] > 1.0
        assert min(c.a_x for c in run.commands) > -5.0

    @pytest.mark.parametrize(("speed", "gap"), [(20.0, 80.0), (15.0, 110.0)])
    def test_fast_ego_brakes_for_a_slow_lead_harder_than_it_needs(self, speed: float, gap: float) -> None:
        """The worst case cannot be excluded: the ego leaves room for a lead that brakes."""
        planner = Planner(CAR, Road(straight(2000.0)), cruise_speed=40.0, evasion=ALL_KNOWN)
        run = ClosedLoop(planner, [ScriptedVehicle("R", gap, 0.0, speed)], 8.0, v=40.0)
        need = (40.0 - speed) ** 2 / (2.0 * (gap - 4.5))
        assert min(c.a_x for c in run.commands[:50]) < -1.5 * need
        assert run.gaps["R"] > 9.0

    @pytest.mark.parametrize(
        ("v", "speed", "gap", "begin"),
        [
            (40.0, 29.5, 42.0, 4.5), (40.0, 24.0, 60.0, 4.5), (40.0, 20.0, 80.0, 4.5),
            (40.0, 29.5, 42.0, 2.5), (30.0, 20.0, 35.0, 2.0), (30.0, 20.0, 45.0, 3.0),
            (30.0, 24.0, 25.0, 2.0), (33.0, 28.0, 30.0, 2.0), (25.0, 25.0, 10.0, 2.0),
            (25.0, 23.0, 12.0, 1.5), (20.0, 12.0, 25.0, 2.0), (20.0, 10.0, 30.0, 3.0),
        ],
    )  # fmt: skip
    def test_lead_braking_after_cut_in_is_not_hit(
        self, v: float, speed: float, gap: float, begin: float
    ) -> None:
        """Nothing is certified at first: the ego brakes the harder the greater the impact may be."""
        planner = Planner(CAR, Road(straight(2000.0)), cruise_speed=v, evasion=ALL_KNOWN)
        lead = ScriptedVehicle("R", gap, 0.0, speed, a=lambda t: -7.0 if t >= begin else 0.0)
        run = ClosedLoop(planner, [lead], 10.0, v=v)
        assert run.gaps["R"] > 1.0
        if v - speed <= 10.0 and gap >= 42.0:
            assert min(c.a_x for c in run.commands[: round(begin / CYCLE)]) > -5.0

    @pytest.mark.parametrize(
        ("v", "speed", "aside", "gap"),
        [(13.0, 8.0, 0.8, 13.5), (20.0, 17.0, 1.2, 9.5), (20.0, 17.0, 0.8, 8.5), (30.0, 22.0, 0.8, 13.5)],
    )
    def test_car_that_cuts_in_alongside_is_not_touched(
        self, v: float, speed: float, aside: float, gap: float
    ) -> None:
        """The ego brakes until it is behind it, and does not stay next to it at its speed."""
        planner = Planner(CAR, Road(straight(2000.0), TWO_LANES), cruise_speed=v, evasion=ALL_KNOWN)
        other = CutInVehicle(gap, speed, begin=1.0, speed=aside)
        run = ClosedLoop(planner, [other], 9.0, v=v)
        assert run.collided_with is None

    @pytest.mark.parametrize("gap", [12.5, 13.5, 14.5, 16.5])
    def test_brakes_are_not_released_before_an_impact(self, gap: float) -> None:
        """A car cuts in so close that it cannot be avoided: comfort does not count any more."""
        planner = Planner(CAR, Road(straight(2000.0), TWO_LANES), cruise_speed=20.0, evasion=ALL_KNOWN)
        run = ClosedLoop(planner, [CutInVehicle(gap, 14.0, begin=1.0, speed=1.2)], 9.0)
        assert run.collided_with == "C"
        assert max(c.a_x for c in run.commands[round(1.8 / CYCLE) :]) < -6.9

    @pytest.mark.parametrize("gap", [180.0, 220.0])
    @pytest.mark.parametrize("speed", [12.0, 18.0])
    @pytest.mark.parametrize("begin", sweep(3.0, 4.0))
    @pytest.mark.parametrize("shoulder", [False, True])
    def test_oncoming_overtaker_can_return_to_its_lane(
        self, gap: float, speed: float, begin: float, shoulder: bool
    ) -> None:
        """It comes towards the ego in the ego's lane; it may return to its own, where the ego must not be."""
        lanes = (Lane(d=0.0), Lane(d=3.5, direction=-1), *([Lane(d=-2.75, width=2.0)] if shoulder else []))
        planner = Planner(CAR, Road(straight(), lanes), cruise_speed=20.0, evasion=ALL_KNOWN)
        run = ClosedLoop(planner, [ReturningVehicle(gap, speed, begin=begin)], 9.0)
        assert run.gaps["O"] > 0.5
        assert "EVADE_LEFT" not in run.actions

    @pytest.mark.parametrize("gap", [180.0, 220.0])
    @pytest.mark.parametrize("speed", [12.0, 18.0])
    @pytest.mark.parametrize("begin", sweep(3.0, 4.0))
    def test_oncoming_vehicle_can_return_across_a_lane(self, gap: float, speed: float, begin: float) -> None:
        """The lane between them is clear, but not to be evaded into."""
        lanes = Lane(d=0.0), Lane(d=3.5), Lane(d=7.0, direction=-1)
        planner = Planner(CAR, Road(straight(), lanes), cruise_speed=20.0, evasion=ALL_KNOWN)
        run = ClosedLoop(planner, [ReturningVehicle(gap, speed, begin=begin, home=7.0)], 9.0)
        assert run.gaps["O"] > 0.5
        assert "EVADE_LEFT" not in run.actions

    @pytest.mark.parametrize(
        ("left", "size", "speed"),
        [
            ((3.5, 7.0), (0.5, 0.6), 1.4),  # a pedestrian
            ((3.5, 7.0), (1.9, 0.7), 5.0),  # a cyclist
            ((3.5, 12.0), (4.5, 1.8), 20.0),  # a car on the wrong side of a median
        ],
    )
    def test_oncoming_body_that_cannot_return_is_evaded(
        self, left: tuple[float, float], size: tuple[float, float], speed: float
    ) -> None:
        lanes = Lane(d=0.0), Lane(d=left[0]), Lane(d=left[1], direction=-1)
        planner = Planner(CAR, Road(straight(), lanes), cruise_speed=20.0, evasion=ALL_KNOWN)
        other = ScriptedVehicle("O", 180.0, -0.3, speed, psi=math.pi, length=size[0], width=size[1])
        run = ClosedLoop(planner, [other], 10.0)
        assert run.gaps["O"] > 0.9
        assert min(run.v) > 12.0
        assert "EVADE_LEFT" in run.actions

    @pytest.mark.parametrize(("d", "action"), [(-3.0, "KEEP"), (-1.4, "EVADE_LEFT")])
    def test_cyclist_at_the_edge_against_traffic_is_passed(self, d: float, action: str) -> None:
        """It drives neither in the opposing lane nor in the middle of the ego's, and will not return."""
        lanes = Lane(d=0.0), Lane(d=3.5, direction=-1), Lane(d=-3.0, width=2.5)
        planner = Planner(CAR, Road(straight(), lanes), cruise_speed=20.0, evasion=ALL_KNOWN)
        cyclist = ScriptedVehicle("C", 150.0, d, 5.0, psi=math.pi, length=2.0, width=0.8)
        run = ClosedLoop(planner, [cyclist], 6.0)
        assert min(run.v) > 19.0
        assert run.actions[-1] == action
        assert run.gaps["C"] > 1.0

    @pytest.mark.parametrize(("speed", "braking"), [(10.0, 3.5), (10.0, 4.5), (13.0, 4.5)])
    def test_braking_of_a_crossing_car_is_believed(self, speed: float, braking: float) -> None:
        """It stops 5 m from the ego's lane, 60 m ahead; the ego at 20 m/s need not stop for it."""
        begin = -1.75 - 5.25 - speed**2 / (2.0 * braking)
        crossing = CrossingVehicle("X", 60.0, begin, speed, a=lambda t: -braking, psi=0.5 * math.pi)
        run = ClosedLoop(make_planner(None), [crossing], 5.0)
        assert run.gaps["X"] > 3.0
        assert min(run.v) > 9.0

    @pytest.mark.parametrize("gap", [0.0, -5.0])
    def test_maneuver_is_canceled_within_lane(self, gap: float) -> None:
        """The first message of a car alongside comes after the start, with the body still in its lane."""
        alongside = ScriptedVehicle("L", gap, 3.5, 20.0)
        run = ClosedLoop(
            make_planner(), [ScriptedVehicle("R", 70.0, 0.0, 12.0), alongside], 14.0,
            receive=lambda t, remotes: [r for r in remotes if r.id != "L" or t > 1.6],
        )  # fmt: skip
        assert 0.3 < run.y[81] < 1.75 - 0.9
        assert "EVADE_LEFT" in run.actions
        assert run.collided_with is None
        assert run.gaps["L"] > 0.5

    def test_vehicle_alongside_at_decision_is_not_hit(self) -> None:
        run = ClosedLoop(
            make_planner(),
            [ScriptedVehicle("R", 70.0, 0.0, 12.0), ScriptedVehicle("L", 0.0, 3.5, 20.0)],
            14.0,
        )
        assert run.collided_with is None
        assert run.gaps["L"] > 0.5
        assert run.gaps["R"] > 0.5

    @pytest.mark.parametrize("begin", sweep(4.2, 5.5, 4.6, 5.0, quick=2))
    def test_lead_braking_during_maneuver_is_not_hit(self, begin: float) -> None:
        lead = ScriptedVehicle("R", 70.0, 0.0, 12.0, a=lambda t: -7.0 if t >= begin else 0.0)
        run = ClosedLoop(make_planner(), [lead], 18.0)
        assert "EVADE_LEFT" in run.actions
        assert run.collided_with is None
        assert run.gaps["R"] > 0.5

    @pytest.mark.parametrize("seconds", [1.0, 3.0])
    def test_message_gap_during_maneuver_is_safe(self, seconds: float) -> None:
        run = ClosedLoop(
            make_planner(), [ScriptedVehicle("R", 70.0, 0.0, 12.0)], 18.0,
            receive=lambda t, remotes: [] if 4.6 < t < 4.6 + seconds else remotes,
        )  # fmt: skip
        assert "EVADE_LEFT" in run.actions
        assert run.gaps["R"] > 0.9
        assert abs(run.y[-1]) < 0.1

    def test_message_gap_while_following_is_safe(self) -> None:
        run = ClosedLoop(
            make_planner(None), [ScriptedVehicle("R", 70.0, 0.0, 12.0)], 30.0,
            receive=lambda t, remotes: [] if 15.0 < t < 16.0 else remotes,
        )  # fmt: skip
        assert run.collided_with is None
        assert max(run.v[int(15.0 / CYCLE) :]) < 14.5

    @pytest.mark.parametrize("gap", [35.0, 40.0])
    def test_late_stationary_car_is_not_hit(self, gap: float) -> None:
        run = ClosedLoop(make_planner(), [ScriptedVehicle("R", gap, 0.0, 0.0)], 8.0)
        assert run.collided_with is None
        assert run.gaps["R"] > 0.2

    def test_feasible_maneuver_is_within_grip(self) -> None:
        run = ClosedLoop(make_planner(), [ScriptedVehicle("R", 60.0, 0.0, 0.0)], 8.0)
        assert run.collided_with is None
        assert max(map(abs, run.a_y)) <= 0.85 * CAR.mu * 9.81

    def test_stale_vehicle_blocks_its_lane(self) -> None:
        """A vehicle older than a second blocks its lane (theory.md, section 3)."""
        run = ClosedLoop(
            make_planner(),
            [ScriptedVehicle("R", 70.0, 0.0, 12.0), ScriptedVehicle("L", -30.0, 3.5, 12.0)], 12.0,
            receive=lambda t, remotes: [replace(r, age=r.age + 3.0) if r.id == "L" else r for r in remotes],
        )  # fmt: skip
        assert run.collided_with is None
        assert run.actions[-1] == "FOLLOW"
        assert "EVADE_LEFT" not in run.actions

    def test_oncoming_car_in_ego_lane_stops_ego(self) -> None:
        run = ClosedLoop(make_planner(None), [ScriptedVehicle("O", 400.0, 0.0, 15.0, psi=math.pi)], 14.0)
        assert min(run.v) < 0.5  # all that can be done is to stand when it comes

    @pytest.mark.parametrize(("gap", "driven"), [(60.0, 1.15), (70.0, 1.0)])
    def test_late_maneuver_keeps_lateral_limit(self, gap: float, driven: float) -> None:
        """At a difference of 21 m/s: faster than comfort, the band within the limit of 4 m/s^2.

        Steering that lags catches up in a maneuver that starts at once.
        """
        run = ClosedLoop(make_planner(cruise=27.9), [ScriptedVehicle("R", gap, 0.0, 6.9)], 15.0, v=27.9)
        assert run.collided_with is None
        assert "EVADE_LEFT" in run.actions
        assert max(map(abs, run.a_y)) < driven * EvasionSettings().lateral_acceleration_limit

    def test_early_maneuver_keeps_lateral_setting(self) -> None:
        """Seen in time, a large difference in speed: the knob of 2 m/s^2 still means about 2."""
        run = ClosedLoop(make_planner(cruise=27.9), [ScriptedVehicle("R", 160.0, 0.0, 6.9)], 18.0, v=27.9)
        assert run.collided_with is None
        assert "EVADE_LEFT" in run.actions
        assert 1.0 < max(map(abs, run.a_y)) < 2.0


@settings(max_examples=8)
@given(
    st.floats(12.0, 28.0), st.floats(0.2, 0.85), st.lists(st.floats(20.0, 120.0), min_size=1, max_size=3),
    st.floats(8.0, 33.0), st.floats(-300.0, -10.0), st.lists(st.floats(15.0, 200.0), max_size=3),
)  # fmt: skip
def test_steady_traffic_is_never_hit(
    cruise: float, slow: float, spaces: list[float], v_left: float, left: float, gaps: list[float]
) -> None:
    v = slow * cruise
    traffic = [ScriptedVehicle(f"R{i}", 40.0 + x, 0.0, v) for i, x in enumerate(np.cumsum(spaces).tolist())]
    traffic += [
        ScriptedVehicle(f"L{i}", left + x, 3.5, v_left) for i, x in enumerate(np.cumsum(gaps).tolist())
    ]
    run = ClosedLoop(make_planner(cruise=cruise), traffic, 14.0, v=cruise)
    assert run.collided_with is None


@pytest.mark.parametrize("v_x", sweep(20.0, 15.0, 28.0))
@pytest.mark.parametrize("d", [0.0, 0.3, -0.5])
def test_replanning_past_parked_car_keeps_side_and_shape(v_x: float, d: float) -> None:
    """Replanned ten times a second: the side stays, d(s) moves by millimeters, no curve tightens."""
    x = np.arange(0.0, 801.0, 5.0)
    path = fit_path(np.column_stack((x, np.zeros_like(x))), tolerance=0.05)
    road = Road(path, (Lane(d=0.0), Lane(d=3.5), Lane(d=-3.5)))
    settings = EvasionSettings(awareness_range=math.inf)
    planner = Planner(CAR, road, cruise_speed=v_x, evasion=settings)
    plant = SingleTrackPlant(CAR, VehicleState(x=100.0, y=0.0, psi=0.0, v_x=v_x))
    parked = RemoteVehicle(id="P", x=250.0, y=d, psi=0.0, v_x=0.0)
    shapes, sides, a_y = [], set(), []
    for cycle in range(3000):
        command = planner.step(0.02 * cycle, plant.state, [parked])
        plant.step(command.delta, command.a_x, 0.02)
        maneuver = planner.maneuver
        if maneuver is not None:
            shapes.append([maneuver.offset_at(s) for s in np.linspace(100.0, 400.0, 301)])
            sides.add(maneuver.side)
            at = np.linspace(maneuver.start, maneuver.end, 300)
            a_y.append(v_x**2 * np.abs(maneuver.reference.curvature(at)).max())
        elif plant.state.x > 260.0:
            break
    assert len(shapes) > 100
    assert len(sides) == 1
    assert np.abs(np.diff(shapes, axis=0)).max() < 0.05
    assert max(a_y) <= settings.lateral_acceleration
    assert max(a_y) <= 1.1 * a_y[0]


class TestPassingLane:
    """A pass of trucks on the middle one of three lanes, whose lead vehicle brakes hard beside the first."""

    LANES = tuple(Lane(d=d, width=3.75) for d in (0.0, 3.75, 7.5))

    def drive(self, t: float, behind: float) -> ClosedLoop:
        """The lead brakes from `t` on [s], a follower [m] 1.9 s later."""
        trucks = [
            ScriptedVehicle(f"truck{i}", 94.7 + 40.0 * i, 0.0, 21.3, length=14.0, width=2.5) for i in range(3)
        ]
        others = [
            ScriptedVehicle("lead", 66.5, 3.75, 31.5, a=lambda now: -5.9 if now >= t else 0.0),
            ScriptedVehicle("follower", -behind, 3.75, 32.0, a=lambda now: -7.0 if now >= t + 1.9 else 0.0),
            ScriptedVehicle("left", 15.0, 7.5, 32.5),
            ScriptedVehicle("left behind", -11.0, 7.5, 32.5),
        ]
        planner = Planner(CAR, Road(straight(3000.0), self.LANES), cruise_speed=33.0)
        return ClosedLoop(planner, [*trucks, *others], 16.0, v=33.0)

    @pytest.mark.parametrize("t", sweep(6.0, 6.4, 6.8, 7.2))
    @pytest.mark.parametrize("behind", [30.0, 60.0])
    def test_ego_brakes_in_passing_lane(self, t: float, behind: float) -> None:
        run = self.drive(t, behind)
        assert run.collided_with is None
        assert run.gaps["truck0"] > 0.5
        grades = {command.certificate.grade for command in run.commands if command.certificate is not None}
        assert max(grades) < Grade.SEVERITY


class TestGap:
    """What the ego does about a gap that is too small."""

    def test_gap_opens_slowly(self) -> None:
        """Behind an equally fast car, 10 m ahead, the ego is hardly slower than it."""
        run = ClosedLoop(make_planner(None), [ScriptedVehicle("R", 10.0 + 4.5, 0.0, 20.0)], 15.0)
        assert 17.5 < min(run.v) < 19.5
        assert run.x[-1] < 15.0 * 20.0


class TestStoppedLead:
    """A vehicle ahead comes to rest for good, next to a lane that is free later or now."""

    LANES = (Lane(d=0.0), Lane(d=3.5))

    def drive(self, lead: ScriptedVehicle, v: float, others: Sequence[ScriptedVehicle] = ()) -> ClosedLoop:
        planner = Planner(CAR, Road(straight(3000.0), self.LANES), cruise_speed=max(v + 2.0, 12.0))
        return ClosedLoop(planner, [lead, *others], 45.0, v=v)

    @pytest.mark.parametrize("v", [8.0, 14.0])
    @pytest.mark.parametrize("braking", sweep(4.0, 2.0, 3.0))
    def test_lead_that_stops_is_passed(self, v: float, braking: float) -> None:
        """The next lane is occupied while it stops. The ego keeps the distance that it needs to pull out."""
        lead = ScriptedVehicle("R", 2.0 + 1.2 * v + 4.5, 0.0, v, a=lambda t: -braking if t > 3.0 else 0.0)
        trucks = [ScriptedVehicle(f"truck{i}", 10.0 - 14.0 * i, 3.5, v, length=12.0) for i in range(3)]
        run = self.drive(lead, v, trucks)
        assert run.collided_with is None
        assert run.gaps["R"] > 0.4
        assert run.x[-1] > lead.x + 100.0
        assert min(command.a_x for command in run.commands) > -4.0

    @pytest.mark.parametrize("gap", sweep(5.0, 10.0, 5.5, 6.5, 8.0, quick=2))
    def test_ego_pulls_out_from_standstill(self, gap: float) -> None:
        run = self.drive(ScriptedVehicle("R", gap + 4.5, 0.0, 0.0), 0.0)
        assert run.collided_with is None
        assert run.gaps["R"] > 0.3
        assert run.x[-1] > 200.0

    @pytest.mark.parametrize(
        ("gap", "v"), sweep((5.0, 2.0), (12.0, 6.0), (6.0, 3.0), (8.0, 4.0), (10.0, 5.0), quick=2)
    )
    def test_later_pass_is_no_reason_to_brake_hard(self, gap: float, v: float) -> None:
        lead = ScriptedVehicle("R", gap + 4.5, 0.0, 0.7, a=lambda t: -0.7)
        queue = [ScriptedVehicle(f"Q{i}", -6.0 - 9.0 * i, 3.5, v) for i in range(3)]
        run = self.drive(lead, v, queue)
        assert run.gaps["R"] > 0.4
        assert min(command.a_x for command in run.commands) > -4.0

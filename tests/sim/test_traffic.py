"""Actions and reactions of scripted road users."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import Lane, Road
from cca_core.errors import InputError
from cca_core.path import Path, interpolate_path
from cca_core.sim import (
    BrakeAction,
    FixedTimeGap,
    LateralShiftAction,
    Log,
    ReactToLeadAction,
    RoadUser,
    Scenario,
    SpeedAction,
    simulate,
)
from cca_core.sim.scenarios.eebl import CAR


def straight() -> Path:
    return interpolate_path([[0.0, 0.0], [500.0, 0.0], [1000.0, 0.0]])


def run(*users: RoadUser, duration: float = 8.0, **kwargs: Any) -> Log:
    return simulate(
        Scenario(
            name="test", case=None, road=Road(straight(), [Lane(d=0.0), Lane(d=3.5)]), vehicle=CAR,
            start=20.0, v_x=5.0, cruise_speed=5.0, road_users=users, duration=duration,
            ego_type="driver", **kwargs,
        )
    )  # fmt: skip


def car(name: str = "R", **kwargs: Any) -> RoadUser:
    return RoadUser(**({"id": name, "s": 200.0, "d": 0.0, "v_x": 20.0, "jerk": 12.65} | kwargs))


def test_brake_action_stops_vehicle() -> None:
    log = run(car(actions=(BrakeAction(t=2.0, deceleration=7.0),)))
    v, a = log.road_users[:, 0, 3], log.user_motion[:, 0, 0]
    assert (v[log.t <= 2.0] == 20.0).all()
    assert a.min() == -7.0
    assert np.abs(np.diff(a)[:200]).max() <= 12.65 * 0.02 + 1e-9
    # ramp of 0.553 s, then 7 m/s^2
    assert log.time_of("stopped", "R") == pytest.approx(2.0 + 20.0 / 7.0 + 0.5 * 7.0 / 12.65, abs=0.04)
    route = log.user_frenet[-1, 0, 0] - 200.0 - 40.0
    assert route == pytest.approx(400.0 / 14.0 + 20.0 * 0.5 * 7.0 / 12.65, abs=0.6)
    assert v[-1] == 0.0
    assert (np.diff(log.user_frenet[:, 0, 0]) >= 0.0).all()


@pytest.mark.parametrize("jerk", [math.inf, 12.65, 2.0])
def test_speed_actions_make_a_profile(jerk: float) -> None:
    profile = (SpeedAction(t=1.0, v_x=26.0, acceleration=3.0), SpeedAction(t=6.0, v_x=20.0, acceleration=4.0))
    log = run(car(actions=profile, jerk=jerk), duration=12.0)
    v, a = log.road_users[:, 0, 3], log.user_motion[:, 0, 0]
    assert (v[log.t <= 1.0] == 20.0).all()
    assert a.max() == pytest.approx(3.0)
    assert a.min() == pytest.approx(-4.0, abs=0.6 if jerk == 2.0 else 1e-9)
    assert v[log.t <= 5.9][-1] == pytest.approx(26.0, abs=0.05)
    assert v[-1] == pytest.approx(20.0, abs=0.05)
    assert v.max() <= 26.05
    assert v.min() >= 19.95


def test_speed_action_to_zero_and_on() -> None:
    profile = (SpeedAction(t=0.0, v_x=0.0, acceleration=5.0), SpeedAction(t=6.0, v_x=4.0))
    log = run(car(actions=profile, jerk=math.inf), duration=9.0)
    v = log.road_users[:, 0, 3]
    assert v[(log.t > 4.1) & (log.t < 5.9)] == pytest.approx(0.0)
    assert v[-1] == pytest.approx(4.0)


def test_braking_takes_precedence_over_speed() -> None:
    actions = (SpeedAction(t=0.0, v_x=30.0), BrakeAction(t=1.0, deceleration=6.0))
    log = run(car(actions=actions, jerk=math.inf), duration=8.0)
    assert log.road_users[-1, 0, 3] == 0.0


def test_lateral_shift_is_quintic() -> None:
    log = run(car(actions=(LateralShiftAction(s_start=240.0, offset=3.0, duration=2.0),)))
    s, d = log.user_frenet[:, 0].T
    t = log.t - log.t[np.argmax(s >= 240.0)]
    z = np.clip(t / 2.0, 0.0, 1.0)
    assert d == pytest.approx(3.0 * z**3 * (10.0 - 15.0 * z + 6.0 * z * z), abs=0.05)
    heading = np.arctan2(np.gradient(d, log.t), np.gradient(s, log.t))
    assert log.road_users[2:-2, 0, 2] == pytest.approx(heading[2:-2], abs=0.01)
    assert d[-1] == pytest.approx(3.0)


@pytest.mark.parametrize(("gap", "reaction"), [(8.0, 0.3), (15.0, 0.3), (15.0, 0.7), (40.0, 0.7)])
@pytest.mark.parametrize("deceleration", [4.0, 7.0])
def test_vehicle_reacting_to_lead_does_not_collide(gap: float, reaction: float, deceleration: float) -> None:
    lead = car("L", s=300.0, actions=(BrakeAction(t=1.0),))
    follower = car(
        "F",
        s=300.0 - gap - 4.5,
        actions=(ReactToLeadAction(lead_id="L", reaction_time=reaction, deceleration=deceleration),),
    )
    log = run(lead, follower)
    assert (log.user_frenet[:, 0, 0] - log.user_frenet[:, 1, 0] - 4.5).min() > 0.2
    assert log.user_motion[:, 1, 0].min() >= -7.0
    assert log.time_of("brakes", "F") - log.time_of("brakes", "L") == pytest.approx(reaction, abs=0.12)


def test_warned_vehicle_brakes_on_message() -> None:
    lead = car("L", s=300.0, actions=(BrakeAction(t=1.0),))
    late, warned = (
        car("F", s=260.0, actions=(ReactToLeadAction(lead_id="L", warning_delay=after),))
        for after in (math.inf, 0.12)
    )
    slow, fast = run(lead, late), run(lead, warned)
    assert slow.time_of("brakes", "F") == pytest.approx(1.0 + 1.25 + 0.1, abs=0.1)
    # 0.31 s to 0.4 g, at most 0.1 s to the next message, 0.1 s latency, 0.12 s
    assert 1.4 < fast.time_of("brakes", "F") < 1.8


def test_road_user_on_own_route() -> None:
    """A car that crosses at a right angle: its Frenet coordinates are its foot points on the ego's route."""
    route = interpolate_path([[100.0, -80.0], [100.0, 200.0]])
    log = run(RoadUser(id="X", s=0.0, d=0.0, v_x=10.0, route=route))
    assert log.road_users[:, 0, 0] == pytest.approx(np.full(len(log.t), 100.0))
    assert log.road_users[:, 0, 1] == pytest.approx(-80.0 + 10.0 * log.t)
    assert log.user_frenet[:, 0, 0] == pytest.approx(np.full(len(log.t), 100.0))
    assert log.user_frenet[:, 0, 1] == pytest.approx(-80.0 + 10.0 * log.t)
    assert np.cos(log.road_users[:, 0, 2] - 0.5 * np.pi) == pytest.approx(np.ones(len(log.t)))


def test_yaw_rate_on_curve() -> None:
    s = np.linspace(0.0, 600.0, 61)
    curve = interpolate_path(np.column_stack((500.0 * np.sin(s / 500.0), 500.0 - 500.0 * np.cos(s / 500.0))))
    log = run(car(s=100.0, route=curve), duration=3.0)
    assert log.user_motion[:, 0, 1] == pytest.approx(np.full(len(log.t), 20.0 / 500.0), rel=0.01)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: BrakeAction(t=-1.0), "t"), (lambda: BrakeAction(t=1.0, deceleration=-1.0), "deceleration"),
        (lambda: ReactToLeadAction(lead_id="L", reaction_time=-1.0), "reaction_time"),
        (lambda: LateralShiftAction(s_start=np.nan, offset=1.0), "s_start"),
        (lambda: LateralShiftAction(s_start=0.0, offset=1.0, duration=0.0), "duration"),
        (lambda: car(jerk=0.0), "jerk"), (lambda: car(actions=(1,)), "actions"),
        (lambda: car(route=1), "route"),
        (lambda: FixedTimeGap(lead_id="R", time_gap=0.0), "time_gap"),
        (lambda: run(car(), car()), "road_users"),
        (lambda: run(car(actions=(ReactToLeadAction(lead_id="?"),))), "lead_id"),
        (lambda: run(fixed_gap=FixedTimeGap(lead_id="?", time_gap=1.0)), "lead_id"),
        (lambda: run(visibility=-1.0), "visibility"), (lambda: run(field_of_view=7.0), "field_of_view"),
        (lambda: run(sensor_delay=-1.0), "sensor_delay"), (lambda: run(reaction_time=-1.0), "reaction_time"),
        (lambda: run(origin=(100.0, 0.0)), "origin"), (lambda: run(stop_line=np.nan), "stop_line"),
        (lambda: run(occluders=((1.0, 2.0),)), "occluders"),
        (lambda: replace(run().scenario, ego_type="cat"), "ego_type"),
    ],
)  # fmt: skip
def test_invalid_argument_raises(make: Callable[[], object], named: str) -> None:
    with pytest.raises(InputError, match=rf"\b{named}\b"):
        make()

"""Who keeps to a lane: a heading that is off, or dead reckoning out of a bend, is no lane change."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import Command, Lane, Path, Planner, RemoteVehicle, Road, VehicleState, fit_path
from cca_core.planner.last_known import dead_reckoned
from cca_core.sim import SingleTrackPlant
from tests.support.planner_drives import (
    ALL_KNOWN,
    CAR,
    ClosedLoop,
    ScriptedVehicle,
    WobblingVehicle,
    straight,
)
from tests.support.sweeps import sweep

LANES = (Lane(d=0.0), Lane(d=3.5, direction=-1))
V, CYCLE, GAP, START = 18.0, 0.1, 200.0, 20.0
Motion = Callable[[float], tuple[float, float]]  # lateral offset [m] and angle [rad] over time


def bend(radius: float) -> Path:
    angle = np.linspace(0.0, 400.0 / radius, 81)
    return fit_path(np.column_stack((radius * np.sin(angle), radius * (1.0 - np.cos(angle)))))


def meet(path: Path, motion: Motion, *, loss: float = 0.0) -> list[Command]:
    """Drive towards an oncoming car whose messages are lost, all but one each `loss` seconds."""
    planner = Planner(CAR, Road(path, LANES), cruise_speed=V)
    commands = []
    for k in range(int(0.5 * GAP / V / CYCLE)):
        t = k * CYCLE
        age = math.fmod(t + 1e-9, loss) if loss else 0.0
        s, (d, off) = START + GAP - V * (t - age), motion(t - age)
        (x, y), psi = path.to_cartesian(s, d).tolist(), float(path.heading(s)) + math.pi + off
        red = RemoteVehicle(id="red", x=x, y=y, psi=psi, v_x=V, length=4.5, width=1.8)
        s = START + V * t
        (x, y), psi = path.position(s).tolist(), float(path.heading(s))
        ego = VehicleState(x=x, y=y, psi=psi, v_x=V, r=V * float(path.curvature(s)))
        commands.append(planner.step(t, ego, [dead_reckoned(red, age)]))
    return commands


@given(st.floats(-0.035, 0.035), st.floats(-0.2, 0.2))
def test_heading_that_is_off_by_two_degrees_is_not_braked_for(off: float, aside: float) -> None:
    """It may come over, in the worst case, which costs a little speed."""
    commands = meet(straight(600.0), lambda t: (3.5 + aside, off * math.cos(8.0 * t)))
    assert min(command.a_x for command in commands) > -1.0


@pytest.mark.parametrize("swing", [0.03, 0.06, 0.1])
def test_car_aside_with_swinging_heading_is_not_braked_for(swing: float) -> None:
    """It is no lead vehicle: how fast the ego comes near does not count."""
    road = Road(straight(1200.0), [Lane(d=0.0), Lane(d=3.5)])
    planner = Planner(CAR, road, cruise_speed=20.0, evasion=ALL_KNOWN)
    run = ClosedLoop(planner, [WobblingVehicle(80.0, 3.5, 6.0, swing=swing)], 8.0, v=20.0)
    assert run.gaps["S"] > 1.5
    assert min(command.a_x for command in run.commands) > -1.0


@pytest.mark.parametrize("radius", [250.0, 400.0, -300.0])
@pytest.mark.parametrize("loss", [0.3, 0.6, 0.9])
def test_car_dead_reckoned_out_of_a_bend_brakes_for_nothing(radius: float, loss: float) -> None:
    commands = meet(bend(radius), lambda t: (3.5, 0.0), loss=loss)
    assert min(command.a_x for command in commands) > -0.5


@pytest.mark.parametrize("v_d", [0.4, 0.8, 1.5])
@pytest.mark.parametrize("loss", [0.0, 0.3])
def test_car_that_leaves_its_lane_is_answered_at_once(v_d: float, loss: float) -> None:
    begin = 1.0
    commands = meet(straight(600.0), lambda t: drift(t - begin, v_d), loss=loss)
    answered = next(k * CYCLE for k, command in enumerate(commands) if command.a_x < -0.3)
    assert begin <= answered < begin + 0.3 / v_d + loss + 0.25


def drift(t: float, v_d: float) -> tuple[float, float]:
    """Offset and angle of a car that moves to the ego's lane from a time on."""
    return (3.5, 0.0) if t < 0.0 else (max(3.5 - v_d * t, 0.0), math.asin(v_d / V))


@pytest.mark.parametrize("gap", sweep(0.3, 0.2999, 0.3 + 1e-9, 0.3 - 1e-12, 0.3001))
@pytest.mark.parametrize("speed", [0.0, 5.0])
def test_what_is_as_far_aside_as_a_limit_is_passed(gap: float, speed: float) -> None:
    """A gap at which a plan counts as too close is also one at which the vehicle is evaded."""
    planner = Planner(CAR, Road(straight(), LANES), cruise_speed=14.0, evasion=ALL_KNOWN)
    bike = ScriptedVehicle("bike", 100.0, -(0.5 * CAR.width + gap + 0.35), speed, length=1.8, width=0.7)
    run = ClosedLoop(planner, [bike], 20.0, v=14.0)
    assert run.gaps["bike"] > 0.25
    assert min(run.v) > 10.0
    assert run.x[-1] > bike.x


@pytest.mark.parametrize(("side", "off"), [(-1.0, 0.5), (1.0, -0.5)])
def test_return_in_a_bend_leaves_grip_to_the_bend(side: float, off: float) -> None:
    """The lateral acceleration of the return comes on top of that of the bend."""
    radius, v = 100.0, 15.0
    path = bend(side * radius)
    planner = Planner(CAR, Road(path, LANES), cruise_speed=v)
    (x, y), psi = path.to_cartesian(20.0, off).tolist(), float(path.heading(20.0))
    plant = SingleTrackPlant(CAR, VehicleState(x=x, y=y, psi=psi, v_x=v, r=side * v / radius))
    a_y = []
    for k in range(250):
        command = planner.step(0.02 * k, plant.state, [])
        plant.step(command.delta, command.a_x, 0.02)
        a_y.append(plant.a_y)
    assert abs(float(path.project((plant.state.x, plant.state.y))[1])) < 0.15
    assert max(map(abs, a_y)) < v * v / radius + 1.5

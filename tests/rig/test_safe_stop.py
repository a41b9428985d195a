"""Safe stop: rest on the reference path, however late the brakes are applied."""

from dataclasses import replace

import numpy as np
import pytest

from cca_core import InputError, Path, VehicleParams, VehicleState, fit_path
from cca_core.follow import PreviewController, steady_turn
from cca_core.rig import StopProfile, plan_safe_stop
from cca_core.sim import SingleTrackPlant

CAR = VehicleParams.bmw_320i()
STRAIGHT = fit_path([(x, 0.0) for x in np.linspace(0.0, 400.0, 81)])


def arc(radius: float) -> Path:
    angle = np.linspace(0.0, 2.0, 161)
    return fit_path(np.column_stack((radius * np.sin(angle), radius * (1.0 - np.cos(angle)))))


def drive(path: Path, s: float, v_x: float, *, until: float) -> SingleTrackPlant:
    """A car that has been steered along a path to a station."""
    car = SingleTrackPlant(CAR, steady_turn(path, s, v_x, CAR))
    controller = PreviewController(CAR)
    while path.foot_point(car.state.x, car.state.y, s)[0] < until:
        s = path.foot_point(car.state.x, car.state.y, s)[0]
        car.step(controller.steer(car.state, path), 0.0, 0.02)
    return car


def execute(car: SingleTrackPlant, plan: StopProfile, delay: float) -> float:
    """Drive a plan by distance, the brakes after a delay; return the distance."""
    distance, t = 0.0, 0.0
    while car.state.v_x > 0.0 and t < 30.0:
        delta, a_x = plan.at(distance)
        distance += car.state.v_x * 0.02
        car.step(delta, a_x if t >= delay else 0.0, 0.02)
        t += 0.02
    assert car.state.v_x == 0.0
    return distance


@pytest.mark.parametrize("delay", [0.0, 0.15, 0.25])
@pytest.mark.parametrize("v_x", [5.0, 15.0, 30.0])
@pytest.mark.parametrize("radius", [None, 150.0])
def test_stop_ends_on_path(radius: float | None, v_x: float, delay: float) -> None:
    path = STRAIGHT if radius is None else arc(radius)
    if radius is not None:
        v_x = min(v_x, 25.0)
    car = drive(path, 20.0, v_x, until=30.0)
    plan = plan_safe_stop(CAR, path, car.state)
    execute(car, plan, delay)
    d = path.project((car.state.x, car.state.y))[1]
    assert abs(d) < 0.3


@pytest.mark.parametrize("delay", [0.0, 0.2])
@pytest.mark.parametrize("begin", range(90, 170, 10))
def test_stop_in_lane_change_ends_in_a_lane(begin: int, delay: float) -> None:
    """From anywhere in a sharp lane change the car comes to rest within 0.3 m of its path."""
    path = lane_change()
    car = drive(path, 20.0, 20.0, until=float(begin))
    plan = plan_safe_stop(CAR, path, car.state)
    execute(car, plan, delay)
    assert abs(path.project((car.state.x, car.state.y))[1]) < 0.3


def lane_change() -> Path:
    x = np.linspace(0.0, 300.0, 601)
    z = np.clip((x - 100.0) / 60.0, 0.0, 1.0)
    return fit_path(np.column_stack((x, 3.5 * z**3 * (10.0 - 15.0 * z + 6.0 * z * z))), tolerance=0.01)


def test_first_point_brakes_and_last_is_at_rest() -> None:
    car = drive(STRAIGHT, 20.0, 20.0, until=30.0)
    plan = plan_safe_stop(CAR, STRAIGHT, car.state)
    assert plan.at(0.0)[1] == pytest.approx(-7.0, abs=0.1)
    # 0.3 s of reaction, then 7 m/s^2 with a lag of 0.1 s
    assert 39 * plan.spacing == pytest.approx(20.0 * 0.4 + 20.0**2 / 14.0, abs=1.5)
    assert plan.at(1e6) == plan.at(39 * plan.spacing)


def test_plan_at_rest_is_finite() -> None:
    car = replace(steady_turn(STRAIGHT, 20.0, 0.0, CAR))
    plan = plan_safe_stop(CAR, STRAIGHT, car)
    assert np.isfinite([*plan.heading, *plan.delta, *plan.a_x, plan.spacing]).all()


@pytest.mark.parametrize("y", [0.5, -1.0, 3.0])
def test_car_off_its_path_returns_while_braking(y: float) -> None:
    state = VehicleState(x=50.0, y=y, psi=0.0, v_x=25.0)
    car = SingleTrackPlant(CAR, state)
    execute(car, plan_safe_stop(CAR, STRAIGHT, state), 0.2)
    assert abs(car.state.y) < max(0.35, 0.3 * abs(y))


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"spacing": 0.0}, "spacing"), ({"delta": (0.0,) * 39}, "delta"),
        ({"heading": (np.nan,) * 40}, "heading"),
        ({"a_x": (-1.0,) * 39}, "a_x"), ({"a_x": (-1.0,) * 39 + (0.0,)}, "a_x"),
    ],
)  # fmt: skip
def test_invalid_safe_stop_raises(change: dict[str, object], named: str) -> None:
    good = StopProfile(spacing=1.0, heading=(0.0,) * 40, delta=(0.0,) * 40, a_x=(-7.0,) * 40)
    with pytest.raises(InputError, match=named):
        replace(good, **change)  # type: ignore[arg-type]

"""Preview steering in the kernel: both forms have the same bits, cycle after cycle."""

import math

import numpy as np
import pytest

from cca_core.kernel import bind
from cca_core.kernel.memory import lend
from cca_core.kernel.steering import IdealCar, Steering, advance, find_passed, front_slip, steer
from tests.support.kernel_curves import random_curve
from tests.support.kernel_forms import FULL, QUICK, Filled, check_forms, needs_c

KEPT = 1024
CAR = {"l_f": 1.2, "l_r": 1.4, "m": 1100.0, "inertia": 1800.0, "c_f": 1.3e5, "c_r": 1.1e5, "mu": 0.9}


def car(random: np.random.Generator) -> Filled:
    """An ideal car that has passed up to a full ring of points."""
    count = int(random.choice([0, 1, 2, 5, 40, KEPT]))
    numbers = {
        "started": bool(random.integers(2)) and count > 0, "s": float(random.uniform(0.0, 60.0)),
        "kappa": float(random.normal(0.0, 0.02)), "v_y": float(random.normal()),
        "r": float(random.normal(0.0, 0.3)), "delta": float(random.normal(0.0, 0.1)),
        "first": int(random.integers(KEPT)), "count": count,
    }  # fmt: skip
    trace = np.roll(np.sort(random.uniform(0.0, 80.0, KEPT)), numbers["first"])
    beta, r = random.normal(0.0, 0.1, (2, KEPT))
    return Filled(IdealCar, {}, {**CAR, **numbers, "trace_s": trace, "trace_beta": beta, "trace_r": r})


def started_car(random: np.random.Generator) -> Filled:
    made = car(random)
    return Filled(IdealCar, {}, {**made.values, "count": max(int(made.values["count"]), 1)})


def law(random: np.random.Generator) -> Filled:
    """A steering law with one to five speeds."""
    n = int(random.integers(1, 6))
    numbers = {
        "delta_max": 0.6, "delta_rate_max": 0.6, "steering_lag": 0.1,
        "understeer": float(random.normal(0.0, 2e-3)),
        "delay": float(random.uniform(0.0, 0.3)), "a_y_max": float(random.uniform(1.0, 9.0)),
        "ahead": bool(random.integers(2)), "s": 0.0, "integral": float(random.normal(0.0, 0.01)),
        "started": bool(random.integers(2)), "delta": float(random.normal(0.0, 0.1)),
    }  # fmt: skip
    gains = {name: random.uniform(0.0, 0.3, n) for name in ("k_p", "k_d", "l_s")}
    return Filled(
        Steering, {"count": n}, {**numbers, **gains, "speeds": np.sort(random.uniform(1.0, 40.0, n))}
    )


def speed(random: np.random.Generator) -> float:
    return float(random.choice([0.0, random.uniform(-0.5, 4.0), random.uniform(0.0, 45.0)]))


def steered(random: np.random.Generator) -> tuple[object, ...]:
    path, curve = random_curve(random)
    pose = (
        float(random.uniform(path.start, path.end)),
        *random.uniform(-20.0, 200.0, 2),
        float(random.normal(0, 2)),
    )
    return law(random), car(random), curve, *pose, speed(random), *random.normal(0.0, 0.3, 2), 0.02


def advanced(random: np.random.Generator) -> tuple[object, ...]:
    given = [float(random.uniform(0, 70)), float(random.normal(0, 0.05)), speed(random), 0.02]
    if random.random() < 0.2:  # what is absurd, or no number
        given[random.integers(4)] = float(random.choice([math.nan, math.inf, -math.inf, 1e160, -1e308]))
    return car(random), *given


@needs_c
@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_steering_in_c_equals_python(count: int) -> None:
    check_forms(steer, steered, count)
    check_forms(advance, advanced, count)
    check_forms(find_passed, lambda random: (started_car(random), float(random.uniform(-10.0, 90.0))), count)
    check_forms(front_slip, lambda random: (car(random), float(random.normal())), count)


@pytest.mark.parametrize("v", [4.0, 12.0, 31.0])
def test_full_ring_drops_oldest_point(v: float) -> None:
    """Nothing is asked for longer than the ring holds: what is dropped is what lies farthest behind."""
    lent = lend(IdealCar)
    for name, value in CAR.items():
        setattr(lent.workspace, name, value)
    drive, passed = bind(advance), bind(find_passed)
    for k in range(3 * KEPT // 2):
        drive(lent.workspace, 0.01 * v * k, 1e-6 * k, v, 0.01)
    assert lent.workspace.count == KEPT
    last = 0.01 * v * (3 * KEPT // 2 - 1)
    beta, r = passed(lent.workspace, last - 0.005 * v)
    assert r == pytest.approx(v * 1e-6 * (3 * KEPT // 2 - 1.5), rel=0.05)
    assert math.isfinite(beta)

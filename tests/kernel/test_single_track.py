"""The single-track plant in the kernel: both forms have the same bits, at all speeds."""

import numpy as np
import pytest

from cca_core.kernel.single_track import SingleTrackCar, drive, fiala_force
from tests.support.kernel_forms import FULL, QUICK, Filled, check_forms, needs_c

CAR = {
    "l_f": 1.2, "l_r": 1.4, "m": 1100.0, "inertia": 1800.0, "c_f": 1.3e5, "c_r": 1.1e5, "mu": 0.9,
    "delta_rate_max": 0.6, "steering_lag": 0.1, "drive_lag": 0.1, "a_y": 0.0,
}  # fmt: skip


def driven(random: np.random.Generator) -> tuple[object, ...]:
    names = ("x", "y", "psi", "v_y", "r", "delta", "a_x")
    state = dict(zip(names, random.normal(0.0, 0.4, 7).tolist(), strict=True))
    v_x = float(random.choice([0.0, 0.8, 1.2, 4.9, 5.1, float(random.uniform(0.0, 45.0))]))
    car = Filled(SingleTrackCar, {}, {**CAR, **state, "v_x": v_x})
    return car, *random.normal(0.0, 0.3, 1).tolist(), float(random.normal(0.0, 5.0)), 0.02


@needs_c
@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_plant_in_c_equals_python(count: int) -> None:
    check_forms(drive, driven, count)
    check_forms(fiala_force, lambda random: (1.2e5, float(random.normal(0.0, 0.1)), 5e3), count)

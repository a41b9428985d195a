"""Double lane changes of ISO 3888 on two plants: the highest entry speed that passes."""

import math
from collections.abc import Callable
from typing import Any

import pytest

from cca_core import VehicleParams, VehicleState
from cca_core.sim import (
    DoubleLaneChange,
    GateRun,
    MultiBodyPlant,
    drive_through,
    iso3888_1,
    iso3888_2,
    plan_gate_path,
)

CAR = VehicleParams.bmw_320i()
COURSES: dict[str, tuple[DoubleLaneChange, int]] = {  # with the required entry speed [km/h]
    "part 1, center to center": (iso3888_1(CAR.width), 80),
    "part 1, edge to center": (iso3888_1(CAR.width, offset="edge to center"), 80),
    "part 1, edge to edge": (iso3888_1(CAR.width, offset="edge to edge"), 80),
    "part 2": (iso3888_2(CAR.width), 55),
}
PLANTS: dict[str, Callable[[VehicleState], Any] | None] = {"single_track": None, "multi_body": MultiBodyPlant}


@pytest.mark.requires("qpsolvers", "piqp")
@pytest.mark.parametrize(
    "plant", ["single_track", pytest.param("multi_body", marks=pytest.mark.requires("vehiclemodels"))]
)
@pytest.mark.parametrize("name", COURSES)
def test_highest_entry_speed(benchmark: Any, name: str, plant: str) -> None:
    """The required speed passes; then 1 km/h more each time until a gate is hit."""
    course, required = COURSES[name]

    def highest() -> tuple[int, GateRun]:
        speed_kmh, first = required - 1, None
        while True:
            speed = (speed_kmh + 1) / 3.6
            band = plan_gate_path(course, CAR, speed)
            if not band.ok:
                break
            passage = drive_through(course, band, speed, PLANTS[plant])
            if not passage.passed:
                break
            first = first or passage
            speed_kmh += 1
        assert first is not None
        return speed_kmh, first

    speed_kmh, first = benchmark.pedantic(highest, rounds=1)
    assert first.gap > 0.03
    assert first.run.peak < 0.2
    benchmark.extra_info |= {
        "highest_speed_kmh": speed_kmh,
        "gap": round(first.gap, 3),
        "a_y": round(first.a_y, 2),
        "sideslip_deg": round(math.degrees(first.sideslip), 2),
    }

"""Euro NCAP car-to-car rear tests: stationary, moving and braking targets on a road of one lane.

Speeds and decelerations of the Car-to-Car protocol, CCRs, CCRm and CCRb. The target is 4.02 m x 1.71 m
and known by its messages within 100 m. A cell reports the speed difference at the impact, 0 without one.
"""

import os
from collections.abc import Callable, Iterator

import pytest

from cca_core import Planner
from tests.support.planner_drives import CAR, ClosedLoop, ScriptedVehicle, straight

STEP = 5 if os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full" else 10
AWARENESS_RANGE = 100.0  # [m]
TABLE: dict[str, float] = {}


def steady(t: float) -> float:
    return 0.0


def impact(kmh: float, target: float, gap: float, a: Callable[[float], float] = steady) -> float:
    """Speed difference at the impact [km/h], 0 if there is none."""
    v, v_target = kmh / 3.6, target / 3.6
    between = 0.5 * (CAR.length + 4.02)
    target_vehicle = ScriptedVehicle("T", gap + between, 0.0, v_target, a=a, length=4.02, width=1.71)
    seconds = 16.0
    run = ClosedLoop(
        Planner(CAR, straight(1500.0), cruise_speed=v), [target_vehicle], seconds, v=v,
        done=lambda s: s.v_x < max(v_target if target_vehicle.a is steady else 0.0, 0.05) + 0.05,
    )  # fmt: skip
    assert run.v[-1] <= max(v_target, 0.5) + 1.0 or run.collided_with
    return 3.6 * (run.v[-1] - target_vehicle.v) if run.collided_with else 0.0


@pytest.fixture(scope="module", autouse=True)
def table() -> Iterator[None]:
    yield
    for cell, speed in TABLE.items():
        print(f"{cell}: {'avoided' if speed == 0.0 else f'impact at {speed:.1f} km/h'}")  # noqa: T201


@pytest.mark.parametrize("kmh", range(10, 81, STEP))
def test_stationary_target_is_avoided(kmh: int) -> None:
    TABLE[f"CCRs {kmh}"] = impact(kmh, 0.0, min(AWARENESS_RANGE, 6.0 * kmh / 3.6))
    assert TABLE[f"CCRs {kmh}"] == 0.0


@pytest.mark.parametrize("kmh", range(30, 81, STEP))
def test_slower_target_is_avoided(kmh: int) -> None:
    TABLE[f"CCRm {kmh}/20"] = impact(kmh, 20.0, min(AWARENESS_RANGE, 6.0 * (kmh - 20.0) / 3.6))
    assert TABLE[f"CCRm {kmh}/20"] == 0.0


@pytest.mark.parametrize("braking", [2.0, 6.0])
@pytest.mark.parametrize("gap", [12.0, 40.0])
def test_braking_target_is_avoided(gap: float, braking: float) -> None:
    """Full deceleration is reached within a second, down to standstill."""

    def a(t: float) -> float:
        return -braking * min(max(t - 1.0, 0.0), 1.0)

    cell = f"CCRb 50/50 {gap:.0f} m -{braking:.0f}"
    TABLE[cell] = impact(50.0, 50.0, gap, a)
    assert TABLE[cell] == 0.0

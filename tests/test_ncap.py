"""Euro NCAP car-to-car rear tests: standing, moving and braking targets on a road of one lane.

Speeds and decelerations of the Car-to-Car protocol, CCRs, CCRm and CCRb; the target is 4.02 m x 1.71 m
and known by its messages from 100 m on. What a cell reports is the speed difference at the impact, 0 without
one.
"""

import os
from collections.abc import Callable, Iterator

import pytest

from cca_core import Planner
from tests.planner.test_planner import CAR, Drive, Mover, straight

STEP = 5 if os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full" else 10
KNOWN = 100.0  # [m]
TABLE: dict[str, float] = {}


def steady(t: float) -> float:
    return 0.0


def impact(kmh: float, target: float, gap: float, a: Callable[[float], float] = steady) -> float:
    """Speed difference at the impact [km/h], 0 if there is none."""
    v, v_target = kmh / 3.6, target / 3.6
    between = 0.5 * (CAR.length + 4.02)
    mover = Mover("T", gap + between, 0.0, v_target, a=a, length=4.02, width=1.71)
    seconds = 16.0
    run = Drive(
        Planner(CAR, straight(1500.0), cruise_speed=v), [mover], seconds, v=v,
        done=lambda s: s.v_x < max(v_target if mover.a is steady else 0.0, 0.05) + 0.05,
    )  # fmt: skip
    assert run.v[-1] <= max(v_target, 0.5) + 1.0 or run.hit
    return 3.6 * (run.v[-1] - mover.v) if run.hit else 0.0


@pytest.fixture(scope="module", autouse=True)
def table() -> Iterator[None]:
    yield
    for cell, speed in TABLE.items():
        print(f"{cell}: {'avoided' if speed == 0.0 else f'impact at {speed:.1f} km/h'}")  # noqa: T201


@pytest.mark.parametrize("kmh", range(10, 81, STEP))
def test_standing_target(kmh: int) -> None:
    TABLE[f"CCRs {kmh}"] = impact(kmh, 0.0, min(KNOWN, 6.0 * kmh / 3.6))
    assert TABLE[f"CCRs {kmh}"] == 0.0


@pytest.mark.parametrize("kmh", range(30, 81, STEP))
def test_slower_target(kmh: int) -> None:
    TABLE[f"CCRm {kmh}/20"] = impact(kmh, 20.0, min(KNOWN, 6.0 * (kmh - 20.0) / 3.6))
    assert TABLE[f"CCRm {kmh}/20"] == 0.0


@pytest.mark.parametrize("braking", [2.0, 6.0])
@pytest.mark.parametrize("gap", [12.0, 40.0])
def test_braking_target(gap: float, braking: float) -> None:
    """Full deceleration is reached within a second, down to standstill."""

    def a(t: float) -> float:
        return -braking * min(max(t - 1.0, 0.0), 1.0)

    cell = f"CCRb 50/50 {gap:.0f} m -{braking:.0f}"
    TABLE[cell] = impact(50.0, 50.0, gap, a)
    assert TABLE[cell] == 0.0

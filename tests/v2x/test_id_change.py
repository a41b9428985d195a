"""New ids after a message gap in curves: the new track continues the old one, and no other."""

import itertools
import math
import random

import numpy as np
import pytest

from cca_core.v2x import Tracker
from tests.support.v2x_messages import FRAME, T0, bsm

BEFORE = 2.0  # time with the old id [s]


def pose(s: float, radius: float, straight: float, side: int) -> tuple[float, float, float]:
    """Position and heading on a straight line, and then on an arc to the left for side 1."""
    if s < straight:
        return s, 0.0, 0.0
    angle = (s - straight) / radius
    return straight + radius * math.sin(angle), side * radius * (1.0 - math.cos(angle)), side * angle


def ids_after_change(
    radius: float,
    gap: float,
    side: int,
    *,
    share: float = 1.0,
    has_yaw_rate: bool = True,
    noise: float = 0.0,
    seed: int = 1,
    slower: float = 0.0,
    aside: float = 0.0,
    turned: float = 0.0,
) -> list[str]:
    """Ids of the tracks a second after a new sender of equal size continued the drive of an old one.

    `share` is the part of the message gap in the curve; `aside` and `turned` move the new sender to the left
    of that drive, and turn it.
    """  # fmt: skip
    rng, tracker = np.random.default_rng(seed), Tracker(FRAME)
    v = min(math.sqrt(3.5 * radius), 20.0)
    driven = (v - 0.5 * slower) * gap
    straight = v * BEFORE + (1.0 - share) * driven if share < 1.0 else 0.0
    for name, begin, s, speed in (
        ("00000001", 0.0, 0.0, v), ("0000beef", BEFORE + gap, v * BEFORE + driven, v - slower),
    ):  # fmt: skip
        for k in range(1 + round(10.0 * BEFORE) if s == 0.0 else 10):
            t, at = T0 + begin + 0.1 * k, s + 0.1 * k * speed
            x, y, psi = pose(at, radius, straight, side)
            if name == "0000beef":
                x, y, psi = x - aside * math.sin(psi), y + aside * math.cos(psi), psi + turned
            r = side * speed / radius if has_yaw_rate and at >= straight else 0.0
            x, y = rng.normal((x, y), noise)
            tracker.update(bsm(t, x, y, v=speed, psi=psi, r=r, id=name), t + 0.02)
    return sorted(vehicle.id for vehicle in tracker.vehicles(t))


CURVES = list(itertools.product((20.0, 60.0, 200.0), (0.4, 0.9, 1.2, 2.0, 3.0, 5.0, 8.0), (1, -1)))


@pytest.mark.parametrize(("radius", "gap", "side"), CURVES)
def test_new_id_in_curve_leaves_no_ghost(radius: float, gap: float, side: int) -> None:
    """Constant or beginning curves, with noise of the receiver, at equal or lower speed."""
    for share, noise, slower in itertools.product((1.0, 0.5, 0.2), (0.0, 0.5), (0.0, 3.0)):
        found = ids_after_change(radius, gap, side, share=share, noise=noise, slower=slower)
        assert found == ["0000beef"], (share, noise, slower)


@pytest.mark.parametrize(("radius", "gap", "side"), CURVES)
def test_new_id_without_yaw_rate_leaves_no_ghost(radius: float, gap: float, side: int) -> None:
    for share, slower in itertools.product((1.0, 0.5, 0.2), (0.0, 3.0)):
        v = min(math.sqrt(3.5 * radius), 20.0)
        if share * v * gap / radius < 1.9:  # more could be a vehicle that drives the other way
            assert ids_after_change(
                radius, gap, side, share=share, has_yaw_rate=False, slower=slower
            ) == ["0000beef"], (share, slower)  # fmt: skip


@pytest.mark.parametrize("seed", range(10))
def test_noise_of_a_receiver_leaves_no_ghost(seed: int) -> None:
    source = random.Random(seed)
    for _ in range(10):
        radius, gap = source.choice((40.0, 60.0, 100.0)), source.uniform(2.0, 6.0)
        assert ids_after_change(radius, gap, 1, noise=0.7, seed=seed) == ["0000beef"], (radius, gap)


@pytest.mark.parametrize("gap", [1.2, 2.0, 3.0])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(
    "values",
    [{"aside": 3.5}, {"aside": -3.5}, {"turned": math.pi}, {"turned": 0.5 * math.pi, "aside": 6.0}],
    ids=["left lane", "right lane", "oncoming", "crossing"],
)
def test_other_vehicle_in_curve_leaves_stale_one(gap: float, side: int, values: dict[str, float]) -> None:
    for radius in (60.0, 200.0):
        assert len(ids_after_change(radius, gap, side, **values)) == 2, radius


def test_yaw_rates_that_contradict_are_no_reason_to_join() -> None:
    """An oncoming vehicle of equal size, without yaw rate, near the place of the silent one."""
    assert len(ids_after_change(60.0, 3.0, 1, has_yaw_rate=False, turned=math.pi)) == 2

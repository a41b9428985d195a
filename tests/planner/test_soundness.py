"""Soundness of EVADE: no motion of other vehicles within the assumptions leads to a collision."""

import os

import numpy as np
import pytest

from tests.support.random_situations import decide, free_at_worst, min_gap, roads, situation

FULL = os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full"
BLOCKS, PER_BLOCK = (48, 2500) if FULL else (2, 250)
ROADS = roads()


def check(block: int, count: int) -> None:
    """Drive maneuvers without replanning among the true vehicles; count decisions and false rejections."""
    collisions, evaded, clear, rejected = [], 0, 0, 0
    for i in range(count):
        case = situation(np.random.default_rng([block, i]), ROADS[i % len(ROADS)])
        planner = decide(case, case.others)
        if planner.maneuver is not None:
            evaded += 1
            gap = min_gap(case, planner, planner.maneuver)
            if gap <= 0.0:
                collisions.append((i, gap, repr(planner)))
        alone = decide(case, case.others[:1])  # without the other vehicles
        if alone.maneuver is not None and free_at_worst(case, alone, alone.maneuver):
            clear += 1
            rejected += planner.maneuver is None
    assert collisions == []
    assert evaded >= 0.08 * count
    assert rejected <= 0.15 * clear


def test_evade_is_collision_free_and_not_rejected_falsely() -> None:
    check(0, 60)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_evade_is_collision_free_in_many_situations(block: int) -> None:
    check(block, PER_BLOCK)

"""Gaps of boxes in the kernel."""

import math

import numpy as np
import pytest

from cca_core.geometry import box_gap, boxes
from cca_core.kernel import bind
from cca_core.kernel.box_gaps import aligned_box_gaps, oriented_box_gap
from tests.support.kernel_forms import FULL, QUICK, check_forms, needs_c


def pair(random: np.random.Generator) -> tuple[float, ...]:
    """Two boxes: offset, headings and half extents."""
    a, b = random.uniform(-math.pi, math.pi, 2)
    extents = random.uniform(0.2, 9.0, 4)
    return (*random.normal(0.0, 6.0, 2), math.cos(a), math.sin(a), math.cos(b), math.sin(b), *extents)


def row(random: np.random.Generator) -> tuple[object, ...]:
    """Arguments of aligned boxes."""
    n = int(random.integers(0, 20))
    return (n, random.normal(0, 8, n), random.normal(0, 3, n), 4.5, 1.9, np.empty(n))


@needs_c
@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_gap_in_c_equals_python(count: int) -> None:
    check_forms(oriented_box_gap, pair, count)
    check_forms(aligned_box_gaps, row, count)


def test_gap_equals_numpy_form() -> None:
    gap = bind(oriented_box_gap)
    for seed in range(QUICK):
        dx, dy, ax, ay, bx, by, *half = pair(np.random.default_rng(seed))
        a, b = math.atan2(ay, ax), math.atan2(by, bx)
        expected = box_gap(
            boxes(0, 0, a, 2 * half[0], 2 * half[1]), boxes(dx, dy, b, 2 * half[2], 2 * half[3])
        )
        assert gap(dx, dy, ax, ay, bx, by, *half) == pytest.approx(float(expected), abs=1e-12)


def test_aligned_gaps_equal_oriented_gaps() -> None:
    n, dx, dy, length, width, gap = row(np.random.default_rng(3))
    smallest = bind(aligned_box_gaps)(n, dx, dy, length, width, gap)
    single = bind(oriented_box_gap)
    expected = [
        single(x, y, 1.0, 0.0, 1.0, 0.0, length, width, 0.0, 0.0) for x, y in zip(dx, dy, strict=True)
    ]
    assert gap.tolist() == pytest.approx(expected, abs=1e-12)
    assert smallest == min(gap)

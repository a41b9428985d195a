"""Gaps of boxes in the kernel."""

import math

import numpy as np
import pytest

from cca_core import geometry
from cca_core.geometry import boxes
from cca_core.kernel import bind
from cca_core.kernel.band_cubics import join_cubics
from cca_core.kernel.box_gaps import box_gap, box_gaps, oriented_box_gap
from tests.support import numpy_forms
from tests.support.kernel_forms import FULL, QUICK, check_forms, needs_c

FORMS = [pytest.param("c", marks=needs_c), "python"]


def pair(random: np.random.Generator) -> tuple[float, ...]:
    """Two boxes: offset, headings and half extents."""
    a, b = random.uniform(-math.pi, math.pi, 2)
    extents = random.uniform(0.2, 9.0, 4)
    return (*random.normal(0.0, 6.0, 2), math.cos(a), math.sin(a), math.cos(b), math.sin(b), *extents)


def many(random: np.random.Generator, n: int) -> tuple[object, ...]:
    """n pairs of boxes."""
    a, b = np.concatenate((random.normal(0.0, 4.0, (2, n, 3)), random.uniform(0.2, 9.0, (2, n, 2))), axis=-1)
    return n, n, a, b, np.empty(n)


@needs_c
@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_gap_in_c_equals_python(count: int) -> None:
    check_forms(oriented_box_gap, pair, count)
    check_forms(box_gaps, lambda random: many(random, int(random.integers(0, 9))), count)
    check_forms(box_gap, lambda random: tuple(random.uniform(0.2, 9.0, 10).tolist()), count)


@needs_c
def test_gap_of_huge_numbers_in_c_equals_python() -> None:
    def huge(random: np.random.Generator) -> tuple[float, ...]:
        given = np.array(pair(random))
        given[[0, 1, 6, 7, 8, 9]] *= 10.0 ** random.uniform(-320.0, 300.0, 6)
        return tuple(given.tolist())

    check_forms(oriented_box_gap, huge)


@pytest.mark.parametrize("scale", [1.0, 1e140, 1e154, 1e200, 1e300])
@pytest.mark.parametrize(("x", "y", "gap"), [(7.0, 9.0, math.hypot(4.0, 7.0)), (7.0, 1.0, 4.0)])
def test_gap_of_far_boxes_is_finite(scale: float, x: float, y: float, gap: float) -> None:
    a = 0.0, 0.0, 0.0, 4.0 * scale, 2.0 * scale
    b = x * scale, y * scale, 0.0, 2.0 * scale, 2.0 * scale
    assert bind(box_gap)(*a, *b) == pytest.approx(gap * scale, rel=1e-14)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("scale", [5e-324, 1e-300, 1e-160, 1.0, 1e153, 1e155, 1e300])
def test_length_of_vector_of_any_size_has_its_digits(scale: float, form: str) -> None:
    """A segment of a path from (0, 0) to (3, 4) times the scale."""
    breaks, cubics = np.zeros(2), np.zeros((1, 8))
    nodes = np.array([[0.0, 0.0], [3.0 * scale, 4.0 * scale]])
    bind(join_cubics, form)(1, nodes, np.zeros((2, 2)), 0.0, breaks, cubics)
    assert breaks[1] == pytest.approx(5.0 * scale, rel=1e-15)


def test_gap_equals_numpy_form() -> None:
    n, _, a, b, gap = many(np.random.default_rng(5), 500)
    bind(box_gaps)(n, n, a, b, gap)
    np.testing.assert_allclose(gap, numpy_forms.box_gaps(a, b), rtol=0.0, atol=1e-12)
    assert {bool(negative) for negative in gap < 0.0} == {True, False}


def test_gaps_of_repeated_boxes_equal_single_ones() -> None:
    """A body at three times against two vehicles at these times."""
    random = np.random.default_rng(6)
    a, b, gap = random.uniform(0.5, 9.0, (3, 5)), random.uniform(0.5, 9.0, (6, 5)), np.empty(6)
    bind(box_gaps)(6, 3, a, b, gap)
    single = bind(box_gap)
    assert gap.tolist() == [single(*a[i % 3].tolist(), *b[i].tolist()) for i in range(6)]


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("field", range(10))
def test_gap_of_box_that_is_none_is_no_number(field: int, bad: float) -> None:
    """Wherever it stands: no comparison of it may pass for a distance."""
    box = [0.0, 0.0, 0.1, 4.5, 1.8, 9.0, 3.0, 0.2, 4.5, 1.8]
    box[field] = bad
    assert not abs(bind(box_gap)(*box)) < math.inf
    a, b = boxes(*box[:5]), boxes(*box[5:])
    assert not abs(float(geometry.box_gap(a, b))) < math.inf

"""Angles and oriented boxes, against shapely."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import example, given
from hypothesis import strategies as st
from shapely import affinity

from cca_core.geometry import Boxes, box_gap, boxes, quintic_step, wrap_angle

coordinate = st.floats(-12.0, 12.0)
angle = st.floats(-7.0, 7.0)
extent = st.floats(0.05, 20.0)
box = st.tuples(coordinate, coordinate, angle, extent, extent)


def polygon(x: float, y: float, psi: float, length: float, width: float) -> shapely.Polygon:
    flat = shapely.box(-length / 2, -width / 2, length / 2, width / 2)
    return affinity.translate(affinity.rotate(flat, psi, origin=(0, 0), use_radians=True), x, y)


def gap(a: tuple, b: tuple) -> float:
    return float(box_gap(boxes(*a), boxes(*b)))


@given(st.floats(-1e3, 1e3))
@example(math.pi)
@example(-math.pi)
@example(math.nextafter(-math.pi, -math.inf))
@example(math.nextafter(math.pi, 0.0))
@example(3 * math.pi)
def test_wrap_angle_keeps_direction_in_half_open_range(value: float) -> None:
    wrapped = wrap_angle(value)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped - value) == pytest.approx(1.0, abs=1e-12)
    turns = (wrapped - value) / (2 * math.pi)
    assert turns == pytest.approx(round(turns), abs=1e-12)


def test_wrap_angle_equals_hand_values() -> None:
    assert wrap_angle(3.5) == pytest.approx(3.5 - 2 * math.pi, abs=1e-15)
    assert wrap_angle(math.pi) == -math.pi
    assert wrap_angle(0.0) == 0.0
    np.testing.assert_allclose(
        wrap_angle(np.array([[-3.5, 7.0]])), [[2 * math.pi - 3.5, 7.0 - 2 * math.pi]], atol=1e-15
    )


@given(box, box)
@example((0, 0, 0, 4, 2), (4, 0, 0, 4, 2))  # touching
@example((0, 0, 0, 4, 2), (0, 0, 0.3, 1, 1))  # contained
@example((0, 0, 0, 20, 0.1), (0, 0, math.pi / 2, 20, 0.1))  # a cross: no corner inside the other
def test_box_gap_equals_shapely(a: tuple, b: tuple) -> None:
    distance = polygon(*a).distance(polygon(*b))
    measured = gap(a, b)
    if distance > 1e-9:
        assert measured == pytest.approx(distance, abs=1e-9)
    else:
        assert measured <= 1e-9
    if measured < -1e-9:
        assert polygon(*a).intersection(polygon(*b)).area > 0.0


@given(box, box)
def test_overlap_depth_is_shortest_push_along_axis(a: tuple, b: tuple) -> None:
    """A displacement of b by the depth along one of the four axes just separates the boxes."""
    depth = -gap(a, b)
    if depth <= 1e-3:
        return
    parted = []
    for psi in (a[2], a[2] + math.pi / 2, b[2], b[2] + math.pi / 2):
        for sign in (1.0, -1.0):
            for share in (1.0 + 1e-6, 1.0 - 1e-6):
                step = sign * share * depth
                moved = (b[0] + step * math.cos(psi), b[1] + step * math.sin(psi), *b[2:])
                area = polygon(*a).intersection(polygon(*moved)).area
                parted.append((share, area))
    assert min(area for share, area in parted if share > 1) <= 1e-12
    assert all(area > 0.0 for share, area in parted if share < 1)


@given(box, box)
def test_box_gap_is_symmetric(a: tuple, b: tuple) -> None:
    assert gap(a, b) == pytest.approx(gap(b, a), abs=1e-12)


@given(box, box, angle, st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_box_gap_is_invariant_to_rotation_and_translation(
    a: tuple, b: tuple, turn: float, east: float, north: float
) -> None:
    c, s = math.cos(turn), math.sin(turn)

    def moved(v: tuple) -> tuple:
        return (c * v[0] - s * v[1] + east, s * v[0] + c * v[1] + north, v[2] + turn, *v[3:])

    assert gap(moved(a), moved(b)) == pytest.approx(gap(a, b), abs=1e-10)


@given(box, box)
def test_box_gap_is_invariant_to_mirror_and_half_turn(a: tuple, b: tuple) -> None:
    def mirrored(v: tuple) -> tuple:
        return (v[0], -v[1], -v[2], *v[3:])

    turned = (*b[:2], b[2] + math.pi, *b[3:])
    quarter = (*b[:2], b[2] + math.pi / 2, b[4], b[3])
    assert gap(mirrored(a), mirrored(b)) == pytest.approx(gap(a, b), abs=1e-12)
    assert gap(a, turned) == pytest.approx(gap(a, b), abs=1e-10)
    assert gap(a, quarter) == pytest.approx(gap(a, b), abs=1e-10)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ((0, 0, 0, 4, 2), (7, 0, 0, 4, 2), 3.0),
        ((0, 0, 0, 4, 2), (4, 0, 0, 4, 2), 0.0),
        ((0, 0, 0, 4, 2), (3, 0, 0, 4, 2), -1.0),
        ((0, 0, 0, 4, 2), (0, 0, 0, 4, 2), -2.0),
        ((0, 0, 0, 4, 2), (7, 6, 0, 4, 2), 5.0),  # corner to corner: 3-4-5
        ((0, 0, 0, 2, 2), (4, 0, math.pi / 4, 2, 2), 3.0 - math.sqrt(2.0)),  # corner to side
        ((0, 0, 0, 10, 2), (0, 4, math.pi / 2, 4, 2), 1.0),
    ],
)
def test_box_gap_equals_closed_forms(a: tuple, b: tuple, expected: float) -> None:
    assert gap(a, b) == pytest.approx(expected, abs=1e-12)


def test_box_gap_broadcasts() -> None:
    x = np.linspace(-30.0, 30.0, 13)
    many = boxes(x[:, None], np.array([0.0, 3.0]), 0.2, 4.5, 1.8)
    one = boxes(1.0, 2.0, -0.4, 4.0, 2.0)
    gaps = box_gap(many, one)
    assert gaps.shape == (13, 2)
    for i in range(13):
        for j, y in enumerate((0.0, 3.0)):
            single = gap((x[i], y, 0.2, 4.5, 1.8), (1.0, 2.0, -0.4, 4.0, 2.0))
            assert gaps[i, j] == pytest.approx(single, rel=0.0, abs=1e-12)


@given(box)
def test_corners_are_counter_clockwise_from_front_left(a: tuple) -> None:
    x, y, psi, length, width = a
    corners = boxes(*a).corners()
    c, s = math.cos(psi), math.sin(psi)
    local = (corners - [x, y]) @ np.array([[c, -s], [s, c]])
    expected = 0.5 * np.array([[length, width], [-length, width], [-length, -width], [length, -width]])
    np.testing.assert_allclose(local, expected, atol=1e-12)


def test_corners_broadcast_mixed_shapes() -> None:
    many = Boxes(np.arange(3.0), np.zeros(3), np.zeros(3), np.array(4.0), np.array(2.0))
    assert many.corners().shape == (3, 4, 2)
    np.testing.assert_allclose(many.corners()[2, 0], [4.0, 1.0])
    moving = Boxes(np.arange(3.0), np.array(0.0), np.array(0.0), np.array(4.0), np.array(2.0))
    np.testing.assert_allclose(moving.corners(), many.corners())
    turning = Boxes(np.array(0.0), np.array(0.0), np.array([0.0, np.pi / 2]), np.array(4.0), np.array(2.0))
    np.testing.assert_allclose(turning.corners()[1, 0], [-1.0, 2.0], atol=1e-15)


def test_quintic_step_ends_without_slope_and_curvature() -> None:
    step = np.polynomial.Polynomial.fit(z := np.linspace(0.0, 1.0, 11), quintic_step(z, 2.0), 5, domain=[])
    np.testing.assert_allclose(step(np.array([0.0, 0.5, 1.0])), [0.0, 1.0, 2.0], atol=1e-9)
    for order in (1, 2):
        np.testing.assert_allclose(step.deriv(order)(np.array([0.0, 1.0])), 0.0, atol=1e-9)

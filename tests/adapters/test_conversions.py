"""Conversions of reference points, angles and axes, and motion by differences."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError, VehicleParams
from cca_core.adapters import (
    MotionDifferences,
    compass_to_heading,
    convert_reference,
    flip_axes,
    heading_to_compass,
    shift_point,
)
from cca_core.geometry import wrap_angle

CAR = VehicleParams(
    m=1500.0, I_z=2500.0, l_f=1.2, l_r=1.5, C_f=1e5, C_r=1e5, length=4.6, width=1.8, box_offset=0.1
)
POINTS = "front_bumper", "rear_axle", "center_of_gravity", "box_center"
coordinates = st.floats(-1e4, 1e4)
angles = st.floats(-math.pi, math.pi)


@pytest.mark.parametrize(
    ("point", "x"),
    [("front_bumper", 2.4), ("rear_axle", -1.5), ("center_of_gravity", 0.0), ("box_center", 0.1)],
)
def test_reference_point_has_its_distance_from_center_of_gravity(point: str, x: float) -> None:
    assert convert_reference(0.0, 0.0, 0.0, CAR, "center_of_gravity", point) == pytest.approx((x, 0.0))
    there = convert_reference(5.0, 7.0, 0.5 * math.pi, CAR, "center_of_gravity", point)
    assert there == pytest.approx((5.0, 7.0 + x))


@given(coordinates, coordinates, angles, st.sampled_from(POINTS), st.sampled_from(POINTS))
def test_reference_round_trip_returns(x: float, y: float, psi: float, source: str, target: str) -> None:
    there = convert_reference(x, y, psi, CAR, source, target)
    assert convert_reference(*there, psi, CAR, target, source) == pytest.approx((x, y), abs=1e-9)


@given(coordinates, coordinates, angles)
def test_box_center_equals_that_of_vehicle(x: float, y: float, psi: float) -> None:
    there = convert_reference(x, y, psi, CAR, "center_of_gravity", "box_center")
    assert there == pytest.approx(CAR.center_at(x, y, psi), abs=1e-9)


def test_unknown_reference_point_raises() -> None:
    with pytest.raises(InputError, match=r"target must be one of .*'box_center'.*, was 'hood'"):
        convert_reference(0.0, 0.0, 0.0, CAR, "front_bumper", "hood")


@given(coordinates, coordinates, angles, st.floats(-10.0, 10.0))
def test_shifted_point_is_ahead(x: float, y: float, psi: float, forward: float) -> None:
    there = shift_point(x, y, psi, forward)
    assert math.dist(there, (x, y)) == pytest.approx(abs(forward), abs=1e-9)
    assert shift_point(*there, psi, -forward) == pytest.approx((x, y), abs=1e-9)


@pytest.mark.parametrize(("compass", "heading"), [(0, 90), (90, 0), (180, -90), (270, -180), (315, 135)])
def test_compass_of_cardinal_points(compass: float, heading: float) -> None:
    assert math.degrees(compass_to_heading(compass)) == pytest.approx(heading)
    assert heading_to_compass(math.radians(heading)) == pytest.approx(compass)


@given(angles)
def test_compass_round_trip_returns(psi: float) -> None:
    compass = heading_to_compass(psi)
    assert 0.0 <= compass < 360.0
    assert wrap_angle(compass_to_heading(compass) - psi) == pytest.approx(0.0, abs=1e-9)


def test_compass_of_tiny_angle_stays_below_full_turn() -> None:
    assert heading_to_compass(0.5 * math.pi + 1e-17) == 0.0
    assert heading_to_compass(math.nextafter(0.5 * math.pi, 4.0)) < 360.0


@given(coordinates, coordinates, angles)
def test_axes_flipped_twice_are_the_same(x: float, y: float, psi: float) -> None:
    flipped = flip_axes(x, y, psi)
    assert flipped == (x, -y, -psi)
    assert flip_axes(*flipped) == (x, y, psi)


@pytest.mark.parametrize(
    ("axes", "convert"),
    [
        ("east, y north", lambda x, y, compass: (x, y, compass_to_heading(compass))),
        ("north, y east", lambda x, y, compass: flip_axes(x, y, math.radians(compass))),
    ],
)
@given(compass=st.floats(0.0, 360.0))
def test_compass_row_of_the_guide_turns_motion_into_heading(
    axes: str, convert: Callable[..., tuple[float, float, float]], compass: float
) -> None:
    """A vehicle that has driven straight on from the origin is in the direction of its heading."""
    rows = (Path(__file__).parents[2] / "docs" / "adapters.md").read_text(encoding="utf-8").splitlines()
    (row,) = [row for row in rows if row.startswith("| ") and f"x {axes}" in row]
    assert ("compass_to_heading" in row) == ("north" in axes[5:])
    assert ("`~cca_core.adapters.flip_axes`" in row) == ("east" in axes[5:])
    east, north = 9.0 * math.sin(math.radians(compass)), 9.0 * math.cos(math.radians(compass))
    x, y, psi = convert(*((east, north) if axes.startswith("east") else (north, east)), compass)
    assert (x, y) == pytest.approx((9.0 * math.cos(psi), 9.0 * math.sin(psi)))


@pytest.mark.parametrize("call", [compass_to_heading, heading_to_compass])
def test_infinite_angle_raises(call) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match="must be finite, was inf"):
        call(math.inf)


# --- motion by differences ----------------------------------------------------------------------------


@given(st.floats(-0.3, 0.3), st.floats(1.0, 40.0), st.floats(0.05, 0.3))
def test_circle_has_its_yaw_rate(r: float, v: float, dt: float) -> None:
    r = math.copysign(max(abs(r), 1e-3), r)
    motion = MotionDifferences(min_interval=dt)
    for k in range(6):
        psi = r * k * dt
        found = motion.update(k * dt, v / r * math.sin(psi), v / r * (1.0 - math.cos(psi)))
    assert found.r == pytest.approx(r, abs=1e-6)
    assert wrap_angle(found.psi - psi) == pytest.approx(0.0, abs=1e-6)
    assert found.v_x == pytest.approx(v, rel=0.01)  # a chord is shorter than its arc


def test_constant_acceleration_is_exact() -> None:
    motion = MotionDifferences()
    for k in range(5):
        t = 0.1 * k
        found = motion.update(t, 5.0 * t + t * t, 0.0)
    assert found == pytest.approx((0.0, 5.0 + 2.0 * t, 2.0, 0.0))


def test_reported_heading_and_speed_give_their_rates() -> None:
    motion = MotionDifferences()
    for k in range(3):
        found = motion.update(0.1 * k, 2.0 * k, 0.0, psi=3.1 + 0.05 * k, v_x=20.0 - 0.3 * k)
    assert found == pytest.approx((wrap_angle(3.2), 19.4, -3.0, 0.5))


def test_reversing_vehicle_has_negative_speed() -> None:
    motion = MotionDifferences()
    motion.update(0.0, 0.0, 0.0, psi=0.0)
    assert motion.update(0.1, -0.2, 0.0, psi=0.0).v_x == pytest.approx(-2.0)


def test_heading_is_held_at_standstill() -> None:
    motion = MotionDifferences()
    for k in range(4):
        motion.update(0.1 * k, 0.0, 1.5 * k)
    for k in range(4, 10):  # noise of a receiver, 1 cm
        found = motion.update(0.1 * k, 0.01 * (k % 2), 4.5)
        assert found.psi == pytest.approx(0.5 * math.pi)
        assert found.r == 0.0
    assert abs(found.v_x) < 0.5


def test_noisy_reported_heading_is_held_at_standstill() -> None:
    motion = MotionDifferences()
    motion.update(0.0, 0.0, 0.0, psi=0.3, v_x=0.0)
    assert motion.update(0.1, 0.0, 0.0, psi=0.5, v_x=0.1) == pytest.approx((0.3, 0.1, 1.0, 0.0))


def test_stopping_vehicle_decelerates_without_turning() -> None:
    motion = MotionDifferences()
    found = [motion.update(0.1 * k, 0.0, 0.0, psi=0.1 * k, v_x=max(2.0 - 0.6 * k, 0.0)) for k in range(5)]
    assert [each.r for each in found] == pytest.approx([0.0, 1.0, 1.0, 0.0, 0.0])
    assert found[3].a_x == pytest.approx(-6.0)


def test_corners_of_polyline_are_evened_out() -> None:
    """Segments of 5 m on a radius of 100 m: the heading jumps by 0.05 rad; 20 m even it out."""
    rough, even = MotionDifferences(), MotionDifferences(min_distance=20.0)
    rates = []
    for k in range(100):
        psi = 0.05 * (k // 5)  # 1 m in 0.1 s
        rates.append(
            (
                rough.update(0.1 * k, float(k), 0.0, psi, 10.0).r,
                even.update(0.1 * k, float(k), 0.0, psi, 10.0).r,
            )
        )
    assert max(rate for rate, _ in rates) == pytest.approx(0.5)
    assert [rate for _, rate in rates[50:]] == pytest.approx([0.1] * 50)


def test_samples_closer_than_interval_repeat_last_motion() -> None:
    motion = MotionDifferences()
    motion.update(0.0, 0.0, 0.0, psi=0.0, v_x=10.0)
    first = motion.update(0.1, 1.0, 0.0, psi=0.01, v_x=10.0)
    assert motion.update(0.1, 9.0, 9.0, psi=1.0, v_x=0.0) == first
    assert motion.update(0.15, 1.5, 0.0, psi=0.01, v_x=10.0) == first


def test_clock_set_back_begins_anew() -> None:
    motion = MotionDifferences()
    motion.update(5.0, 0.0, 0.0, psi=0.0, v_x=10.0)
    assert motion.update(1.0, 50.0, 0.0, psi=1.0, v_x=5.0) == (1.0, 5.0, 0.0, 0.0)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_pose_that_is_not_finite_repeats_last_motion(value: float) -> None:
    motion = MotionDifferences()
    motion.update(0.0, 0.0, 0.0, psi=0.2, v_x=10.0)
    assert motion.update(0.1, value, 0.0) == (0.2, 10.0, 0.0, 0.0)
    assert motion.update(0.2, 2.0, 0.0, psi=value) == (0.2, 10.0, 0.0, 0.0)


def test_interval_that_is_not_positive_raises() -> None:
    with pytest.raises(InputError, match="min_interval must be greater than 0, was 0"):
        MotionDifferences(min_interval=0.0)

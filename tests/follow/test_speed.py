"""Speed: arrival times, cruise, following and braking, in closed form and in simulation."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cca_core.errors import InputError
from cca_core.follow import (
    SpeedSettings,
    arrival_times,
    cacc_acceleration,
    cruise_acceleration,
    follow_acceleration,
    friction_limited,
    idm_acceleration,
    jerk_limited,
    profile_acceleration,
    required_deceleration,
    squared_speed_limit,
    stop_acceleration,
)
from cca_core.path import fit_path

S = SpeedSettings(a_max=2.0, b_comfort=1.5, b_max=7.0, standstill_gap=3.0, time_gap=1.5)  # not the defaults


# --- arrival times ------------------------------------------------------------------------------------


@given(st.floats(0.5, 40.0), st.floats(0.5, 40.0), st.floats(0.1, 400.0))
def test_arrival_times_equal_integration(v: float, target: float, distance: float) -> None:
    """ds/dt = v, dv/dt = the planned acceleration until the target speed: where is the ego at that time?"""
    t = float(arrival_times(v, target, np.array([distance]), S)[0])
    a = S.a_max if target > v else -S.b_comfort
    t_ramp = (target - v) / a
    found = 0.0
    for begin, end, speed0, slope in ((0.0, min(t, t_ramp), v, a), (t_ramp, max(t, t_ramp), target, 0.0)):
        if end > begin:
            run = solve_ivp(
                lambda tau, y, speed0=speed0, slope=slope, begin=begin: [speed0 + slope * (tau - begin)],
                (begin, end), [0.0], rtol=1e-10, atol=1e-10,
            )  # fmt: skip
            found += run.y[0, -1]
    assert found == pytest.approx(distance, rel=1e-7, abs=1e-7)


def test_arrival_times_equal_hand_values() -> None:
    np.testing.assert_allclose(arrival_times(10.0, 10.0, np.array([0.0, 50.0, -20.0]), S), [0.0, 5.0, -2.0])
    # 10 -> 20 m/s at 2 m/s^2: 75 m in 5 s, then 20 m/s
    np.testing.assert_allclose(arrival_times(10.0, 20.0, np.array([75.0, 115.0]), S), [5.0, 7.0], rtol=1e-12)
    # 20 -> 5 m/s at 1.5 m/s^2: 125 m in 10 s
    np.testing.assert_allclose(
        arrival_times(20.0, 5.0, np.array([125.0, 130.0]), S), [10.0, 11.0], rtol=1e-12
    )


@given(st.floats(0.0, 40.0), st.floats(0.0, 40.0))
def test_arrival_times_increase_from_standstill(v: float, target: float) -> None:
    t = arrival_times(v, target, np.linspace(-50.0, 300.0, 100), S)
    assert np.isfinite(t).all()
    assert (np.diff(t) > 0.0).all()


# --- cruise -------------------------------------------------------------------------------------------


@given(st.floats(0.0, 60.0), st.floats(0.0, 60.0))
def test_cruise_keeps_limits_and_direction(v: float, target: float) -> None:
    a = cruise_acceleration(v, target, S)
    assert -S.b_comfort <= a <= S.a_max
    assert a * (target - v) >= 0.0
    if target == v:
        assert a == 0.0


def test_cruise_saturates_and_converges() -> None:
    assert cruise_acceleration(0.0, 30.0, S) == S.a_max
    assert cruise_acceleration(40.0, 10.0, S) == -S.b_comfort
    v = 5.0
    for _ in range(3000):
        v += 0.01 * cruise_acceleration(v, 20.0, S)
    assert v == pytest.approx(20.0, abs=1e-3)


# --- required deceleration ----------------------------------------------------------------------------


def test_required_deceleration_equals_hand_values() -> None:
    g = S.standstill_gap
    assert required_deceleration(20.0, g + 40.0, 0.0, S) == pytest.approx(5.0)  # v^2 / 2 d
    assert required_deceleration(20.0, g + 25.0, 10.0, S) == pytest.approx(2.0)  # relative speed
    assert required_deceleration(10.0, g + 5.0, 10.0, S) == 0.0
    assert required_deceleration(10.0, g + 5.0, 12.0, S) == 0.0
    assert required_deceleration(20.0, g, 10.0, S) == math.inf
    assert required_deceleration(20.0, -1.0, 10.0, S) == math.inf
    # both at 20 m/s, the lead brakes at 4 m/s^2: its 50 m and 30 m of gap remain
    assert required_deceleration(20.0, g + 30.0, 20.0, S, a_lead=-4.0) == pytest.approx(400.0 / 160.0)
    assert required_deceleration(0.0, g + 1.0, 0.0, S) == 0.0


def min_gap(v: float, gap: float, v_lead: float, a_lead: float, b: float) -> float:
    """Least gap if the ego brakes at b; both brake to standstill, in closed form."""
    a = max(-a_lead, 0.0)
    t = np.linspace(0.0, v / b, 4001) if b > 0.0 else np.linspace(0.0, 60.0, 4001)
    ego = v * t - 0.5 * b * t * t
    t_lead = np.minimum(t, v_lead / a) if a > 0.0 and v_lead > 0.0 else t
    lead = v_lead * t_lead - 0.5 * (a if v_lead > 0.0 else 0.0) * t_lead**2
    return float((gap + lead - ego).min())


@given(st.floats(1.0, 40.0), st.floats(0.0, 40.0), st.floats(0.5, 150.0))
def test_required_deceleration_keeps_standstill_gap(v: float, v_lead: float, distance: float) -> None:
    """Lead at constant speed: the deceleration suffices, and nine tenths of it do not."""
    gap = S.standstill_gap + distance
    b = required_deceleration(v, gap, v_lead, S)
    assert min_gap(v, gap, v_lead, 0.0, b) >= S.standstill_gap - 1e-6 * max(distance, 1.0)
    if b > 1e-3:
        assert min_gap(v, gap, v_lead, 0.0, 0.9 * b) < S.standstill_gap


@given(st.floats(1.0, 40.0), st.floats(0.0, 40.0), st.floats(0.5, 150.0), st.floats(-9.0, -0.6))
@example(20.0, 10.0, 15.0, -1.0)
def test_required_deceleration_behind_braking_lead(
    v: float, v_lead: float, distance: float, a_lead: float
) -> None:
    """The least gap to a lead that brakes to standstill equals the standstill gap."""
    gap = S.standstill_gap + distance
    b = required_deceleration(v, gap, v_lead, S, a_lead)
    assert min_gap(v, gap, v_lead, a_lead, b) >= S.standstill_gap - 1e-3 * max(distance, 1.0)


@given(st.floats(1.0, 30.0), st.floats(-30.0, -0.1), st.floats(10.0, 200.0))
@example(20.0, -10.0, 100.0)
def test_required_deceleration_toward_oncoming_vehicle(v: float, v_lead: float, distance: float) -> None:
    """The gap to an oncoming vehicle is preserved until the ego stops."""
    gap = S.standstill_gap + distance
    b = required_deceleration(v, gap, v_lead, S)
    assert min_gap(v, gap, v_lead, 0.0, b) >= S.standstill_gap - 1e-3 * distance


# --- following ----------------------------------------------------------------------------------------


def follow(
    v: float, gap: float, lead: list[tuple[float, float]], seconds: float, lag: float = 0.0, dt: float = 0.02
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closed loop; `lead` is a list of (time, acceleration of the lead from then on)."""
    v_lead, a, out = lead[0][1], 0.0, []
    plan = lead[1:]
    for i in range(round(seconds / dt)):
        t = i * dt
        a_lead = next((rate for begin, rate in reversed(plan) if t >= begin), 0.0)
        if v_lead <= 0.0 and a_lead < 0.0:
            v_lead, a_lead = 0.0, 0.0
        target = min(follow_acceleration(v, gap, v_lead, S, a_lead), S.a_max)
        a += (target - a) * (dt / lag if lag > dt else 1.0)
        out.append((v, gap, a))
        v_next = max(v + a * dt, 0.0)
        gap += (v_lead + 0.5 * a_lead * dt - 0.5 * (v + v_next)) * dt
        v, v_lead = v_next, v_lead + a_lead * dt
    return tuple(np.array(out).T)  # type: ignore[return-value]


@pytest.mark.parametrize("v_lead", [0.0, 5.0, 12.0, 25.0])
@pytest.mark.parametrize(("v", "extra"), [(20.0, 150.0), (30.0, 250.0), (12.0, 30.0), (5.0, 60.0)])
@pytest.mark.parametrize("lag", [0.0, 0.1])
def test_following_converges_to_lead_speed_and_target_gap(
    v_lead: float, v: float, extra: float, lag: float
) -> None:
    target = S.standstill_gap + S.time_gap * v_lead
    speed, gap, a = follow(v, target + extra, [(0.0, v_lead)], 120.0, lag)
    assert speed[-1] == pytest.approx(v_lead, abs=0.02)
    assert gap[-1] == pytest.approx(target, abs=0.1)
    assert gap.min() >= target - 0.3  # no undershoot
    if required_deceleration(v, target + extra, v_lead, S) < 0.7 * S.b_comfort:
        assert a.min() >= -1.5 * S.b_comfort  # seen early, the approach is comfortable
    assert (np.diff(gap[len(gap) // 2 :]) <= 1e-3).all()  # and does not swing


@given(st.floats(0.0, 40.0), st.floats(3.1, 200.0), st.floats(0.1, 60.0), st.floats(0.0, 40.0))
def test_larger_gap_never_lowers_acceleration(v: float, gap: float, more: float, v_lead: float) -> None:
    near, far = (follow_acceleration(v, g, v_lead, S) for g in (gap, gap + more))
    assert far >= near - 1e-9


@given(st.floats(0.0, 40.0), st.floats(3.1, 200.0), st.floats(0.0, 20.0), st.floats(0.0, 40.0))
def test_faster_ego_never_accelerates_more(v: float, gap: float, faster: float, v_lead: float) -> None:
    assume(gap > S.standstill_gap)
    slow, fast = (follow_acceleration(w, gap, v_lead, S) for w in (v, v + faster))
    assert fast <= slow + 1e-9


@pytest.mark.parametrize("v_lead", [0.0, 8.0, 20.0])
def test_following_is_continuous_at_linear_range(v_lead: float) -> None:
    target = S.standstill_gap + S.time_gap * v_lead
    assert follow_acceleration(v_lead, target, v_lead, S) == pytest.approx(0.0, abs=1e-12)
    seam = target + S.b_comfort / 0.35**2
    for v in (v_lead, v_lead + 1.0):
        below, above = (follow_acceleration(v, seam + e, v_lead, S) for e in (-1e-7, 1e-7))
        assert below == pytest.approx(above, abs=1e-5)


@given(st.floats(0.0, 40.0), st.floats(-5.0, 200.0), st.floats(-20.0, 40.0), st.floats(-10.0, 3.0))
def test_follow_is_finite_and_not_below_b_max(v: float, gap: float, v_lead: float, a_lead: float) -> None:
    a = follow_acceleration(v, gap, v_lead, S, a_lead)
    assert math.isfinite(a)
    assert a >= -S.b_max


@pytest.mark.parametrize("gap", [S.standstill_gap + 1e-6, S.standstill_gap, S.standstill_gap - 1e-6])
def test_tiny_gap_error_needs_no_full_braking(gap: float) -> None:
    """Same speed, a hair inside the standstill gap: the result must not depend on the last digit."""
    calm = follow_acceleration(5.0, gap, 5.0, S)
    assert follow_acceleration(5.0 + 1e-6, gap, 5.0, S) == pytest.approx(calm, abs=0.1)


@pytest.mark.parametrize("brake", [-2.0, -4.0, -6.0])
@pytest.mark.parametrize("v", [10.0, 20.0, 30.0])
def test_lead_that_brakes_to_standstill_is_not_reached(brake: float, v: float) -> None:
    target = S.standstill_gap + S.time_gap * v
    speed, gap, a = follow(v, target, [(0.0, v), (2.0, brake)], 40.0, lag=0.1)
    assert gap.min() > 0.5 * S.standstill_gap
    assert speed[-1] < 0.05
    assert gap[-1] == pytest.approx(S.standstill_gap, abs=1.0)
    assert a.min() >= -S.b_max - 1e-9


@pytest.mark.parametrize("gap", [60.0, 45.0])
def test_late_stationary_obstacle_uses_full_brakes(gap: float) -> None:
    speed, left, a = follow(20.0, gap, [(0.0, 0.0)], 30.0, lag=0.1)
    assert left.min() > 0.5 * S.standstill_gap
    assert speed[-1] < 0.05
    assert a.min() >= -S.b_max


@pytest.mark.parametrize("name", SpeedSettings.__slots__)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, None])
def test_invalid_settings_raise(name: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"^{name} must be"):
        SpeedSettings(**{name: value})


# --- IDM, CACC, stopping, limits --------------------------------------------------------------------------


@given(st.floats(0.0, 25.0), st.floats(26.0, 40.0))
def test_idm_equilibrium(v: float, target: float) -> None:
    """At equal speeds the gap (s_0 + v T) / sqrt(1 - (v/v_0)^4) stays; more accelerates, less brakes."""
    gap = (S.standstill_gap + v * S.time_gap) / math.sqrt(1.0 - (v / target) ** 4)
    assert idm_acceleration(v, gap, v, target, S) == pytest.approx(0.0, abs=1e-9)
    assert idm_acceleration(v, 1.01 * gap, v, target, S) > 0.0
    assert idm_acceleration(v, 0.99 * gap, v, target, S) < 0.0


def test_idm_on_free_road_keeps_limits() -> None:
    assert idm_acceleration(0.0, 1e9, 0.0, 30.0, S) == pytest.approx(S.a_max)
    assert idm_acceleration(30.0, 1e9, 30.0, 30.0, S) == pytest.approx(0.0, abs=1e-9)
    assert idm_acceleration(30.0, 0.0, 0.0, 30.0, S) == -S.b_max
    assert math.isfinite(idm_acceleration(0.0, -5.0, 0.0, 0.0, S))


@given(st.floats(0.0, 35.0))
def test_cacc_equilibrium(v: float) -> None:
    gap = S.standstill_gap + S.time_gap * v
    assert cacc_acceleration(v, gap, v, 0.0, S) == pytest.approx(0.0, abs=1e-12)
    assert cacc_acceleration(v, gap, v, -1.0, S) == pytest.approx(-1.0)
    assert cacc_acceleration(v, -50.0, 0.0, -9.0, S) == -S.b_max
    assert cacc_acceleration(v, 1e6, 99.0, 0.0, S) == S.a_max


def test_cacc_platoon_is_string_stable() -> None:
    """Eight cars behind an oscillating lead: speed and gap of each oscillate less than those ahead."""
    dt, n = 0.02, 8
    speeds, a = np.full(n + 1, 20.0), np.zeros(n + 1)
    positions = -np.arange(n + 1) * (S.standstill_gap + S.time_gap * 20.0)
    swing = []
    for k in range(round(120.0 / dt)):
        a[0] = 0.5 * math.cos(0.3 * k * dt)
        for i in range(n, 0, -1):
            gap = positions[i - 1] - positions[i]
            target = cacc_acceleration(speeds[i], gap, speeds[i - 1], a[i - 1], S)
            a[i] += dt / 0.1 * (target - a[i])
        speeds += dt * a
        positions += dt * speeds
        swing.append(speeds.copy())
    width = np.ptp(np.array(swing)[round(60.0 / dt) :], axis=0)
    assert (np.diff(width) < 0.0).all()
    assert width[-1] < 0.9 * width[0]


@pytest.mark.parametrize("v", [3.0, 10.0, 20.0, 30.0])
@pytest.mark.parametrize("more", [1.0, 1.5, 4.0])
def test_ego_stops_at_point(v: float, more: float) -> None:
    """From one to four times the distance of comfort braking the ego stops within 0.1 m."""
    dt, position, distance = 0.005, 0.0, more * v * v / (2.0 * S.b_comfort)
    hardest = 0.0
    for _ in range(60_000):
        a = stop_acceleration(v, distance - position, S)
        hardest = min(hardest, a)
        position += dt * max(v + 0.5 * a * dt, 0.0)
        v = max(v + a * dt, 0.0)
        if v == 0.0:
            break
    assert v == 0.0
    assert position == pytest.approx(distance, abs=0.1)
    assert hardest > -1.5 * S.b_comfort or more == 1.0


def test_stop_behind_point_brakes_fully() -> None:
    assert stop_acceleration(5.0, -1.0, S) == -S.b_max
    assert stop_acceleration(5.0, 0.0, S) == -S.b_max
    assert stop_acceleration(0.0, 5.0, S) == 0.0
    assert stop_acceleration(5.0, 1e3, S) == S.a_max


@given(st.floats(-20.0, 20.0), st.floats(-9.0, 3.0), st.floats(0.001, 0.2), st.booleans())
def test_jerk_is_limited(target: float, previous: float, dt: float, emergency: bool) -> None:
    a = jerk_limited(target, previous, dt, S, emergency=emergency)
    jerk = S.jerk_emergency if emergency else S.jerk
    assert abs(a - previous) <= jerk * dt + 1e-12
    assert min(target, previous) - 1e-12 <= a <= max(target, previous) + 1e-12
    if abs(target - previous) <= jerk * dt:
        assert a == target


@given(st.floats(-20.0, 20.0), st.floats(-12.0, 12.0), st.floats(0.1, 1.2))
def test_limited_acceleration_is_in_friction_circle(a_x: float, a_y: float, mu: float) -> None:
    a = friction_limited(a_x, a_y, mu)
    left = math.sqrt(max((0.9 * mu * 9.81) ** 2 - a_y**2, 0.0))
    assert a == pytest.approx(math.copysign(min(abs(a_x), left), a_x), abs=1e-12)


@pytest.mark.parametrize("amplitude", [0.0, 5.0, 15.0])
def test_speed_limit_along_path_is_feasible(amplitude: float) -> None:
    """At most cruise speed and the limit of the curve; never falling faster than comfort braking."""
    x = np.arange(0.0, 801.0, 10.0)
    path = fit_path(np.column_stack((x, amplitude * np.sin(x / 40.0))), tolerance=0.05)
    s, squared = squared_speed_limit(path, 25.0, 2.5, S)
    on = s <= path.end
    assert (squared[on] <= 25.0**2 + 1e-9).all()
    assert (squared[on] * np.abs(path.curvature(s[on])) <= 2.5 + 1e-9).all()
    assert (np.diff(squared) >= -2.0 * S.b_comfort * np.diff(s) - 1e-6).all()
    assert np.interp(path.end, s, squared) == pytest.approx(0.0, abs=1e-9)
    tight = np.minimum(625.0, 2.5 / np.maximum(np.abs(path.curvature(s[on])), 1e-9))
    # where it is below both, it is because of a slower point ahead, exactly
    for i in np.flatnonzero(squared[on] < tight - 1e-6)[:-1]:
        assert squared[i + 1] - squared[i] == pytest.approx(-2.0 * S.b_comfort * (s[i + 1] - s[i]), rel=1e-6)


@pytest.mark.parametrize("profile", [([], []), ([0.0, 1.0], [1.0]), ([[0.0]], [[1.0]])])
def test_profile_without_two_equal_rows_raises(profile: tuple[object, object]) -> None:
    with pytest.raises(InputError, match="profile must be two rows of one length"):
        profile_acceleration(0.0, 10.0, profile, S)

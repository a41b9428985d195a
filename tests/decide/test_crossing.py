"""Crossing conflicts: scripted ones, and random ones against box sweeps in small time steps."""

import math
import os
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError, RemoteVehicle, VehicleParams
from cca_core.decide import Conflict, CrossingSettings, find_conflict
from cca_core.geometry import box_gap, boxes, wrap_angle
from cca_core.path import Path, interpolate_path
from tests.support.turns import quarter_turn

CAR = VehicleParams(
    m=1500.0, I_z=2500.0, l_f=1.2, l_r=1.4, C_f=1e5, C_r=1e5, length=4.5, width=1.8, box_offset=0.1
)
STRAIGHT = Path([-100.0, 300.0], [[[0, 0, 400, -100], [0, 0, 0, 0]]])
HORIZON = 8.0
ENCOUNTERS = 4000 if os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full" else 250


def car(x: float, y: float, psi: float, v: float, **more: Any) -> RemoteVehicle:
    return RemoteVehicle(id="A", x=x, y=y, psi=psi, v_x=v, **more)


def drive(path: Path, s: float, v: float, remote: RemoteVehicle, **more: Any) -> Conflict | None:
    return find_conflict(path, s, [s, s + 60.0 * v], [0.0, 60.0], CAR, remote, **more)


class TestScripted:
    def test_right_angle(self) -> None:
        found = drive(STRAIGHT, 0.0, 10.0, car(30.0, -40.0, math.pi / 2.0, 10.0))
        assert found is not None
        # bodies 1.8 m wide, 4.5 m long, clearance 0.3 m: +-3.45 m in s; samples add at most 1 m at each end
        assert 25.45 <= found.s_enter + 0.1 <= 26.55
        assert 33.45 <= found.s_exit + 0.1 <= 34.55
        assert found.distance == found.s_enter
        assert found.t_other_nominal == pytest.approx(((40 - 3.45) / 10.0, (40 + 3.45) / 10.0), abs=0.11)
        assert found.t_other[0] < found.t_other_nominal[0] < found.t_other_nominal[1] < found.t_other[1]
        assert found.t_ego == pytest.approx((found.s_enter / 10.0, found.s_exit / 10.0))
        assert not found.is_clear
        assert found.must_yield

    @pytest.mark.parametrize(
        ("y", "v", "before", "after"),
        [(-40.0, 10.0, False, False), (-80.0, 10.0, True, False), (-8.0, 15.0, False, True)],
    )
    def test_order_of_passing_follows_from_times(self, y: float, v: float, before: bool, after: bool) -> None:
        found = drive(
            STRAIGHT, 0.0, 10.0, car(30.0, y, math.pi / 2.0, v), settings=CrossingSettings(min_pet=0.5)
        )
        assert found is not None
        assert (found.ego_first, found.other_first, found.is_clear, found.must_yield) == (
            before, after, before or after, not (before or after),
        )  # fmt: skip

    def test_vehicle_that_may_stop_inside_has_no_exit_time(self) -> None:
        found = drive(STRAIGHT, 0.0, 10.0, car(30.0, -20.0, math.pi / 2.0, 8.0))
        assert found is not None
        assert found.t_other[1] == math.inf
        assert math.isfinite(found.t_other_nominal[1])

    def test_ego_inside_area_does_not_yield(self) -> None:
        found = drive(STRAIGHT, 28.0, 5.0, car(30.0, -15.0, math.pi / 2.0, 10.0))
        assert found is not None
        assert found.distance <= 0.0
        assert not found.must_yield

    def test_left_turn_across(self) -> None:
        path = quarter_turn()
        s = float(path.project((-20.0, 0.0))[0])
        found = drive(path, s, 6.0, car(60.0, 7.0, math.pi, 16.0))
        assert found is not None
        middle = path.position(0.5 * (found.s_enter + found.s_exit))
        assert middle[1] == pytest.approx(7.0, abs=2.0)
        assert found.distance > 20.0

    def test_turning_oncoming_vehicle_conflicts(self) -> None:
        # oncoming in the adjacent lane, turning left across the ego lane
        ahead = car(40.0, 3.5, math.pi, 6.0)
        assert drive(STRAIGHT, 0.0, 10.0, ahead) is None
        assert drive(STRAIGHT, 0.0, 10.0, replace(ahead, r=0.6)) is not None

    def test_uncertainty_widens_time_windows(self) -> None:
        remote = car(30.0, -40.0, math.pi / 2.0, 10.0)
        base = drive(STRAIGHT, 0.0, 10.0, remote)
        for more in ({"sigma_along": 1.0}, {"age": 0.5}, {"length": 9.0}):
            found = drive(STRAIGHT, 0.0, 10.0, replace(remote, **more))
            assert base is not None
            assert found is not None
            assert found.t_other[0] < base.t_other[0] - 0.05
            assert found.t_other[1] > base.t_other[1] + 0.05 or base.t_other[1] == math.inf
        wide = drive(STRAIGHT, 0.0, 10.0, replace(remote, sigma_across=1.0))
        assert wide is not None
        assert base is not None
        assert wide.s_enter == pytest.approx(base.s_enter - 2.0, abs=1.0)
        assert wide.s_exit == pytest.approx(base.s_exit + 2.0, abs=1.0)

    @pytest.mark.parametrize(
        "remote",
        [
            car(30.0, 0.0, 0.0, 5.0),
            car(30.0, 3.5, 0.1, 15.0),
            car(-30.0, 0.0, 0.0, 20.0),
            car(60.0, 0.0, math.pi, 20.0),
            car(60.0, 3.5, math.pi - 0.1, 20.0),
            car(20.0, 1.0, 0.3, 8.0),
            car(30.0, -400.0, math.pi / 2.0, 10.0),
            car(30.0, 10.0, math.pi / 2.0, 10.0),
            car(-20.0, -40.0, math.pi / 2.0, 10.0),
            car(30.0, -10.0, math.pi / 2.0, 0.3),
            car(30.0, math.nan, math.pi / 2.0, 10.0),
        ],
        ids=(
            "lead", "adjacent", "behind", "head-on", "oncoming", "merging", "too far", "gone",
            "crosses behind", "stationary", "not a number",
        ),
    )  # fmt: skip
    def test_no_conflict(self, remote: RemoteVehicle) -> None:
        assert drive(STRAIGHT, 0.0, 10.0, remote) is None

    @pytest.mark.parametrize("radius", [20.0, 100.0, 500.0])
    @pytest.mark.parametrize("sign", [1.0, -1.0])
    @pytest.mark.parametrize("d", [-3.5, 0.0, 3.5])
    @pytest.mark.parametrize("direction", [1.0, -1.0])
    def test_parallel_traffic_on_curve_has_no_conflict(
        self, radius: float, sign: float, d: float, direction: float
    ) -> None:
        phi = np.arange(-1.5, 1.5, 2.0 / radius)
        xy = radius * np.column_stack((np.sin(phi), sign * (1.0 - np.cos(phi))))
        path, v = interpolate_path(xy), math.sqrt(2.0 * radius)
        for s in np.linspace(0.3, 0.6, 4) * path.length:
            for ahead in np.linspace(-0.2, 0.3, 6) * path.length:
                x, y = path.to_cartesian(s + ahead, d).tolist()
                psi, kappa = float(path.heading(s + ahead)), path.curvature_at(s + ahead)
                r = direction * v * kappa / (1.0 - d * kappa)
                remote = car(x, y, psi + (0.0 if direction > 0.0 else math.pi), v, r=r)
                assert drive(path, float(s), v, remote, horizon=2.0) is None

    @pytest.mark.parametrize("d", [-3.5, 3.5])
    @pytest.mark.parametrize("direction", [1.0, -1.0])
    def test_parallel_traffic_before_wide_curve_has_no_conflict(self, d: float, direction: float) -> None:
        """The vehicle does not turn yet; straight ahead it would cross the ego lane at a small angle."""
        path = quarter_turn(100.0, before=100.0)
        for ahead in (5.0, 20.0, 40.0):
            s = 40.0 if direction > 0.0 else 160.0
            x, y = path.to_cartesian(s + ahead, d).tolist()
            psi = float(path.heading(s + ahead)) + (0.0 if direction > 0.0 else math.pi)
            assert drive(path, 40.0, 14.0, car(x, y, psi, 14.0), horizon=6.0) is None


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"s": math.nan}, "s"),
        ({"stations": [0.0]}, "stations"),
        ({"times": [1.0, 0.0]}, "increase"),
        ({"stations": [1.0, 0.0]}, "increase"),
        ({"stations": [0.0, math.inf]}, "stations"),
        ({"horizon": 0.0}, "horizon"),
    ],
)
def test_invalid_arguments_raise(changes: dict[str, Any], named: str) -> None:
    good = {
        "path": STRAIGHT, "s": 0.0, "stations": [0.0, 100.0], "times": [0.0, 10.0], "vehicle": CAR,
        "remote": car(30.0, -40.0, math.pi / 2.0, 10.0),
    }  # fmt: skip
    with pytest.raises(InputError, match=named):
        find_conflict(**{**good, **changes})


@pytest.mark.parametrize("changes", [{"a_max": -1.0}, {"min_pet": math.nan}, {"min_angle": 2.0}])
def test_invalid_settings_raise(changes: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(changes))):
        CrossingSettings(**changes)


def curve(rng: np.random.Generator) -> Path:
    """Path along +x at first with curvature up to 1/10 m that changes smoothly."""
    s = np.arange(0.0, 120.0, 2.0)
    peak = rng.choice([0.0, rng.uniform(-0.1, 0.1)])
    middle, width = rng.uniform(10.0, 60.0), rng.uniform(8.0, 20.0)
    psi = np.cumsum(peak * np.exp(-(((s - middle) / width) ** 2)) * 2.0)
    psi = np.clip(psi, -1.8, 1.8)
    return interpolate_path(np.column_stack((np.cumsum(np.cos(psi)) * 2.0, np.cumsum(np.sin(psi)) * 2.0)))


def positions(remote: RemoteVehicle, u: Any) -> tuple[Any, Any, Any]:
    """Pose of a vehicle after `u` meters: straight, or around a corner and then straight, by summation."""
    step = 0.02
    grid = np.arange(0.0, float(u.max()) + 2.0 * step, step)
    kappa = remote.r / max(remote.v_x, 1.0)
    turned = np.clip(kappa * (grid + 0.5 * step), -math.pi / 2.0, math.pi / 2.0)
    psi = remote.psi + turned
    x = remote.x + np.concatenate(([0.0], np.cumsum(np.cos(psi))[:-1] * step))
    y = remote.y + np.concatenate(([0.0], np.cumsum(np.sin(psi))[:-1] * step))
    heading = remote.psi + np.clip(kappa * u, -math.pi / 2.0, math.pi / 2.0)
    return np.interp(u, grid, x), np.interp(u, grid, y), heading


def traveled(v: float, a: float, t: Any) -> Any:
    until = np.minimum(t, -v / a) if a < 0.0 else t
    return v * until + 0.5 * a * until**2


def encounter(rng: np.random.Generator) -> tuple[Path, float, Any, Any, RemoteVehicle]:
    """An ego with a random speed profile, and a vehicle aimed at a point of the path of the ego."""
    path, s = curve(rng), float(rng.uniform(0.0, 15.0))
    v, a = rng.uniform(2.0, 15.0), rng.uniform(-1.0, 2.0)
    times = np.arange(0.0, 12.0, 0.5)
    stations = s + traveled(v, a, times)
    increasing = np.concatenate(([True], np.diff(stations) > 1e-6))
    stations, times = stations[increasing], times[increasing]
    target_s = rng.uniform(s, min(float(stations[-1]), 110.0))
    target, heading = path.position(target_s), float(path.heading(target_s))
    angle = heading + rng.choice([-1.0, 1.0]) * rng.uniform(0.6, 2.5)
    speed = rng.uniform(1.0, 20.0)
    # straight back from the target, for a random time of arrival; then turned by its own arc
    back = speed * rng.uniform(0.0, 7.0)
    kappa = rng.choice([0.0, rng.uniform(-0.08, 0.08)])
    kappa = 0.0 if abs(kappa) < 2e-3 else kappa
    start = car(0.0, 0.0, 0.0, speed, r=kappa * speed)
    x, y, turned = (float(q[0]) for q in positions(start, np.array([back])))
    psi = float(wrap_angle(angle - turned))
    c, k = math.cos(psi), math.sin(psi)
    remote = replace(
        start, x=target[0] - c * x + k * y, y=target[1] - k * x - c * y, psi=psi,
        length=rng.uniform(3.0, 15.0), width=rng.uniform(1.5, 2.6),
        age=rng.choice([0.0, rng.uniform(0.0, 1.0)]), sigma_along=rng.uniform(0.0, 1.0),
        sigma_across=rng.uniform(0.0, 0.5),
    )  # fmt: skip
    return path, s, stations, times, remote


def sweep_gaps(
    path: Path, stations: Any, times: Any, remote: RemoteVehicle, a: float, late: float, shift: float
) -> tuple[Any, Any, Any, Any]:
    """Gap between the bodies over time, angle between their headings, station, time.

    The vehicle has accelerated by `a` since its message, and is off by `shift` (of two standard deviations).
    """
    t = np.arange(0.0, min(HORIZON, float(times[-1])), 0.02)
    s = np.interp(t, times, stations)
    point, psi = path.position(s), path.heading(s)
    v = max(remote.v_x + a * late, 0.0)
    u = traveled(v, a, t) + 0.5 * a * late**2 + shift * 2.0 * remote.sigma_along
    x, y, heading = positions(remote, np.maximum(u, 0.0))
    x, y = x + np.minimum(u, 0.0) * np.cos(remote.psi), y + np.minimum(u, 0.0) * np.sin(remote.psi)
    across = shift * 2.0 * remote.sigma_across
    x, y = x - across * np.sin(heading), y + across * np.cos(heading)
    ego = CAR.body_at(point[:, 0], point[:, 1], psi)
    return (
        box_gap(ego, boxes(x, y, heading, remote.length, remote.width)),
        np.abs(np.sin(heading - psi)),
        s,
        t,
    )


def test_random_conflicts_cover_every_box_overlap() -> None:
    rng = np.random.default_rng(2024)
    settings = CrossingSettings(min_pet=0.0, clearance=0.0)
    met = free = conflicts = 0
    for _ in range(ENCOUNTERS):
        path, s, stations, times, remote = encounter(rng)
        found = find_conflict(path, s, stations, times, CAR, remote, horizon=HORIZON, settings=settings)
        conflicts += found is not None
        free += found is not None and found.is_clear
        for a in np.linspace(-settings.b_max, settings.a_max, 5):
            shift, late = rng.choice([-1.0, 1.0, rng.uniform(-1.0, 1.0)]), remote.age * rng.choice([0.5, 1.0])
            gap, sine, at, t = sweep_gaps(path, stations, times, remote, float(a), late, shift)
            overlap = (gap < 0.0) & (sine > math.sin(settings.min_angle))
            if not overlap.any():
                continue
            met += 1
            assert found is not None
            assert not found.is_clear
            overlap = gap < 0.0
            assert found.s_enter <= at[overlap].min()
            assert found.s_exit >= at[overlap].max()
            assert found.t_ego[0] <= t[overlap].min() + 1e-6
            assert found.t_ego[1] >= t[overlap].max() - 1e-6
            assert found.t_other[0] <= t[overlap].min() + 1e-6
            assert found.t_other[1] >= t[overlap].max() - 1e-6
    assert met > ENCOUNTERS // 5
    assert conflicts > ENCOUNTERS // 3
    assert free > ENCOUNTERS // 50


def test_conflict_area_exceeds_sweep_by_3_m_only() -> None:
    """Reports are exact and speeds constant here."""
    rng = np.random.default_rng(5)
    settings = CrossingSettings(min_pet=0.0, clearance=0.0, a_max=0.0, b_max=0.0)
    for _ in range(12):
        angle = rng.uniform(0.7, math.pi - 0.7)
        remote = car(60.0 - 40.0 * math.cos(angle), -40.0 * math.sin(angle), angle, 10.0)
        found = drive(STRAIGHT, 0.0, 12.0, remote, settings=settings)
        assert found is not None
        s = np.arange(40.0, 80.0, 0.2)
        u = np.arange(20.0, 60.0, 0.2)[:, None]
        ego = CAR.body_at(s, 0.0, 0.0)
        x, y = remote.x + u * math.cos(angle), remote.y + u * math.sin(angle)
        overlap = box_gap(ego, boxes(x, y, angle, remote.length, remote.width)) < 0.0
        reached, reached_other = s[overlap.any(axis=0)], u[overlap.any(axis=1), 0]
        assert found.s_enter <= reached.min()
        assert found.s_exit >= reached.max()
        assert found.s_exit - found.s_enter <= np.ptp(reached) + 3.0
        assert found.t_other_nominal[1] - found.t_other_nominal[0] <= (np.ptp(reached_other) + 3.0) / 10.0


@given(
    st.integers(0, 10_000), st.floats(-3.1, 3.1), st.floats(-500.0, 500.0), st.sampled_from([1.0, -1.0])
)  # fmt: skip
def test_conflict_is_invariant_to_rotation_shift_mirror(
    seed: int, angle: float, shift: float, mirror: float
) -> None:
    path, s, stations, times, remote = encounter(np.random.default_rng(seed))
    found = find_conflict(path, s, stations, times, CAR, remote)
    c, k = math.cos(angle), math.sin(angle)
    turned = np.array([[c, -k], [k, c]])
    coefficients = np.einsum("ij,njk->nik", turned @ np.diag([1.0, mirror]), path.coefficients)
    coefficients[:, :, 3] += shift
    x, y = turned @ (remote.x, mirror * remote.y) + shift
    other = replace(remote, x=float(x), y=float(y), psi=mirror * remote.psi + angle, r=mirror * remote.r)
    again = find_conflict(Path(path.breaks, coefficients), s, stations, times, CAR, other)
    assert (found is None) == (again is None)
    if found is not None and again is not None:
        for name in ("s_enter", "s_exit", "distance", "t_ego", "t_other", "t_other_nominal"):
            # a body that only just overlapes a sample may do so or not
            assert getattr(again, name) == pytest.approx(getattr(found, name), abs=1e-6)

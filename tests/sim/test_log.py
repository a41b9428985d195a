"""Metrics of a log against shapely and plain loops."""

import json
import math
from collections.abc import Callable

import numpy as np
import pytest

from cca_core.sim import Log, eebl, simulate

Run = Callable[..., Log]


def test_repr_is_one_line() -> None:
    log = simulate(eebl("A"))
    assert repr(log) == f"Log(eebl A, driver, single_track, seed 1, {log.t[-1]:.2f} s, collision with yellow)"


def test_gaps_equal_shapely(run: Run) -> None:
    shapely = pytest.importorskip("shapely")
    affinity = pytest.importorskip("shapely.affinity")

    def rectangle(x: float, y: float, psi: float, length: float, width: float) -> "shapely.Polygon":
        box = shapely.box(-0.5 * length, -0.5 * width, 0.5 * length, 0.5 * width)
        return affinity.translate(affinity.rotate(box, psi, origin=(0, 0), use_radians=True), x, y)

    for log in (run("1-fast", "curved", 1), run("3", "straight", 1, lead_only=True)):
        vehicle, gaps = log.scenario.vehicle, log.gaps()
        assert gaps.shape == (len(log.t), len(log.scenario.road_users))
        for k in [*range(0, len(log.t), 17), int(gaps.min(axis=1).argmin())]:
            x, y, psi = log.ego[k, :3]
            ego = rectangle(
                x + vehicle.box_offset * math.cos(psi), y + vehicle.box_offset * math.sin(psi), psi,
                vehicle.length, vehicle.width,
            )  # fmt: skip
            for i, user in enumerate(log.scenario.road_users):
                other = rectangle(*log.road_users[k, i, :3], user.length, user.width)
                distance = ego.distance(other)
                if distance > 0.0:
                    assert gaps[k, i] == pytest.approx(distance, abs=1e-9)
                else:
                    assert gaps[k, i] <= 0.0
                    assert ego.intersects(other)


def test_run_ends_at_first_collision(run: Run) -> None:
    gaps = run("2", lead_only=True).gaps().min(axis=1)
    assert gaps[-1] <= 0.0
    assert (gaps[:-1] > 0.0).all()


def test_time_to_collision_of_straight_approach(run: Run) -> None:
    """Before the first maneuver everything is one-dimensional."""
    log = run("1-smooth", "straight", 1)
    ttc = log.time_to_collision()
    for k in range(0, int(3.5 / 0.02), 10):
        gap = log.user_frenet[k, 0, 0] - log.ego_frenet[k, 0] - 0.5 * (4.5 + log.scenario.vehicle.length)
        assert ttc[k] == pytest.approx(gap / (log.ego[k, 3] - 12.0))
    assert ttc.shape == log.t.shape


def test_time_to_collision_equals_plain_loops(run: Run) -> None:
    log = run("3", "curved", 1, lead_only=True)
    ttc = log.time_to_collision()
    for k in range(0, len(log.t), 13):
        shortest = math.inf
        for i, user in enumerate(log.scenario.road_users):
            s, d = log.user_frenet[k, i]
            if abs(d - log.ego_frenet[k, 1]) >= 0.5 * (user.width + log.scenario.vehicle.width):
                continue
            reach = 0.5 * (user.length + log.scenario.vehicle.length)
            closing = log.ego[k, 3] - user.direction * log.road_users[k, i, 3]
            if s > log.ego_frenet[k, 0] + reach and closing > 0.1:
                shortest = min(shortest, (s - log.ego_frenet[k, 0] - reach) / closing)
            if s < log.ego_frenet[k, 0] - reach and closing < -0.1:
                shortest = min(shortest, (log.ego_frenet[k, 0] - s - reach) / -closing)
        assert ttc[k] == pytest.approx(shortest)


def test_time_to_collision_reaches_zero_at_collision(run: Run) -> None:
    ttc = run("3", lead_only=True).time_to_collision()
    assert ttc[-3:-1].max() < 0.15
    assert ttc.min() >= 0.0


def test_ego_frenet_and_tracking_are_lateral_errors(run: Run) -> None:
    log = run("1-fast", "curved", 1)
    _, d = log.scenario.road.path.project(log.ego[:, :2])
    assert d == pytest.approx(log.ego_frenet[:, 1], abs=1e-6)
    # outside a maneuver the reference is the route
    assert log.tracking[:100] == pytest.approx(log.ego_frenet[:100, 1], abs=1e-9)


def test_summary_equals_arrays(run: Run) -> None:
    log = run("2")
    summary = log.summary()
    expected = {
        "min_gap_m": log.gaps().min(),
        "min_ttc_s": log.time_to_collision().min(),
        "max_abs_ay_mps2": np.abs(log.a_y).max(),
        "max_decel_mps2": -log.ego[:, 7].min(),
        "max_tracking_error_m": np.abs(log.tracking).max(),
        "max_offset_m": np.abs(log.ego_frenet[:, 1]).max(),
        "duration_s": 38.0,
    }
    for name, value in expected.items():
        assert summary[name] == pytest.approx(float(value), abs=6e-4), name
    assert summary["actions"] == [[round(t, 2), name] for t, name, _ in log.decisions]
    times = [t for t, _, _ in log.decisions]
    evading = sum(
        end - t
        for (t, name, _), end in zip(log.decisions, [*times[1:], 38.0], strict=True)
        if name.startswith("EVADE")
    )
    assert summary["evading_s"] == pytest.approx(evading, abs=0.05)
    assert (summary["scenario"], summary["case"], summary["v2v"]) == ("maneuver", "2", True)
    assert (summary["plant"], summary["seed"], summary["collided_with"]) == ("single_track", 1, None)


def test_summary_is_json_with_documented_fields(run: Run) -> None:
    for log in (run("2"), run("2", lead_only=True), run("1-fast", "curved")):
        text = json.dumps(log.summary(), allow_nan=False)
        assert set(json.loads(text)) >= {
            "scenario", "case", "v2v", "plant", "seed", "collided", "collided_with", "min_gap_m", "min_ttc_s",
            "max_abs_ay_mps2", "max_decel_mps2", "max_tracking_error_m", "actions", "duration_s",
            "realtime_factor", "cycle_us",
        }  # fmt: skip
        assert set(json.loads(text)["cycle_us"]) == {"median", "p99", "max"}

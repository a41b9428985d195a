"""Stale tracks, deletion, capacity and eviction."""

import math

import numpy as np
import pytest

from cca_core import VehicleState
from cca_core.v2x import Tracker, TrackerSettings
from tests.support.v2x_messages import FRAME, T0, bsm, feed


def test_stale_track_is_kept_while_ego_brakes() -> None:
    """The ego may accelerate again; a stale vehicle may be at its last position."""
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)
    for k in range(1, 81):
        v = max(20.0 - 0.5 * k, 0.0)
        ego = VehicleState(x=-30.0 + 40.0 * (1.0 - v / 20.0), y=0.0, psi=0.0, v_x=v)
        assert len(tracker.vehicles(t + 0.1 * k, ego)) == 1


def test_stale_track_is_deleted_out_of_reach() -> None:
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)  # at 20 m, drives away from the ego behind
    ego = VehicleState(x=-30.0, y=0.0, psi=0.0, v_x=10.0)
    bounds = []
    for k in range(1, 300):
        vehicles = tracker.vehicles(t + 0.1 * k, ego)
        if not vehicles:
            break
        bounds.append(2.0 * vehicles[0].sigma_along)
    assert np.all(np.diff(bounds) >= 0.0)
    assert len(bounds) >= 10
    assert len(bounds) < 40
    assert len(tracker) == 0


def test_nearby_stale_track_is_kept() -> None:
    tracker = Tracker(FRAME, TrackerSettings(delete_after=12.0))
    t = feed(tracker, 1.0)
    for k in range(1, 120):
        ego = VehicleState(x=20.0 + 2.0 * k, y=3.5, psi=0.0, v_x=20.0)
        (vehicle,) = tracker.vehicles(t + 0.1 * k, ego)
        assert vehicle.invalid_reason is None
    assert tracker.vehicles(t + 12.1, ego) == ()


@pytest.mark.parametrize(("psi", "kept"), [(math.pi, True), (0.0, False)], ids=["nearer", "farther"])
def test_approaching_stale_track_is_kept(psi: float, kept: bool) -> None:
    """Stale for 1 s 250 m ahead: an oncoming car arrives when the maneuver would end."""
    tracker, ego = Tracker(FRAME), VehicleState(x=0.0, y=0.0, psi=0.0, v_x=15.0)
    assert tracker.update(bsm(T0, 250.0, 3.5, psi=psi), T0 + 0.02).accepted
    assert len(tracker.vehicles(T0 + 2.0, ego)) == kept


def test_capacity_limit_under_sender_flood() -> None:
    """The closest 200 senders are kept."""
    tracker = Tracker(FRAME, TrackerSettings(retention_range=1000.0))
    ego = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0)
    tracker.vehicles(T0, ego)
    order = np.random.default_rng(3).permutation(1000)
    for k in range(3):
        for i in order.tolist():
            tracker.update(bsm(T0 + 0.1 * k, 4.8 * i + 20.0 + 2.0 * k, id=f"{i:08x}"), T0 + 0.1 * k)
    vehicles = tracker.vehicles(T0 + 0.3, ego)
    assert len(vehicles) == len(tracker) == 200
    assert {v.id for v in vehicles} == {f"{i:08x}" for i in range(200)}
    assert tracker.is_saturated(T0 + 0.3)
    assert not tracker.is_saturated(T0 + 2.0)
    assert tracker.counts["full"] > 0
    assert len(tracker.dropped) == 100


def flood(seconds: float, x: float, max_tracks: int = 20) -> tuple[Tracker, float]:
    """Feed a tracker a car ahead of the ego for some time, then a flood of closer senders."""
    tracker = Tracker(FRAME, TrackerSettings(max_tracks=max_tracks))
    ego = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0)
    tracker.vehicles(T0, ego)
    t = T0
    for k in range(round(10 * seconds) + 20):
        t = T0 + 0.1 * k
        tracker.update(bsm(t, x, v=0.0), t)
        if k > 10 * seconds:
            for i in range(60):
                tracker.update(bsm(t, 3.0 + i % 10, 5.0 + 5.0 * (i // 10), v=0.0, id=f"{16 + i:08x}"), t)
    return tracker, t


def test_flood_keeps_confirmed_tracks() -> None:
    tracker, t = flood(0.5, 200.0)
    assert "00000001" in {v.id for v in tracker.vehicles(t)}
    assert len(tracker) == 20
    assert tracker.is_saturated(t)


def test_flood_evicts_distant_tracks() -> None:
    """A confirmed track beyond the retention range can be evicted."""
    tracker, t = flood(0.5, 400.0)
    assert "00000001" not in {v.id for v in tracker.vehicles(t)}


def test_distant_rejected_senders_do_not_saturate() -> None:
    tracker = Tracker(FRAME, TrackerSettings(max_tracks=3))
    tracker.vehicles(T0, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0))
    results = [tracker.update(bsm(T0, 200.0 * i, id=f"{i:08x}"), T0).kind for i in range(5)]
    assert results == ["new"] * 3 + ["full"] * 2
    assert not tracker.is_saturated(T0)
    assert tracker.update(bsm(T0, 100.0, id="0000beef"), T0).kind == "new"  # evicts the one at 400 m
    assert not tracker.is_saturated(T0)
    assert tracker.update(bsm(T0, 150.0, id="0000cafe"), T0).kind == "new"  # evicts the one at 200 m
    assert tracker.is_saturated(T0)


def test_overlapping_positions_are_rejected() -> None:
    """Bodies have a minimum size, whatever they report: in a crowd they overlap."""
    tracker = Tracker(FRAME)
    rng = np.random.default_rng(2)
    for i in range(200):
        x, y = rng.uniform(0.0, 5.0, 2)
        tracker.update(bsm(T0, x, y, v=0.0, id=f"{i:08x}", length=0.3, width=0.3), T0)
    assert tracker.counts["overlap"] > 150
    assert len(tracker) < 5.0 * 5.0 / (1.5 * 0.8) * 2.0


def test_full_tracker_without_ego_rejects_senders() -> None:
    tracker = Tracker(FRAME, TrackerSettings(max_tracks=3))
    results = [tracker.update(bsm(T0, 30.0 * i, id=f"{i:08x}"), T0).kind for i in range(4)]
    assert results == ["new"] * 3 + ["full"]

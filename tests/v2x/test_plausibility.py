"""Plausibility: each check rejects its case, can be switched off, and accepts honest senders."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError
from cca_core.v2x import PLAUSIBILITY_CHECKS, Bsm, PlausibilitySettings, Tracker, TrackerSettings
from tests.support.v2x_messages import FRAME, T0, bsm


def fed(checks: PlausibilitySettings | None = None) -> Tracker:
    """Tracker of a car received for one second; it is at 20 m at T0 + 1 s."""
    tracker = Tracker(FRAME, TrackerSettings(plausibility=checks or PlausibilitySettings()))
    for k in range(11):
        assert tracker.update(bsm(T0 + 0.1 * k, 2.0 * k), T0 + 0.1 * k + 0.02).accepted
    return tracker


NEXT = T0 + 1.1
FALSE: dict[str, tuple[Bsm, float]] = {
    "replay": (bsm(NEXT, 22.0), NEXT + 1.5),
    "future": (bsm(NEXT + 0.4, 28.0), NEXT),
    "size": (bsm(NEXT, 22.0, length=41.0), NEXT),
    "frozen": (bsm(NEXT, 20.0), NEXT),
    "teleport": (bsm(NEXT, 122.0), NEXT),
    "displacement": (bsm(NEXT, 22.0, 15.0), NEXT),
    "acceleration": (bsm(NEXT, 22.0, speed=30.0), NEXT),
    "yaw": (bsm(NEXT, 22.0, psi=0.8), NEXT),
    "overlap": (bsm(NEXT, 23.0, id="00000bad"), NEXT),
}


@pytest.mark.parametrize("check", PLAUSIBILITY_CHECKS)
def test_check_rejects_its_case(check: str) -> None:
    message, t = FALSE[check]
    tracker = fed()
    before = tracker.vehicles(t)
    result = tracker.update(message, t)
    assert (result.accepted, result.kind, result.t) == (False, check, t)
    assert tracker.counts[check] == 1
    assert tracker.dropped == (result,)
    moved = [(v.x, v.y, v.psi, v.v_x, v.age, v.sigma_along, v.sigma_across) for v in tracker.vehicles(t)]
    expected = [(v.x, v.y, v.psi, v.v_x, v.age, v.sigma_along, v.sigma_across) for v in before]
    np.testing.assert_allclose(moved, expected, atol=1e-9)


@pytest.mark.parametrize("check", PLAUSIBILITY_CHECKS)
def test_check_can_be_switched_off(check: str) -> None:
    message, t = FALSE[check]
    off = {check: False} | ({"displacement": False} if check == "teleport" else {})
    assert fed(PlausibilitySettings(**off)).update(message, t).accepted


@pytest.mark.parametrize("values", [{"a_x": 15.0}, {"a_x": -15.0}, {"r": 1.0}, {"r": -1.0}])
def test_impossible_values_are_rejected(values: dict[str, float]) -> None:
    assert fed().update(bsm(NEXT, 22.0, **values), NEXT).kind in ("acceleration", "yaw")


@pytest.mark.parametrize(
    "values", [{"frozen": 1}, {"position_tolerance": 0.0}, {"max_acceleration": math.nan}]
)
def test_invalid_settings_raise(values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(values))):
        PlausibilitySettings(**values)


@pytest.mark.parametrize("missing", [("speed",), ("speed", "psi"), ("psi",)], ids="+".join)
@pytest.mark.parametrize("braking", [1.0, 4.0, 8.0])
@pytest.mark.parametrize("v", [3.0, 10.0, 25.0])
def test_stopping_sender_with_missing_motion_is_accepted(
    missing: tuple[str, ...], braking: float, v: float
) -> None:
    """A constant position cannot contradict a speed that was found from positions; it drives on later."""
    for noise, gear in ((0.0, "forward"), (0.05, None), (0.3, "forward"), (0.3, None)):
        tracker, rng, x, speed = Tracker(FRAME), np.random.default_rng(1), 0.0, v
        stop, kinds = 20 + math.ceil(10.0 * v / braking), []
        for k in range(stop + 90):
            speed = max(speed - 0.1 * braking * (k > 20), 0.0) if k < stop + 50 else min(speed + 0.2, 5.0)
            x += 0.1 * speed
            values = {"speed": speed, "transmission": gear} | dict.fromkeys(missing)
            position = rng.normal((x, 0.0), noise)
            kinds.append(tracker.update(bsm(T0 + 0.1 * k, *position, **values), T0 + 0.1 * k + 0.02).kind)
        assert kinds.count("frozen") == 0, (noise, gear)
        assert set(kinds[-30:]) == {"updated"}, (noise, gear)


@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.5, 1.0]))
def test_honest_senders_are_accepted(seed: int, noise: float) -> None:
    """Stopping, starting and turning with noise: at most 3 of 105 messages are rejected."""
    rng = np.random.default_rng(seed)
    tracker = Tracker(FRAME)
    x = y = psi = 0.0
    v, a, r, rejected = rng.uniform(0.0, 30.0), 0.0, 0.0, 0
    for k in range(150):
        if k % 20 == 0:
            a, r = rng.uniform(-8.0, 3.0), rng.uniform(-3.0, 3.0) / max(v, 6.0)
        if rng.random() < 0.7:
            off = rng.normal(0.0, noise, 2)
            message = bsm(
                T0 + 0.1 * k, x + off[0], y + off[1], speed=round(v, 2), psi=psi, a_x=a * (v > 0.0),
                r=r * (v > 0.0),
            )  # fmt: skip
            rejected += not tracker.update(message, T0 + 0.1 * k + 0.03).accepted
        for _ in range(10):
            v = min(max(v + 0.01 * a, 0.0), 40.0)
            psi += 0.01 * r * (v > 0.0)
            x, y = x + 0.01 * v * math.cos(psi), y + 0.01 * v * math.sin(psi)
    assert rejected <= 3


def test_frozen_sender_is_stale_but_its_events_count() -> None:
    tracker = fed()
    for k in range(1, 31):
        t = T0 + 1.0 + 0.1 * k
        result = tracker.update(bsm(t, 20.0, events=frozenset({"hard_braking"})), t + 0.02)
        assert result.kind in ("frozen", "teleport", "displacement")
    (vehicle,) = tracker.vehicles(t)
    assert vehicle.age == pytest.approx(3.0)
    assert vehicle.sigma_along > 5.0
    assert vehicle.events == {"hard_braking"}


def test_teleporting_sender_stays_near_last_accepted() -> None:
    tracker = fed()
    rng = np.random.default_rng(5)
    for k in range(1, 41):
        t = T0 + 1.0 + 0.1 * k
        x, y = rng.uniform(-200.0, 200.0, 2)
        tracker.update(bsm(t, 200.0 + x, y), t + 0.02)
        (vehicle,) = tracker.vehicles(t)
        off = math.hypot(vehicle.x - 20.0 - 2.0 * k, vehicle.y)
        assert off < 40.0 + 20.0 * 0.1 * k * (k > 10)


def test_slow_drift_is_bounded() -> None:
    """A lateral drift of 1 m per message, 40 m in total, with a straight heading."""
    tracker = fed()
    worst = 0.0
    for k in range(1, 41):
        t = T0 + 1.0 + 0.1 * k
        tracker.update(bsm(t, 20.0 + 2.0 * k, 1.0 * k), t + 0.02)
        worst = max(worst, abs(tracker.vehicles(t)[0].y))
    assert tracker.counts["displacement"] > 0
    assert worst < 22.0


@pytest.mark.parametrize("pause", [3.0, 60.0, 600.0])
def test_replay_leaves_track_unchanged(pause: float) -> None:
    """A second of messages, repeated later; second marks fit again after whole minutes."""
    tracker = fed()
    t = T0 + 1.0 + pause
    x = 20.0 + 20.0 * pause
    assert tracker.update(bsm(t, x), t).accepted
    for k in range(11):
        old = bsm(T0 + 0.1 * k, 2.0 * k)
        assert not tracker.update(old, t + 0.1 * k + 0.05).accepted
    assert tracker.vehicles(t + 1.0)[0].x == pytest.approx(x + 20.0, abs=0.1)


def test_ghost_inside_body_is_rejected() -> None:
    tracker = fed()
    for k in range(1, 31):
        t = T0 + 1.0 + 0.1 * k
        assert tracker.update(bsm(t, 21.0 + 2.0 * k, id="00000bad"), t).kind == "overlap"
        assert tracker.update(bsm(t, 20.0 + 2.0 * k), t + 0.02).kind == "updated"
    assert [v.id for v in tracker.vehicles(t)] == ["00000001"]


def test_sender_returns_after_ghost_took_its_track() -> None:
    """A ghost can only move as a body; the sender gets a new track once the ghost is elsewhere."""
    tracker = fed()
    for k in range(4, 40):  # three messages are lost
        t = T0 + 1.0 + 0.1 * k
        tracker.update(bsm(t, 20.0 + 2.0 * k, min(0.2 * (k - 4), 4.0), id="00000bad"), t)
        tracker.update(bsm(t, 20.0 + 2.0 * k), t + 0.02)
        positions = [(v.x, v.y) for v in tracker.vehicles(t)]
        assert min(math.dist(p, (20.0 + 2.0 * k, 0.0)) for p in positions) < 2.5
    assert {v.id for v in tracker.vehicles(t)} == {"00000bad", "00000001"}

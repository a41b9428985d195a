"""Lies: each check finds its own, can be switched off, and leaves honest senders alone."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError
from cca_core.v2x import PLAUSIBILITY_CHECKS, Bsm, PlausibilitySettings, Tracker, TrackerSettings
from tests.v2x.test_tracker import FRAME, T0, bsm


def heard(checks: PlausibilitySettings | None = None) -> Tracker:
    """Tracker that has heard a car for one second; it is at 20 m at T0 + 1 s."""
    tracker = Tracker(FRAME, TrackerSettings(plausibility=checks or PlausibilitySettings()))
    for k in range(11):
        assert tracker.update(bsm(T0 + 0.1 * k, 2.0 * k), T0 + 0.1 * k + 0.02).accepted
    return tracker


NEXT = T0 + 1.1
LIES: dict[str, tuple[Bsm, float]] = {
    "replay": (bsm(NEXT, 22.0), NEXT + 1.5),
    "future": (bsm(NEXT + 0.4, 28.0), NEXT),
    "size": (bsm(NEXT, 22.0, length=39.0), NEXT),
    "frozen": (bsm(NEXT, 20.0), NEXT),
    "teleport": (bsm(NEXT, 122.0), NEXT),
    "displacement": (bsm(NEXT, 22.0, 15.0), NEXT),
    "acceleration": (bsm(NEXT, 22.0, speed=30.0), NEXT),
    "yaw": (bsm(NEXT, 22.0, psi=0.8), NEXT),
    "overlap": (bsm(NEXT, 23.0, id="00000bad"), NEXT),
}


@pytest.mark.parametrize("check", PLAUSIBILITY_CHECKS)
def test_each_check_finds_its_lie(check: str) -> None:
    lie, t = LIES[check]
    tracker = heard()
    before = tracker.vehicles(t)
    outcome = tracker.update(lie, t)
    assert (outcome.accepted, outcome.kind, outcome.t) == (False, check, t)
    assert tracker.counts[check] == 1
    assert tracker.dropped == (outcome,)
    moved = [(v.x, v.y, v.psi, v.v_x, v.age, v.sigma_along, v.sigma_across) for v in tracker.vehicles(t)]
    as_before = [(v.x, v.y, v.psi, v.v_x, v.age, v.sigma_along, v.sigma_across) for v in before]
    np.testing.assert_allclose(moved, as_before, atol=1e-9)  # its place moved nothing


@pytest.mark.parametrize("check", PLAUSIBILITY_CHECKS)
def test_each_check_can_be_switched_off(check: str) -> None:
    lie, t = LIES[check]
    off = {check: False} | ({"displacement": False} if check == "teleport" else {})
    assert heard(PlausibilitySettings(**off)).update(lie, t).accepted


@pytest.mark.parametrize("values", [{"a_x": 15.0}, {"a_x": -15.0}, {"r": 1.0}, {"r": -1.0}])
def test_impossible_values(values: dict[str, float]) -> None:
    assert heard().update(bsm(NEXT, 22.0, **values), NEXT).kind in ("acceleration", "yaw")


@pytest.mark.parametrize(
    "values", [{"frozen": 1}, {"position_tolerance": 0.0}, {"max_acceleration": math.nan}]
)
def test_settings_are_checked(values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(values))):
        PlausibilitySettings(**values)


@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.5, 1.0]))
def test_honest_senders_are_believed(seed: int, noise: float) -> None:
    """Braking to a stop, starting, turning, with noise: next to nothing is dropped."""
    rng = np.random.default_rng(seed)
    tracker = Tracker(FRAME)
    x = y = psi = 0.0
    v, a, r, dropped = rng.uniform(0.0, 30.0), 0.0, 0.0, 0
    for k in range(150):
        if k % 20 == 0:
            a, r = rng.uniform(-8.0, 3.0), rng.uniform(-3.0, 3.0) / max(v, 6.0)
        if rng.random() < 0.7:
            off = rng.normal(0.0, noise, 2)
            said = bsm(
                T0 + 0.1 * k, x + off[0], y + off[1], speed=round(v, 2), psi=psi, a_x=a * (v > 0.0),
                r=r * (v > 0.0),
            )  # fmt: skip
            dropped += not tracker.update(said, T0 + 0.1 * k + 0.03).accepted
        for _ in range(10):
            v = min(max(v + 0.01 * a, 0.0), 40.0)
            psi += 0.01 * r * (v > 0.0)
            x, y = x + 0.01 * v * math.cos(psi), y + 0.01 * v * math.sin(psi)
    assert dropped <= 3


def test_frozen_sender_grows_stale_but_its_warning_counts() -> None:
    tracker = heard()
    for k in range(1, 31):
        t = T0 + 1.0 + 0.1 * k
        outcome = tracker.update(bsm(t, 20.0, events=frozenset({"hard_braking"})), t + 0.02)
        assert outcome.kind in ("frozen", "teleport", "displacement")
    (vehicle,) = tracker.vehicles(t)
    assert vehicle.age == pytest.approx(3.0)
    assert vehicle.sigma_along > 5.0
    assert vehicle.events == {"hard_braking"}


def test_teleporting_sender_stays_where_it_was_last_believed() -> None:
    tracker = heard()
    rng = np.random.default_rng(5)
    for k in range(1, 41):
        t = T0 + 1.0 + 0.1 * k
        x, y = rng.uniform(-200.0, 200.0, 2)
        tracker.update(bsm(t, 200.0 + x, y), t + 0.02)
        (vehicle,) = tracker.vehicles(t)
        off = math.hypot(vehicle.x - 20.0 - 2.0 * k, vehicle.y)
        assert off < 40.0 + 20.0 * 0.1 * k * (k > 10)


def test_a_slow_drift_is_held_back() -> None:
    """Sideways by 1 m a message, 40 m in all, while it says to drive straight on."""
    tracker = heard()
    worst = 0.0
    for k in range(1, 41):
        t = T0 + 1.0 + 0.1 * k
        tracker.update(bsm(t, 20.0 + 2.0 * k, 1.0 * k), t + 0.02)
        worst = max(worst, abs(tracker.vehicles(t)[0].y))
    assert tracker.counts["displacement"] > 0
    assert worst < 22.0


@pytest.mark.parametrize("pause", [3.0, 60.0, 600.0])
def test_replay_moves_no_track(pause: float) -> None:
    """A second of messages, sent again later; their second marks fit again after whole minutes."""
    tracker = heard()
    t = T0 + 1.0 + pause
    x = 20.0 + 20.0 * pause
    assert tracker.update(bsm(t, x), t).accepted
    for k in range(11):
        old = bsm(T0 + 0.1 * k, 2.0 * k)
        assert not tracker.update(old, t + 0.1 * k + 0.05).accepted
    assert tracker.vehicles(t + 1.0)[0].x == pytest.approx(x + 20.0, abs=0.1)


def test_ghost_inside_a_body_does_not_hide_it() -> None:
    tracker = heard()
    for k in range(1, 31):
        t = T0 + 1.0 + 0.1 * k
        assert tracker.update(bsm(t, 21.0 + 2.0 * k, id="00000bad"), t).kind == "overlap"
        assert tracker.update(bsm(t, 20.0 + 2.0 * k), t + 0.02).kind == "updated"
    assert [v.id for v in tracker.vehicles(t)] == ["00000001"]


def test_ghost_that_takes_a_lost_track_over_does_not_keep_the_sender_out() -> None:
    """It can only go on from there as a body would; the sender is heard again as soon as it is elsewhere."""
    tracker = heard()
    for k in range(4, 40):  # three messages of the car are lost
        t = T0 + 1.0 + 0.1 * k
        tracker.update(bsm(t, 20.0 + 2.0 * k, min(0.2 * (k - 4), 4.0), id="00000bad"), t)
        tracker.update(bsm(t, 20.0 + 2.0 * k), t + 0.02)
        places = [(v.x, v.y) for v in tracker.vehicles(t)]
        assert min(math.dist(p, (20.0 + 2.0 * k, 0.0)) for p in places) < 2.5
    assert {v.id for v in tracker.vehicles(t)} == {"00000bad", "00000001"}

"""Tracker: order, wraps, association, readmission and invalid messages."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError, RemoteVehicle
from cca_core.path import LocalFrame
from cca_core.predict import predict_ctra
from cca_core.v2x import (
    PlausibilitySettings,
    PositionalAccuracy,
    Sender,
    SenderSettings,
    Tracker,
    TrackerSettings,
    decode_bsm,
    encode_bsm,
)
from tests.support.v2x_messages import FRAME, T0, bsm, feed


def test_message_becomes_vehicle() -> None:
    tracker = Tracker(FRAME)
    sent = bsm(T0, 30.0, 4.0, v=12.0, psi=0.4, a_x=-2.0, r=0.1, events=frozenset({"hard_braking"}))
    result = tracker.update(encode_bsm(sent), T0 + 0.05)
    assert (result.accepted, result.kind, result.id) == (True, "new", "00000001")
    (vehicle,) = tracker.vehicles(T0 + 0.3)
    assert vehicle.invalid_reason is None
    assert vehicle.events == {"hard_braking"}
    assert vehicle.age == pytest.approx(0.3)
    measured = RemoteVehicle(id="", x=30.0, y=4.0, psi=0.4, v_x=12.0, a_x=-2.0, r=0.1)
    x, y, psi = predict_ctra(measured, 0.3)
    assert (vehicle.x, vehicle.y, vehicle.psi) == pytest.approx((x, y, psi), abs=0.02)
    assert vehicle.v_x == pytest.approx(12.0 - 0.6)
    assert vehicle.source == "v2v"


@pytest.mark.parametrize(
    ("reported", "limit", "added"), [(0.4, 1.5, 0.4), (4.75, 1.5, 1.5), (None, 1.5, 0.0), (0.4, 0.0, 0.0)]
)
def test_reported_accuracy_is_capped(reported: float | None, limit: float, added: float) -> None:
    without, with_it = Tracker(FRAME), Tracker(FRAME, TrackerSettings(max_reported_accuracy=limit))
    for tracker in (without, with_it):
        tracker.update(
            encode_bsm(bsm(T0, accuracy=PositionalAccuracy(semi_major=reported, semi_minor=reported))),
            T0 + 0.02,
        )
    (bare,), (grown,) = without.vehicles(T0 + 0.2), with_it.vehicles(T0 + 0.2)
    assert grown.sigma_along == pytest.approx(math.hypot(bare.sigma_along, added))
    assert grown.sigma_across == pytest.approx(math.hypot(bare.sigma_across, added))


@pytest.mark.parametrize("reported", [math.nan, math.inf, -1.0, "0.4"])
def test_invalid_accuracy_is_ignored(reported: object) -> None:
    tracker = Tracker(FRAME, TrackerSettings(max_reported_accuracy=1.5))
    accuracy = PositionalAccuracy(semi_major=reported)  # type: ignore[arg-type]
    tracker.update(bsm(T0, accuracy=accuracy), T0 + 0.02)
    tracker.update(bsm(T0 + 0.1, accuracy=None), T0 + 0.12)
    assert all(vehicle.invalid_reason is None for vehicle in tracker.vehicles(T0 + 0.2))


def test_projection_equals_local_frame() -> None:
    """Positions agree with the frame to a micrometer, up to 100 km away."""
    tracker = Tracker(FRAME)
    rng = np.random.default_rng(1)
    xy = rng.uniform(-1e5, 1e5, (50, 2))
    for i, (x, y) in enumerate(xy):
        assert tracker.update(bsm(T0, x, y, id=f"{i:08x}"), T0).accepted
    positions = [(v.x, v.y) for v in tracker.vehicles(T0)]
    np.testing.assert_allclose(positions, xy, atol=1e-6)


@pytest.mark.parametrize("origin", [(45.0, 14.0), (0.0, 0.0), (-60.0, 179.9), (89.0, -30.0)])
def test_sender_position_equals_local_frame(origin: tuple[float, float]) -> None:
    """What a sender measures is the position of the frame, to the digits of a message."""
    frame = LocalFrame(*origin)
    for x, y in np.random.default_rng(2).uniform(-1e5, 1e5, (50, 2)).tolist():
        sender = Sender("00c0ffee", frame, SenderSettings(), np.random.default_rng(0))
        vehicle = RemoteVehicle(id="A", x=x, y=y, psi=0.0, v_x=10.0)
        data = sender.poll(T0, vehicle) or sender.poll(T0 + 1.0, vehicle)
        assert data is not None
        sent = decode_bsm(data)
        assert (sent.latitude_deg, sent.longitude_deg) == pytest.approx(frame.to_geodetic((x, y)), abs=6e-8)


def test_duplicate_and_late_messages_are_rejected() -> None:
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)
    before = tracker.vehicles(t + 0.1)
    for data, kind in ((bsm(t, 20.0), "duplicate"), (bsm(t - 0.3, 14.0), "out_of_order")):
        result = tracker.update(data, t + 0.05)
        assert (result.accepted, result.kind) == (False, kind)
    assert tracker.vehicles(t + 0.1) == before
    assert tracker.counts["duplicate"] == tracker.counts["out_of_order"] == 1
    assert [o.kind for o in tracker.dropped] == ["duplicate", "out_of_order"]


@given(st.lists(st.integers(0, 3), min_size=20, max_size=60), st.randoms(use_true_random=False))
def test_newest_message_wins_in_any_order(delays: list[int], random: Any) -> None:
    tracker = Tracker(FRAME)
    messages = sorted((k + d, random.random(), k) for k, d in enumerate(delays))
    for at, _, k in messages:
        t = T0 + 0.1 * k
        tracker.update(bsm(t, 2.0 * k), T0 + 0.1 * at + 0.01)
    end = T0 + 0.1 * messages[-1][0]
    (vehicle,) = tracker.vehicles(end)
    newest = T0 + 0.1 * (len(delays) - 1)
    assert vehicle.age == pytest.approx(end - newest)
    assert vehicle.x == pytest.approx(20.0 * (end - T0), abs=0.05)


def test_minute_and_count_wrap() -> None:
    tracker = Tracker(FRAME)
    t = feed(tracker, 20.0, t=T0 - 10.0)  # over the minute, and over 127
    (vehicle,) = tracker.vehicles(t)
    assert (vehicle.age, vehicle.x) == pytest.approx((0.0, 400.0), abs=0.01)
    assert tracker.counts == {"new": 1, "updated": 200}


@pytest.mark.parametrize("received", [-0.1, 0.0, 0.4, 0.9])
def test_minute_is_nearest_to_reception(received: float) -> None:
    for t in (T0 - 0.01, T0, T0 + 0.01):
        tracker = Tracker(FRAME)
        assert tracker.update(bsm(t), t + received).accepted
        assert tracker.vehicles(t + 1.0)[0].age == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("mark", [None, 60.0, 60.5])
def test_message_count_orders_without_time(mark: float | None) -> None:
    """Unavailable time, and leap seconds, which are not on the clock."""
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)
    for k in range(1, 8):
        at = t + 0.1 * k
        message = bsm(at, 20.0 + 2.0 * k, sec_mark=mark)
        assert tracker.update(message, at + 0.02).kind == "updated"
        assert tracker.update(message, at + 0.03).kind == "duplicate"
        assert tracker.update(bsm(at - 0.2, 16.0 + 2.0 * k, sec_mark=mark), at + 0.04).kind == "out_of_order"
    after = t + 1.0
    assert tracker.update(bsm(after, 40.0), after + 0.02).accepted


def test_new_id_is_associated_with_lost_track() -> None:
    tracker = Tracker(FRAME)
    t = feed(tracker, 2.0)
    results = [
        tracker.update(bsm(t + 0.1 * k, 40.0 + 2.0 * k, id="0000beef"), t + 0.1 * k) for k in range(1, 6)
    ]
    assert [o.kind for o in results] == ["overlap", "overlap", "reassociated", "updated", "updated"]
    (vehicle,) = tracker.vehicles(t + 0.5)
    assert vehicle.id == "0000beef"
    assert vehicle.x == pytest.approx(50.0, abs=0.1)


def test_track_continues_after_message_gap() -> None:
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)
    assert tracker.vehicles(t + 5.0)[0].age == pytest.approx(5.0)
    assert tracker.update(bsm(t + 5.0, 110.0, v=18.0), t + 5.0).accepted
    assert tracker.vehicles(t + 5.0)[0].age == 0.0


def test_jump_is_readmitted_after_consistent_second() -> None:
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)
    kinds = []
    for k in range(1, 15):
        at = t + 0.1 * k
        kinds.append(tracker.update(bsm(at, 320.0 + 2.0 * k), at).kind)
    assert kinds[:10] == ["teleport"] * 10
    assert set(kinds[11:]) == {"updated"}
    assert tracker.counts["readmitted"] == 1


def test_rejected_crash_is_within_bounds() -> None:
    """A stop within 0.1 s is rejected, but the bounds include the reported position."""
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)
    for k in range(1, 101):
        at = t + 0.1 * k
        tracker.update(bsm(at, 20.5, v=0.0), at)
        (vehicle,) = tracker.vehicles(at)
        if k > 15:
            assert vehicle.x - 2.0 * vehicle.sigma_along <= 20.5 <= vehicle.x + 2.0 * vehicle.sigma_along
    assert vehicle.v_x == 0.0


def test_frozen_position_stays_rejected_at_standstill() -> None:
    """It brakes to standstill 28.6 m after its position froze; the track coasts there and stays."""
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)
    for k in range(1, 301):
        at = t + 0.1 * k
        v = max(20.0 - 0.7 * k, 0.0)
        tracker.update(bsm(at, 20.0, v=v, a_x=-7.0 if v else 0.0), at)
        (vehicle,) = tracker.vehicles(at)
        assert vehicle.v_x == pytest.approx(v, abs=0.02)
        assert vehicle.age == pytest.approx(0.1 * k)
    assert vehicle.x == pytest.approx(20.0 + 200.0 / 7.0, abs=0.3)
    assert vehicle.x - 2.0 * vehicle.sigma_along < 20.0  # both positions are covered
    assert tracker.counts["readmitted"] == 0


def test_frozen_position_is_readmitted_by_driving() -> None:
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0)
    for k in range(1, 81):
        at = t + 0.1 * k
        v = max(20.0 - 0.7 * k, 0.0) if k < 40 else 5.0 * min((k - 39) / 20.0, 1.0)
        x = 20.0 if k < 40 else 20.0 + max(sum(min(i / 40.0, 0.5) for i in range(1, k - 38)) - 1.0, 0.0)
        tracker.update(bsm(at, x, v=v), at)
    (vehicle,) = tracker.vehicles(at)
    assert tracker.counts["readmitted"] == 1
    assert vehicle.x == pytest.approx(x, abs=0.1)
    assert vehicle.age == 0.0


def test_unknown_size_and_heading() -> None:
    tracker = Tracker(FRAME)
    assert tracker.update(bsm(T0, v=10.0, psi=None), T0).kind == "unusable"
    assert tracker.update(bsm(T0, v=0.0, psi=None, length=None, width=None), T0).kind == "new"
    (vehicle,) = tracker.vehicles(T0)
    assert (vehicle.length, vehicle.width) == (5.0, 5.0)  # unknown heading
    assert tracker.update(bsm(T0 + 0.1, v=0.0, psi=0.3), T0 + 0.1).accepted
    assert tracker.update(bsm(T0 + 0.2, v=0.0, psi=None), T0 + 0.2).accepted
    assert tracker.vehicles(T0 + 0.2)[0].psi == 0.3


def test_reverse_gear_moves_backwards() -> None:
    tracker = Tracker(FRAME)
    assert tracker.update(bsm(T0, v=3.0, transmission="reverse"), T0).accepted
    assert tracker.vehicles(T0 + 1.0)[0].x == pytest.approx(-3.0)


ANY = st.one_of(st.none(), st.floats(), st.floats(-100.0, 100.0), st.text(max_size=2))


@given(
    st.lists(
        st.fixed_dictionaries(
            {
                name: ANY
                for name in ("sec_mark", "latitude_deg", "longitude_deg", "speed", "psi", "a_x", "r", "width")
            }
        ),
        max_size=8,
    )
)
def test_update_never_raises(messages: list[dict[str, Any]]) -> None:
    off = PlausibilitySettings(
        replay=False, future=False, size=False, frozen=False, teleport=False, displacement=False,
        acceleration=False, yaw=False, overlap=False,
    )  # fmt: skip
    for settings in (PlausibilitySettings(), off):
        tracker = Tracker(FRAME, TrackerSettings(plausibility=settings))
        for k, values in enumerate(messages):
            tracker.update(replace(bsm(T0 + 0.1 * k), **values), T0 + 0.1 * k)
        for vehicle in tracker.vehicles(T0 + 3.0):
            numbers = (vehicle.x, vehicle.y, vehicle.psi, vehicle.v_x, vehicle.a_x, vehicle.r)
            assert all(map(math.isfinite, numbers))


@given(st.binary(max_size=60))
def test_invalid_bytes_are_rejected(data: bytes) -> None:
    try:
        decode_bsm(data)
    except InputError:
        assert not Tracker(FRAME).update(data, T0).accepted


@pytest.mark.parametrize("t", [math.nan, math.inf, None])
def test_invalid_time_raises(t: Any) -> None:
    with pytest.raises(InputError, match="t_received"):
        Tracker(FRAME).update(bsm(T0), t)
    with pytest.raises(InputError, match="t must"):
        Tracker(FRAME).vehicles(t)


@pytest.mark.parametrize(
    "values",
    [
        {"position_errors": None},
        {"readmit_distance": -1.0},
        {"max_tracks": 0},
        {"max_tracks": 2.5},
        {"braking": 0.0},
        {"plausibility": None},
    ],
)
def test_invalid_settings_raise(values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(values))):
        TrackerSettings(**values)

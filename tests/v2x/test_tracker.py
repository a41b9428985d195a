"""Tracks: order, wraps, loss, identity, bounds and forgetting."""

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from cca_core import InputError, LocalFrame, RemoteVehicle, VehicleState
from cca_core.predict import predict_ctra
from cca_core.v2x import (
    Bsm,
    Fix,
    PlausibilitySettings,
    PositionalAccuracy,
    Tracker,
    TrackerSettings,
    dead_reckon,
    decode_bsm,
    encode_bsm,
    position_bounds,
)

FRAME = LocalFrame(41.0, -104.0)
T0 = 6000.0


def bsm(
    t: float, x: float = 0.0, y: float = 0.0, *, v: float = 20.0, n: int | None = None, **more: Any
) -> Bsm:
    """Message of a car at a place, measured at `t`, which drives along +x."""
    lat, lon = FRAME.to_geodetic((x, y))
    values: dict[str, Any] = {
        "msg_count": round(t * 10.0) % 128 if n is None else n, "id": "00000001", "sec_mark": t % 60.0,
        "latitude_deg": float(lat), "longitude_deg": float(lon), "speed": v, "psi": 0.0, "a_x": 0.0, "r": 0.0,
        "length": 4.5, "width": 1.8,
    }  # fmt: skip
    return Bsm(**(values | more))


def driven(tracker: Tracker, seconds: float, *, t: float = T0, v: float = 20.0, **more: Any) -> float:
    """Feed 10 Hz messages of a car at constant speed; return the time of the last."""
    n = round(10 * seconds)
    for k in range(n + 1):
        at = t + 0.1 * k
        assert tracker.update(bsm(at, v * 0.1 * k, v=v, **more), at + 0.02).accepted
    return t + 0.1 * n


def test_bytes_become_a_vehicle() -> None:
    tracker = Tracker(FRAME)
    sent = bsm(T0, 30.0, 4.0, v=12.0, psi=0.4, a_x=-2.0, r=0.1, events=frozenset({"hard_braking"}))
    outcome = tracker.update(encode_bsm(sent), T0 + 0.05)
    assert (outcome.accepted, outcome.kind, outcome.id) == (True, "new", "00000001")
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
    ("told", "most", "counts"), [(0.4, 1.5, 0.4), (4.75, 1.5, 1.5), (None, 1.5, 0.0), (0.4, 0.0, 0.0)]
)
def test_reported_accuracy_is_capped(told: float | None, most: float, counts: float) -> None:
    without, with_it = Tracker(FRAME), Tracker(FRAME, TrackerSettings(max_reported_accuracy=most))
    for tracker in (without, with_it):
        tracker.update(
            encode_bsm(bsm(T0, accuracy=PositionalAccuracy(semi_major=told, semi_minor=told))), T0 + 0.02
        )
    (bare,), (grown,) = without.vehicles(T0 + 0.2), with_it.vehicles(T0 + 0.2)
    assert grown.sigma_along == pytest.approx(math.hypot(bare.sigma_along, counts))
    assert grown.sigma_across == pytest.approx(math.hypot(bare.sigma_across, counts))


@pytest.mark.parametrize("told", [math.nan, math.inf, -1.0, "0.4"])
def test_an_accuracy_that_is_none_does_no_harm(told: object) -> None:
    tracker = Tracker(FRAME, TrackerSettings(max_reported_accuracy=1.5))
    tracker.update(bsm(T0, accuracy=PositionalAccuracy(semi_major=told)), T0 + 0.02)  # type: ignore[arg-type]
    tracker.update(bsm(T0 + 0.1, accuracy=None), T0 + 0.12)
    assert all(vehicle.invalid_reason is None for vehicle in tracker.vehicles(T0 + 0.2))


@given(
    st.floats(-20.0, 60.0), st.floats(-10.0, 10.0), st.floats(-1.0, 1.0), st.floats(-4.0, 4.0),
    st.floats(0.0, 1.0),
)  # fmt: skip
def test_dead_reckoning_is_predict_free(v: float, a: float, r: float, psi: float, age: float) -> None:
    fix = dead_reckon(Fix(5.0, 1.0, 2.0, psi, v, a, r), 5.0 + age)
    remote = RemoteVehicle(id="", x=1.0, y=2.0, psi=psi, v_x=v, a_x=a, r=r)
    assert fix[1:4] == pytest.approx([float(c) for c in predict_ctra(remote, age)], abs=1e-8)


@given(st.floats(-20.0, 100.0), st.floats(0.0, 3000.0), st.floats(0.0, 100.0))
def test_bounds_grow_with_age(v: float, age: float, more: float) -> None:
    young, old = position_bounds(v, age), position_bounds(v, age + more)
    assert all(0.0 < a <= b < math.inf for a, b in zip(young, old, strict=True))


def test_frame_of_one_position() -> None:
    """Places agree with the frame to a micrometer, up to 100 km away."""
    tracker = Tracker(FRAME)
    rng = np.random.default_rng(1)
    xy = rng.uniform(-1e5, 1e5, (50, 2))
    for i, (x, y) in enumerate(xy):
        assert tracker.update(bsm(T0, x, y, id=f"{i:08x}"), T0).accepted
    places = [(v.x, v.y) for v in tracker.vehicles(T0)]
    np.testing.assert_allclose(places, xy, atol=1e-6)


def test_duplicates_and_late_messages_change_nothing() -> None:
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)
    before = tracker.vehicles(t + 0.1)
    for data, what in ((bsm(t, 20.0), "duplicate"), (bsm(t - 0.3, 14.0), "out_of_order")):
        outcome = tracker.update(data, t + 0.05)
        assert (outcome.accepted, outcome.kind) == (False, what)
    assert tracker.vehicles(t + 0.1) == before
    assert tracker.counts["duplicate"] == tracker.counts["out_of_order"] == 1
    assert [o.kind for o in tracker.dropped] == ["duplicate", "out_of_order"]


@given(st.lists(st.integers(0, 3), min_size=20, max_size=60), st.randoms(use_true_random=False))
def test_any_order_leaves_the_newest(delays: list[int], random: Any) -> None:
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
    t = driven(tracker, 20.0, t=T0 - 10.0)  # over the minute, and over 127
    (vehicle,) = tracker.vehicles(t)
    assert (vehicle.age, vehicle.x) == pytest.approx((0.0, 400.0), abs=0.01)
    assert tracker.counts == {"new": 1, "updated": 200}


@pytest.mark.parametrize("received", [-0.1, 0.0, 0.4, 0.9])
def test_minute_is_the_nearest(received: float) -> None:
    for t in (T0 - 0.01, T0, T0 + 0.01):
        tracker = Tracker(FRAME)
        assert tracker.update(bsm(t), t + received).accepted
        assert tracker.vehicles(t + 1.0)[0].age == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("mark", [None, 60.0, 60.5])
def test_without_time_the_count_orders(mark: float | None) -> None:
    """Unavailable, and leap seconds, which have no place on the clock."""
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)
    for k in range(1, 8):
        at = t + 0.1 * k
        message = bsm(at, 20.0 + 2.0 * k, sec_mark=mark)
        assert tracker.update(message, at + 0.02).kind == "updated"
        assert tracker.update(message, at + 0.03).kind == "duplicate"
        assert tracker.update(bsm(at - 0.2, 16.0 + 2.0 * k, sec_mark=mark), at + 0.04).kind == "out_of_order"
    after = t + 1.0
    assert tracker.update(bsm(after, 40.0), after + 0.02).accepted


def test_a_new_id_takes_over_a_lost_track() -> None:
    tracker = Tracker(FRAME)
    t = driven(tracker, 2.0)
    told = [tracker.update(bsm(t + 0.1 * k, 40.0 + 2.0 * k, id="0000beef"), t + 0.1 * k) for k in range(1, 6)]
    assert [o.kind for o in told] == ["overlap", "overlap", "took_over", "updated", "updated"]
    (vehicle,) = tracker.vehicles(t + 0.5)
    assert vehicle.id == "0000beef"
    assert vehicle.x == pytest.approx(50.0, abs=0.1)


def test_lost_and_returned() -> None:
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)
    assert tracker.vehicles(t + 5.0)[0].age == pytest.approx(5.0)
    assert tracker.update(bsm(t + 5.0, 110.0, v=18.0), t + 5.0).accepted
    assert tracker.vehicles(t + 5.0)[0].age == 0.0


def test_a_jump_is_believed_after_a_second_of_agreement() -> None:
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)
    told = []
    for k in range(1, 15):
        at = t + 0.1 * k
        told.append(tracker.update(bsm(at, 320.0 + 2.0 * k), at).kind)
    assert told[:10] == ["teleport"] * 10
    assert set(told[11:]) == {"updated"}
    assert tracker.counts["returned"] == 1


def test_a_crash_is_within_the_bounds_before_it_is_believed() -> None:
    """From 20 m/s to standstill at once is no motion of a car; where it says that it stands is covered."""
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)
    for k in range(1, 101):
        at = t + 0.1 * k
        tracker.update(bsm(at, 20.5, v=0.0), at)
        (vehicle,) = tracker.vehicles(at)
        if k > 15:
            assert vehicle.x - 2.0 * vehicle.sigma_along <= 20.5 <= vehicle.x + 2.0 * vehicle.sigma_along
    assert vehicle.v_x == 0.0


def test_frozen_position_stays_rejected_at_standstill() -> None:
    """It brakes to standstill 28.6 m from where its place froze; the track goes there and stays."""
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)
    for k in range(1, 301):
        at = t + 0.1 * k
        v = max(20.0 - 0.7 * k, 0.0)
        tracker.update(bsm(at, 20.0, v=v, a_x=-7.0 if v else 0.0), at)
        (vehicle,) = tracker.vehicles(at)
        assert vehicle.v_x == pytest.approx(v, abs=0.02)
        assert vehicle.age == pytest.approx(0.1 * k)
    assert vehicle.x == pytest.approx(20.0 + 200.0 / 7.0, abs=0.3)
    assert vehicle.x - 2.0 * vehicle.sigma_along < 20.0  # both places are covered
    assert tracker.counts["returned"] == 0


def test_a_frozen_place_returns_by_driving() -> None:
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)
    for k in range(1, 81):
        at = t + 0.1 * k
        v = max(20.0 - 0.7 * k, 0.0) if k < 40 else 5.0 * min((k - 39) / 20.0, 1.0)
        x = 20.0 if k < 40 else 20.0 + max(sum(min(i / 40.0, 0.5) for i in range(1, k - 38)) - 1.0, 0.0)
        tracker.update(bsm(at, x, v=v), at)
    (vehicle,) = tracker.vehicles(at)
    assert tracker.counts["returned"] == 1
    assert vehicle.x == pytest.approx(x, abs=0.1)
    assert vehicle.age == 0.0


def test_a_vehicle_that_fell_silent_is_not_forgotten_because_the_ego_brakes() -> None:
    """The ego is soon fast again; a silent car may stand where it was last heard."""
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)
    for k in range(1, 81):
        v = max(20.0 - 0.5 * k, 0.0)
        ego = VehicleState(x=-30.0 + 40.0 * (1.0 - v / 20.0), y=0.0, psi=0.0, v_x=v)
        assert len(tracker.vehicles(t + 0.1 * k, ego)) == 1


def test_a_stale_track_blocks_until_it_is_out_of_reach() -> None:
    tracker = Tracker(FRAME)
    t = driven(tracker, 1.0)  # at 20 m, drives away from the ego behind
    ego = VehicleState(x=-30.0, y=0.0, psi=0.0, v_x=10.0)
    bounds = []
    for k in range(1, 300):
        known = tracker.vehicles(t + 0.1 * k, ego)
        if not known:
            break
        bounds.append(2.0 * known[0].sigma_along)
    assert np.all(np.diff(bounds) >= 0.0)
    assert len(bounds) >= 10
    assert len(bounds) < 40
    assert len(tracker) == 0


def test_nearby_stale_track_is_kept() -> None:
    tracker = Tracker(FRAME, TrackerSettings(delete_after=12.0))
    t = driven(tracker, 1.0)
    for k in range(1, 120):
        ego = VehicleState(x=20.0 + 2.0 * k, y=3.5, psi=0.0, v_x=20.0)
        (vehicle,) = tracker.vehicles(t + 0.1 * k, ego)
        assert vehicle.invalid_reason is None
    assert tracker.vehicles(t + 12.1, ego) == ()


@pytest.mark.parametrize(("psi", "kept"), [(math.pi, True), (0.0, False)], ids=["nearer", "farther"])
def test_approaching_stale_track_is_kept(psi: float, kept: bool) -> None:
    """Silent for two seconds 250 m ahead: an oncoming car is there when the pass would end."""
    tracker, ego = Tracker(FRAME), VehicleState(x=0.0, y=0.0, psi=0.0, v_x=15.0)
    assert tracker.update(bsm(T0, 250.0, 3.5, psi=psi), T0 + 0.02).accepted
    assert len(tracker.vehicles(T0 + 2.0, ego)) == kept


def test_capacity_limit_under_sender_flood() -> None:
    """At most 200 are kept, the nearest of them; the one that matters is among them."""
    tracker = Tracker(FRAME, TrackerSettings(retention_range=1000.0))
    ego = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0)
    tracker.vehicles(T0, ego)
    places = np.random.default_rng(3).permutation(1000)
    for k in range(3):
        for i in places.tolist():
            tracker.update(bsm(T0 + 0.1 * k, 4.8 * i + 20.0 + 2.0 * k, id=f"{i:08x}"), T0 + 0.1 * k)
    known = tracker.vehicles(T0 + 0.3, ego)
    assert len(known) == len(tracker) == 200
    assert {v.id for v in known} == {f"{i:08x}" for i in range(200)}
    assert tracker.is_saturated(T0 + 0.3)
    assert not tracker.is_saturated(T0 + 2.0)
    assert tracker.counts["full"] > 0
    assert len(tracker.dropped) == 100


def crowded(seconds: float, place: float, most: int = 20) -> tuple[Tracker, float]:
    """Tracker that hears a car at a place ahead of the ego for some time, then many between them."""
    tracker = Tracker(FRAME, TrackerSettings(max_tracks=most))
    ego = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0)
    tracker.vehicles(T0, ego)
    t = T0
    for k in range(round(10 * seconds) + 20):
        t = T0 + 0.1 * k
        tracker.update(bsm(t, place, v=0.0), t)
        if k > 10 * seconds:
            for i in range(60):
                tracker.update(bsm(t, 3.0 + i % 10, 5.0 + 5.0 * (i // 10), v=0.0, id=f"{16 + i:08x}"), t)
    return tracker, t


def test_flood_keeps_confirmed_tracks() -> None:
    tracker, t = crowded(0.5, 200.0)
    assert "00000001" in {v.id for v in tracker.vehicles(t)}
    assert len(tracker) == 20
    assert tracker.is_saturated(t)


def test_flood_evicts_distant_tracks() -> None:
    """Farther than all are wanted it says nothing of silence within that distance."""
    tracker, t = crowded(0.5, 400.0)
    assert "00000001" not in {v.id for v in tracker.vehicles(t)}


def test_far_senders_that_are_turned_away_are_not_missed() -> None:
    tracker = Tracker(FRAME, TrackerSettings(max_tracks=3))
    tracker.vehicles(T0, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0))
    told = [tracker.update(bsm(T0, 200.0 * i, id=f"{i:08x}"), T0).kind for i in range(5)]
    assert told == ["new"] * 3 + ["full"] * 2
    assert not tracker.is_saturated(T0)
    assert tracker.update(bsm(T0, 100.0, id="0000beef"), T0).kind == "new"  # in place of the one at 400 m
    assert not tracker.is_saturated(T0)
    assert tracker.update(bsm(T0, 150.0, id="0000cafe"), T0).kind == "new"  # of the one at 200 m
    assert tracker.is_saturated(T0)


def test_overlapping_positions_are_rejected() -> None:
    """However small they say that they are: of a crowd within a few meters most are inside another."""
    tracker = Tracker(FRAME)
    rng = np.random.default_rng(2)
    for i in range(200):
        x, y = rng.uniform(0.0, 5.0, 2)
        tracker.update(bsm(T0, x, y, v=0.0, id=f"{i:08x}", length=0.3, width=0.3), T0)
    assert tracker.counts["overlap"] > 150
    assert len(tracker) < 5.0 * 5.0 / (1.5 * 0.8) * 2.0


def test_without_ego_newcomers_are_turned_away() -> None:
    tracker = Tracker(FRAME, TrackerSettings(max_tracks=3))
    told = [tracker.update(bsm(T0, 30.0 * i, id=f"{i:08x}"), T0).kind for i in range(4)]
    assert told == ["new"] * 3 + ["full"]


def test_unknown_size_and_heading() -> None:
    tracker = Tracker(FRAME)
    assert tracker.update(bsm(T0, v=10.0, psi=None), T0).kind == "unusable"
    assert tracker.update(bsm(T0, v=0.0, psi=None, length=None, width=None), T0).kind == "new"
    (vehicle,) = tracker.vehicles(T0)
    assert (vehicle.length, vehicle.width) == (5.0, 5.0)  # it may point anywhere
    assert tracker.update(bsm(T0 + 0.1, v=0.0, psi=0.3), T0 + 0.1).accepted
    assert tracker.update(bsm(T0 + 0.2, v=0.0, psi=None), T0 + 0.2).accepted
    assert tracker.vehicles(T0 + 0.2)[0].psi == 0.3


def test_reverse_drives_backwards() -> None:
    tracker = Tracker(FRAME)
    assert tracker.update(bsm(T0, v=3.0, transmission="reverse"), T0).accepted
    assert tracker.vehicles(T0 + 1.0)[0].x == pytest.approx(-3.0)


_ANY = st.one_of(st.none(), st.floats(), st.floats(-100.0, 100.0), st.text(max_size=2))


@given(
    st.lists(
        st.fixed_dictionaries(
            {
                name: _ANY
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
def test_bytes_that_are_no_message(data: bytes) -> None:
    try:
        decode_bsm(data)
    except InputError:
        assert not Tracker(FRAME).update(data, T0).accepted


@pytest.mark.parametrize("t", [math.nan, math.inf, None])
def test_times_are_checked(t: Any) -> None:
    with pytest.raises(InputError, match="t_received"):
        Tracker(FRAME).update(bsm(T0), t)
    with pytest.raises(InputError, match="t must"):
        Tracker(FRAME).vehicles(t)


@pytest.mark.parametrize(
    "values", [{"max_tracks": 0}, {"max_tracks": 2.5}, {"braking": 0.0}, {"plausibility": None}]
)
def test_settings_are_checked(values: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(values))):
        TrackerSettings(**values)


@dataclass
class Prediction:
    """A recorded position against what was expected of it before."""

    row: int
    target: int
    horizon: float
    age: float
    v: float
    along: float
    across: float
    bound_along: float
    bound_across: float

    @property
    def inside(self) -> bool:
        return abs(self.along) <= self.bound_along and abs(self.across) <= self.bound_across


@pytest.fixture(scope="module")
def predictions(data_dir: FilePath) -> list[Prediction]:
    """After each message: the first position reported at least a horizon (and at most 0.5 s) later."""
    with (data_dir / "bsm" / "wyoming_rx_decoded.csv").open() as file:
        messages = [decode_bsm(bytes.fromhex(row["uper_hex"])) for row in csv.DictReader(file)]
    frame = LocalFrame(messages[0].latitude_deg, messages[0].longitude_deg)
    xy = frame.to_local([m.latitude_deg for m in messages], [m.longitude_deg for m in messages])
    found = []
    for begin, end in ((0, 138), (138, 243)):  # two drives
        marks = np.array([m.sec_mark for m in messages[begin:end]])
        t = T0 + marks + 60.0 * np.cumsum(np.diff(marks, prepend=marks[0]) < -30.0)
        tracker = Tracker(frame)
        for i in range(end - begin):
            outcome = tracker.update(messages[begin + i], float(t[i]) + 0.05)
            assert outcome.accepted or outcome.kind == "frozen"
            for horizon in (0.1, 0.5, 1.0):
                j = int(np.searchsorted(t, t[i] + horizon - 0.005))
                if j == len(t) or t[j] > t[i] + horizon + 0.5:
                    continue
                (vehicle,) = tracker.vehicles(float(t[j]))
                off = complex(*(xy[begin + j] - (vehicle.x, vehicle.y))) * np.exp(-1j * vehicle.psi)
                found.append(
                    Prediction(
                        begin + i, begin + j, horizon, vehicle.age, vehicle.v_x, off.real, off.imag,
                        2.0 * vehicle.sigma_along, 2.0 * vehicle.sigma_across,
                    )
                )  # fmt: skip
    return found


_HALF = 121  # of 243 messages


def rounded_up(value: float, digits: int = 2) -> float:
    """Next number of so many significant digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    return math.ceil(value / unit - 1e-9) * unit


def test_bounds_are_the_largest_errors_of_the_first_half(predictions: list[Prediction]) -> None:
    """The rule by which the shipped constants were made; nothing of the second half is looked at."""
    first = [p for p in predictions if p.target < _HALF]
    age, v, along, across = np.array([(p.age, p.v, abs(p.along), abs(p.across)) for p in first]).T
    assert len(first) > 300
    timing, rate = rounded_up(max(along / v)), rounded_up(max(along / (v * age)))
    # the line of least mean that no error across exceeds
    line = linprog(
        [len(age), age.sum()], A_ub=-np.column_stack((np.ones_like(age), age)), b_ub=-across, method="highs"
    )
    new, growth = (rounded_up(float(value)) for value in line.x)
    for moment in (0.0, 0.05, 0.1, 0.2, 1.0):
        for speed in (0.0, 12.0, 30.0):
            expected = 0.1 + speed * min(rate * moment, timing), new + growth * moment
            assert position_bounds(speed, moment) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("horizon", [0.1, 0.5, 1.0])
def test_bounds_hold_on_the_second_half(predictions: list[Prediction], horizon: float) -> None:
    those = [p for p in predictions if p.horizon == horizon and p.row >= _HALF]
    assert len(those) > 70
    assert 0.93 <= np.mean([p.inside for p in those]) <= 0.99
    errors = np.sort([abs(p.along) for p in those])
    constant = errors[math.ceil(0.95 * len(errors)) - 1]
    assert np.mean([p.bound_along for p in those]) <= 1.5 * constant


def test_safety_distance_covers_the_recorded_errors(predictions: list[Prediction]) -> None:
    """7 m, up to the age at which a lane is no longer believed to be known."""
    errors = np.abs([p.along for p in predictions])
    assert np.mean(errors <= 7.0) >= 0.99
    assert errors.max() < 8.0

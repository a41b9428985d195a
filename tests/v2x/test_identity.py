"""Which body a message belongs to, and messages with unusual or missing values."""

import math
import os
import random
import tracemalloc

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import RemoteVehicle, VehicleState
from cca_core.v2x import Tracker, TrackerSettings, encode_bsm
from tests.support.v2x_messages import FRAME, T0, bsm, feed

N_FRAMES = 1_000_000 if os.environ.get("CCA_HYPOTHESIS_PROFILE") == "full" else 3000


def positions(tracker: Tracker, t: float, **more: object) -> list[tuple[float, float]]:
    """Positions of all vehicles, by x."""
    return sorted((round(v.x, 1), round(v.y, 1)) for v in tracker.vehicles(t, **more))


@pytest.mark.parametrize("phase", [-0.05, -0.013, 0.0, 0.03], ids=str)
@pytest.mark.parametrize("n", [0, 17, 100])
@pytest.mark.parametrize("v", [0.0, 15.0, -10.0])
def test_two_senders_of_one_id_are_two_bodies(phase: float, n: int, v: float) -> None:
    """One drives at 15 m/s, the other is 240 m ahead; their time stamps and counts differ."""
    tracker = Tracker(FRAME)
    for k in range(41):
        t = T0 + 0.1 * k
        tracker.update(bsm(t, 1.5 * k, 3.5, v=15.0, n=k, transmission="forward"), t + 0.02)
        other = bsm(
            t + phase, 240.0 + v * (t + phase - T0), psi=0.0 if v >= 0.0 else math.pi, v=abs(v),
            n=(k + n) % 128, transmission="forward",
        )  # fmt: skip
        tracker.update(other, t + 0.02)
        if k > 10:
            x = [p[0] for p in positions(tracker, t)]
            assert x == pytest.approx([1.5 * k, 240.0 + v * 0.1 * k], abs=1.6), k
    assert len({v.id for v in tracker.vehicles(t)}) == 2


@pytest.mark.parametrize("phase", [-0.05, -0.013, 0.02, 0.06], ids=str)
@pytest.mark.parametrize(
    ("x", "y"), [(0.0, 3.5), (3.0, 3.0), (5.5, 0.0)], ids=["alongside", "diagonal", "queue"]
)
def test_two_close_bodies_of_one_id_are_two_bodies(phase: float, x: float, y: float) -> None:
    """Both are stationary; neither hides the other, whichever was received first."""
    tracker = Tracker(FRAME)
    for k in range(11):
        t = T0 + 0.1 * k
        tracker.update(bsm(t, 100.0 + x, y, v=0.0, n=k), t + 0.02)
        tracker.update(bsm(t + phase, 100.0, v=0.0, n=k + 17), t + max(phase, 0.0) + 0.02)
    assert positions(tracker, t) == [(100.0, 0.0), (100.0 + x, y)]


@pytest.mark.parametrize("noise", [1.0, 2.0])
def test_noisy_sender_over_two_channels_is_one_body(noise: float) -> None:
    tracker, rng = Tracker(FRAME), random.Random(1)
    sent = [
        bsm(T0 + 0.1 * k, k + rng.gauss(0.0, noise), rng.gauss(0.0, noise), v=10.0, n=k % 128)
        for k in range(200)
    ]
    for k in range(203):
        if k < 200:
            tracker.update(sent[k], T0 + 0.1 * k + 0.02)
        if k >= 3:
            tracker.update(sent[k - 3], T0 + 0.1 * k + 0.02)
    assert tracker.counts["separated"] == 0


def test_three_senders_of_one_id_are_three_bodies() -> None:
    tracker = Tracker(FRAME)
    for k in range(31):
        t = T0 + 0.1 * k
        for i in range(4):
            tracker.update(bsm(t + 0.01 * i, 100.0 * i + 2.0 * k, n=(k + 11 * i) % 128), t + 0.05)
    assert len(tracker) == 3  # at most


def test_replay_of_tracked_sender_is_no_second_body() -> None:
    tracker = Tracker(FRAME)
    sent = []
    for k in range(60):
        t, v = T0 + 0.1 * k, max(20.0 - 0.7 * k, 0.0)
        x = 20.0 * 0.1 * k - 0.5 * 7.0 * (0.1 * k) ** 2 if v else 28.6
        sent.append(bsm(t, x, v=v, a_x=-7.0 if v else 0.0))
        tracker.update(sent[-1], t + 0.02)
        for delay in (1, 3, 8, 20):
            if k >= delay:
                tracker.update(sent[k - delay], t + 0.03)
    assert len(tracker) == 1
    assert tracker.counts["separated"] == 0


@pytest.mark.parametrize("silence", [0.4, 1.2, 3.0, 8.0])
@pytest.mark.parametrize("change", [-5.0, 0.0, 2.0], ids=["slower", "same", "faster"])
def test_new_id_after_silence_leaves_no_ghost(silence: float, change: float) -> None:
    tracker = Tracker(FRAME)
    end = feed(tracker, 2.0)
    t, v = end + silence, 20.0 + change
    for k in range(10):
        x = 40.0 + 0.5 * (20.0 + v) * silence + v * 0.1 * k
        tracker.update(bsm(t + 0.1 * k, x, v=v, id="0000beef"), t + 0.1 * k)
    assert [vehicle.id for vehicle in tracker.vehicles(t + 0.9)] == ["0000beef"]


@pytest.mark.parametrize(
    "values",
    [{"y": 3.5}, {"length": 12.0}, {"psi": math.pi}, {"x": 200.0}, {"x": 0.0}],
    ids=["other lane", "other size", "oncoming", "far ahead", "behind"],
)
def test_new_vehicle_does_not_replace_stale_one(values: dict[str, float]) -> None:
    tracker = Tracker(FRAME)
    t = feed(tracker, 2.0) + 3.0
    arguments = {"x": 100.0, "y": 0.0} | values
    tracker.update(bsm(t, **arguments, id="0000beef"), t)
    assert {vehicle.id for vehicle in tracker.vehicles(t)} == {"00000001", "0000beef"}


def test_two_possible_stale_tracks_stay() -> None:
    tracker = Tracker(FRAME)
    for k in range(11):
        for i in range(2):
            tracker.update(bsm(T0 + 0.1 * k, 2.0 * k + 8.0 * i, id=f"{i:08x}"), T0 + 0.1 * k)
    tracker.update(bsm(T0 + 4.0, 84.0, id="0000beef"), T0 + 4.0)
    assert len(tracker) == 3


def test_own_message_without_known_id_is_recognized() -> None:
    """A body that moves with the ego at its position; a car that follows in a queue is none."""
    tracker = Tracker(FRAME)
    for k in range(41):
        t = T0 + 0.1 * k
        ego = VehicleState(x=1.0 * k, y=0.0, psi=0.0, v_x=10.0)
        tracker.update(bsm(t - 0.02, 1.0 * k - 0.2, 0.1, v=10.0, id="000000ee"), t)
        tracker.update(bsm(t - 0.02, 1.0 * k + 6.3, v=10.0, id="0000cafe"), t)
        ids = {vehicle.id for vehicle in tracker.vehicles(t, ego)}
        assert "0000cafe" in ids
    assert "000000ee" not in ids
    aside = VehicleState(x=40.0, y=3.5, psi=0.0, v_x=10.0)
    assert "000000ee" in {vehicle.id for vehicle in tracker.vehicles(t, aside)}


def test_stationary_vehicle_at_ego_position_counts() -> None:
    tracker, ego = Tracker(FRAME), VehicleState(x=0.0, y=0.0, psi=0.0, v_x=0.0)
    for k in range(41):
        tracker.update(bsm(T0 + 0.1 * k, 1.0, v=0.0), T0 + 0.1 * k)
        assert len(tracker.vehicles(T0 + 0.1 * k, ego)) == 1


@pytest.mark.parametrize(("length", "width"), [(27.0, 2.6), (40.95, 10.23), (0.5, 0.5)])
def test_size_within_message_range_is_accepted(length: float, width: float) -> None:
    tracker = Tracker(FRAME)
    assert tracker.update(encode_bsm(bsm(T0, length=length, width=width)), T0).accepted
    (vehicle,) = tracker.vehicles(T0)
    assert (vehicle.length, vehicle.width) == (length, width)
    assert vehicle.invalid_reason is None


@pytest.mark.parametrize("missing", [("psi",), ("speed",), ("psi", "speed")], ids="+".join)
@pytest.mark.parametrize("psi", [0.0, 2.0, -2.5])
@pytest.mark.parametrize("v", [3.0, 20.0])
def test_missing_motion_comes_from_positions(missing: tuple[str, ...], psi: float, v: float) -> None:
    tracker, rng = Tracker(FRAME), np.random.default_rng(1)
    for k in range(31):
        t, s = T0 + 0.1 * k, 0.1 * k * v
        x, y = s * math.cos(psi) + rng.normal(0.0, 0.05), s * math.sin(psi) + rng.normal(0.0, 0.05)
        values = {"speed": v, "psi": psi} | dict.fromkeys(missing)
        result = tracker.update(bsm(t, x, y, **values), t + 0.02)
        assert result.accepted or k * 0.1 * v < 1.2
    (vehicle,) = tracker.vehicles(t)
    assert vehicle.v_x == pytest.approx(v, abs=0.5)
    assert math.remainder(vehicle.psi - psi, math.tau) == pytest.approx(0.0, abs=0.15)
    assert math.dist((vehicle.x, vehicle.y), (x, y)) < 0.3


@pytest.mark.parametrize("gear", [None, "neutral", "park"])
@pytest.mark.parametrize("v", [1.0, 3.0, 8.0])
def test_gear_not_reported_and_going_backwards_is_reversing(gear: str | None, v: float) -> None:
    tracker, x = Tracker(FRAME), 0.0
    for k in range(61):
        t, speed = T0 + 0.1 * k, min(max(0.2 * (k - 20), 0.0), v)
        x -= 0.1 * speed
        result = tracker.update(bsm(t, x, v=speed, transmission=gear), t + 0.02)
        assert result.accepted
    (vehicle,) = tracker.vehicles(t)
    assert vehicle.v_x == pytest.approx(-v)
    assert vehicle.x == pytest.approx(x, abs=0.1)


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_gear_not_reported_and_going_forwards_is_not_reversing(noise: float) -> None:
    tracker, rng, x = Tracker(FRAME), np.random.default_rng(2), 0.0
    for k in range(200):
        t, v = T0 + 0.1 * k, 2.0 * abs(math.sin(0.05 * k))
        x += 0.1 * v
        tracker.update(bsm(t, x + rng.normal(0.0, noise), v=v, transmission=None), t + 0.02)
        assert tracker.vehicles(t)[0].v_x >= 0.0


@pytest.mark.parametrize(("v", "gear"), [(99.9, "forward"), (19.9, "reverse")])
@pytest.mark.parametrize("a_x", [-11.0, 11.0])
@pytest.mark.parametrize("age", [0.5, 1.0, 3.0, 25.0])
def test_fastest_vehicle_stays_valid(v: float, gear: str, a_x: float, age: float) -> None:
    tracker = Tracker(FRAME)
    assert tracker.update(bsm(T0, v=v, a_x=a_x, transmission=gear), T0).accepted
    (vehicle,) = tracker.vehicles(T0 + age)
    assert vehicle.invalid_reason is None


@pytest.mark.parametrize("repeats", [1, 2, 3])
def test_repeated_mark_with_new_count_counts(repeats: int) -> None:
    """Devices that repeat the time stamp of a position: events, braking and speed are new."""
    tracker = Tracker(FRAME)
    t = feed(tracker, 1.0, a_x=0.0)
    for k in range(1, repeats + 1):
        message = bsm(
            t, 20.0, v=20.0 - 0.8 * k, a_x=-8.0, n=(round(10.0 * t) + k) % 128, events={"hard_braking"}
        )
        assert tracker.update(message, t + 0.1 * k + 0.02).kind == "updated"
        assert tracker.update(message, t + 0.1 * k + 0.03).kind == "duplicate"
    (vehicle,) = tracker.vehicles(t + 0.1 * repeats + 0.03)
    assert vehicle.events == {"hard_braking"}
    assert vehicle.a_x == -8.0
    assert vehicle.v_x < 20.0 - 0.8 * repeats
    assert vehicle.age == pytest.approx(0.1 * repeats + 0.03)


@pytest.mark.parametrize(("elevation", "z"), [(208.0, 8.0), (195.5, -4.5), (None, None), (math.nan, None)])
def test_height_is_relative_to_frame(elevation: float | None, z: float | None) -> None:
    tracker, unknown = Tracker(FRAME, height=200.0), Tracker(FRAME)
    for each in (tracker, unknown):
        each.update(bsm(T0, elevation=elevation), T0)
    assert tracker.vehicles(T0)[0].z == z
    assert tracker.vehicles(T0)[0].sigma_z == TrackerSettings().sigma_height
    assert unknown.vehicles(T0)[0].z is None


VALUES = {
    "id": st.sampled_from(["00000001", "00000002"]),
    "n": st.integers(-200, 300),
    "sec_mark": st.one_of(st.none(), st.floats(0.0, 61.0)),
    "speed": st.one_of(st.none(), st.floats(0.0, 60.0)),
    "psi": st.one_of(st.none(), st.floats(-7.0, 7.0)),
    "transmission": st.sampled_from([None, "forward", "reverse", "neutral"]),
    "elevation": st.one_of(st.none(), st.floats(-400.0, 6000.0)),
    "x": st.floats(-300.0, 300.0),
    "y": st.floats(-20.0, 20.0),
}


@given(st.lists(st.fixed_dictionaries(VALUES), max_size=40), st.floats(-40.0, 40.0), st.booleans())
def test_any_messages_give_valid_vehicles(messages: list[dict], offset: float, with_ego: bool) -> None:
    tracker = Tracker(FRAME, height=0.0)
    ego = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0) if with_ego else None
    for k, values in enumerate(messages):
        t = T0 + offset + 0.1 * k - 3.0 * (k > 20)
        tracker.update(bsm(T0 + 0.1 * k, **values), t)
        for vehicle in tracker.vehicles(t, ego):
            assert isinstance(vehicle, RemoteVehicle)
            assert vehicle.invalid_reason is None
            assert vehicle.z is None or math.isfinite(vehicle.z)
        health = tracker.health(t)
        assert health.received == health.accepted + sum(rate for _, rate in health.rejected)
        assert len({vehicle.id for vehicle in tracker.vehicles(t)}) == len(tracker.vehicles(t))


def test_memory_is_bounded_by_any_number_of_ids() -> None:
    """Senders without gear whose clocks are all wrong, each with a new id."""
    tracker, source, sizes = Tracker(FRAME, TrackerSettings(max_tracks=20)), random.Random(1), []
    tracemalloc.start()
    for k in range(6000):
        t = T0 + 0.002 * k
        message = bsm(t, source.uniform(-300.0, 300.0), id=f"{k:08x}", sec_mark=source.uniform(0.0, 60.0))
        tracker.update(message, t)
        if k % 2000 == 1999:
            sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert len(tracker) <= 20
    assert sizes[-1] - sizes[-2] < 50_000


def test_spoiled_frames_raise_nothing() -> None:
    """Frames of three senders with flipped bits, cuts and additions, at spoiled times."""
    tracker, source = Tracker(FRAME, height=0.0), random.Random(3)
    ego = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0)
    for k in range(N_FRAMES):
        t = T0 + 0.01 * k + source.choice((0.0, 0.0, 0.0, 5.0, -0.3))
        data = bytearray(encode_bsm(bsm(T0 + 0.01 * k, 0.2 * k % 500.0, 3.5 * (k % 3), id=f"{k % 3:08x}")))
        for _ in range(source.choice((0, 1, 3, 20))):
            data[source.randrange(len(data))] ^= 1 << source.randrange(8)
        if source.random() < 0.1:
            data = data[: source.randrange(len(data))]
        tracker.update(bytes(data), t)
        if k % 10 == 0:
            assert all(vehicle.invalid_reason is None for vehicle in tracker.vehicles(t, ego))
            assert tracker.health(t).received >= 0.0
    assert sum(tracker.counts.values()) == N_FRAMES

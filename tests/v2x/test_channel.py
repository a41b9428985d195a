"""Channel and sender: loss, delay, repetition and reproducibility."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError, LocalFrame, RemoteVehicle
from cca_core.v2x import (
    Channel,
    ChannelSettings,
    ReceivedMessage,
    Sender,
    SenderSettings,
    Tracker,
    decode_bsm,
)

FRAME = LocalFrame(41.0, -104.0)
HERE = (0.0, 0.0)
T0 = 6000.0


def number(k: int) -> bytes:
    return k.to_bytes(4, "big")


def arrived(
    settings: ChannelSettings, n: int, *, seed: int = 1, distance: float = 0.0
) -> list[ReceivedMessage]:
    """Send `n` numbered messages at 10 Hz from a distance; return the received ones."""
    channel, found = Channel(settings, np.random.default_rng(seed)), []
    for k in range(n):
        channel.send(0.1 * k, (distance, 0.0), number(k), sender="a")
        found += channel.receive(0.1 * k, HERE)
    return found + list(channel.receive(1e9, HERE))


def numbers(arrivals: list[ReceivedMessage]) -> list[int]:
    return [int.from_bytes(a.data, "big") for a in arrivals]


def test_default_channel_is_perfect() -> None:
    found = arrived(ChannelSettings(), 50)
    assert numbers(found) == list(range(50))
    assert [a.t for a in found] == pytest.approx([0.1 * k for k in range(50)])
    assert {a.sender for a in found} == {"a"}


@pytest.mark.parametrize(("loss", "burst"), [(0.1, 1.5), (0.28, 3.0), (0.5, 2.0), (0.8, 6.0)])
def test_loss_and_bursts(loss: float, burst: float) -> None:
    kept = np.array(numbers(arrived(ChannelSettings(loss_probability=loss, mean_burst_length=burst), 20_000)))
    runs = np.diff(kept) - 1
    assert 1.0 - len(kept) / 20_000 == pytest.approx(loss, abs=0.03)
    assert runs[runs > 0].mean() == pytest.approx(burst, rel=0.1)


def test_bursts_of_senders_are_independent() -> None:
    channel = Channel(ChannelSettings(loss_probability=0.5, mean_burst_length=5.0), np.random.default_rng(2))
    received = {"a": set(), "b": set()}
    for k in range(4000):
        for sender in received:
            channel.send(0.1 * k, HERE, number(k), sender=sender)
    for arrival in channel.receive(1e9, HERE):
        received[arrival.sender].add(arrival.data)
    assert len(received["a"] & received["b"]) == pytest.approx(1000, abs=150)


def test_latency_and_jitter() -> None:
    found = arrived(ChannelSettings(latency=0.05, jitter=0.02), 3000)
    delays = np.array([a.t - 0.1 * k for a, k in zip(found, numbers(found), strict=True)])
    assert delays.min() >= 0.05 - 1e-9
    assert delays.mean() == pytest.approx(0.07, abs=0.002)


def test_latency_delays_arrival() -> None:
    channel = Channel(ChannelSettings(latency=0.2), np.random.default_rng(0))
    channel.send(1.0, HERE, b"a")
    assert channel.receive(1.19, HERE) == ()
    assert [a.data for a in channel.receive(1.2, HERE)] == [b"a"]
    assert channel.receive(9.0, HERE) == ()


@pytest.mark.parametrize(("distance", "fraction"), [(0.0, 1.0), (150.0, 0.9625), (299.0, 0.41), (301.0, 0.0)])
def test_loss_grows_with_distance(distance: float, fraction: float) -> None:
    found = arrived(ChannelSettings(range=300.0, loss_at_range=0.6), 5000, distance=distance)
    assert len(found) / 5000 == pytest.approx(fraction, abs=0.03)


def test_reordering_and_duplicates() -> None:
    found = numbers(arrived(ChannelSettings(reorder_probability=0.2, duplicate_probability=0.1), 5000))
    assert set(found) == set(range(5000))
    assert len(found) / 5000 == pytest.approx(1.1, abs=0.02)
    assert sum(b < a for a, b in itertools.pairwise(found)) > 500


@given(st.integers(0, 2**32), st.lists(st.floats(0.0, 0.3), min_size=1, max_size=30))
def test_randomness_independent_of_polling(seed: int, pauses: list[float]) -> None:
    settings = ChannelSettings(
        latency=0.02, jitter=0.05, loss_probability=0.3, mean_burst_length=2.0, range=400.0,
        loss_at_range=0.5, reorder_probability=0.2, duplicate_probability=0.2,
    )  # fmt: skip
    once, often = (Channel(settings, np.random.default_rng(seed)) for _ in range(2))
    polled, t = [], 0.0
    for k, pause in enumerate(pauses):
        t += pause
        for channel in (once, often):
            channel.send(t, (350.0, 0.0), number(k), sender=str(k % 3))
        polled += often.receive(t, HERE)
    assert polled + list(often.receive(1e9, HERE)) == list(once.receive(1e9, HERE))


@pytest.mark.parametrize(
    "values",
    [
        {"loss_probability": 1.0},
        {"loss_probability": 0.9, "mean_burst_length": 2.0},
        {"latency": -1.0},
        {"range": math.nan},
        {"mean_burst_length": 0.5},
    ],
)
def test_invalid_settings_raise(values: dict[str, float]) -> None:
    with pytest.raises(InputError, match=list(values)[-1]):
        ChannelSettings(**values)


def sent(settings: SenderSettings, seconds: float, *, step: float = 0.001, seed: int = 1) -> list[Any]:
    """Messages of a car at 20 m/s along +x, each with the time at which it was sent."""
    sender = Sender("0000cafe", FRAME, settings, np.random.default_rng(seed))
    found = []
    for k in range(round(seconds / step)):
        t = T0 + step * k
        data = sender.poll(t, RemoteVehicle(id="", x=20.0 * step * k, y=0.0, psi=0.0, v_x=20.0))
        if data is not None:
            found.append((t, data))
    return found


def test_sender_reports_true_state() -> None:
    found = sent(SenderSettings(), 3.0, step=0.02)
    assert len(found) in (29, 30)
    messages = [decode_bsm(data) for _, data in found]
    assert {b.msg_count - a.msg_count for a, b in itertools.pairwise(messages)} <= {1, -127}
    tracker = Tracker(FRAME)
    for t, data in found:
        assert tracker.update(data, t).accepted
        (vehicle,) = tracker.vehicles(t)
        assert (vehicle.x, vehicle.y) == pytest.approx((20.0 * (t - T0), 0.0), abs=0.02)
    assert (vehicle.id, vehicle.length, vehicle.width) == ("0000cafe", 4.5, 1.8)


def test_wyoming_statistics() -> None:
    """Intervals of 95 to 105 ms, 28 % lost, mostly one to three in succession, a few repeated positions."""
    found = sent(SenderSettings.wyoming(), 60.0)
    intervals = np.diff([t for t, _ in found])
    assert 0.094 <= intervals.min() < 0.097
    assert 0.103 < intervals.max() <= 0.1061
    longitudes = [decode_bsm(data).longitude_deg for _, data in found]
    repeats = sum(a == b for a, b in itertools.pairwise(longitudes))
    assert 0.01 < repeats / len(longitudes) < 0.06
    kept = np.array(numbers(arrived(ChannelSettings.wyoming(), 20_000)))
    runs = np.diff(np.sort(kept)) - 1
    assert 1.0 - len(kept) / 20_000 == pytest.approx(0.28, abs=0.02)
    assert np.mean(runs[runs > 0] <= 3) > 0.6


@pytest.mark.parametrize("noise_time_constant", [0.0, 5.0])
def test_position_noise(noise_time_constant: float) -> None:
    found = sent(SenderSettings(position_noise=1.5, noise_time_constant=noise_time_constant), 400.0, step=0.1)
    messages = [decode_bsm(data) for _, data in found]
    xy = FRAME.to_local([m.latitude_deg for m in messages], [m.longitude_deg for m in messages])
    across = xy[:, 1]
    assert across.std() == pytest.approx(1.5, rel=0.3)
    kept = np.corrcoef(across[1:], across[:-1])[0, 1]
    assert kept == pytest.approx(
        math.exp(-0.1 / noise_time_constant) if noise_time_constant else 0.0, abs=0.1
    )


def test_same_seed_gives_same_bytes() -> None:
    settings = SenderSettings(
        interval_spread=0.005, position_noise=1.0, freeze_probability=0.1, mean_freeze_length=3.0
    )
    runs = [sent(settings, 5.0, seed=seed) for seed in (4, 4, 5)]
    assert runs[0] == runs[1] != runs[2]
    lossy = ChannelSettings(
        loss_probability=0.3,
        mean_burst_length=2.0,
        jitter=0.02,
        reorder_probability=0.1,
        duplicate_probability=0.1,
    )
    assert arrived(lossy, 300) == arrived(lossy, 300)


def test_bounds_hold_through_poor_channel() -> None:
    """Loss of 50 %, delay, duplicates and disorder: the vehicle stays within its bounds."""
    settings = ChannelSettings(
        latency=0.1,
        jitter=0.05,
        loss_probability=0.5,
        mean_burst_length=2.0,
        reorder_probability=0.1,
        duplicate_probability=0.1,
    )
    channel, tracker = Channel(settings, np.random.default_rng(6)), Tracker(FRAME)
    sender = Sender("0000cafe", FRAME, SenderSettings.wyoming(), np.random.default_rng(7))
    within = []
    for k in range(3000):
        t, x = T0 + 0.02 * k, 20.0 * 0.02 * k
        data = sender.poll(t, RemoteVehicle(id="", x=x, y=0.0, psi=0.0, v_x=20.0))
        if data is not None:
            channel.send(t, (x, 0.0), data, sender=sender.id)
        for arrival in channel.receive(t, (x, 0.0)):
            tracker.update(arrival.data, t)
        within += [abs(v.x - x) <= 2.0 * v.sigma_along for v in tracker.vehicles(t)]
    assert len(within) > 2900
    assert np.mean(within) > 0.95


@pytest.mark.parametrize("values", [{"interval": 0.0}, {"interval_spread": 0.2}, {"freeze_probability": 1.5}])
def test_invalid_sender_settings_raise(values: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(values))):
        SenderSettings(**values)

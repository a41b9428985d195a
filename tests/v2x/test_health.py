"""Health of the radio: rates, offsets of the clock, and when the radio cannot be trusted."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import (
    InputError,
    Lane,
    LocalFrame,
    Planner,
    RemoteVehicle,
    Road,
    VehicleParams,
    VehicleState,
    fit_path,
)
from cca_core.v2x import Bsm, Tracker, TrackerHealth, TrackerSettings
from tests.support.sweeps import sweep
from tests.support.v2x_messages import FRAME, T0, bsm

Clock = Callable[[float], float]  # receiver's clock minus the senders' at a time


def receive(
    tracker: Tracker,
    clock: Clock,
    seconds: float,
    senders: tuple[float, ...] = (0.0, 0.0, 0.0),
    latency: Callable[[int], float] = lambda i: 0.02 + 0.01 * i,
    begin: float = 0.0,
) -> float:
    """Receive cars at 20 m/s, 40 m apart; each sender's clock leads by a value [s]. Return the last time."""
    now = 0.0
    for k in range(round(10.0 * seconds) + 1):
        since = begin + 0.1 * k
        for i, lead in enumerate(senders):
            message = bsm(
                T0 + since + lead, 40.0 * i + 20.0 * since, id=f"{i + 1:08x}",
                n=round(10.0 * since) % 128, transmission="forward",
            )  # fmt: skip
            tracker.update(message, T0 + since + latency(i) + clock(since))
        now = T0 + since + clock(since)
    return now + latency(len(senders) - 1)


OFFSETS = [-30.0 + 1.0, -5.0, -2.0, -0.3, 0.8, 2.0, 5.0, 18.0, 29.0, 37.0 - 60.0]


@pytest.mark.parametrize("offset", OFFSETS)
def test_clock_offset_is_found_and_corrected(offset: float) -> None:
    tracker = Tracker(FRAME)
    now = receive(tracker, lambda t: offset, 4.0)
    health = tracker.health(now)
    assert health.trusted
    assert health.clock_offset == pytest.approx(offset + 0.03, abs=0.011)
    assert health.accepted == health.received == pytest.approx(30.0, abs=3.0)
    vehicles = {v.id: v for v in tracker.vehicles(now)}
    assert len(vehicles) == 3
    for i in range(3):
        vehicle, true = vehicles[f"{i + 1:08x}"], 40.0 * i + 20.0 * 4.04
        assert abs(vehicle.x - true) <= 2.0 * vehicle.sigma_along
        assert vehicle.age <= 0.2


@pytest.mark.parametrize("offset", [0.0, 0.1, 0.3, 0.5])
def test_latency_is_not_corrected(offset: float) -> None:
    tracker = Tracker(FRAME)
    now = receive(tracker, lambda t: offset, 12.0)
    assert tracker.health(now).clock_correction == 0.0
    assert [v.age for v in tracker.vehicles(now)] == pytest.approx([offset + 0.04] * 3, abs=1e-6)


@pytest.mark.parametrize("offset", [-0.5, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 2.0, 18.0])
@pytest.mark.parametrize("v", [-3.0, 12.0, 20.0, 30.0])
@pytest.mark.parametrize("one_sender", [False, True])
def test_position_is_within_its_bound_from_the_first_message_on(
    offset: float, v: float, one_sender: bool
) -> None:
    """A receiver's clock that leads by an offset, or that of one sender of four which is late by it."""
    tracker = Tracker(FRAME)
    for k in range(400):
        t = 0.02 * k
        now = T0 + t + (0.0 if one_sender else offset)
        for i in range(4 if one_sender else 1):
            if k % 5 == 2 and (measured := t - 0.04) >= 0.0:
                late = offset if one_sender and i == 0 else 0.0
                message = bsm(
                    T0 + measured - late, abs(v) * measured * math.copysign(1.0, v) + 100.0 * i, v=abs(v),
                    id=f"{i + 1:08x}", n=k // 5 % 128, transmission="forward" if v > 0.0 else "reverse",
                )  # fmt: skip
                tracker.update(message, now)
        vehicles = tracker.vehicles(now)
        assert vehicles or k < 30
        for vehicle in vehicles:
            true = v * t + 100.0 * (int(vehicle.id) - 1)
            assert abs(vehicle.x - true) <= 2.0 * vehicle.sigma_along + 1e-6, (t, vehicle)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("lead", [-2.0, -0.8, -0.6, -0.4, 0.3, 0.6, 2.0])
def test_honest_sender_is_within_its_bound_next_to_a_wrong_one(lead: float, seed: int) -> None:
    """Whichever of both is known first, by the loss of messages."""
    tracker, random, seen = Tracker(FRAME), np.random.default_rng(seed), 0
    for k in range(300):
        t = 0.02 * k
        for i in range(2):
            if k % 5 == 2 and random.random() > 0.2:
                measured = t - 0.04
                message = bsm(
                    T0 + measured + i * lead, 20.0 * measured + 100.0 * i, id=f"{i + 1:08x}", n=k // 5 % 128,
                    transmission="forward",
                )  # fmt: skip
                tracker.update(message, T0 + t)
        for vehicle in tracker.vehicles(T0 + t):
            if vehicle.id == "00000001":
                assert abs(vehicle.x - 20.0 * t) <= 2.0 * vehicle.sigma_along + 1e-6
                seen += 1
    assert seen > 250


@pytest.mark.parametrize("step", [-0.45, -0.15, 0.15, 0.3, 0.45, 0.55])
@pytest.mark.parametrize("v", [20.0, 40.0])
def test_bound_holds_again_soon_after_a_clock_step(step: float, v: float) -> None:
    """A step of up to 0.3 s ahead is covered at once."""
    tracker, seen = Tracker(FRAME), 0
    for k in range(800):
        t = 0.02 * k
        now = T0 + t + (step if t > 10.0 else 0.0)
        if k % 5 == 2:
            message = bsm(T0 + t - 0.04, v * (t - 0.04), v=v, n=k // 5 % 128, transmission="forward")
            tracker.update(message, now)
        is_unsure = 10.0 <= t < 10.0 + (0.0 if 0.0 < step <= 0.3 else 1.1)
        for vehicle in tracker.vehicles(now):
            assert is_unsure or abs(vehicle.x - v * t) <= 2.0 * vehicle.sigma_along + 1e-6, t
            seen += 1
    assert seen > 750


def test_forged_future_marks_do_not_widen_bounds() -> None:
    """They are rejected: one in five messages under the id of the first of three senders."""
    tracker, widest = Tracker(FRAME), 0.0
    for k in range(1500):
        t = 0.02 * k
        for i in range(3):
            if k % 5 == 2:
                message = bsm(
                    T0 + t - 0.04,
                    20.0 * t + 100.0 * i,
                    id=f"{i + 1:08x}",
                    n=k // 5 % 128,
                    transmission="forward",
                )
                tracker.update(message, T0 + t)
        if k % 25 == 9:
            tracker.update(bsm(T0 + t + 5.0, 20.0 * t, n=(k // 5 + 1) % 128), T0 + t)
        widest = max([widest, *(vehicle.sigma_along for vehicle in tracker.vehicles(T0 + t))])
    assert 1.0 < widest < 3.5


@pytest.mark.parametrize("drift", [50e-6, -50e-6])
@pytest.mark.parametrize("offset", [-3.0, 0.0, 18.0])
def test_clock_drift_is_followed(offset: float, drift: float) -> None:
    """For 10 minutes of every hour: 0.18 s an hour."""
    tracker = Tracker(FRAME)
    for hour in range(3):
        now = receive(tracker, lambda t: offset + drift * t, 20.0, begin=3600.0 * hour)
        health = tracker.health(now)
        assert health.trusted
        assert health.clock_offset == pytest.approx(offset + drift * 3600.0 * hour + 0.03, abs=0.015)
        assert all(v.age < 0.7 for v in tracker.vehicles(now))


@pytest.mark.parametrize("step", [-5.0, -3600.0, 5.0, 3600.0, -0.4, 0.9])
def test_clock_step_is_corrected(step: float) -> None:
    tracker = Tracker(FRAME)
    now = receive(tracker, lambda t: step * (t > 4.0), 9.0)
    assert tracker.health(now).trusted
    vehicles = tracker.vehicles(now)
    assert len(vehicles) == 3
    assert max(v.age for v in vehicles) < 1.0
    assert min(v.x for v in vehicles) == pytest.approx(20.0 * 9.04, abs=15.0)


@pytest.mark.parametrize("lead", [-20.0, -1.5, -0.5, 0.3, 5.0, 25.0])
@pytest.mark.parametrize("offset", [0.0, 5.0])
@pytest.mark.parametrize("honest", sweep(1, 3, 2, 4, quick=2))
def test_one_wrong_sender_moves_estimate_by_nothing(lead: float, offset: float, honest: int) -> None:
    """It joins the others. A lead that may be latency moves it within the latencies of the others."""
    plain, attacked = Tracker(FRAME), Tracker(FRAME)
    senders = (0.0,) * honest
    for tracker in (plain, attacked):
        receive(tracker, lambda t: offset, 5.0, senders)
    now = receive(plain, lambda t: offset, 15.0, senders, begin=5.1)
    receive(attacked, lambda t: offset, 15.0, (*senders, lead), begin=5.1)
    health, expected = attacked.health(now), plain.health(now)
    plausible = lead in (-0.5, 0.3)
    assert health.clock_offset == pytest.approx(expected.clock_offset, abs=0.011 if plausible else 1e-9)
    assert health.clock_correction == pytest.approx(
        expected.clock_correction, abs=0.011 if plausible else 1e-9
    )
    assert health.trusted or lead in (-20.0, -1.5) or (honest == 1 and lead != -0.5)
    assert health.accepted >= 8.0 * honest


@pytest.mark.parametrize(
    ("lead", "latency", "jitter"),
    [
        *((lead, 0.03, jitter) for lead in (0.25, 0.3, 0.5, 1.0, 5.0, 18.0, 25.0) for jitter in (0.0, 0.2)),
        *((lead, 0.3, 0.3) for lead in (1.0, 5.0, 18.0)),  # as large as latency may be
    ],
)
def test_sender_with_clock_ahead_is_within_its_bound(lead: float, latency: float, jitter: float) -> None:
    """No latency explains it, so its messages are timed by their reception."""
    tracker, random = Tracker(FRAME), np.random.default_rng(1)
    for begin in np.arange(0.0, 8.0, 0.1):
        now = receive(
            tracker, lambda t: 0.0, 0.0, (0.0, 0.0, lead), lambda i: latency + jitter * random.random(), begin
        )
        if begin > 1.0:
            vehicle = {v.id: v for v in tracker.vehicles(now)}["00000003"]
            true = 80.0 + 20.0 * (now - T0)
            assert abs(vehicle.x - true) <= 2.0 * vehicle.sigma_along < 16.0
            assert vehicle.age < 0.5
    assert tracker.health(now).trusted


@pytest.mark.parametrize("lead", [-1.5, -3.0, -18.0])
def test_sender_with_old_messages_alone_is_not_trusted(lead: float) -> None:
    """Its vehicle is there, but not known where."""
    tracker = Tracker(FRAME)
    now = receive(tracker, lambda t: 0.0, 3.0, (0.0, 0.0, 0.0, lead))
    health = tracker.health(now)
    assert health.awareness_range == 0.0
    assert re.match(r"all messages of 00000004 are \d+\.\d s old, or its clock is behind", health.reason)
    assert tracker.health(receive(tracker, lambda t: 0.0, 2.0, begin=3.1)).trusted  # it is gone


def test_sender_with_a_clock_that_stands_is_not_trusted() -> None:
    tracker = Tracker(FRAME)
    for k in range(60):
        now = receive(tracker, lambda t: 0.0, 0.0, begin=0.1 * k)
        frozen = bsm(T0 - 2.0, 200.0 + 2.0 * k, id="0000000a", n=k, transmission="forward")
        assert not tracker.update(frozen, now).accepted
        assert tracker.health(now).trusted == (k < 6)


def test_messages_without_a_position_are_no_reason_for_distrust() -> None:
    tracker = Tracker(FRAME)
    now = receive(tracker, lambda t: 0.0, 3.0)
    for k in range(10):
        tracker.update(Bsm(msg_count=k, id="0000000a", sec_mark=(now - 5.0) % 60.0), now)
    assert tracker.health(now).trusted


@pytest.mark.parametrize("lead", [0.4, 0.8, 5.0, 15.0])
@pytest.mark.parametrize("number", [1, 9])
@pytest.mark.parametrize("has_position", [False, True])
@pytest.mark.parametrize("known", [0.0, 3.0])
def test_forged_marks_from_the_future_do_not_move_a_vehicle(
    lead: float, number: int, has_position: bool, known: float
) -> None:
    """Others send under its id, more often than the vehicle itself."""
    tracker = Tracker(FRAME)
    receive(tracker, lambda t: 0.0, known)
    for k in range(round(10.0 * known) + 1, round(10.0 * known) + 60):
        now = receive(tracker, lambda t: 0.0, 0.0, begin=0.1 * k)
        for j in range(number):
            at = 0.1 * k + 0.009 * (j + 1)
            forged = bsm(
                T0 + at + lead, 20.0 * at, id="00000001", n=(k + j + 1) % 128, transmission="forward"
            )
            if not has_position:
                forged = replace(forged, latitude_deg=None, longitude_deg=None)
            tracker.update(forged, T0 + at)
        vehicle = {v.id: v for v in tracker.vehicles(now)}["00000001"]
        assert abs(vehicle.x - 20.0 * (now - T0)) <= 2.0 * vehicle.sigma_along + 0.5
        assert vehicle.age < 0.3


@pytest.mark.parametrize(
    ("changed", "kind", "detail"),
    [
        ({"latitude_deg": 408.1}, "unusable", "latitude_deg must be within +-90 deg, was 408.1"),
        ({"longitude_deg": -200.0}, "unusable", "longitude_deg must be within +-180 deg, was -200"),
        ({"latitude_deg": None}, "unusable", "latitude_deg is missing"),
        ({"sec_mark": 1.7e9}, "unusable", "sec_mark must be within the minute, 0 to 60.999 s, was 1.7e+09"),
        ({"speed": None}, "unusable", "speed or heading is missing, and not known from positions yet"),
        ({"speed": 500.0}, "unusable", "position, speed or size is not that of a road vehicle"),
        ({"id": 77}, "unreadable", "id must be text, was 77"),
        ({"speed": "43"}, "unreadable", "speed must be a finite number or None, was '43'"),
        ({"sec_mark": 2.0}, "future", "measured 0.90 s after its reception"),
        ({"sec_mark": 58.0}, "replay", "measured 3.10 s before its reception"),
    ],
)  # fmt: skip
def test_rejected_message_names_its_fault(changed: dict[str, Any], kind: str, detail: str) -> None:
    valid = Bsm(
        msg_count=0, id="00000001", sec_mark=1.0, latitude_deg=45.0, longitude_deg=14.0, speed=1.0, psi=0.0
    )
    tracker = Tracker(LocalFrame(45.0, 14.0))
    result = tracker.update(replace(valid, **changed), 1777622461.1)
    assert (result.kind, result.detail) == (kind, detail)
    assert tracker.dropped == (result,)
    assert "t=1777622461.1," in repr(result)
    assert tracker.update(valid, 1777622461.1).detail == ""


def test_rejected_messages_are_counted_by_reason() -> None:
    tracker = Tracker(FRAME)
    now = receive(tracker, lambda t: 0.0, 3.0, (0.0,))
    for _ in range(5):
        tracker.update(b"noise", now)
        tracker.update(bsm(T0 + 3.0, 60.0, n=30), now)  # the last one again
    health = tracker.health(now)
    assert health.rejected == (("unreadable", 5.0), ("duplicate", 5.0))
    assert health.received == health.accepted + 10.0
    assert health.trusted
    assert tracker.health(now + 2.0) == TrackerHealth(
        t=now + 2.0, received=0.0, accepted=0.0, clock_offset=health.clock_offset, clock_senders=1
    )


def test_radio_is_not_trusted_if_no_message_is_accepted() -> None:
    tracker = Tracker(FRAME)
    assert tracker.health(T0).trusted
    for k in range(10):
        tracker.update(bsm(T0 + 0.1 * k, latitude_deg=None), T0 + 0.1 * k)
    health = tracker.health(T0 + 0.95)
    assert not health.trusted
    assert health.awareness_range == 0.0
    assert health.reason == "none of 10 messages per second accepted (10 unusable)"


def test_own_and_other_messages_do_not_count() -> None:
    tracker = Tracker(FRAME, own_ids=["000000ee"])
    tracker.update(bsm(T0, id="000000ee"), T0)
    tracker.update("00120a" + 10 * "00", T0)
    assert set(tracker.counts) <= {"own", "other_message", "unreadable"}
    assert tracker.counts["own"] == 1
    assert tracker.dropped == () or tracker.counts["unreadable"]
    tracker.own_ids.add("000000ef")
    assert tracker.update(bsm(T0, id="000000ef"), T0).kind == "own"
    assert len(tracker) == 0


def test_untrusted_radio_blocks_lanes_and_command_names_it() -> None:
    """A slow car ahead that a sensor detects; every message is refused."""
    s = np.arange(0.0, 1001.0, 10.0)
    road = Road(
        fit_path(np.column_stack((s, np.zeros_like(s)))), [Lane(d=0.0), Lane(d=3.5)], speed_limit=30.0
    )
    texts = set()
    for trusted in (True, False):
        planner, tracker = Planner(VehicleParams.bmw_320i(), road, cruise_speed=20.0), Tracker(FRAME)
        actions = set()
        for k in range(150):
            t = 0.02 * k
            if not trusted:
                tracker.update(b"", t)
            state = VehicleState(x=200.0 + 20.0 * t, y=0.0, psi=0.0, v_x=20.0)
            slow = RemoteVehicle(id="slow", x=280.0 + 8.0 * t, y=0.0, psi=0.0, v_x=8.0, source="sensor")
            command = planner.step(t, state, [slow], radio=tracker.health(t))
            actions.add(command.decision.action.is_evading)
            texts.add((trusted, command.input_faults))
        assert (True in actions) == trusted
    assert {faults for trusted, faults in texts if trusted} == {()}
    assert all("messages per second accepted" in faults[0] for trusted, faults in texts if not trusted)


def test_saturated_tracker_is_not_trusted() -> None:
    tracker = Tracker(FRAME, TrackerSettings(max_tracks=2))
    for i in range(3):
        tracker.update(bsm(T0, 40.0 * i, id=f"{i:08x}"), T0)
    assert tracker.health(T0).reason == "more senders than tracks"


@pytest.mark.parametrize("t", [math.nan, None])
def test_invalid_time_raises(t: float) -> None:
    with pytest.raises(InputError, match="t must"):
        Tracker(FRAME).health(t)

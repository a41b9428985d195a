"""Clocks: steps and drift of the operating system's clock, offsets of the senders."""

import numpy as np
import pytest

from cca_core import InputError, LocalFrame, RemoteVehicle
from cca_core.rig import ClockMap, RigClock
from cca_core.v2x import Sender, SenderSettings, Tracker

FRAME = LocalFrame(41.3, -105.6)


def test_map_and_its_inverse() -> None:
    clocks = ClockMap(100.0, 1.7e9 + 1800.25)
    for t in (0.0, 100.0, 5000.0):
        assert clocks.control(clocks.utc(t)) == pytest.approx(t)
    assert clocks.utc(130.5) - clocks.utc(100.0) == pytest.approx(30.5)


def test_minutes_begin_at_multiples_of_60() -> None:
    utc = 1_799_999_990.0
    assert ClockMap(7.0, utc).utc(7.0) % 60.0 == pytest.approx(utc % 60.0, abs=1e-6)


@pytest.mark.parametrize("step", [-5.0, 5.0])
def test_step_of_system_clock_does_not_change_map(step: float) -> None:
    clocks = ClockMap(0.0, 1.7e9)
    before = clocks.utc(20.0)
    for t in range(20):
        error = clocks.compare(t, 1.7e9 + t + (step if t >= 10 else 0.0))
    assert error == pytest.approx(step)
    assert clocks.steps == 1
    assert clocks.utc(20.0) == before


def test_drift_of_system_clock_is_no_step() -> None:
    clocks = ClockMap(0.0, 1.7e9)
    errors = [clocks.compare(t, 1.7e9 + 1.0005 * t) for t in range(0, 600, 10)]
    assert errors[-1] == pytest.approx(0.295, abs=1e-3)
    assert clocks.steps == 0


@pytest.mark.parametrize("offset", [-5.0, -0.3, 0.0, 0.4, 5.0])
def test_sent_time_is_that_of_senders(offset: float) -> None:
    """The map is made by a clock that is wrong; after a second of messages the sent time is right."""
    clocks = ClockMap(0.0, 600.0 + offset)
    tracker, rng = Tracker(FRAME), np.random.default_rng(1)
    senders = [Sender(f"0000000{i}", FRAME, SenderSettings(), rng) for i in range(1, 4)]
    for k in range(300):
        t = 0.02 * k
        for i, sender in enumerate(senders):
            vehicle = RemoteVehicle(id=sender.id, x=100.0 * i, y=10.0, psi=0.0, v_x=0.0)
            data = sender.poll(600.0 + t, vehicle)
            if data is not None:
                tracker.update(data, clocks.utc(t + 0.02))
        if k % 5 == 0:
            clocks.feed(tracker.health(clocks.utc(t)))
    # an offset within the possible latency of messages cannot be told from it
    left = (clocks.senders(6.0) - 606.0 + 1800.0) % 3600.0 - 1800.0
    assert abs(left) < (0.12 if not 0.0 <= offset <= 0.5 else offset + 0.12)
    assert tracker.health(clocks.utc(6.0)).trusted


def test_slow_motion_slows_all_times() -> None:
    now, slept = [10.0], []
    clock = RigClock(0.25, monotonic=lambda: now[0], utc=lambda: 1000.0 + now[0], sleep=slept.append)
    before = clock.now(), clock.utc()
    now[0] += 4.0
    assert (clock.now() - before[0], clock.utc() - before[1]) == (1.0, 1.0)
    clock.sleep(0.02)
    assert slept == [0.08]


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan")])
def test_rate_must_be_positive(rate: float) -> None:
    with pytest.raises(InputError, match="rate"):
        RigClock(rate)

"""Real-time loop in virtual time: schedule, late cycles, counts; what a process asks of the system."""

import gc
import os
import random

import pytest

from cca_core import InputError
from cca_core.real_time import DurationHistogram, RealTimeLoop, RealTimeSettings, real_time_process


class Clock:
    """Virtual time in which a sleep ends late."""

    def __init__(self, lateness: float = 0.0) -> None:
        self.now, self.lateness = 50.0, lateness

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.now += seconds + self.lateness


def loop(clock: Clock) -> RealTimeLoop:
    return RealTimeLoop(0.02, clock=clock, sleep=clock.sleep)


def test_lateness_does_not_add_up() -> None:
    clock = Clock(lateness=0.003)
    cycle, starts = loop(clock), []
    for _ in range(1000):
        clock.now += 0.004
        assert cycle.wait() == 0
        starts.append(clock.now)
    assert starts == pytest.approx([50.0 + 0.02 * (k + 1) + 0.003 for k in range(1000)])
    assert (cycle.missed, cycle.skipped) == (0, 0)
    assert cycle.lateness.quantile_us(0.5) == pytest.approx(3000.0, rel=0.2)
    assert cycle.busy.quantile_us(0.5) == pytest.approx(4000.0, rel=0.2)


def test_late_cycle_is_skipped_and_not_made_up_for() -> None:
    clock = Clock()
    cycle = loop(clock)
    clock.now += 0.07  # the cycles due at 0.02, 0.04 and 0.06 s cannot begin in time
    assert cycle.wait() == 3
    assert clock.now == pytest.approx(50.08)
    assert (cycle.missed, cycle.skipped) == (1, 3)
    assert cycle.wait() == 0
    assert clock.now == pytest.approx(50.10)


def test_cycle_that_ends_when_next_is_due_is_in_time() -> None:
    clock = Clock()
    cycle = loop(clock)
    for _ in range(50):
        clock.now = cycle.due
        assert cycle.wait() == 0
    assert cycle.missed == 0


def test_random_busy_times_never_burst_and_are_counted() -> None:
    rng, clock = random.Random(1), Clock()
    cycle, last, missed, total = loop(clock), clock.now, 0, 0
    for _ in range(3000):
        busy = rng.choice((0.001, 0.01, 0.019, 0.021, 0.05, 0.3))
        missed += clock.now + busy > cycle.due + 1e-9
        clock.now += busy
        total += 1 + cycle.wait()
        assert clock.now - last >= 0.02 - 1e-9
        assert (clock.now - 50.0) / 0.02 == pytest.approx(total)
        last = clock.now
    assert cycle.missed == missed
    assert cycle.skipped == total - 3000


def test_restart_begins_schedule_anew() -> None:
    clock = Clock()
    cycle = loop(clock)
    clock.now += 5.0
    cycle.restart()
    assert cycle.wait() == 0
    assert clock.now == pytest.approx(55.02)


def test_histogram_quantiles_are_within_a_bin() -> None:
    rng, histogram = random.Random(2), DurationHistogram()
    values = sorted(rng.lognormvariate(-7.0, 1.5) for _ in range(5000))
    for value in values:
        histogram.add(value)
    for fraction in (0.01, 0.5, 0.9, 0.99):
        exact = 1e6 * values[int(fraction * 5000)]
        assert exact / 1.25 <= histogram.quantile_us(fraction) <= 1.25 * exact
    assert histogram.quantile_us(1.0) == histogram.max_us == 1e6 * values[-1]
    assert sum(n for _, n in histogram.bins()) == histogram.count == 5000


def test_empty_histogram_and_extreme_durations() -> None:
    histogram = DurationHistogram()
    assert histogram.quantile_us(0.5) == 0.0
    for seconds in (-1.0, 0.0, 1e-9, 1e6):
        histogram.add(seconds)
    assert histogram.quantile_us(0.5) <= 1.0
    assert histogram.max_us == 1e12


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan")])
def test_period_must_be_positive(period: float) -> None:
    with pytest.raises(InputError, match="period"):
        RealTimeLoop(period)


@pytest.mark.parametrize(("name", "value"), [("priority", 100), ("priority", -1), ("cpus", (-1,))])
def test_settings_out_of_range_raise(name: str, value: object) -> None:
    with pytest.raises(InputError, match=name):
        RealTimeSettings(**{name: value})  # type: ignore[arg-type]


@pytest.mark.skipif(not hasattr(os, "sched_getscheduler"), reason="no scheduling classes")
def test_process_gets_back_what_it_had() -> None:
    before = os.sched_getscheduler(0), os.sched_getaffinity(0), gc.get_freeze_count()
    cpu = min(before[1])
    with real_time_process(RealTimeSettings(priority=5, cpus=(cpu,))) as refused:
        assert os.sched_getaffinity(0) == {cpu}
        assert gc.get_freeze_count() > before[2]
        assert ("priority" in refused) == (os.sched_getscheduler(0) != os.SCHED_FIFO)
    assert (os.sched_getscheduler(0), os.sched_getaffinity(0), gc.get_freeze_count()) == before


def test_refused_requests_are_named() -> None:
    with real_time_process(RealTimeSettings(cpus=(9999,))) as refused:
        assert list(refused) == ["cpus"]

"""Real-time loop: absolute schedule, late cycles are skipped, lateness and busy time are counted."""

import ctypes
import gc
import math
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError

__all__ = ["DurationHistogram", "RealTimeLoop", "RealTimeSettings", "real_time_process"]

_BINS_PER_OCTAVE, _N_BINS = 4, 100  # from 1 us to 30 s, each 19 % wide


class DurationHistogram:
    """Histogram of durations with bins of equal ratio; its memory does not grow.

    Attributes
    ----------
    count : int
        Number of durations.
    max_us : float
        Longest duration [us].
    """

    def __init__(self) -> None:
        self.count, self.max_us = 0, 0.0
        self._bins = [0] * _N_BINS

    def add(self, seconds: float) -> None:
        """Count a duration.

        Parameters
        ----------
        seconds : float
            Duration [s]; a negative one counts as 0.
        """
        us = max(1e6 * seconds, 0.0)
        index = 0 if us <= 1.0 else math.ceil(_BINS_PER_OCTAVE * math.log2(us))
        self._bins[min(index, _N_BINS - 1)] += 1
        self.count, self.max_us = self.count + 1, max(self.max_us, us)

    def quantile_us(self, fraction: float) -> float:
        """Duration that a fraction of all does not exceed.

        Parameters
        ----------
        fraction : float
            Fraction [-], 0 to 1.

        Returns
        -------
        duration : float
            Upper end of the bin, at most the longest duration [us]; 0 without durations.

        Raises
        ------
        InputError
            If the fraction is out of range.
        """
        rank, n = check_real("fraction", fraction, ge=0.0, le=1.0) * self.count, 0
        for index, size in enumerate(self._bins):
            n += size
            if n >= rank and n:
                return min(math.exp2(index / _BINS_PER_OCTAVE), self.max_us)
        return 0.0

    def bins(self) -> list[tuple[float, int]]:
        """Bins that are not empty.

        Returns
        -------
        bins : list of (float, int)
            Upper end [us] and number of each.
        """
        return [(math.exp2(i / _BINS_PER_OCTAVE), size) for i, size in enumerate(self._bins) if size]

    def summary(self) -> dict[str, float]:
        """Key figures for a report.

        Returns
        -------
        summary : dict
            Median, 99th percentile and maximum [us].
        """
        return {
            "median_us": round(self.quantile_us(0.5), 1), "p99_us": round(self.quantile_us(0.99), 1),
            "max_us": round(self.max_us, 1),
        }  # fmt: skip


class RealTimeLoop:
    """Schedule of a cyclic task.

    Parameters
    ----------
    period : float
        Time between two cycles [s], positive.
    clock, sleep : callable
        Monotonic time [s], and waiting for a time [s]; given by tests and slow-motion runs.

    Attributes
    ----------
    period : float
        The same [s].
    missed : int
        Number of cycles that ended after the next one was due.
    skipped : int
        Number of cycles that were left out for that.
    lateness, busy : DurationHistogram
        Start after the scheduled time, and time at work, of each cycle.

    Raises
    ------
    InputError
        If the period is not positive.

    Notes
    -----
    Cycle k is due at the start plus k periods, whatever the cycles before did: errors do not add up. A cycle
    that ends late is followed by the next one that is still ahead. Cycles are never made up for in a burst.
    """

    def __init__(
        self,
        period: float,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], object] = time.sleep,
    ) -> None:
        self.period = check_real("period", period, gt=0.0)
        self.missed = self.skipped = 0
        self.lateness, self.busy = DurationHistogram(), DurationHistogram()
        self._clock, self._sleep = clock, sleep
        self._begin = self._woken = clock()
        self._k = 0

    @property
    def due(self) -> float:
        """Time at which the next cycle is due [s]."""
        return self._begin + (self._k + 1) * self.period

    def restart(self) -> None:
        """Begin the schedule anew, with a cycle that starts now."""
        self._begin = self._woken = self._clock()
        self._k = 0

    def wait(self) -> int:
        """End a cycle and wait for the next one.

        Returns
        -------
        skipped : int
            Number of cycles that were left out because this one ended late.
        """
        now = self._clock()
        self.busy.add(now - self._woken)
        skipped = 0
        if now > self.due + 1e-9:
            self.missed += 1
            skipped = max(math.ceil((now - self._begin) / self.period - 1e-9) - self._k - 1, 0)
            self.skipped += skipped
        self._k += skipped + 1
        scheduled = self._begin + self._k * self.period
        if scheduled > now:
            self._sleep(scheduled - now)
        self._woken = self._clock()
        self.lateness.add(self._woken - scheduled)
        return skipped

    def summary(self) -> dict[str, Any]:
        """Key figures for a report.

        Returns
        -------
        summary : dict
            Numbers of cycles, misses and skipped cycles; lateness and busy time [us].
        """
        return {
            "cycles": self.busy.count, "missed": self.missed, "skipped": self.skipped,
            "lateness": self.lateness.summary(), "busy": self.busy.summary(),
        }  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class RealTimeSettings:
    """What a process asks of the operating system.

    Parameters
    ----------
    priority : int
        Priority of the class SCHED_FIFO, 1 to 99 [-]; 0 is the normal class.
    lock_memory : bool
        Whether all memory stays in RAM.
    cpus : tuple of int
        Processors that the process may use; none are all.
    freeze_gc : bool
        Whether objects that exist at the start are left out of garbage collection.

    Raises
    ------
    InputError
        If the priority is out of range or a processor is negative.
    """

    priority: int = 0
    lock_memory: bool = False
    cpus: tuple[int, ...] = ()
    freeze_gc: bool = True

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_real("priority", self.priority, ge=0, le=99)
        if any(cpu < 0 for cpu in self.cpus):
            raise InputError(f"cpus must be at least 0, was {min(self.cpus)}")


@contextmanager
def real_time_process(settings: RealTimeSettings | None = None) -> Iterator[dict[str, str]]:
    """Ask the operating system for what a real-time process needs; the end of the block takes it back.

    Parameters
    ----------
    settings : RealTimeSettings, optional
        The default only freezes the objects that exist.

    Yields
    ------
    refused : dict
        What was not granted (``"priority"``, ``"lock_memory"``, ``"cpus"``), and why. The process runs
        nevertheless.
    """
    settings = settings or RealTimeSettings()
    refused: dict[str, str] = {}
    undo: list[Callable[[], object]] = []

    def ask(name: str, change: Callable[[], Callable[[], object]]) -> None:
        try:
            undo.append(change())
        except (OSError, AttributeError, ValueError) as error:  # not allowed, or not on this system
            refused[name] = str(error)

    if settings.cpus:
        ask("cpus", lambda: _set_affinity(settings.cpus))
    if settings.lock_memory:
        ask("lock_memory", _lock_memory)
    if settings.priority:
        ask("priority", lambda: _set_priority(settings.priority))
    if settings.freeze_gc:
        gc.collect()
        gc.freeze()
        undo.append(gc.unfreeze)
    try:
        yield refused
    finally:
        for take_back in reversed(undo):
            take_back()


def _set_affinity(cpus: tuple[int, ...]) -> Callable[[], object]:
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cpus)
    return lambda: os.sched_setaffinity(0, before)


def _set_priority(priority: int) -> Callable[[], object]:
    before, parameters = os.sched_getscheduler(0), os.sched_getparam(0)
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    return lambda: os.sched_setscheduler(0, before, parameters)


def _lock_memory() -> Callable[[], object]:
    """Lock present and future memory (mlockall)."""
    library = ctypes.CDLL(None, use_errno=True)
    if library.mlockall(3):  # MCL_CURRENT | MCL_FUTURE
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return lambda: library.munlockall()

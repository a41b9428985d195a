"""Clocks of the rig: monotonic time for control, UTC for messages, and the conversion."""

import time
from collections.abc import Callable

from cca_core._checks import check_real
from cca_core.v2x import TrackerHealth

_PERIOD = 3600.0  # its start is that of message times, so that minutes begin at multiples of 60 [s]


class RigClock:
    """Monotonic time for control, which can be slowed down.

    Parameters
    ----------
    rate : float
        Seconds of the rig per second of the wall clock [-]. All processes of a rig need the same.
    monotonic, utc, sleep : callable
        Sources of time [s], and waiting for a time [s]; given by tests.

    Raises
    ------
    InputError
        If the rate is not positive.
    """

    def __init__(
        self,
        rate: float = 1.0,
        *,
        monotonic: Callable[[], float] = time.monotonic,
        utc: Callable[[], float] = time.time,
        sleep: Callable[[float], object] = time.sleep,
    ) -> None:
        self.rate = check_real("rate", rate, gt=0.0)
        self._monotonic, self._utc, self._sleep = monotonic, utc, sleep

    def now(self) -> float:
        """Return the control time.

        Returns
        -------
        t : float
            Monotonic time [s].
        """
        return self.rate * self._monotonic()

    def utc(self) -> float:
        """Return UTC of the operating system, which can step.

        Returns
        -------
        utc : float
            UTC at the rate of the rig [s].
        """
        return self.rate * self._utc()

    def sleep(self, seconds: float) -> None:
        """Wait.

        Parameters
        ----------
        seconds : float
            Time of the rig [s].
        """
        self._sleep(seconds / self.rate)


class ClockMap:
    """Conversion between control time and UTC, made once.

    Parameters
    ----------
    t : float
        Control time now [s].
    utc : float
        UTC of the operating system now [s].

    Attributes
    ----------
    correction : float
        UTC of this map minus that of the senders [s], as the radio has found it from their messages.
    steps : int
        Number of steps of the operating system's clock [-]; they do not change the map.

    Raises
    ------
    InputError
        If a time is not finite.

    Notes
    -----
    The receiver gets its times from `utc`, which never steps. If the operating system's clock was wrong at
    the start, the tracker finds the offset from the messages (`TrackerHealth.clock_correction`). Sent
    messages carry `senders`, the time on which the senders agree.
    """

    def __init__(self, t: float, utc: float) -> None:
        t, utc = check_real("t", t), check_real("utc", utc)
        self._offset = utc - t
        self._hour = utc // _PERIOD * _PERIOD
        self.correction, self.steps = 0.0, 0
        self._error = 0.0  # of the operating system's clock against this map [s]

    def utc(self, t: float) -> float:
        """UTC at a control time.

        Parameters
        ----------
        t : float
            Control time [s].

        Returns
        -------
        utc : float
            UTC since the start of the hour in which the map was made [s].
        """
        return t + self._offset - self._hour

    def control(self, utc: float) -> float:
        """Control time at a UTC.

        Parameters
        ----------
        utc : float
            UTC since the start of that hour [s].

        Returns
        -------
        t : float
            Control time [s].
        """
        return utc - self._offset + self._hour

    def senders(self, t: float) -> float:
        """UTC of the senders at a control time.

        Parameters
        ----------
        t : float
            Control time [s].

        Returns
        -------
        utc : float
            UTC on which the senders agree, since the start of that hour [s].
        """
        return self.utc(t) - self.correction

    def feed(self, health: TrackerHealth) -> None:
        """Take the offset that the radio has found.

        Parameters
        ----------
        health : TrackerHealth
            Result of `Tracker.health`.
        """
        self.correction = health.clock_correction

    def compare(self, t: float, utc: float, *, tolerance: float = 0.1) -> float:
        """Compare the operating system's clock with the map.

        Parameters
        ----------
        t : float
            Control time now [s].
        utc : float
            UTC of the operating system now [s].
        tolerance : float
            Change since the last comparison from which on it counts as a step [s].

        Returns
        -------
        error : float
            Operating system's UTC minus that of the map [s]; it grows with drift and steps.
        """
        error = utc - t - self._offset
        self.steps += abs(error - self._error) > tolerance
        self._error = error
        return error

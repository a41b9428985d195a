"""Offset of the receiver's clock from the senders', estimated from their messages."""

import math
from collections import deque
from collections.abc import Sequence

from cca_core.v2x.plausibility import PlausibilitySettings

__all__ = ["SenderClocks"]

_INTERVAL = 0.5  # between two estimates [s]
_MEMORY = 10.0  # time for which the marks of a sender count [s]
_MAX_SENDERS = 64  # enough for a median
_RECENT, _MIN_MARKS, _MIN_SPAN = 8, 4, 0.3  # marks that show a step of the clock, and their least span [s]
_SET_BACK = 0.5  # step of the reception time that is a clock set back [s]
_MAX_LATENCY = 0.6  # a larger delay is an offset of the clock [s]
_PROVEN = 2.0  # time without a timely message after which a sender's clock is ahead [s]
_LATE = 0.5  # and after which its messages are too old [s]
_SLEW = 0.05  # rate at which the correction follows the offset [s/s]


class _Marks:
    """Last second marks of one sender: times of reception, and reception minus mark."""

    __slots__ = ("ahead", "begun", "delay", "delays", "lowest", "mark", "received", "timely")

    def __init__(self) -> None:
        self.mark: float | None = None
        self.ahead = 0.0  # by which its clock is ahead of the others [s], 0 if it is not
        # of the usable messages, in order or not: the last delay, and the times of reception of the first
        # one, the last one and the last one whose delay was acceptable [s]
        self.delay, self.begun, self.received, self.timely = 0.0, math.inf, -math.inf, -math.inf
        self.lowest = math.inf  # of the delays, up to the next estimate that of `low` [s]
        self.delays: deque[tuple[float, float]] = deque(maxlen=100)

    def recent(self) -> float | None:
        """Return a low quantile of the last few delays; None if they are too few."""
        last = list(self.delays)[-_RECENT:]
        if len(last) < _MIN_MARKS or last[-1][0] - last[0][0] < _MIN_SPAN:
            return None
        return sorted(delay for _, delay in last)[len(last) >= 6]

    def low(self, t: float) -> float:
        """Return the 10 % quantile of the delays of the last 10 s."""
        delays = sorted(delay for t_received, delay in self.delays if t - t_received <= _MEMORY)
        return delays[len(delays) // 10] if delays else self.delays[-1][1]


class SenderClocks:
    """Difference between reception and second marks: the median over senders of a low quantile."""

    # A difference between 0 and 0.6 s can be latency: the messages are that old, and nothing is
    # corrected. Any other is an offset, of which a correction leaves `latency`, the age assumed of the
    # youngest messages.

    def __init__(self, checks: PlausibilitySettings, latency: float) -> None:
        self.correction = 0.0  # receiver's clock minus the time base of the tracks [s]
        self.offset: float | None = None
        self.n_senders = self.n_agreeing = 0
        self._checks, self._latency = checks, latency
        self._senders: dict[str, _Marks] = {}
        self._t = self._t_estimated = -math.inf

    def tick(self, t: float) -> None:
        """Advance to a time of reception [s]; a clock that was set back is corrected at once."""
        step = t - self._t
        if -math.inf < step < -_SET_BACK:
            self.correction += step
            self._t_estimated += step
            for marks in self._senders.values():
                shifted = [(t_received + step, delay + step) for t_received, delay in marks.delays]
                marks.delays = deque(shifted, maxlen=marks.delays.maxlen)
                marks.delay, marks.begun = marks.delay + step, marks.begun + step
                marks.received, marks.timely = marks.received + step, marks.timely + step
                marks.lowest += step
        self._t = t
        if abs(t - self._t_estimated) >= _INTERVAL:
            self._estimate(t)

    def add_mark(self, sender: str, mark: float, t: float) -> None:
        """Take the second mark of a message into account."""
        marks = self._senders.get(sender)
        if marks is None:
            if len(self._senders) >= _MAX_SENDERS:
                return
            marks = self._senders[sender] = _Marks()
        # an earlier mark comes from a late or replayed message, an equal one is not new
        elif marks.mark is not None and (mark - marks.mark + 30.0) % 60.0 <= 30.0:
            return
        marks.mark = mark
        delay = self._delay(mark, t)
        marks.delays.append((t, delay))
        marks.lowest = min(marks.lowest, delay)

    def ahead(self, sender: str, mark: float, t: float) -> float:
        """Take a usable message into account; return by how much the clock of its sender is ahead [s].

        No latency makes a message come from the future. The sender's youngest messages then have the age
        `latency`. A single timely message shows that others forge its marks, or that its clock was set.
        """
        marks = self._senders.get(sender)
        if marks is None:
            return 0.0
        marks.delay = self._delay(mark, t)
        marks.begun, marks.received = min(marks.begun, t), t
        if self._is_acceptable(marks.delay):
            marks.timely, marks.ahead = t, 0.0
        return marks.ahead

    def late_sender(self, t: float) -> tuple[str, float] | None:
        """Return a sender whose usable messages are all too old, and the age of the last one [s]."""
        for sender, marks in self._senders.items():
            age = marks.delay - self.correction
            is_late = age > self._checks.age_limit and t - marks.received < 1.0
            if is_late and marks.received - max(marks.begun, marks.timely) > _LATE:
                return sender, age
        return None

    def _delay(self, mark: float, t: float) -> float:
        """Return the time of reception minus a mark, in the minute nearest to the correction [s]."""
        return (t - mark - self.correction + 30.0) % 60.0 - 30.0 + self.correction

    def error(self, sender: str, age: float) -> float:
        """Return how far the time of a sender's message may be off that has an apparent age [s].

        The apparent age of its youngest messages may be latency or an error of either clock, and a latency of
        up to `latency` may be hidden behind such an error. Of the last few messages the youngest one counts,
        so that the error is known soon after a clock has stepped. What comes from the future is rejected.
        """
        marks, limit = self._senders.get(sender), -self._checks.clock_error
        youngest = recent = age
        if marks is not None and marks.ahead:
            return max(age, _MAX_LATENCY - self._latency)
        if marks is not None:
            youngest = min(age, marks.lowest - self.correction)
            last = (delay - self.correction for _, delay in list(marks.delays)[-_RECENT:])
            recent = min((x for x in last if x >= limit), default=age)
        return max(min(age, recent), self._latency - max(youngest, limit))

    def _estimate(self, t: float) -> None:
        """Update offset and correction."""
        elapsed, self._t_estimated = min(t - self._t_estimated, 2.0 * _INTERVAL), t
        for sender in [s for s, m in self._senders.items() if not m.delays or t - m.delays[-1][0] > _MEMORY]:
            del self._senders[sender]
        for marks in self._senders.values():
            marks.lowest = marks.low(t)
        recent = {s: low for s, m in self._senders.items() if (low := m.recent()) is not None}
        others = [m.lowest for s, m in self._senders.items() if s not in recent and t - m.delays[-1][0] < 1.0]
        self.n_senders = len(recent)
        if not recent:
            self.n_agreeing = 0
            return
        expected = self.correction if self.offset is None else self.offset
        step = _median([*recent.values(), *others], expected)
        if not -self._checks.clock_error <= step - self.correction <= _MAX_LATENCY:
            self.offset, self.correction = step, step - self._latency
            for marks in self._senders.values():
                marks.delays = deque(list(marks.delays)[-_RECENT:], maxlen=marks.delays.maxlen)
                marks.lowest = marks.low(t)
        else:
            agreeing = [s for s, low in recent.items() if self._is_acceptable(low)]
            self.offset = _median([self._senders[s].lowest for s in agreeing] or [step], expected)
            self._follow(self.offset, elapsed)
        self.n_agreeing = sum(map(self._is_acceptable, recent.values()))
        for sender, low in recent.items():
            marks, age = self._senders[sender], low - self.correction
            is_ahead = age < -self._checks.clock_error and t - marks.timely > _PROVEN
            marks.ahead = self._latency - age if is_ahead else 0.0

    def _is_acceptable(self, delay: float) -> bool:
        """Return whether a message with a delay passes the checks of its time."""
        return -self._checks.clock_error <= delay - self.correction <= self._checks.age_limit

    def _follow(self, offset: float, elapsed: float) -> None:
        """Move the correction toward an offset."""
        is_latency = -0.02 <= offset <= _MAX_LATENCY if self.correction == 0.0 else 0.05 <= offset <= 0.5
        target = 0.0 if is_latency else offset - self._latency
        change = target - self.correction
        self.correction = (
            target
            if abs(change) <= _SLEW * elapsed
            else (self.correction + math.copysign(_SLEW * elapsed, change))
        )


def _median(values: Sequence[float], expected: float) -> float:
    """Return the median; of two in the middle the one closer to the expected value."""
    ranked = sorted(values)
    low, high = ranked[(len(ranked) - 1) // 2], ranked[len(ranked) // 2]
    return low if abs(low - expected) <= abs(high - expected) else high

"""Health of a radio: what is received, accepted and rejected, and the offset of its clock."""

import math
from collections import Counter, deque
from dataclasses import dataclass

from cca_core._repr import short_repr
from cca_core.v2x.update_result import ACCEPTED_KINDS, UNCOUNTED_KINDS

__all__ = ["MessageRates", "TrackerHealth"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerHealth:
    """Health of a radio in the last second.

    Parameters
    ----------
    t : float
        Time [s].
    received, accepted : float
        Messages received and accepted per second [1/s], without the ego's own ones and other types.
    rejected : tuple of (str, float)
        Rejected messages per second by `UpdateResult.kind` [1/s], the most frequent first.
    clock_offset : float or None
        Receiver's clock minus the senders' [s], which includes the latency; None before the first estimate.
        Offsets of minutes do not show.
    clock_correction : float
        Part of the offset that the tracker subtracts from its times [s].
    clock_senders : int
        Number of senders of the estimate.
    reason : str
        Why the radio cannot be trusted; empty if it can.

    Examples
    --------
    >>> from cca_core import LocalFrame
    >>> from cca_core.v2x import Tracker
    >>> tracker = Tracker(LocalFrame(45.0, 14.0))
    >>> tracker.update(b"no message", 7.0).kind
    'unreadable'
    >>> health = tracker.health(7.0)
    >>> health.trusted, health.awareness_range, health.rejected
    (False, 0.0, (('unreadable', 1.0),))
    """

    t: float
    received: float
    accepted: float
    rejected: tuple[tuple[str, float], ...] = ()
    clock_offset: float | None = None
    clock_correction: float = 0.0
    clock_senders: int = 0
    reason: str = ""

    __repr__ = short_repr

    @property
    def trusted(self) -> bool:
        """Whether the absence of a vehicle from the tracks means anything."""
        return not self.reason

    @property
    def awareness_range(self) -> float:
        """Awareness range for `Planner.step` [m]: 0 if the radio cannot be trusted, else infinite."""
        return math.inf if self.trusted else 0.0


class MessageRates:
    """Numbers of results by kind in the last second, in bins of 0.1 s."""

    def __init__(self) -> None:
        self._bins: deque[tuple[int, Counter[str]]] = deque(maxlen=30)

    def add(self, kind: str, t: float) -> None:
        """Count a result at a time [s]."""
        index = math.floor(10.0 * t)
        if self._bins and index < self._bins[-1][0] - 5:  # the clock was set back
            self._bins.clear()
        if not self._bins or self._bins[-1][0] < index:
            self._bins.append((index, Counter()))
        self._bins[-1][1][kind] += 1

    def last_second(self, t: float) -> Counter[str]:
        """Return the counts of the last second, without those that do not depend on the radio."""
        index, total = math.floor(10.0 * t), Counter[str]()
        for at, counts in self._bins:
            if index - 10 < at <= index + 5:  # messages may be processed ahead of the time of a cycle
                for kind, n in counts.items():
                    if kind not in UNCOUNTED_KINDS:
                        total[kind] += n
        return total


def health_of(
    counts: Counter[str],
    t: float,
    is_saturated: bool,
    clock: tuple[float | None, float, int, int],
    late_sender: tuple[str, float] | None,
) -> TrackerHealth:
    """Return the health of a radio from the counts of a second and its clock."""
    offset, correction, n_senders, n_agreeing = clock
    rejected = tuple((kind, float(n)) for kind, n in counts.most_common() if kind not in ACCEPTED_KINDS)
    received = sum(counts.values())
    accepted = received - round(sum(rate for _, rate in rejected))
    reason = ""
    if received and not accepted:
        kind, rate = rejected[0]
        reason = f"none of {received} messages per second accepted ({rate:.0f} {kind})"
    elif is_saturated:
        reason = "more senders than tracks"
    elif n_senders and 2 * n_agreeing <= n_senders:
        reason = f"clocks of {n_senders - n_agreeing} of {n_senders} senders disagree"
    elif late_sender is not None:
        reason = f"all messages of {late_sender[0]} are {late_sender[1]:.1f} s old, or its clock is behind"
    return TrackerHealth(
        t=t, received=float(received), accepted=float(accepted), rejected=rejected, clock_offset=offset,
        clock_correction=correction, clock_senders=n_senders, reason=reason,
    )  # fmt: skip

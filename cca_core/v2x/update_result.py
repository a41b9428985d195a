"""What became of a message."""

from dataclasses import dataclass

__all__ = ["UpdateResult"]


@dataclass(frozen=True, slots=True, kw_only=True)
class UpdateResult:
    """What a tracker did with a message.

    Parameters
    ----------
    accepted : bool
        Whether the sender's track follows it.
    kind : str
        Accepted: ``"new"``, ``"updated"``, ``"returned"`` (believed again after a jump) or
        ``"took_over"`` (a new id of a sender that is known). Dropped: ``"unreadable"``, ``"unusable"`` (a
        value needed is not available, or not that of a road vehicle), ``"duplicate"``, ``"out_of_order"``,
        ``"full"``, or the name of a plausibility check.
    id : str
        Sender; empty if unreadable.
    t : float
        When the message was received [s].
    """

    accepted: bool
    kind: str
    id: str
    t: float

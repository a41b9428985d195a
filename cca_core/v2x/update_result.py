"""Result of a tracker's update."""

from dataclasses import dataclass

__all__ = ["ACCEPTED_KINDS", "UpdateResult"]

ACCEPTED_KINDS = frozenset({"new", "updated", "readmitted", "reassociated"})
"""Kinds of accepted messages."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UpdateResult:
    """Result of an update with one message.

    Parameters
    ----------
    accepted : bool
        Whether the message updated the sender's track.
    kind : str
        Accepted: ``"new"``, ``"updated"``, ``"readmitted"`` (after rejected positions) or ``"reassociated"``
        (new id of a known sender). Rejected: ``"unreadable"``, ``"unusable"`` (a required value is
        unavailable, or not that of a road vehicle), ``"duplicate"``, ``"out_of_order"``, ``"full"``, or the
        name of a plausibility check. Neither: ``"other_message"``, a message without a vehicle.
    id : str
        Sender; empty if unreadable or of another kind.
    t : float
        Time of reception [s].
    message : str
        Kind of the message: ``"BSM"``, ``"SPaT"``, ``"MAP"``, ``"TIM"``, ``"PSM"`` and so on; empty if
        unreadable.
    signed : str or None
        ``"unverified"`` if the message came in signed data: the signature was not checked. None without.
    """

    accepted: bool
    kind: str
    id: str
    t: float
    message: str = "BSM"
    signed: str | None = None

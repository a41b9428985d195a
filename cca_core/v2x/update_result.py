"""Result of a tracker's update."""

from dataclasses import dataclass

from cca_core._repr import short_repr

__all__ = ["ACCEPTED_KINDS", "UNCOUNTED_KINDS", "UpdateResult"]

ACCEPTED_KINDS = frozenset({"new", "updated", "readmitted", "reassociated", "separated"})
"""Kinds of accepted messages."""

UNCOUNTED_KINDS = frozenset({"own", "other_message"})
"""Kinds of rejected messages that do not depend on the health of the radio."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UpdateResult:
    """Result of an update with one message.

    Parameters
    ----------
    accepted : bool
        Whether the message updated the sender's track.
    kind : str
        Accepted: ``"new"``, ``"updated"``, ``"readmitted"`` (after rejected positions), ``"reassociated"``
        (new id of a known sender) or ``"separated"`` (second body under one id). Rejected: ``"unreadable"``,
        ``"unusable"`` (a required value is unavailable, or not that of a road vehicle), ``"duplicate"``,
        ``"out_of_order"``, ``"full"``, or the name of a plausibility check. Neither: ``"own"``, a message of
        the ego, and ``"other_message"``, one without a vehicle.
    id : str
        Sender; empty if unreadable or of another kind.
    t : float
        Time of reception [s].
    message : str
        Kind of the message: ``"BSM"``, ``"SPaT"``, ``"MAP"``, ``"TIM"``, ``"PSM"`` and so on; empty if
        unreadable.
    signed : str or None
        ``"unverified"`` if the message came in signed data: the signature was not checked. None without.
    detail : str
        What is wrong with a message that is ``"unreadable"`` or ``"unusable"``, and by how much the time of
        one is off that is from the ``"future"`` or a ``"replay"``; else empty.
    """

    accepted: bool
    kind: str
    id: str
    t: float
    message: str = "BSM"
    signed: str | None = None
    detail: str = ""

    __repr__ = short_repr

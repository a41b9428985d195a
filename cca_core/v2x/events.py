"""Part II of a Basic Safety Message: the event flags; all other content is skipped whole."""

from collections.abc import Set

from cca_core.errors import InputError
from cca_core.v2x.uper import open_type, take, take_open_type

__all__ = ["EVENTS", "decode_events", "encode_events"]

EVENTS = (
    "hazard_lights", "stop_line_violation", "abs_activated", "traction_control_loss",
    "stability_control_activated", "hazardous_materials", "reserved", "hard_braking", "lights_changed",
    "wipers_changed", "flat_tire", "disabled_vehicle", "air_bag_deployment", "jackknife",
)  # fmt: skip
"""Names of the event flags, in their order on the wire; the last one came with the edition of 2024."""

_SAFETY = 0  # kind of Part II content that holds the event flags
_ROOT = 13  # flags of the first edition; more need their number before them
_BIT = {name: i for i, name in enumerate(EVENTS)}
_NONE: frozenset[str] = frozenset()


def decode_events(bits: int, left: int) -> frozenset[str]:
    """Read the event flags out of Part II.

    Parameters
    ----------
    bits : int
        The message.
    left : int
        Its bits not yet read: Part II and what follows.

    Returns
    -------
    events : frozenset of str
        Names among `EVENTS`; flags of later editions have no name and are left out.

    Raises
    ------
    InputError
        If Part II is cut off or not well formed.
    """
    more, left = take(bits, left, 3)
    events = _NONE
    for _ in range(more + 1):
        kind, left = take(bits, left, 6)
        content, n_bits, left = take_open_type(bits, left)
        if kind == _SAFETY:
            events |= _flags(content, n_bits)
    return events


def _flags(content: int, left: int) -> frozenset[str]:
    head, left = take(content, left, 5)  # additions, then presence: events, history, prediction, lights
    if not head & 0b01000:
        return _NONE
    longer, left = take(content, left, 1)
    count = _ROOT
    if longer:
        count, left = take(content, left, 8)
        if count & 0x80:
            raise InputError(f"data must have fewer than 128 event flags, had the length code {count}")
    flags, left = take(content, left, count)
    if not flags:
        return _NONE
    text = f"{flags:0{count}b}"
    return frozenset(name for name, flag in zip(EVENTS, text, strict=False) if flag == "1")


def encode_events(events: Set[str]) -> tuple[int, int]:
    """Write a Part II that holds nothing but event flags.

    Parameters
    ----------
    events : set of str
        Names among `EVENTS`, at least one.

    Returns
    -------
    bits : int
        Part II.
    n_bits : int
        Its length in bits.

    Raises
    ------
    InputError
        If a name is none of `EVENTS`.
    """
    try:
        flags = sum(1 << len(EVENTS) - 1 - _BIT[name] for name in events)
    except (KeyError, TypeError):
        raise InputError(f"events must be a set of names among {', '.join(EVENTS)}, was {events!r}") from None
    if flags & 1:
        content, n_bits = 0b01000_1 << 22 | len(EVENTS) << 14 | flags, 28
    else:
        content, n_bits = 0b01000_0 << _ROOT | flags >> 1, 6 + _ROOT
    bits, n_bits = open_type(content, n_bits)
    return bits, 9 + n_bits  # before it: one part (000) of kind 0 (000000)

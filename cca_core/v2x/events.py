"""Event flags in Part II of a Basic Safety Message."""

from collections.abc import Set

from cca_core._checks import shown
from cca_core.errors import InputError
from cca_core.v2x.uper import open_type, take, take_open_type

__all__ = ["EVENTS", "decode_events", "encode_events"]

EVENTS = (
    "hazard_lights", "stop_line_violation", "abs_activated", "traction_control_loss",
    "stability_control_activated", "hazardous_materials", "reserved", "hard_braking", "lights_changed",
    "wipers_changed", "flat_tire", "disabled_vehicle", "air_bag_deployment", "jackknife",
)  # fmt: skip
"""Names of the event flags, in their order on the wire; the last one came with the edition of 2024."""

_ROOT = 13  # flags of the first edition; more need their number before them


def decode_events(bits: int, left: int) -> frozenset[str]:
    """Return the names of the event flags in Part II; flags without a name are ignored."""
    more, left = take(bits, left, 3)
    events: frozenset[str] = frozenset()
    for _ in range(more + 1):
        kind, left = take(bits, left, 6)
        content, n_bits, left = take_open_type(bits, left)
        if kind == 0:  # safety extensions
            events |= _flags(content, n_bits)
    return events


def _flags(content: int, left: int) -> frozenset[str]:
    """Return the names of the event flags in the safety extensions."""
    head, left = take(content, left, 5)  # additions, then presence: events, history, prediction, lights
    if not head & 0b01000:
        return frozenset()
    longer, left = take(content, left, 1)
    count = _ROOT
    if longer:
        count, left = take(content, left, 8)
        if count & 0x80:
            raise InputError(f"data must have fewer than 128 event flags, had the length code {count}")
    flags, left = take(content, left, count)
    if not flags:
        return frozenset()
    text = f"{flags:0{count}b}"
    return frozenset(name for name, flag in zip(EVENTS, text, strict=False) if flag == "1")


def encode_events(events: Set[str]) -> tuple[int, int]:
    """Return a Part II that holds event flags only: its bits and their number."""
    try:
        flags = sum(1 << len(EVENTS) - 1 - EVENTS.index(name) for name in events)
    except (TypeError, ValueError):
        raise InputError(f"events must be names among {', '.join(EVENTS)}, was {shown(events)}") from None
    if flags & 1:
        content, n_bits = 0b01000_1 << 22 | len(EVENTS) << 14 | flags, 28
    else:
        content, n_bits = 0b01000_0 << _ROOT | flags >> 1, 6 + _ROOT
    bits, n_bits = open_type(content, n_bits)
    return bits, 9 + n_bits  # before it: one part (000) of kind 0 (000000)

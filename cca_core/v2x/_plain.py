"""Messages from callers: values of any type to Python's own types."""

import math
import operator
from collections.abc import Set
from dataclasses import replace
from typing import Any

from cca_core._checks import shown
from cca_core.errors import InputError
from cca_core.v2x.message import Bsm, PositionalAccuracy

__all__ = ["plain_bsm", "read_count", "read_number", "unusable_value"]

_TRACKED = (
    "sec_mark", "latitude_deg", "longitude_deg", "elevation", "speed", "psi", "a_x", "r", "width", "length",
)  # fmt: skip


def plain_bsm(bsm: Bsm) -> Bsm:
    """Return a message whose values for tracking are of Python's own types; they may be NaN or infinite."""
    changed: dict[str, Any] = {}
    for name in _TRACKED:
        value = getattr(bsm, name)
        if value is not None and type(value) is not float:
            changed[name] = read_number(name, value)
    if type(bsm.msg_count) is not int:
        changed["msg_count"] = read_count(bsm.msg_count)
    id: Any = bsm.id
    events: Any = bsm.events
    if not isinstance(id, str):
        raise InputError(f"id must be text, was {shown(id)}")
    if not isinstance(events, Set) or not all(isinstance(name, str) for name in events):
        raise InputError(f"events must be a set of names, was {shown(events)}")
    if type(id) is not str or type(events) is not frozenset:
        changed |= {"id": str(id), "events": frozenset(map(str, events))}
    gear: Any = bsm.transmission
    if gear is not None and not isinstance(gear, str):
        raise InputError(f"transmission must be text or None, was {shown(gear)}")
    major = getattr(bsm.accuracy, "semi_major", None)
    if major is not None and type(major) is not float:
        changed["accuracy"] = PositionalAccuracy(semi_major=read_number("semi_major", major))
    return replace(bsm, **changed) if changed else bsm


def unusable_value(bsm: Bsm) -> str:
    """Return which value of a message keeps it from being tracked; empty if none is missing or out of range.

    The largest code of a speed means that or more: no speed of a road vehicle.
    """
    for name, limit in (("latitude_deg", 90.0), ("longitude_deg", 180.0)):
        value = getattr(bsm, name)
        if value is None:
            return f"{name} is missing"
        if not abs(value) <= limit:
            return f"{name} must be within +-{limit:g} deg, was {value:g}"
    mark = bsm.sec_mark
    if mark is not None and not 0.0 <= mark < 61.0:
        return f"sec_mark must be within the minute, 0 to 60.999 s, was {mark:g}"
    for name in ("speed", "psi"):
        value = getattr(bsm, name)
        if value is not None and not math.isfinite(value):
            return f"{name} must be finite, was {value:g}"
    return ""


def read_number(name: str, value: Any) -> float:
    """Return any real number as float."""
    try:
        if isinstance(value, (str, bytes, bytearray)):  # float() would read them
            raise TypeError
        return float(value)
    except Exception:  # a value may be of any class
        raise InputError(f"{name} must be a finite number or None, was {shown(value)}") from None


def read_count(value: int) -> int:
    """Return a checked message count."""
    try:
        count = operator.index(value)
    except Exception:  # a value may be of any class
        count = -1
    if not 0 <= count <= 127:
        raise InputError(f"msg_count must be an integer from 0 to 127, was {shown(value)}")
    return count

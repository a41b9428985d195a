"""Fields of an untrusted XML file; each error names the element."""

import math
import re
from pathlib import Path as FilePath
from xml.etree.ElementTree import Element

import numpy as np

from cca_core._checks import Array, read_real
from cca_core._files import parse_tree, read_bytes
from cca_core.errors import InputError
from cca_core.vehicle import MAX_COORDINATE


def parse(file: str | FilePath) -> Element:
    """Return the root of a file that is not too large or deep and has no document type declaration."""
    return parse_tree(read_bytes(file), FilePath(file).name)


def child(element: Element, tag: str, name: str) -> Element:
    """Return the one child with a tag; `name` names `element` in messages."""
    found = element.findall(tag)
    if len(found) != 1:
        raise InputError(f"{name} must hold one {tag}, held {len(found)}")
    return found[0]


def identity(name: str, text: str | None) -> int:
    """Return an id."""
    text = (text or "").strip()
    if not re.fullmatch(r"-?[0-9]{1,15}", text):
        raise InputError(f"{name} must be a whole number, was {text[:40]!r}")
    return int(text)


def number(
    element: Element, tag: str, name: str, *, ge: float = -MAX_COORDINATE, le: float = MAX_COORDINATE
) -> float:
    """Return the number in a child."""
    text = (child(element, tag, name).text or "").strip()
    return read_real(f"{tag} of {name}", text, ge=ge, le=le)


def middle(element: Element, tag: str, name: str, limit: float) -> float:
    """Return the number in a child, or the middle of its interval; NaN without such a child."""
    if element.find(tag) is None:
        return math.nan
    low, high = interval(element, tag, name, -limit, limit)
    return 0.5 * (low + high)


def interval(element: Element, tag: str, name: str, lower: float, upper: float) -> tuple[float, float]:
    """Return the interval in a child; an ``exact`` is an interval of length zero."""
    inner, where = child(element, tag, name), f"{tag} of {name}"
    ends = ("exact", "exact") if inner.find("exact") is not None else ("intervalStart", "intervalEnd")
    low, high = (number(inner, end, where, ge=lower, le=upper) for end in ends)
    if low > high:
        raise InputError(f"intervalEnd of {where} must be at least {low:g}, was {high:g}")
    return low, high


def points(element: Element, name: str, min_points: int = 2) -> Array:
    """Return all points of an element [m], shape (n, 2)."""
    found = [(number(p, "x", name), number(p, "y", name)) for p in element.iterfind("point")]
    if len(found) < min_points:
        raise InputError(f"{name} must have at least {min_points} points, had {len(found)}")
    return frozen(np.array(found))


def references(element: Element, tag: str, name: str) -> tuple[int, ...]:
    """Return the ids that all children with a tag refer to."""
    return tuple(identity(f"ref of {tag} of {name}", e.get("ref")) for e in element.iterfind(tag))


def frozen(array: Array) -> Array:
    """Make an array read-only and return it."""
    array.setflags(write=False)
    return array

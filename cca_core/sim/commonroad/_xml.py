"""Fields of an untrusted XML file; each error names the element."""

from collections.abc import Container
from pathlib import Path as FilePath
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from cca_core._checks import Array, read_real
from cca_core.errors import InputError
from cca_core.vehicle import MAX_COORDINATE


class _PlainTreeBuilder(ElementTree.TreeBuilder):
    """Builds the tree of a file without a document type declaration, and so without entities."""

    def doctype(self, *_: object) -> None:
        raise InputError("DOCTYPE must not occur in the file")


def parse(file: str | FilePath, *, max_bytes: int = 50_000_000) -> Element:
    """Return the root of a file that is not too large and has no document type declaration."""
    try:
        with FilePath(file).open("rb") as stream:
            data = stream.read(max_bytes + 1)
    except TypeError:
        raise InputError(f"file must be a path, was {file!r}") from None
    except (OSError, ValueError) as error:
        raise InputError(f"file {str(file)!r} cannot be read: {error}") from None
    if len(data) > max_bytes:
        raise InputError(f"file must be at most {max_bytes // 1_000_000} MB long")
    try:
        return ElementTree.fromstring(data, ElementTree.XMLParser(target=_PlainTreeBuilder()))
    except InputError:
        raise
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise InputError(f"file {FilePath(file).name!r} is broken XML: {error}") from None


def child(element: Element, tag: str, name: str) -> Element:
    """Return the one child with a tag; `name` says what `element` is."""
    found = element.findall(tag)
    if len(found) != 1:
        raise InputError(f"{name} must hold one {tag}, held {len(found)}")
    return found[0]


def whole(name: str, text: str | None) -> int:
    """Return a whole number that is not negative."""
    text = (text or "").strip()
    if not (text.isascii() and text.isdigit() and len(text) < 16):
        raise InputError(f"{name} must be a whole number, was {text[:40]!r}")
    return int(text)


def number(
    element: Element, tag: str, name: str, *, ge: float = -MAX_COORDINATE, le: float = MAX_COORDINATE
) -> float:
    """Return the number in a child."""
    text = (child(element, tag, name).text or "").strip()
    return read_real(f"{tag} of {name}", text[:40], ge=ge, le=le)


def exact(element: Element, tag: str, name: str, limit: float) -> float:
    """Return the number in the ``exact`` of a child, between -`limit` and `limit`."""
    return number(child(element, tag, name), "exact", f"{tag} of {name}", ge=-limit, le=limit)


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
    return tuple(whole(f"ref of {tag} of {name}", e.get("ref")) for e in element.iterfind(tag))


def check_known(ids: tuple[int, ...], known: Container[int], name: str) -> None:
    """Raise if an id is not known."""
    for id_ in ids:
        if id_ not in known:
            raise InputError(f"{name} refers to lanelet {id_}, which is not in the file")


def frozen(array: Array) -> Array:
    """Make an array read-only and return it."""
    array.setflags(write=False)
    return array

"""Shapes in CommonRoad files: boxes around bodies, corners of regions."""

import math
from xml.etree.ElementTree import Element

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.sim.commonroad._xml import child, number, points

MIN_SIZE = 1e-3  # [m]
MAX_ANGLE = 100.0  # [rad]


def box(shape: Element, name: str) -> tuple[tuple[float, float], float, float, float]:
    """Center, heading, length and width of the box around some shapes, in the obstacle's own frame."""
    if len(shape) == 1 and shape[0].tag == "rectangle":
        return _rectangle(shape[0], f"rectangle of {name}")
    if not len(shape):
        raise InputError(f"shape of {name} must be a rectangle, circle or polygon, was empty")
    extent = np.vstack([_extent(form, name) for form in shape])
    low, high = extent.min(axis=0), extent.max(axis=0)
    (x, y), (length, width) = 0.5 * (low + high), high - low
    if min(length, width) < MIN_SIZE:
        raise InputError(f"shape of {name} must enclose an area")
    return (float(x), float(y)), 0.0, float(length), float(width)


def _extent(form: Element, name: str) -> Array:
    """Return points whose bounds are those of a shape [m], shape (n, 2)."""
    if form.tag != "circle":
        return corners(form, name)
    radius = number(form, "radius", f"circle of {name}", ge=0.5 * MIN_SIZE)
    x, y = _center(form, f"circle of {name}")
    return np.array(((x - radius, y - radius), (x + radius, y + radius)))


def corners(form: Element, name: str) -> Array:
    """Return a polygon [m] of a shape, shape (n, 2); a circle gets 36 corners on it."""
    where = f"{form.tag} of {name}"
    if form.tag == "rectangle":
        center, psi, length, width = _rectangle(form, where)
        ahead, left = 0.5 * length * np.exp(1j * psi), 0.5j * width * np.exp(1j * psi)
        found = np.array((ahead + left, left - ahead, -ahead - left, ahead - left))
    elif form.tag == "circle":
        center = _center(form, where)
        radius = number(form, "radius", where, ge=MIN_SIZE)
        found = radius * np.exp(2j * np.pi * np.arange(36) / 36)
    elif form.tag == "polygon":
        return points(form, where, 3)
    else:
        raise InputError(f"shape of {name} must be a rectangle, circle or polygon, was {form.tag[:40]!r}")
    return np.column_stack((found.real, found.imag)) + center


def position(element: Element, name: str) -> tuple[float, float, bool]:
    """Return the position in a state [m], and whether it is the middle of a region."""
    outer, where = child(element, "position", name), f"position of {name}"
    if outer.find("point") is not None:
        point = child(outer, "point", where)
        return number(point, "x", where), number(point, "y", where), False
    if not len(outer):
        raise InputError(f"{where} must hold a point or shapes, held nothing")
    extent = np.vstack([_extent(form, where) for form in outer])
    x, y = (0.5 * (extent.min(axis=0) + extent.max(axis=0))).tolist()
    return x, y, True


def _rectangle(form: Element, name: str) -> tuple[tuple[float, float], float, float, float]:
    psi = 0.0
    if form.find("orientation") is not None:
        psi = number(form, "orientation", name, ge=-MAX_ANGLE, le=MAX_ANGLE)
    length, width = (number(form, tag, name, ge=MIN_SIZE) for tag in ("length", "width"))
    return _center(form, name), math.remainder(psi, math.tau), length, width


def _center(form: Element, name: str) -> tuple[float, float]:
    if form.find("center") is None:
        return 0.0, 0.0
    center = child(form, "center", name)
    return number(center, "x", f"center of {name}"), number(center, "y", f"center of {name}")

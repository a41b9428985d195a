"""Reported state of a remote vehicle, and what makes a report unusable."""

import math
from dataclasses import dataclass
from numbers import Real
from operator import attrgetter
from typing import TypeGuard

import numpy as np

from cca_core._repr import short_repr
from cca_core.vehicle.constants import MAX_COORDINATE, MAX_SPEED

__all__ = ["RemoteVehicle", "is_finite_number"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RemoteVehicle:
    """Reported state of another vehicle now, at the center of its body box.

    The record comes from outside, so it accepts any value. `invalid_reason` is set if it cannot be used. The
    planner drops such records with this reason.

    Parameters
    ----------
    id : str
        Id of the sender, or of the track of the sensor.
    x, y, psi : float
        Position in the local frame now, dead-reckoned by `age` [m], and heading [rad], counter-clockwise.
    v_x, a_x : float
        Forward speed [m/s] and acceleration [m/s^2].
    r : float
        Yaw rate [rad/s], left positive.
    length, width : float
        Body box [m].
    age : float
        Time since the values were measured [s].
    sigma_along, sigma_across : float
        Standard deviation of the position along and across the heading [m].
    events : frozenset of str
        Reported event flags, such as ``"hard_braking"``.
    source : str
        ``"v2v"`` or ``"sensor"``.
    z : float or None
        Height in the local frame [m]; None, or a value that is not finite, is unknown.
    sigma_z : float
        Standard deviation of the height [m].
    """

    id: str
    x: float
    y: float
    psi: float
    v_x: float
    a_x: float = 0.0
    r: float = 0.0
    length: float = 4.5
    width: float = 1.8
    age: float = 0.0
    sigma_along: float = 0.0
    sigma_across: float = 0.0
    events: frozenset[str] = frozenset()
    source: str = "v2v"
    z: float | None = None
    sigma_z: float = 0.0

    __repr__ = short_repr

    @property
    def invalid_reason(self) -> str | None:
        """Why the record cannot be used; None if it can."""
        values = _REMOTE_VALUES(self)
        if not (_FLOATS.issuperset(map(type, values)) and all(map(math.isfinite, values))):
            for name, value in zip(_REMOTE_NUMBERS, values, strict=True):
                if not is_finite_number(value):
                    return f"{name} must be a finite number, was {type(value).__name__} {str(value)[:20]}"
        labels: tuple[object, object] = (self.id, self.events)
        if not (isinstance(labels[0], str) and isinstance(labels[1], frozenset)):
            was = " and ".join(type(label).__name__ for label in labels)
            return f"id and events must be a string and a frozenset, were {was}"
        return _out_of_range(values)


_REMOTE_NUMBERS = (
    "x", "y", "psi", "v_x", "a_x", "r", "length", "width", "age", "sigma_along", "sigma_across",
)  # fmt: skip
_FLOATS = frozenset((float, np.float64))
_REMOTE_VALUES = attrgetter(*_REMOTE_NUMBERS)


def is_plain(record: object) -> TypeGuard[RemoteVehicle]:
    """Return whether an object is a valid record, and holds nothing of a class of the caller's."""
    if type(record) is not RemoteVehicle:
        return False
    values = _REMOTE_VALUES(record)
    return (
        _FLOATS.issuperset(map(type, values))
        and type(record.id) is type(record.source) is str
        and type(record.events) is frozenset
        and type(record.sigma_z) is float
        and (record.z is None or type(record.z) is float)
        and all(map(math.isfinite, values))
        and _out_of_range(values) is None
    )


def _out_of_range(values: tuple[float, ...]) -> str | None:
    """Why numbers of a record, finite ones, cannot be used; None if they can."""
    x, y, _, v_x, a_x, r, length, width, age, along, across = values
    if abs(x) > MAX_COORDINATE or abs(y) > MAX_COORDINATE:
        return f"position must be within {MAX_COORDINATE / 1e3:.0f} km of the origin"
    if abs(a_x) > 100.0 or abs(r) > 100.0:
        return f"a_x and r must be at most 100, were {a_x:g} m/s^2 and {r:g} rad/s"
    if not (0.0 < length <= 400.0 and 0.0 < width <= 20.0):  # a train
        return f"length and width must be within 400 m x 20 m, were {length:g} m x {width:g} m"
    if not -20.0 <= v_x <= MAX_SPEED:
        return f"v_x must be between -20 and {MAX_SPEED:g} m/s, was {v_x:g} m/s"
    if not (0.0 <= age <= 3600.0 and 0.0 <= along <= 1e3 and 0.0 <= across <= 1e3):
        return "age and sigmas must be between 0 and 3600 s and 0 and 1000 m"
    return None


def is_finite_number(value: object) -> bool:
    """Return whether a value is a real number that a float can hold."""
    try:
        return isinstance(value, Real) and math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False

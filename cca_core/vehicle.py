"""Vehicles: parameters and state of the ego, reported state of a remote vehicle."""

import math
from dataclasses import dataclass, fields
from numbers import Real
from operator import attrgetter
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.geometry import Boxes, boxes

MAX_COORDINATE = 1.0e6
"""Largest coordinate in a local frame [m]."""

MAX_SPEED = 100.0
"""Largest speed of a road vehicle [m/s]."""

GRAVITY = 9.81  # [m/s^2]
STANDSTILL_SPEED = 0.5  # a vehicle that reports less counts as stationary: reports err by 0.2 [m/s]
STALE_AGE = 1.0  # an older report is stale: ten messages of SAE J2945/1 are missing [s]

_MIN_PARAMS = {"m": 100.0, "I_z": 10.0, "C_f": 1e3, "C_r": 1e3}  # smaller values are in tonnes or kilonewtons

__all__ = ["MAX_COORDINATE", "MAX_SPEED", "RemoteVehicle", "VehicleParams", "VehicleState"]


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleParams:
    """Geometry, inertia and tires of a car.

    Parameters
    ----------
    m : float
        Mass [kg].
    I_z : float
        Yaw inertia about the center of gravity [kg m^2].
    l_f, l_r : float
        Center of gravity to front and rear axle [m].
    C_f, C_r : float
        Cornering stiffness per axle [N/rad], positive.
    length, width : float
        Body box [m].
    box_offset : float
        Center of gravity to center of the body box [m], forward positive.
    mu : float
        Tire-road friction coefficient [-].
    delta_max, delta_rate_max : float
        Largest road-wheel angle [rad] and its largest rate [rad/s].
    steering_lag : float
        Time constant of the steering actuator [s].

    Raises
    ------
    InputError
        If a value is not finite or outside its range.
    """

    m: float
    I_z: float
    l_f: float
    l_r: float
    C_f: float
    C_r: float
    length: float
    width: float
    box_offset: float = 0.0
    mu: float = 0.9
    delta_max: float = 0.6
    delta_rate_max: float = 0.6
    steering_lag: float = 0.1

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "box_offset":
                check_real("box_offset", value, ge=-5.0, le=5.0)
            elif field.name == "steering_lag":
                check_real("steering_lag", value, ge=0.0)
            else:
                check_real(field.name, value, gt=0.0, ge=_MIN_PARAMS.get(field.name, 0.0))

    @property
    def wheelbase(self) -> float:
        """Distance between the axles [m]."""
        return self.l_f + self.l_r

    @property
    def understeer_gradient(self) -> float:
        """Understeer gradient K of delta = kappa (L + K v^2) [s^2/m]; positive for understeer."""
        return self.m / self.wheelbase * (self.l_r / self.C_f - self.l_f / self.C_r)

    @property
    def front(self) -> float:
        """Center of gravity to the front end of the body box [m], forward positive."""
        return self.box_offset + 0.5 * self.length

    @property
    def rear(self) -> float:
        """Center of gravity to the rear end of the body box [m], forward positive: less than zero."""
        return self.box_offset - 0.5 * self.length

    def center_at(self, x: float, y: float, psi: float) -> tuple[float, float]:
        """Center of the body box for one pose of the center of gravity.

        Parameters
        ----------
        x, y, psi : float
            Center of gravity [m] and heading [rad], counter-clockwise from +x.

        Returns
        -------
        x, y : float
            Center of the body box [m].
        """
        return x + self.box_offset * math.cos(psi), y + self.box_offset * math.sin(psi)

    def body_at(self, x: ArrayLike, y: ArrayLike, psi: ArrayLike) -> Boxes:
        """Body boxes for poses of the center of gravity.

        Parameters
        ----------
        x, y, psi : array_like, shape (...)
            Center of gravity [m] and heading [rad], counter-clockwise from +x.

        Returns
        -------
        body : Boxes
            One box for each pose.
        """
        forward, left = self.box_offset * np.cos(psi), self.box_offset * np.sin(psi)
        return boxes(np.asarray(x) + forward, np.asarray(y) + left, psi, self.length, self.width)

    @classmethod
    def bmw_320i(cls) -> Self:
        """BMW 320i, vehicle 2 of the CommonRoad vehicle models; body 4.508 m x 1.610 m.

        Returns
        -------
        vehicle : VehicleParams
            Sedan, neutral steer in the linear range; from the package commonroad-vehicle-models 3.0.2.
        """
        return cls(
            m=1093.3, I_z=1791.6, l_f=1.156, l_r=1.423, C_f=129.7e3, C_r=105.4e3,
            length=4.508, width=1.610,
        )  # fmt: skip

    @classmethod
    def ford_escort(cls) -> Self:
        """Ford Escort, vehicle 1 of the CommonRoad vehicle models; body 4.298 m x 1.674 m.

        Returns
        -------
        vehicle : VehicleParams
            Compact car; source as for `bmw_320i`.
        """
        return cls(
            m=1225.9, I_z=1538.9, l_f=0.884, l_r=1.509, C_f=166.2e3, C_r=97.4e3,
            length=4.298, width=1.674,
        )  # fmt: skip

    @classmethod
    def vw_vanagon(cls) -> Self:
        """VW Vanagon, vehicle 3 of the CommonRoad vehicle models; body 4.569 m x 1.844 m.

        Returns
        -------
        vehicle : VehicleParams
            Van; source as for `bmw_320i`.
        """
        return cls(
            m=1478.9, I_z=2473.1, l_f=1.151, l_r=1.321, C_f=170.0e3, C_r=148.1e3,
            length=4.569, width=1.844,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleState:
    """Planar motion of the ego at its center of gravity (ISO 8855).

    Parameters
    ----------
    x, y, psi : float
        Position in the local frame [m] and heading [rad], counter-clockwise from +x.
    v_x : float
        Forward speed [m/s], not negative; values down to -0.5 m/s count as sensor noise at standstill.
    v_y, r : float
        Lateral speed [m/s] and yaw rate [rad/s], left positive.
    delta : float
        Road-wheel angle [rad], left positive.
    a_x : float
        Forward acceleration [m/s^2].
    t : float, optional
        Time of the measurement, on the clock of `Planner.step` [s]. The planner makes a safe stop if it is
        too old. By default it is that of the step.

    Raises
    ------
    InputError
        If a value is not finite, or the speed is below -0.5 m/s.
    """

    x: float
    y: float
    psi: float
    v_x: float
    v_y: float = 0.0
    r: float = 0.0
    delta: float = 0.0
    a_x: float = 0.0
    t: float | None = None

    def __post_init__(self) -> None:
        try:
            usable = math.isfinite(
                self.x + self.y + self.psi + self.v_x + self.v_y + self.r + self.delta + self.a_x
                + (0.0 if self.t is None else self.t)
            )  # fmt: skip
        except (TypeError, OverflowError):
            usable = False
        if not usable:
            for field in fields(self):
                if field.name != "t" or self.t is not None:
                    check_real(field.name, getattr(self, field.name))
        if self.v_x < -STANDSTILL_SPEED:
            raise InputError(f"v_x must be at least -0.5 m/s (forward driving), was {self.v_x:g}")


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

    @property
    def invalid_reason(self) -> str | None:
        """Why the record cannot be used; None if it can."""
        values = _REMOTE_VALUES(self)
        if not ({float, np.float64}.issuperset(map(type, values)) and all(map(math.isfinite, values))):
            for name, value in zip(_REMOTE_NUMBERS, values, strict=True):
                if not is_finite_number(value):
                    return f"{name} must be a finite number, was {type(value).__name__} {str(value)[:20]}"
        labels: tuple[object, object] = (self.id, self.events)
        if not (isinstance(labels[0], str) and isinstance(labels[1], frozenset)):
            was = " and ".join(type(label).__name__ for label in labels)
            return f"id and events must be a string and a frozenset, were {was}"
        if max(abs(self.x), abs(self.y)) > MAX_COORDINATE:
            return f"position must be within {MAX_COORDINATE / 1e3:.0f} km of the origin"
        if max(abs(self.a_x), abs(self.r)) > 100.0:
            return f"a_x and r must be at most 100, were {self.a_x:g} m/s^2 and {self.r:g} rad/s"
        if not (0.0 < self.length <= 400.0 and 0.0 < self.width <= 20.0):  # a train
            return f"length and width must be within 400 m x 20 m, were {self.length:g} m x {self.width:g} m"
        if not -20.0 <= self.v_x <= MAX_SPEED:
            return f"v_x must be between -20 and {MAX_SPEED:g} m/s, was {self.v_x:g} m/s"
        if not (
            0.0 <= self.age <= 3600.0 and 0.0 <= self.sigma_along <= 1e3 and 0.0 <= self.sigma_across <= 1e3
        ):
            return "age and sigmas must be between 0 and 3600 s and 0 and 1000 m"
        return None


_REMOTE_NUMBERS = (
    "x", "y", "psi", "v_x", "a_x", "r", "length", "width", "age", "sigma_along", "sigma_across",
)  # fmt: skip
_REMOTE_VALUES = attrgetter(*_REMOTE_NUMBERS)


def is_finite_number(value: object) -> bool:
    """Return whether a value is a real number that a float can hold."""
    try:
        return isinstance(value, Real) and math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False

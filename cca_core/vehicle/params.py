"""Parameters of a car, with presets."""

import math
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import as_array, check_real, formula
from cca_core._repr import short_repr
from cca_core.geometry import Boxes, boxes

__all__ = ["VehicleParams"]

_MIN_PARAMS = {"m": 100.0, "I_z": 10.0, "C_f": 1e3, "C_r": 1e3}  # smaller values are in tonnes or kilonewtons


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

    __repr__ = short_repr

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

    @formula
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

        Raises
        ------
        InputError
            If a value is no array of real numbers.
        """
        x, y, psi = as_array("x", x), as_array("y", y), as_array("psi", psi)
        forward, left = self.box_offset * np.cos(psi), self.box_offset * np.sin(psi)
        return boxes(x + forward, y + left, psi, self.length, self.width)

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

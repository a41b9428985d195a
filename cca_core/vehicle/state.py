"""State of the ego."""

import math
from dataclasses import dataclass, fields

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.vehicle.constants import STANDSTILL_SPEED

__all__ = ["VehicleState"]


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

"""Feedforward of curvature: the single-track model inverted along a path."""

from copy import copy
from typing import Self

from cca_core.kernel import bind
from cca_core.kernel.memory import lend, put
from cca_core.kernel.steering import IdealCar, advance, find_passed, front_slip
from cca_core.vehicle import VehicleParams

_advance, _find_passed, _front_slip = bind(advance), bind(find_passed), bind(front_slip)


class InverseSteering:
    """Dynamic feedforward of curvature.

    Parameters
    ----------
    vehicle : VehicleParams
        Geometry, inertia, tires and friction.

    Notes
    -----
    If the center of gravity stays on the path, its lateral acceleration is v^2 kappa. This fixes the sum of
    the tires' side forces. The yaw balance then leaves two states, lateral speed and yaw rate:

    ``I_z r' = l_f m v^2 kappa - L F_r``,  ``v_y' = v^2 kappa - v r``,

    with the rear axle's force F_r from its slip angle. These states are the zero dynamics of the lateral
    position and are stable, so the class integrates them along the path. The steering angle follows from the
    slip that the front axle needs for the rest of the force (brush tire, solved for the slip angle). In a
    steady turn this is the static law delta = kappa (L + K v^2).
    """

    def __init__(self, vehicle: VehicleParams) -> None:
        self._lent = lend(IdealCar)
        put(
            self.car, l_f=vehicle.l_f, l_r=vehicle.l_r, m=vehicle.m, inertia=vehicle.I_z,
            c_f=vehicle.C_f, c_r=vehicle.C_r, mu=vehicle.mu,
        )  # fmt: skip

    @property
    def car(self) -> IdealCar:
        """The ideal car in the kernel, for its calls."""
        return self._lent.workspace

    @property
    def held(self) -> bool:
        """Whether the last call of `advance` was given what is no number, and its angle is the one before."""
        return self.car.held

    def __copy__(self) -> Self:
        twin = object.__new__(type(self))
        twin.__dict__ |= self.__dict__ | {"_lent": copy(self._lent)}
        return twin

    def __repr__(self) -> str:
        car = self.car
        if not car.started:
            return "InverseSteering(not started)"
        held = ", held" if car.held else ""
        return f"InverseSteering(s={car.s:.1f} m, kappa={car.kappa:.4f} 1/m, r={car.r:.3f} rad/s{held})"

    def advance(self, s: float, kappa: float, v_x: float, dt: float) -> float:
        """Integrate to the next station and return the steering angle there.

        An argument that is not finite drops the call: the ideal car stays where it is, the last angle is
        returned (0 before the first), and `held` is true until the next call.

        Parameters
        ----------
        s : float
            Station of the point [m].
        kappa : float
            Curvature there [1/m], left turn positive.
        v_x : float
            Forward speed [m/s].
        dt : float
            Time since the last call [s].

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive.
        """
        return _advance(self.car, s, kappa, v_x, dt)

    def front_slip(self, fraction: float) -> float:
        """Slip angle at which the front tires carry a fraction of their grip (brush tire).

        Parameters
        ----------
        fraction : float
            Fraction of the largest side force, left positive [-]; limited to 0.97, where the slip is finite.

        Returns
        -------
        slip : float
            Angle between the wheels and their direction of motion [rad], left positive.
        """
        return _front_slip(self.car, fraction)

    def motion_at(self, s: float) -> tuple[float, float]:
        """Motion of the ideal car at a station that it has passed.

        Parameters
        ----------
        s : float
            Station [m], not ahead of the last `advance`.

        Returns
        -------
        beta : float
            Sideslip angle [rad], left positive.
        r : float
            Yaw rate [rad/s], left positive.
        """
        return _find_passed(self.car, s)

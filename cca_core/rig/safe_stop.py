"""Safe stop as the kit holds it: heading, steering and braking over the distance that is driven."""

import math
from dataclasses import dataclass

from cca_core._checks import check_array, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError

SAFE_STOP_POINTS = 40
"""Number of points of a safe stop; each is one CAN message."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StopProfile:
    """Steering and braking over the distance from where it was planned.

    Parameters
    ----------
    spacing : float
        Distance between two points [m], positive. CAN carries multiples of 0.05 m.
    heading : tuple of float
        Heading at each of 40 points [rad], counter-clockwise from that at the first one.
    delta : tuple of float
        Road-wheel angle at each point [rad], left positive.
    a_x : tuple of float
        Acceleration at each point [m/s^2], forward positive; the last one brakes.

    Raises
    ------
    InputError
        If a value is not finite or out of range, there are not 40 points, or the last one does not brake.

    Notes
    -----
    Distance instead of time makes the steering independent of the moment at which the brakes are applied, and
    the place where they are applied independent of the speed: a maneuver ends before the vehicle stops.
    """

    spacing: float
    heading: tuple[float, ...]
    delta: tuple[float, ...]
    a_x: tuple[float, ...]

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_real("spacing", self.spacing, gt=0.0)
        check_array("heading", self.heading, (SAFE_STOP_POINTS,))
        check_array("delta", self.delta, (SAFE_STOP_POINTS,))
        last = float(check_array("a_x", self.a_x, (SAFE_STOP_POINTS,))[-1])
        if last >= 0.0:
            raise InputError(f"a_x must be negative at the last point, was {last:g}")

    def at(self, distance: float) -> tuple[float, float]:
        """Command at a distance from the start.

        Parameters
        ----------
        distance : float
            Distance traveled since the safe stop was planned [m]. The last point counts beyond the end.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive.
        a_x : float
            Acceleration [m/s^2], forward positive.
        """
        i, w = self._cell(distance)
        delta = (1.0 - w) * self.delta[i] + w * self.delta[i + 1]
        return delta, (1.0 - w) * self.a_x[i] + w * self.a_x[i + 1]

    def heading_at(self, distance: float) -> float:
        """Heading at a distance from the start.

        Parameters
        ----------
        distance : float
            Distance traveled since the safe stop was planned [m].

        Returns
        -------
        heading : float
            Counter-clockwise from that at the start [rad].
        """
        i, w = self._cell(distance)
        return (1.0 - w) * self.heading[i] + w * self.heading[i + 1]

    def _cell(self, distance: float) -> tuple[int, float]:
        """Return the point before a distance, and the part of the way to the next one."""
        position = min(max(distance / self.spacing, 0.0), SAFE_STOP_POINTS - 1.0)
        i = min(int(position), SAFE_STOP_POINTS - 2)
        return i, position - i


class StoredStop:
    """The last safe stop of a computer, and the motion since it was planned.

    Speed and yaw rate tell how far the vehicle is from the planned motion: until commands are missed it is
    steered by them, and actuators are never exact. The steering corrects it.
    """

    def __init__(self, gain: float = 0.017, preview: float = 25.0, max_correction: float = 0.03) -> None:
        self.plan: StopProfile | None = None
        self._gain, self._preview, self._max_correction = gain, preview, max_correction  # [rad/m, m, rad]
        self._distance = self._heading = self._offset = 0.0  # since the start; offset to the left [m]
        self._v, self._r, self._t = 0.0, 0.0, -math.inf

    def load(self, plan: StopProfile, t: float) -> None:
        """Store a safe stop that begins at the present position."""
        self.plan, self._t = plan, t
        self._distance = self._heading = self._offset = 0.0

    def move(self, v_x: float, r: float, t: float) -> None:
        """Advance by the motion since the last call, at a measured speed [m/s] and yaw rate [rad/s]."""
        # a pause of the process counts as 1 s
        elapsed = min(max(t - self._t, 0.0), 1.0) if self._t > -math.inf else 0.0
        step, angle = 0.5 * (self._v + v_x) * elapsed, self._angle()
        self._distance += step
        self._heading += 0.5 * (self._r + r) * elapsed
        self._offset += step * math.sin(0.5 * (angle + self._angle()))
        self._v, self._r, self._t = v_x, r, t

    def execute(self) -> tuple[float, float] | None:
        """Return road-wheel angle [rad] and acceleration [m/s^2] at this distance; None without a plan."""
        if self.plan is None:
            return None
        delta, a_x = self.plan.at(self._distance)
        correction = self._gain * (self._offset + self._preview * self._angle())
        return delta - min(max(correction, -self._max_correction), self._max_correction), a_x

    def _angle(self) -> float:
        """Angle to the planned heading [rad]."""
        return 0.0 if self.plan is None else self._heading - self.plan.heading_at(self._distance)

"""Reference points, angles and axes of other worlds, and motion by differences of poses."""

import math
from typing import NamedTuple

from cca_core._checks import check_real, formula, shown
from cca_core.errors import InputError
from cca_core.geometry import wrap_angle
from cca_core.vehicle import STANDSTILL_SPEED, VehicleParams

_ROUNDING = 1e-3  # by which an interval may fall short of the least one, as a fraction


@formula
def shift_point(x: float, y: float, psi: float, forward: float) -> tuple[float, float]:
    """Point ahead of another one.

    Parameters
    ----------
    x, y, psi : float
        Position [m] and heading [rad], counter-clockwise from +x.
    forward : float
        Distance along the heading [m]; negative is behind.

    Returns
    -------
    x, y : float
        Position [m].

    Examples
    --------
    The center of a body 4.5 m long from the middle of its front bumper:

    >>> shift_point(10.0, 0.0, 0.0, -0.5 * 4.5)
    (7.75, 0.0)
    """
    return x + forward * math.cos(psi), y + forward * math.sin(psi)


def convert_reference(
    x: float, y: float, psi: float, vehicle: VehicleParams, source: str, target: str
) -> tuple[float, float]:
    """Position of one reference point of the ego from that of another.

    Parameters
    ----------
    x, y, psi : float
        Position of `source` [m] and heading [rad], counter-clockwise from +x.
    vehicle : VehicleParams
        The ego.
    source, target : str
        Reference points: ``"front_bumper"``, ``"rear_axle"``, ``"center_of_gravity"`` or ``"box_center"``.

    Returns
    -------
    x, y : float
        Position of `target` [m].

    Raises
    ------
    InputError
        If a reference point is none of these.

    Notes
    -----
    A `VehicleState` is at the center of gravity, a `RemoteVehicle` at the center of its body box.

    Examples
    --------
    >>> convert_reference(0.0, 0.0, 0.0, VehicleParams.bmw_320i(), "rear_axle", "center_of_gravity")
    (1.423, 0.0)
    """
    ahead = {
        "front_bumper": vehicle.front, "rear_axle": -vehicle.l_r, "center_of_gravity": 0.0,
        "box_center": vehicle.box_offset,
    }  # fmt: skip
    for name, point in (("source", source), ("target", target)):
        if point not in ahead:
            raise InputError(f"{name} must be one of {', '.join(map(repr, ahead))}, was {shown(point)}")
    return shift_point(x, y, psi, ahead[target] - ahead[source])


def compass_to_heading(compass_deg: float) -> float:
    """Heading from a compass angle.

    Parameters
    ----------
    compass_deg : float
        Angle clockwise from north [deg].

    Returns
    -------
    psi : float
        Heading counter-clockwise from east, in [-pi, pi) [rad].

    Raises
    ------
    InputError
        If the angle is not finite.
    """
    return wrap_angle(math.radians(90.0 - check_real("compass_deg", compass_deg)))


def heading_to_compass(psi: float) -> float:
    """Compass angle from a heading.

    Parameters
    ----------
    psi : float
        Heading counter-clockwise from east [rad].

    Returns
    -------
    compass_deg : float
        Angle clockwise from north, in [0, 360) [deg].

    Raises
    ------
    InputError
        If the angle is not finite.
    """
    compass = (90.0 - math.degrees(check_real("psi", psi))) % 360.0
    return 0.0 if compass == 360.0 else compass  # the remainder of a tiny negative angle


@formula
def flip_axes(x: float, y: float, angle: float) -> tuple[float, float, float]:
    """Convert between left-handed axes (y to the right, or down on a screen) and those of ISO 8855.

    Parameters
    ----------
    x, y : float
        Position [m], velocity [m/s] or acceleration [m/s^2].
    angle : float
        Heading or road-wheel angle [rad], or yaw rate [rad/s].

    Returns
    -------
    x, y, angle : float
        The same in the other axes [m], [rad]: the signs of `y` and `angle` change. The conversion is its own
        inverse.
    """
    return x, -y, -angle


class Motion(NamedTuple):
    """Motion of a vehicle.

    Parameters
    ----------
    psi : float
        Heading [rad], in [-pi, pi), counter-clockwise from +x.
    v_x, a_x : float
        Forward speed [m/s] and acceleration [m/s^2].
    r : float
        Yaw rate [rad/s], left positive.
    """

    psi: float
    v_x: float
    a_x: float
    r: float


class MotionDifferences:
    """Motion of one vehicle by differences of its poses, for worlds that do not report it.

    Parameters
    ----------
    min_interval : float
        Time between two samples that are compared [s]. Samples that come earlier repeat the last motion.
    min_distance : float
        Distance along the road over which the change of heading gives the yaw rate [m]. On lanes that are
        polylines, about twice the distance of their corners evens out the jumps of the heading there.
    standstill_speed : float
        Speed below which the heading is held and the yaw rate is zero [m/s].

    Raises
    ------
    InputError
        If the interval is not positive or another value is negative.

    Notes
    -----
    Without reported headings, the chord between two positions is the heading in the middle of the interval.
    Heading and yaw rate are therefore exact on a circle, speed and acceleration are exact on a straight line
    at constant acceleration.

    Examples
    --------
    >>> motion = MotionDifferences()
    >>> for k in range(4):
    ...     found = motion.update(t=0.1 * k, x=2.0 * k, y=0.0)
    >>> round(found.v_x, 6), found.r
    (20.0, 0.0)
    """

    def __init__(
        self,
        *,
        min_interval: float = 0.1,
        min_distance: float = 0.0,
        standstill_speed: float = STANDSTILL_SPEED,
    ) -> None:
        self.min_interval = check_real("min_interval", min_interval, gt=0.0)
        self.min_distance = check_real("min_distance", min_distance, ge=0.0)
        self.standstill_speed = check_real("standstill_speed", standstill_speed, ge=0.0)
        self._pose: tuple[float, float, float] | None = None  # time and position of the last sample
        self._speed: tuple[float, float] | None = None  # with its time
        self._heading: tuple[float, float] | None = None  # from which on the vehicle turns, with its time
        self._distance = 0.0  # since then
        self._motion = Motion(0.0, 0.0, 0.0, 0.0)

    def update(
        self, t: float, x: float, y: float, psi: float | None = None, v_x: float | None = None
    ) -> Motion:
        """Take a sample.

        Parameters
        ----------
        t : float
            Time [s]. A time before the last one begins anew.
        x, y : float
            Position [m].
        psi : float, optional
            Heading [rad], if it is reported.
        v_x : float, optional
            Forward speed [m/s], if it is reported.

        Returns
        -------
        motion : Motion
            Motion now; that of the last call if a value is not finite.
        """
        if not math.isfinite(t + x + y + (psi or 0.0) + (v_x or 0.0)):
            return self._motion
        if self._pose is None or t < self._pose[0]:
            return self._begin(t, x, y, psi, v_x)
        dt, dx, dy = t - self._pose[0], x - self._pose[1], y - self._pose[2]
        if dt < self.min_interval * (1.0 - _ROUNDING):
            return self._motion
        self._pose = t, x, y
        last, middle = self._motion, t - 0.5 * dt
        new = math.atan2(dy, dx) if psi is None else psi
        v = (dx * math.cos(new) + dy * math.sin(new)) / dt if v_x is None else v_x
        t_v = middle if v_x is None else t
        a_x = self._accelerate(t_v, v)
        if abs(v) < self.standstill_speed:
            self._heading, self._distance = (t, last.psi), 0.0
            self._motion = Motion(last.psi, v, a_x, 0.0)
            return self._motion
        now = v + a_x * (t - t_v)
        v = now if now * v > 0.0 else 0.0  # a vehicle that has stopped does not reverse
        self._distance += math.hypot(dx, dy)
        t_new = middle if psi is None else t
        r = self._turn(t_new, new)
        self._motion = Motion(wrap_angle(new + r * (t - t_new)), v, a_x, r)
        return self._motion

    def _begin(self, t: float, x: float, y: float, psi: float | None, v_x: float | None) -> Motion:
        """Take the first sample."""
        self._pose, self._distance = (t, x, y), 0.0
        self._speed = None if v_x is None else (t, v_x)
        self._heading = None if psi is None else (t, psi)
        self._motion = Motion(wrap_angle(psi or 0.0), v_x or 0.0, 0.0, 0.0)
        return self._motion

    def _accelerate(self, t: float, v: float) -> float:
        """Return the acceleration up to a speed at a time."""
        t_0, v_0 = self._speed or (-math.inf, v)
        self._speed = t, v
        return (v - v_0) / (t - t_0)

    def _turn(self, t: float, psi: float) -> float:
        """Return the yaw rate up to a heading at a time."""
        if self._heading is None:
            self._heading = t, psi
            return 0.0
        if self._distance < self.min_distance:
            return self._motion.r
        t_0, psi_0 = self._heading
        self._heading, self._distance = (t, psi), 0.0
        return wrap_angle(psi - psi_0) / (t - t_0)

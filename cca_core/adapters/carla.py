"""Poses, motion and controls of CARLA; no package is needed, its objects are taken as they are."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from cca_core._checks import check_real, formula
from cca_core.adapters.conversions import flip_axes, shift_point
from cca_core.geometry import wrap_angle
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

_STANDSTILL = 0.1  # speed below which the brakes hold the vehicle [m/s]


@dataclass(frozen=True, slots=True, kw_only=True)
class CarlaPedals:
    """What pedals and steering of a vehicle of CARLA do.

    Parameters
    ----------
    full_throttle : float
        Acceleration at full throttle [m/s^2].
    full_brake : float
        Deceleration at full brake [m/s^2].
    drag : float
        Deceleration without throttle and brake [m/s^2].
    max_steering_deg : float
        Road-wheel angle at full steering [deg]: ``max_steer_angle`` of the front wheels in
        ``get_physics_control()``.
    hold_brake : float
        Brake that holds the vehicle at standstill [-].

    Raises
    ------
    InputError
        If a value is out of range.

    Notes
    -----
    CARLA has no acceleration command but that of its Ackermann controller; pedals are linear here, without
    gears. Measure the three accelerations of your vehicle on a straight road. The defaults are assumed.
    """

    full_throttle: float = 4.0
    full_brake: float = 8.0
    drag: float = 0.3
    max_steering_deg: float = 70.0
    hold_brake: float = 0.3

    def __post_init__(self) -> None:
        check_real("full_throttle", self.full_throttle, gt=0.0)
        check_real("full_brake", self.full_brake, gt=0.0)
        check_real("drag", self.drag, ge=0.0)
        check_real("max_steering_deg", self.max_steering_deg, gt=0.0, le=90.0)
        check_real("hold_brake", self.hold_brake, ge=0.0, le=1.0)


class CarlaControl(NamedTuple):
    """Control of a vehicle, as ``carla.VehicleControl(*control)`` takes it.

    Parameters
    ----------
    throttle : float
        From 0 to 1 [-].
    steer : float
        From -1 to 1, right positive [-].
    brake : float
        From 0 to 1 [-].
    """

    throttle: float
    steer: float
    brake: float


def from_carla_transform(transform: Any) -> tuple[float, float, float]:
    """Pose of an actor.

    Parameters
    ----------
    transform : carla.Transform
        Location [m] and rotation [deg]; y to the right, yaw clockwise.

    Returns
    -------
    x, y, psi : float
        Position [m] and heading [rad] in [-pi, pi), counter-clockwise, in axes with y to the left.
    """
    location, yaw = transform.location, math.radians(transform.rotation.yaw)
    x, y, psi = flip_axes(location.x, location.y, yaw)
    return x, y, wrap_angle(psi)


@formula
def to_carla_pose(x: float, y: float, psi: float) -> tuple[float, float, float]:
    """Location and yaw of CARLA from a pose.

    Parameters
    ----------
    x, y, psi : float
        Position [m] and heading [rad], counter-clockwise.

    Returns
    -------
    x, y, yaw_deg : float
        Values of ``carla.Location`` [m] and ``carla.Rotation`` [deg].
    """
    x, y, yaw = flip_axes(x, y, psi)
    return x, y, math.degrees(wrap_angle(yaw))


def carla_state(actor: Any, vehicle: VehicleParams, *, delta: float = 0.0) -> VehicleState:
    """Motion of the ego.

    Parameters
    ----------
    actor : carla.Vehicle
        The ego, at the last tick.
    vehicle : VehicleParams
        Its parameters.
    delta : float
        Road-wheel angle [rad], left positive: the last command, or minus the mean of
        ``get_wheel_steer_angle`` of the front wheels.

    Returns
    -------
    state : VehicleState
        Motion of the center of gravity. Reverse motion counts as standstill.
    """
    x, y, psi, v_x, v_y, a_x, r = _motion(actor)
    offset = vehicle.box_offset  # the pose is that of the body box
    x, y = shift_point(x, y, psi, -offset)
    return VehicleState(x=x, y=y, psi=psi, v_x=max(v_x, 0.0), v_y=v_y, r=r, delta=delta, a_x=a_x)


def carla_remote(actor: Any) -> RemoteVehicle:
    """Motion of another vehicle or pedestrian.

    Parameters
    ----------
    actor : carla.Vehicle or carla.Walker
        An actor with a bounding box, at the last tick.

    Returns
    -------
    vehicle : RemoteVehicle
        Motion of the center of its body, with its size and the id of the actor. Its height is left out: it
        counts only on a road with `elevation` (`Road`).
    """
    x, y, psi, v_x, _, a_x, r = _motion(actor)
    extent = actor.bounding_box.extent  # half sizes
    return RemoteVehicle(
        id=str(actor.id), x=x, y=y, psi=psi, v_x=v_x, a_x=a_x, r=r, length=2.0 * float(extent.x),
        width=2.0 * float(extent.y),
    )  # fmt: skip


@formula
def to_carla_control(delta: float, a_x: float, v_x: float, pedals: CarlaPedals | None = None) -> CarlaControl:
    """Control from a command of the planner.

    Parameters
    ----------
    delta : float
        Road-wheel angle [rad], left positive.
    a_x : float
        Acceleration [m/s^2].
    v_x : float
        Forward speed [m/s].
    pedals : CarlaPedals, optional
        What pedals and steering do.

    Returns
    -------
    control : CarlaControl
        Throttle and steering, or brake and steering. A vehicle that stands and is not to accelerate is held
        by its brakes.
    """
    pedals = pedals or CarlaPedals()
    steer = min(max(-math.degrees(delta) / pedals.max_steering_deg, -1.0), 1.0)
    if a_x <= 0.0 and v_x < _STANDSTILL:
        return CarlaControl(0.0, steer, max(pedals.hold_brake, min(-a_x / pedals.full_brake, 1.0)))
    force = a_x + pedals.drag
    if force >= 0.0:
        return CarlaControl(min(force / pedals.full_throttle, 1.0), steer, 0.0)
    return CarlaControl(0.0, steer, min(-force / pedals.full_brake, 1.0))


def _motion(actor: Any) -> tuple[float, float, float, float, float, float, float]:
    """Return position of the body box, heading, speeds, forward acceleration and yaw rate of an actor."""
    x, y, psi = from_carla_transform(actor.get_transform())
    velocity, acceleration = actor.get_velocity(), actor.get_acceleration()
    r = -math.radians(actor.get_angular_velocity().z)  # CARLA reports degrees per second, clockwise
    cos, sin = math.cos(psi), math.sin(psi)
    v_x, v_y = cos * velocity.x - sin * velocity.y, -sin * velocity.x - cos * velocity.y
    a_x = cos * acceleration.x - sin * acceleration.y
    box = actor.bounding_box.location  # from the actor's origin, in its axes
    ahead, left = box.x, -box.y
    return x + cos * ahead - sin * left, y + sin * ahead + cos * left, psi, v_x, v_y, a_x, r

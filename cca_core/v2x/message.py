"""Content of a Basic Safety Message, in SI units and ISO 8855 axes."""

from dataclasses import dataclass, field

from cca_core._repr import short_repr

__all__ = ["BrakeStatus", "Bsm", "PositionalAccuracy"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionalAccuracy:
    """Error ellipse of a sender's position, typically one standard deviation; None is unavailable.

    Parameters
    ----------
    semi_major, semi_minor : float or None
        Semi-axes [m], 0 to 12.7; 12.7 means that or more.
    orientation : float or None
        Direction of the semi-major axis [rad], counter-clockwise from east.
    """

    semi_major: float | None = None
    semi_minor: float | None = None
    orientation: float | None = None

    __repr__ = short_repr


@dataclass(frozen=True, slots=True, kw_only=True)
class BrakeStatus:
    """State of a sender's brakes; None is unavailable.

    Parameters
    ----------
    wheels : tuple of bool or None
        Whether the brake is applied at the left front, left rear, right front and right rear wheel.
    traction, abs, scs : str or None
        Traction control, anti-lock brakes, stability control: ``"off"``, ``"on"`` or ``"engaged"``.
    boost, aux : str or None
        Brake boost and auxiliary brakes: ``"off"`` or ``"on"``.
    """

    wheels: tuple[bool, ...] | None = None
    traction: str | None = None
    abs: str | None = None
    scs: str | None = None
    boost: str | None = None
    aux: str | None = None

    __repr__ = short_repr


@dataclass(frozen=True, slots=True, kw_only=True)
class Bsm:
    """Content of a Basic Safety Message, in SI units and ISO 8855 axes; None is unavailable.

    Any value is accepted; `encode_bsm` checks them. The position is the center of the body box. The largest
    value of a speed, acceleration, steering angle or accuracy means that or more.

    Parameters
    ----------
    msg_count : int
        Number of the message, 0 to 127, then 0 again.
    id : str
        Temporary identity: 8 hexadecimal digits in lower case.
    sec_mark : float or None
        Time within the minute [s], 0 to 60.999; 60 and above in a leap second.
    latitude_deg, longitude_deg : float or None
        Position on WGS 84 [deg], north and east positive.
    elevation : float or None
        Height above the ellipsoid [m], -409.5 to 6143.9.
    speed : float or None
        Speed [m/s], 0 to 163.8, never negative.
    psi : float or None
        Heading [rad], counter-clockwise from east, decoded to [-pi, pi).
    steering_wheel_angle : float or None
        Angle of the steering wheel [rad], left positive, within 189 degrees.
    a_x, a_y : float or None
        Acceleration forward and to the left [m/s^2], within 20.
    a_z : float or None
        Acceleration upwards [m/s^2], -24.9 to 24.7.
    r : float or None
        Yaw rate [rad/s], counter-clockwise positive. The message has no code for unavailable: None is
        encoded as 0.
    accuracy : PositionalAccuracy
        Error ellipse of the position.
    transmission : str or None
        ``"neutral"``, ``"park"``, ``"forward"`` or ``"reverse"``.
    brakes : BrakeStatus
        State of the brakes.
    width, length : float or None
        Body box [m], 0.01 to 10.23 and 0.01 to 40.95.
    events : frozenset of str
        Names of event flags, such as ``"hard_braking"``.
    signed : str or None
        ``"unverified"`` if the message came in signed data: the signature was not checked. None without.
    """

    msg_count: int
    id: str
    sec_mark: float | None = None
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    elevation: float | None = None
    speed: float | None = None
    psi: float | None = None
    steering_wheel_angle: float | None = None
    a_x: float | None = None
    a_y: float | None = None
    a_z: float | None = None
    r: float | None = None
    accuracy: PositionalAccuracy = field(default_factory=PositionalAccuracy)
    transmission: str | None = None
    brakes: BrakeStatus = field(default_factory=BrakeStatus)
    width: float | None = None
    length: float | None = None
    events: frozenset[str] = frozenset()
    signed: str | None = None

    __repr__ = short_repr

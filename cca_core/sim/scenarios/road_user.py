"""Road users as data: body, route and actions."""

import math
from dataclasses import dataclass, fields
from types import NoneType

from cca_core._checks import check_bool, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.path import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class BrakeAction:
    """Brake to a standstill.

    Parameters
    ----------
    t : float
        Begin [s], not negative.
    deceleration : float
        Deceleration [m/s^2], not negative.

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    t: float
    deceleration: float = 7.0

    def __post_init__(self) -> None:
        for field in fields(self):
            check_real(field.name, getattr(self, field.name), ge=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReactToLeadAction:
    """Brake when the lead vehicle brakes, with up to 7 m/s^2 if the wanted deceleration is too small.

    Parameters
    ----------
    lead_id : str
        Id of the lead vehicle.
    reaction_time : float
        From the brake lights of the lead vehicle to the brakes [s].
    deceleration : float
        Wanted deceleration [m/s^2], not negative.
    warning_delay : float
        From the delivery of the lead vehicle's message of hard braking to the brakes [s]; infinite if the
        vehicle does not receive messages.

    Raises
    ------
    InputError
        If a value is negative or not a number.

    Notes
    -----
    If 7 m/s^2 are too little or too late, the vehicle drives through its lead vehicle: road users do not
    collide. The run then has an overlap (`Log.overlaps`), and `simulate` warns.

    Brake lights go on at 0.25 m/s^2. The reaction of 1.25 s is that of a driver to brake lights [1]_.

    References
    ----------
    .. [1] M. Green, *How long does it take to stop? Methodological analysis of driver perception-brake
       times*, Transportation Human Factors 2(3), 2000.
    """

    lead_id: str
    reaction_time: float = 1.25
    deceleration: float = 7.0
    warning_delay: float = math.inf

    def __post_init__(self) -> None:
        for name in ("reaction_time", "deceleration", "warning_delay"):
            check_real(name, getattr(self, name), ge=0.0, allow_inf=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class LateralShiftAction:
    """Shift laterally along a quintic in time.

    Parameters
    ----------
    s_start : float
        Station of the body's center at the begin [m].
    offset : float
        Lateral shift [m], left positive.
    duration : float
        Duration [s], positive.

    Raises
    ------
    InputError
        If a value is not finite or the duration is not positive.
    """

    s_start: float
    offset: float
    duration: float = 2.0

    def __post_init__(self) -> None:
        check_real("s_start", self.s_start)
        check_real("offset", self.offset)
        check_real("duration", self.duration, gt=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedAction:
    """Change to another speed; several make a speed profile, of which the last one begun counts.

    Parameters
    ----------
    t : float
        Begin [s], not negative.
    v_x : float
        Speed at the end [m/s], not negative.
    acceleration : float
        Magnitude of the acceleration [m/s^2], positive.

    Raises
    ------
    InputError
        If a value is not finite or out of range.

    Notes
    -----
    Braking by another action takes precedence. A vehicle with a finite jerk approaches the speed with an
    acceleration of at most sqrt(2 jerk abs(v_x - v)).
    """

    t: float
    v_x: float
    acceleration: float = 2.0

    def __post_init__(self) -> None:
        check_real("t", self.t, ge=0.0)
        check_real("v_x", self.v_x, ge=0.0)
        check_real("acceleration", self.acceleration, gt=0.0)


RoadUserAction = BrakeAction | ReactToLeadAction | LateralShiftAction | SpeedAction
"""What a road user can do."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RoadUser:
    """A scripted vehicle that keeps lateral offset and speed, but for its actions.

    Parameters
    ----------
    id : str
        Id in logs and messages.
    s, d : float
        Frenet coordinates of the body's center at the start [m], d left positive.
    v_x : float
        Speed at the start [m/s].
    direction : int
        1 along its route, -1 against it [-].
    length, width : float
        Body box [m].
    reaction_time : float
        Reaction time of its driver to an ego that blocks its path [s]; infinite for no reaction.
    deceleration : float
        Deceleration of that reaction [m/s^2], not negative.
    jerk : float
        Build-up rate of its braking [m/s^3]; infinite for a step.
    route : Path, optional
        Its route, to which `s` and `d` refer; the default is the route of the ego.
    actions : tuple of BrakeAction, ReactToLeadAction, LateralShiftAction or SpeedAction
        Its actions.
    connected : bool
        Whether it sends messages.
    events : frozenset of str
        Event flags in all its messages, such as ``"hazard_lights"``; ``"hard_braking"`` is added while it
        brakes with 0.4 g or more.

    Raises
    ------
    InputError
        If a value is out of range or of the wrong type.
    """

    id: str
    s: float
    d: float
    v_x: float
    direction: int = 1
    length: float = 4.5
    width: float = 1.8
    reaction_time: float = math.inf
    deceleration: float = 7.0
    jerk: float = math.inf
    route: Path | None = None
    actions: tuple[RoadUserAction, ...] = ()
    connected: bool = True
    events: frozenset[str] = frozenset()

    __repr__ = short_repr

    def __post_init__(self) -> None:
        check_real("s", self.s)
        check_real("d", self.d)
        check_real("v_x", self.v_x, ge=0.0)
        check_real("length", self.length, gt=0.0)
        check_real("width", self.width, gt=0.0)
        check_real("reaction_time", self.reaction_time, ge=0.0, allow_inf=True)
        check_real("deceleration", self.deceleration, ge=0.0)
        check_real("jerk", self.jerk, gt=0.0, allow_inf=True)
        check_bool("connected", self.connected)
        if self.direction not in (1, -1):
            raise InputError(f"direction must be 1 or -1, was {self.direction!r}")
        if not isinstance(self.route, Path | NoneType):
            raise InputError(f"route must be a Path, was {type(self.route).__name__}")
        if not all(isinstance(action, RoadUserAction) for action in self.actions):
            raise InputError(
                "actions must be BrakeAction, ReactToLeadAction, LateralShiftAction or SpeedAction, "
                f"were {self.actions!r}"
            )

"""Road users as data: a body, a way, and what its driver does."""

import math
from dataclasses import dataclass, fields
from types import NoneType

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.path import Path

__all__ = ["BrakeAction", "LateralShiftAction", "ReactToLeadAction", "RoadUser"]


@dataclass(frozen=True, slots=True, kw_only=True)
class BrakeAction:
    """Brakes from some time on until it stands.

    Parameters
    ----------
    t : float
        When [s].
    deceleration : float
        How hard [m/s^2], positive.

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
    """Brakes when the vehicle in front does; harder than it means to if it would hit it otherwise.

    Parameters
    ----------
    lead_id : str
        Id of the vehicle in front.
    reaction_time : float
        From its brake lights to the own brakes [s].
    deceleration : float
        How hard it means to brake [m/s^2], positive.
    warning_delay : float
        From the delivery of the leader's message of hard braking to the own brakes [s]; infinite: it does not
        receive messages.

    Raises
    ------
    InputError
        If a value is negative or not a number.

    Notes
    -----
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
    """Moves sideways along a quintic in time.

    Parameters
    ----------
    s_start : float
        Path coordinate at which its middle is when it begins [m].
    offset : float
        How far [m], left positive.
    duration : float
        How long it takes [s].

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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RoadUser:
    """A scripted vehicle that keeps to its lane and its speed, but for what it is told to do.

    Parameters
    ----------
    id : str
        Its sender id.
    s, d : float
        Center of its body in path coordinates at the start [m], d left positive.
    v_x : float
        Its speed at the start [m/s].
    direction : int
        1 along its way, -1 against it [-].
    length, width : float
        Body box [m].
    reaction_time : float
        Reaction time of its driver to the ego in its way [s]; infinite: it drives on.
    deceleration : float
        How hard its driver brakes then [m/s^2], positive.
    jerk : float
        How fast its braking builds up [m/s^3]; infinite: at once.
    route : Path, optional
        Its way, to which `s` and `d` refer; the default is the route of the ego.
    actions : tuple of Brakes, Follows or Swerves
        What it does.
    connected : bool
        Whether it sends messages.
    events : frozenset of str
        Event flags that it sends all the time, such as ``"hazard_lights"``; hard braking is added when it
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
    actions: tuple[BrakeAction | ReactToLeadAction | LateralShiftAction, ...] = ()
    connected: bool = True
    events: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        check_real("s", self.s)
        check_real("d", self.d)
        check_real("v_x", self.v_x, ge=0.0)
        check_real("length", self.length, gt=0.0)
        check_real("width", self.width, gt=0.0)
        check_real("reaction_time", self.reaction_time, ge=0.0, allow_inf=True)
        check_real("deceleration", self.deceleration, ge=0.0)
        check_real("jerk", self.jerk, gt=0.0, allow_inf=True)
        if self.direction not in (1, -1):
            raise InputError(f"direction must be 1 or -1, was {self.direction!r}")
        if not isinstance(self.route, Path | NoneType):
            raise InputError(f"route must be a Path, was {type(self.route).__name__}")
        if not all(
            isinstance(act, BrakeAction | ReactToLeadAction | LateralShiftAction) for act in self.actions
        ):
            raise InputError(
                f"actions must be BrakeAction, ReactToLeadAction or LateralShiftAction, were {self.actions!r}"
            )

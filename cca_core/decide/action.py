"""Choice of action: keep the lane, follow the lead vehicle, evade to a side, or brake."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.decide.rejection import Rejection, located, not_passing

_BRAKE_RELEASE_FRACTION = 0.7  # of the brake threshold: below it braking ends, so that it does not chatter
_NO_BRAKES = 20.0  # deceleration that no brakes give [m/s^2]


class Action(Enum):
    """What the ego does."""

    KEEP = "KEEP"
    FOLLOW = "FOLLOW"
    EVADE_LEFT = "EVADE_LEFT"
    EVADE_RIGHT = "EVADE_RIGHT"
    BRAKE = "BRAKE"

    @property
    def is_evading(self) -> bool:
        """Whether the ego leaves its route."""
        return self in (Action.EVADE_LEFT, Action.EVADE_RIGHT)


@dataclass(frozen=True, slots=True, kw_only=True)
class LeadVehicle:
    """Vehicle that limits the ego's speed most.

    Parameters
    ----------
    id : str
        Id of the vehicle.
    gap : float
        Bumper-to-bumper gap along the road [m].
    v_x : float
        Speed along the road [m/s].
    required_deceleration : float
        Deceleration with which the ego stays behind it [m/s^2], not negative.
    follow_acceleration : float
        Acceleration of the ego that follows it [m/s^2].
    kind : {"direct", "downstream", "crossing"}
        Next vehicle ahead, vehicle farther ahead (known by message), or vehicle that crosses the route.
    comfort_stop_deceleration : float
        Deceleration that stops behind a stationary vehicle within the horizon of the decision [m/s^2];
        infinite if the ego passes it wherever a lane is free.
    """

    id: str
    gap: float
    v_x: float
    required_deceleration: float
    follow_acceleration: float
    kind: str = "direct"
    comfort_stop_deceleration: float = math.inf

    __repr__ = short_repr


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A maneuver around the lead vehicle.

    Parameters
    ----------
    side : {"left", "right"}
        Side on which the lead vehicle is passed.
    rejection : Rejection, optional
        Why the maneuver is not feasible; None if it is.
    available_distance : float
        Distance until the ego must be alongside the lead vehicle [m].
    required_distance : float
        Distance that the maneuver takes at the comfort limits [m].
    t_maneuver : float
        Time until the ego's body is back in its own lane [s]; 0 if it never leaves the lane.
    danger_zone : tuple of float, optional
        Danger zone that came nearest to blocking, relative to the ego [m].
    cost : float
        Cost of the candidate [-]; the lowest cost wins.
    """

    side: str
    rejection: Rejection | None = None
    available_distance: float = math.inf
    required_distance: float = 0.0
    t_maneuver: float = 0.0
    danger_zone: tuple[float, float] | None = None
    cost: float = 0.0

    __repr__ = short_repr


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """The action of this cycle.

    Parameters
    ----------
    action : Action
        What the ego does.
    reason : str
        Why, with numbers and limits: ``<activity>: <what is measured>; <cause>``, such as "following R1: gap
        21 m, wants 24 m; not passing on the left: no lane".
    activity, cause : str
        Its first and last part, such as "following R1" and "not passing on the left: no lane"; empty if the
        reason has none.
    lead_id : str, optional
        Id of the lead vehicle.
    danger_zone : tuple of float, optional
        Rear and front end of the danger zone that was compared [m], relative to the ego.
    """

    action: Action
    reason: str
    activity: str = ""
    cause: str = ""
    lead_id: str | None = None
    danger_zone: tuple[float, float] | None = None

    __repr__ = short_repr


def choose_action(
    lead: LeadVehicle | None,
    candidates: Sequence[Candidate],
    *,
    previous: Action = Action.KEEP,
    follow_threshold: float = -0.5,
    brake_threshold: float = 4.0,
    comfort_deceleration: float = 2.0,
) -> Decision:
    """Choose between keeping, following, evading and braking.

    Parameters
    ----------
    lead : LeadVehicle, optional
        Vehicle that limits the ego's speed most; None if there is none.
    candidates : sequence of Candidate
        Maneuvers around it, feasible or rejected.
    previous : Action
        Action of the last cycle.
    follow_threshold : float
        Acceleration of following [m/s^2]: a lower one turns KEEP into FOLLOW.
    brake_threshold : float
        Required deceleration [m/s^2]: a higher one turns FOLLOW into BRAKE.
    comfort_deceleration : float
        Deceleration [m/s^2] up to which a stop behind a stationary vehicle is preferred to passing it.

    Returns
    -------
    decision : Decision
        The action with its reason.

    Raises
    ------
    InputError
        If the brake threshold is not a number.

    Notes
    -----
    With a feasible candidate the ego evades

    - if it already follows or brakes: it has waited long enough;
    - if the maneuver is due: the available distance has shrunk to the required distance;
    - if following would need hard braking.

    Until then it keeps its speed. Without a feasible candidate the ego follows as soon as following needs a
    lower speed. It brakes if following in comfort is no longer possible, or to stop behind a stationary
    vehicle.

    Examples
    --------
    >>> choose_action(None, []).action.name
    'KEEP'
    """
    if lead is None:
        return Decision(action=Action.KEEP, reason="keeping lane: no vehicle ahead")
    limit = check_real("brake_threshold", brake_threshold, allow_inf=True) * (
        _BRAKE_RELEASE_FRACTION if previous is Action.BRAKE else 1.0
    )
    hard, waited = lead.required_deceleration > limit, previous in (Action.FOLLOW, Action.BRAKE)
    feasible = sorted((c for c in candidates if c.rejection is None), key=lambda c: c.cost)
    stops = lead.comfort_stop_deceleration <= comfort_deceleration
    if feasible and not stops:
        best = feasible[0]
        if not (waited or hard or best.available_distance <= best.required_distance):
            action = Action.KEEP
            ahead = best.available_distance - best.required_distance
            activity = f"approaching {lead.id}"
            cause = f"passing on the {best.side} starts in {ahead:.0f} m"
        else:
            action = Action.EVADE_LEFT if best.side == "left" else Action.EVADE_RIGHT
            activity = f"passing {lead.id} on the {best.side}"
            cause = _start(lead, best, waited, limit)
        return explained(action, activity, cause, lead_id=lead.id, danger_zone=best.danger_zone)
    why, position = _why_not_passing(lead, candidates), f"{located(lead.gap)} at {lead.v_x:.1f} m/s"
    if hard:
        action, need = Action.BRAKE, lead.required_deceleration
        activity = f"braking for {lead.id}"
        numbers = (
            f"needs {need:.1f} m/s², {position}" if need < _NO_BRAKES else f"more than the brakes, {position}"
        )
    elif stops:
        action, activity = Action.BRAKE, f"stopping behind {lead.id}"
        numbers, why = f"{lead.comfort_stop_deceleration:.1f} m/s², gap {lead.gap:.0f} m", ""
    elif not (waited or lead.follow_acceleration < follow_threshold):
        action, activity, numbers = Action.KEEP, "keeping lane", f"{lead.id} {position}"
        why = why if candidates else ""
    elif lead.kind == "crossing":
        action, activity, numbers = Action.FOLLOW, f"yielding to {lead.id}", located(lead.gap)
    else:
        action, activity = Action.FOLLOW, f"following {lead.id}"
        numbers = f"gap {lead.gap:.0f} m, it drives {lead.v_x:.1f} m/s"
    zone = candidates[0].danger_zone if candidates else None
    return explained(action, activity, why, numbers=numbers, lead_id=lead.id, danger_zone=zone)


def explained(
    action: Action, activity: str, cause: str = "", *, numbers: str = "", lead_id: str | None = None,
    danger_zone: tuple[float, float] | None = None,
) -> Decision:  # fmt: skip
    """Make a decision whose reason is an activity, what is measured, and its cause."""
    parts = f"{numbers}; {cause}" if numbers and cause else numbers or cause
    return Decision(
        action=action, reason=f"{activity}: {parts}" if parts else activity, activity=activity, cause=cause,
        lead_id=lead_id, danger_zone=danger_zone,
    )  # fmt: skip


def _start(lead: LeadVehicle, best: Candidate, waited: bool, limit: float) -> str:
    """Why a maneuver starts now, and how long its lane is clear."""
    clear = f"{best.side} lane clear for {best.t_maneuver:.1f} s"
    if waited:
        return clear
    if best.available_distance <= best.required_distance:
        numbers = f"needs {best.required_distance:.0f} m, {best.available_distance:.0f} m left"
        return f"latest comfortable start ({numbers}); {clear}"
    need = lead.required_deceleration
    needs_braking = f"{need:.1f} m/s²" if need < _NO_BRAKES else "all brakes"
    return f"following needs {needs_braking} (limit {limit:.1f} m/s²); {clear}"


def _why_not_passing(lead: LeadVehicle, candidates: Sequence[Candidate]) -> str:
    """Rejections of all candidates."""
    if lead.kind == "crossing":
        return "it crosses the route"
    rejections = [c.rejection for c in candidates if c.rejection is not None]
    return not_passing(rejections) or "not passing: no maneuver was planned"

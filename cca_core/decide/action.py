"""Choice of action: keep the lane, follow the leader, evade on a side, or brake; with the reason in words."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

_BEYOND = 20.0  # no brakes give this [m/s^2]
_RELEASE = 0.7  # share of the deceleration from which on it brakes below which it no longer does


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
    """The road user in the way that demands most of the ego.

    Parameters
    ----------
    id : str
        Its id.
    gap : float
        Bumper-to-bumper gap along the road [m].
    v_x : float
        Its speed along the road [m/s].
    required_deceleration : float
        What the ego must brake to stay behind it [m/s^2], not negative.
    follow_acceleration : float
        What following it asks for now [m/s^2].
    kind : {"direct", "downstream", "crossing"}
        Whether it is next in front, hidden behind others (known by its messages), or crosses the route.
    comfort_stop_deceleration : float
        Deceleration that stops behind a standing one within the horizon of the decision [m/s^2]; infinite if
        it is to be passed wherever a lane is free.
    """

    id: str
    gap: float
    v_x: float
    required_deceleration: float
    follow_acceleration: float
    kind: str = "direct"
    comfort_stop_deceleration: float = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A way around the leader.

    Parameters
    ----------
    side : {"left", "right"}
        Side on which the leader is passed.
    rejection : str
        Why it cannot be driven, in words; empty if it can.
    available_distance : float
        Distance to drive until the ego must be beside the leader [m].
    required_distance : float
        Distance that the swerve needs in comfort [m].
    t_maneuver : float
        Time until the ego's body is back in its own lane [s]; 0 if it never leaves it.
    danger_zone : tuple of float, optional
        Danger zone that came nearest to blocking, relative to the ego [m].
    cost : float
        Preference between candidates [-], least wins.
    """

    side: str
    rejection: str = ""
    available_distance: float = math.inf
    required_distance: float = 0.0
    t_maneuver: float = 0.0
    danger_zone: tuple[float, float] | None = None
    cost: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """The action of this cycle.

    Parameters
    ----------
    action : Action
        What to do.
    reason : str
        Why, in words.
    lead_id : str, optional
        Id of the road user in the way.
    danger_zone : tuple of float, optional
        Rear and front end of the danger zone that was compared [m], relative to the ego.
    """

    action: Action
    reason: str
    lead_id: str | None = None
    danger_zone: tuple[float, float] | None = None


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
    lead : Leader, optional
        The road user in the way that demands most, None if the lane ahead is free.
    candidates : sequence of Candidate
        Ways around it, usable or not.
    previous : Action
        Last cycle's action.
    follow_threshold : float
        Acceleration that following must ask for before KEEP becomes FOLLOW [m/s^2].
    brake_threshold : float
        Deceleration needed to stay behind the leader from which on FOLLOW becomes BRAKE [m/s^2].
    comfort_deceleration : float
        Deceleration up to which stopping behind a standing vehicle is preferred to passing it [m/s^2].

    Returns
    -------
    decision : Decision
        The action with its reason.

    Notes
    -----
    With a usable candidate the ego evades: when following already (it has waited long enough), when the
    swerve is due (the lead-in has shrunk to what it needs), or when only hard braking would do
    instead; before that it keeps its speed. Without one it follows as soon as following asks for a lower
    speed, and brakes when following in comfort has become impossible, or to stop behind a standing vehicle.

    Examples
    --------
    >>> choose_action(None, []).action.name
    'KEEP'
    """
    if lead is None:
        return Decision(action=Action.KEEP, reason="the lane ahead is free")
    released = _RELEASE if previous is Action.BRAKE else 1.0
    hard = lead.required_deceleration > brake_threshold * released
    usable = sorted((c for c in candidates if not c.rejection), key=lambda c: c.cost)
    stops = lead.comfort_stop_deceleration <= comfort_deceleration
    if usable and not stops:
        best = usable[0]
        evade = Action.EVADE_LEFT if best.side == "left" else Action.EVADE_RIGHT
        way = f"{best.side} is free for {best.t_maneuver:.1f} s"
        if previous in (Action.FOLLOW, Action.BRAKE):
            return Decision(
                action=evade,
                reason=f"passing {lead.id}: {way}",
                lead_id=lead.id,
                danger_zone=best.danger_zone,
            )
        if best.available_distance <= best.required_distance or hard:
            return Decision(
                action=evade,
                reason=f"passing {lead.id}: {way}, {best.available_distance:.0f} m ahead, {best.required_distance:.0f} m needed",
                lead_id=lead.id, danger_zone=best.danger_zone,
            )  # fmt: skip
        return Decision(
            action=Action.KEEP,
            reason=f"closing in on {lead.id}: {way}",
            lead_id=lead.id,
            danger_zone=best.danger_zone,
        )
    zone = candidates[0].danger_zone if candidates else None
    why = "; ".join(f"{c.side}: {c.rejection}" for c in candidates) or "no way around was looked for"
    if lead.kind == "crossing":
        why = "it crosses the route"
    elif stops:
        why = f"{lead.comfort_stop_deceleration:.1f} m/s^2 stop behind it in comfort"
    if hard:
        need = lead.required_deceleration
        needed = f"{need:.1f} m/s^2" if need < _BEYOND else "all brakes"
        reason = f"{needed} needed behind {lead.id}; {why}"
        return Decision(action=Action.BRAKE, reason=reason, lead_id=lead.id, danger_zone=zone)
    if stops:
        reason = f"stopping behind {lead.id}; {why}"
        return Decision(action=Action.BRAKE, reason=reason, lead_id=lead.id, danger_zone=zone)
    if lead.follow_acceleration < follow_threshold or previous in (Action.FOLLOW, Action.BRAKE):
        return Decision(
            action=Action.FOLLOW,
            reason=f"waiting behind {lead.id}; {why}",
            lead_id=lead.id,
            danger_zone=zone,
        )
    reason = f"{lead.id} is far ahead ({lead.gap:.0f} m)" + (f"; {why}" if candidates else "")
    return Decision(action=Action.KEEP, reason=reason, lead_id=lead.id, danger_zone=zone)

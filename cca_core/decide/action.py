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
    def evades(self) -> bool:
        """Whether the ego leaves its route."""
        return self in (Action.EVADE_LEFT, Action.EVADE_RIGHT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Leader:
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
    kind : {"ahead", "hidden", "crossing"}
        Whether it is next in front, hidden behind others (known by its messages), or crosses the route.
    stop_in_comfort : float
        Deceleration that stops behind a standing one within the horizon of the decision [m/s^2]; infinite if
        it is to be passed wherever a lane is free.
    """

    id: str
    gap: float
    v_x: float
    required_deceleration: float
    follow_acceleration: float
    kind: str = "ahead"
    stop_in_comfort: float = math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A way around the leader.

    Parameters
    ----------
    side : {"left", "right"}
        Side on which the leader is passed.
    obstruction : str
        Why it cannot be driven, in words; empty if it can.
    lead_in : float
        Distance to drive until the ego must be beside the leader [m].
    needed : float
        Distance that the swerve needs in comfort [m].
    duration : float
        Time until the ego's body is back in its own lane [s]; 0 if it never leaves it.
    zone : tuple of float, optional
        Danger zone that came nearest to blocking, relative to the ego [m].
    cost : float
        Preference between candidates [-], least wins.
    """

    side: str
    obstruction: str = ""
    lead_in: float = math.inf
    needed: float = 0.0
    duration: float = 0.0
    zone: tuple[float, float] | None = None
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
    leader : str, optional
        Id of the road user in the way.
    zone : tuple of float, optional
        Rear and front end of the danger zone that was compared [m], relative to the ego.
    """

    action: Action
    reason: str
    leader: str | None = None
    zone: tuple[float, float] | None = None


def choose_action(
    leader: Leader | None,
    candidates: Sequence[Candidate],
    *,
    previous: Action = Action.KEEP,
    follow_below: float = -0.5,
    brake_above: float = 4.0,
    comfortable: float = 2.0,
) -> Decision:
    """Choose between keeping, following, evading and braking.

    Parameters
    ----------
    leader : Leader, optional
        The road user in the way that demands most, None if the lane ahead is free.
    candidates : sequence of Candidate
        Ways around it, usable or not.
    previous : Action
        Last cycle's action.
    follow_below : float
        Acceleration that following must ask for before KEEP becomes FOLLOW [m/s^2].
    brake_above : float
        Deceleration needed to stay behind the leader from which on FOLLOW becomes BRAKE [m/s^2].
    comfortable : float
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
    if leader is None:
        return Decision(action=Action.KEEP, reason="the lane ahead is free")
    released = _RELEASE if previous is Action.BRAKE else 1.0
    hard = leader.required_deceleration > brake_above * released
    usable = sorted((c for c in candidates if not c.obstruction), key=lambda c: c.cost)
    stops = leader.stop_in_comfort <= comfortable
    if usable and not stops:
        best = usable[0]
        evade = Action.EVADE_LEFT if best.side == "left" else Action.EVADE_RIGHT
        way = f"{best.side} is free for {best.duration:.1f} s"
        if previous in (Action.FOLLOW, Action.BRAKE):
            return Decision(
                action=evade, reason=f"passing {leader.id}: {way}", leader=leader.id, zone=best.zone
            )
        if best.lead_in <= best.needed or hard:
            return Decision(
                action=evade,
                reason=f"passing {leader.id}: {way}, {best.lead_in:.0f} m ahead, {best.needed:.0f} m needed",
                leader=leader.id, zone=best.zone,
            )  # fmt: skip
        return Decision(
            action=Action.KEEP,
            reason=f"closing in on {leader.id}: {way}",
            leader=leader.id,
            zone=best.zone,
        )
    zone = candidates[0].zone if candidates else None
    why = "; ".join(f"{c.side}: {c.obstruction}" for c in candidates) or "no way around was looked for"
    if leader.kind == "crossing":
        why = "it crosses the route"
    elif stops:
        why = f"{leader.stop_in_comfort:.1f} m/s^2 stop behind it in comfort"
    if hard:
        need = leader.required_deceleration
        needed = f"{need:.1f} m/s^2" if need < _BEYOND else "all brakes"
        reason = f"{needed} needed behind {leader.id}; {why}"
        return Decision(action=Action.BRAKE, reason=reason, leader=leader.id, zone=zone)
    if stops:
        reason = f"stopping behind {leader.id}; {why}"
        return Decision(action=Action.BRAKE, reason=reason, leader=leader.id, zone=zone)
    if leader.follow_acceleration < follow_below or previous in (Action.FOLLOW, Action.BRAKE):
        return Decision(
            action=Action.FOLLOW,
            reason=f"waiting behind {leader.id}; {why}",
            leader=leader.id,
            zone=zone,
        )
    reason = f"{leader.id} is far ahead ({leader.gap:.0f} m)" + (f"; {why}" if candidates else "")
    return Decision(action=Action.KEEP, reason=reason, leader=leader.id, zone=zone)

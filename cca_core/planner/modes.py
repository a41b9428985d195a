"""Modes: the label of the driven plan, and the only writer of the planner's state."""

from typing import Any

from cca_core.decide import Action
from cca_core.planner.records import DrivenPlan, Mode, PathKind, PlannerState
from cca_core.planner.tuning import DecisionSettings

ACTIONS = {
    Mode.KEEP: Action.KEEP, Mode.FOLLOW: Action.FOLLOW, Mode.EVADE_LEFT: Action.EVADE_LEFT,
    Mode.EVADE_RIGHT: Action.EVADE_RIGHT, Mode.RETURN: Action.FOLLOW, Mode.BRAKE: Action.BRAKE,
    Mode.SAFE_STOP: Action.BRAKE,
}  # fmt: skip
"""Action of `Decision` for each mode."""

_CALM = (Mode.KEEP, Mode.FOLLOW, Mode.BRAKE)
_DWELL = {
    (Mode.KEEP, Mode.FOLLOW): 0.2, (Mode.FOLLOW, Mode.KEEP): 1.0, (Mode.BRAKE, Mode.FOLLOW): 0.4,
    (Mode.BRAKE, Mode.KEEP): 0.4, (Mode.FOLLOW, Mode.BRAKE): 0.0, (Mode.KEEP, Mode.BRAKE): 0.0,
}  # fmt: skip
"""Time for which another mode must be wished for before it is shown [s]; others change at once."""

_RELEASE_FRACTION = 0.7  # of the brake threshold, below which braking ends


def wished_mode(plan: DrivenPlan, mode: Mode, s: float, a_x: float, settings: DecisionSettings) -> Mode:
    """Return the mode that a plan means at a station."""
    path = plan.path
    if path.change and path.begin <= s < path.end:
        return Mode.EVADE_LEFT if path.change == "left" else Mode.EVADE_RIGHT
    if path.kind.is_evasive and s < path.end:
        near = path.begin - s <= plan.v[0]
        waited = near and mode in (Mode.FOLLOW, Mode.EVADE_LEFT, Mode.EVADE_RIGHT)  # it speeds up to pass
        if path.has_begun(s) or waited:
            return Mode.EVADE_LEFT if path.kind is PathKind.LEFT else Mode.EVADE_RIGHT
        if mode is Mode.FOLLOW:
            return mode  # it follows until it passes
    elif path.kind is PathKind.RETURN and s < path.end:
        return Mode.RETURN
    a: float = plan.a.item(3)
    threshold = settings.brake_threshold * (_RELEASE_FRACTION if mode is Mode.BRAKE else 1.0)
    if plan.free_a - a > settings.follow_threshold:  # other vehicles slow the ego, not the route
        return Mode.BRAKE if min(a, a_x) < -threshold else Mode.FOLLOW
    return Mode.KEEP


def advance(state: PlannerState, t: float, wish: Mode, **changes: Any) -> PlannerState:
    """Return the state of the next cycle."""
    mode, t_wish = state.mode, state.t_wish
    if state.s is None:  # the first cycle
        mode, t_wish = wish, t
    elif wish is mode:
        t_wish = t
    elif mode in _CALM and wish in _CALM:
        since = t_wish if state.wish is not mode else t
        dwell = _DWELL.get((mode, wish), 0.0)
        if t - since >= dwell - 1e-9:
            mode, t_wish = wish, t
        else:
            t_wish = since
    else:
        mode, t_wish = wish, t
    return state._replace(mode=mode, wish=wish, t_wish=t_wish, **changes)

"""Reasons: what the ego does and why, from the plan that it drives; made anew in every cycle.

Every text is ``<activity> [<vehicle>]: <what is measured>[, <what is wanted>][; <why not otherwise>]``:

following R1: gap 21 m, wants 24 m; not passing on the left: R2 12 m behind at 25.0 m/s

Figures of the ego and of named vehicles are those of the cycle, figures of rejections those of the decision.
"""

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from cca_core._checks import Array
from cca_core.decide import Decision, RejectionKind
from cca_core.decide.action import explained
from cca_core.decide.rejection import located, not_passing
from cca_core.frenet import FrenetVehicle
from cca_core.planner.command import Command
from cca_core.planner.modes import ACTIONS
from cca_core.planner.records import DrivenPlan, Mode, Observation, PathKind
from cca_core.planner.route_limit import RouteLimit, limit_ahead
from cca_core.planner.scene import TIMES
from cca_core.planner.setup import Setup
from cca_core.vehicle import STALE_AGE

__all__ = ["explain"]

_NOISE = 0.1  # a smaller acceleration needs no explanation [m/s^2]
_UNEXPLAINED = 0.5  # a harder braking needs one in any case [m/s^2]
_FIRM = 1.0  # a harder braking is named within every activity [m/s^2]
_STANDS = 0.1  # speed below which the ego stands [m/s]
_PARKED = 0.5  # and another vehicle [m/s]
_SIDES = {Mode.EVADE_LEFT: "left", Mode.EVADE_RIGHT: "right"}


def explain(
    mode: Mode,
    plan: DrivenPlan,
    observation: Observation,
    a_x: float,
    setup: Setup,
    profile: tuple[Array, Array],
    last: Command | None = None,
) -> Decision:
    """Return the decision that a mode, its plan and its acceleration mean; `last` is the last command."""
    cycle = _Cycle(mode, plan, observation, a_x, setup, profile, last)
    for rule in _AWAY if mode in (Mode.EVADE_LEFT, Mode.EVADE_RIGHT, Mode.RETURN) else _IN_LANE:
        decision = rule(cycle)
        if decision is not None:
            return decision
    return _keep(cycle)


class _Cycle:
    """What a reason is made of."""

    def __init__(
        self, mode: Mode, plan: DrivenPlan, observation: Observation, a_x: float, setup: Setup,
        profile: tuple[Array, Array], last: Command | None,
    ) -> None:  # fmt: skip
        self.mode, self.plan, self.observation, self.a_x = mode, plan, observation, a_x
        self.setup, self.profile, self.last = setup, profile, last
        self.s, self.v = observation.s, observation.v
        self.lead = self.vehicles.get(plan.limited_by) if plan.limited_by else None
        self.stands = self.v < _STANDS and a_x <= 0.0
        self.brakes = a_x < -_NOISE and not self.stands

    def decision(
        self, activity: str, numbers: str = "", cause: str = "", vehicle: str | None = None
    ) -> Decision:
        return explained(ACTIONS[self.mode], activity, cause, numbers=numbers, lead_id=vehicle)

    @cached_property
    def vehicles(self) -> dict[str, FrenetVehicle]:
        """The other vehicles by id."""
        return {n.id: n for n in self.observation.vehicles}

    @property
    def is_held(self) -> bool:
        """Whether vehicles slow the ego now, beyond its route."""
        return self.plan.free_a - float(self.plan.a[3]) > self.setup.settings.decision.follow_threshold

    @property
    def is_releasing(self) -> bool:
        """Whether the ego brakes less than in the last cycle."""
        return self.brakes and self.last is not None and self.a_x > self.last.a_x + 1e-6

    @cached_property
    def holder(self) -> FrenetVehicle | None:
        """The vehicle because of which the ego drives no faster plan."""
        plan = self.plan
        ids = [plan.limited_by, plan.impact_id]
        if plan.profile.braking > 0.0:  # it does not follow
            ids.reverse()
        ids.append(plan.certificate.vehicle_id)
        return next((self.vehicles[each] for each in ids if each in self.vehicles), None)

    @property
    def force(self) -> str:
        """How much it brakes, if it does so hard."""
        return f"{-self.a_x:.1f} m/s², " if _brakes_hard(self) else ""

    def gap(self, n: FrenetVehicle) -> float:
        """Gap to a vehicle ahead [m]."""
        return n.rear - self.s - self.setup.vehicle.front

    def position(self, n: FrenetVehicle) -> str:
        """Where a vehicle is, and its speed."""
        gap, behind = self.gap(n), self.s + self.setup.vehicle.rear - n.front
        where = located(gap if gap > 0.0 else -max(behind, 0.0)) + self.silence(n)
        if abs(n.remote.v_x) < _PARKED:
            return f"{where}, stationary"
        crosses = abs(math.sin(n.angle)) > 0.5
        how = "crossing at" if crosses else "oncoming at" if n.v_s < -_PARKED else "at"
        return f"{where} {how} {abs(n.remote.v_x):.1f} m/s"

    def silence(self, n: FrenetVehicle) -> str:
        """How old the last message of a vehicle is, if that is why it counts as nearer or slower."""
        return f", silent for {n.remote.age:.1f} s" if n.remote.age > STALE_AGE else ""

    def arrival(self) -> str:
        """In which time the path ends."""
        elapsed = self.observation.t - self.plan.t
        t = float(np.interp(self.plan.path.end, self.plan.s, TIMES, right=math.inf)) - elapsed
        return f"in {max(t, 0.0):.1f} s" if math.isfinite(t) else f"in more than {TIMES[-1] - elapsed:.0f} s"

    def braking(self) -> str:
        """For what the ego brakes within another activity; empty if it does not."""
        if self.stands:
            return "stopped, " if self.holder is None else f"stopped for {self.holder.id}, "
        if self.a_x > -_FIRM:
            return ""
        n, limit = self.holder, self.route_limit
        if self.is_releasing and not self.is_held and limit is None:
            return "releasing the brakes, "
        what = n.id if n is not None else limit.why if limit else "no faster plan is certified"
        return f"braking {-self.a_x:.1f} m/s²{', ' if n is None else ' for '}{what}, "

    @cached_property
    def route_limit(self) -> RouteLimit | None:
        """What slows the ego on its route."""
        return limit_ahead(self.setup, self.profile, self.s, self.v)


def _change_lane(c: _Cycle) -> Decision | None:
    if c.mode not in _SIDES or not c.plan.path.change:
        return None
    behind = "" if c.lead is None or c.braking() else f"behind {c.lead.id}, "
    return c.decision(
        f"changing to the {c.plan.path.change} lane", f"{c.braking()}{behind}there {c.arrival()}",
        vehicle=None if c.lead is None else c.lead.id,
    )  # fmt: skip


def _pass(c: _Cycle) -> Decision | None:
    if c.mode not in _SIDES:
        return None
    passed = sorted(c.plan.path.overtaken & c.vehicles.keys())
    return c.decision(
        f"passing {', '.join(passed)}{' ' if passed else ''}on the {_SIDES[c.mode]}",
        f"{c.braking()}back in the ego lane {c.arrival()}", vehicle=next(iter(passed), None),
    )  # fmt: skip


def _return(c: _Cycle) -> Decision | None:
    if c.mode is not Mode.RETURN:
        return None
    return c.decision(
        "returning to the ego lane", f"{c.braking()}there {c.arrival()}", _why_not_passing(c),
        None if c.lead is None else c.lead.id,
    )  # fmt: skip


def _yield(c: _Cycle) -> Decision | None:
    n = c.vehicles.get(c.plan.yields_to) if c.plan.yields_to else None
    if n is None:
        return None
    verb = "stopped for" if c.stands else "braking for" if _brakes_hard(c) else "yielding to"
    gap = c.gap(n)
    where = f"it crosses the route{f' {gap:.0f} m ahead' if gap > 0.0 else ''}"
    return c.decision(f"{verb} {n.id}", f"{c.force}{where}", vehicle=n.id)


def _follow(c: _Cycle) -> Decision | None:
    n = c.lead
    if n is None or not (c.mode in (Mode.FOLLOW, Mode.BRAKE) or c.brakes or c.stands) or c.holder is not n:
        return None
    gap, is_parked = f"gap {max(c.gap(n), 0.0):.0f} m{c.silence(n)}", abs(n.v_s) < _PARKED
    if c.stands:
        return c.decision(f"stopped behind {n.id}", gap, _alternative(c), n.id)
    if _brakes_hard(c):
        return c.decision(f"braking for {n.id}", f"{c.force}{c.position(n)}", _alternative(c), n.id)
    if is_parked:
        activity = f"approaching {n.id}" if c.a_x > 0.0 else f"stopping behind {n.id}"
        return c.decision(activity, f"{gap}, stationary", _alternative(c), n.id)
    wanted = c.setup.speed.standstill_gap + c.setup.speed.time_gap * c.v
    closing = f", closing at {c.v - n.v_s:.1f} m/s" if c.v - n.v_s > 1.0 else ""
    return c.decision(f"following {n.id}", f"{gap}, wants {wanted:.0f} m{closing}", _alternative(c), n.id)


def _hold(c: _Cycle) -> Decision | None:
    """Drive slower because of a vehicle that is not followed."""
    return _slow_for(c, c.holder) if c.mode is not Mode.KEEP and c.is_held and c.holder else None


def _slow_for(c: _Cycle, n: FrenetVehicle) -> Decision:
    if not c.brakes:
        verb = "stopped" if c.stands else "holding back"
        return c.decision(f"{verb} for {n.id}", c.position(n), vehicle=n.id)
    verb, why = "braking" if _brakes_hard(c) else "slowing", _alternative(c) if n is _ahead(c) else ""
    return c.decision(f"{verb} for {n.id}", f"{-c.a_x:.1f} m/s², {c.position(n)}", why, n.id)


def _wait_for_lane(c: _Cycle) -> Decision | None:
    waiting = c.plan.waiting
    if waiting is None or c.a_x < -_FIRM or c.stands:
        return None
    return c.decision(str(waiting), cause=waiting.cause)


def _approach(c: _Cycle) -> Decision | None:
    if c.brakes or not _starts_later(c):
        return None
    first = min(c.plan.path.overtaken & c.vehicles.keys(), default=None)
    if first is None:
        return None
    return c.decision(f"approaching {first}", cause=_alternative(c), vehicle=first)


def _slow_for_route(c: _Cycle) -> Decision | None:
    limit = c.route_limit if c.brakes or c.stands else None
    if limit is None:
        return None
    target, why = limit
    if target == 0.0:
        return c.decision("stopped" if c.stands else "stopping", why)
    return c.decision(f"slowing to {target:.1f} m/s", why) if c.brakes and target < c.v else None


def _release(c: _Cycle) -> Decision | None:
    if not c.is_releasing:
        return None
    n = None if c.last is None else c.vehicles.get(c.last.decision.lead_id or "")
    name = "no vehicle" if n is None else n.id
    tail = "limits the speed" if n is None else "no longer limits the speed"
    return c.decision("releasing the brakes", f"{name} {tail}", vehicle=None if n is None else n.id)


def _brake(c: _Cycle) -> Decision | None:
    """Brake without a limit now: for a vehicle that is not followed, or for want of a better plan."""
    if c.a_x > -_UNEXPLAINED or c.stands:
        return None
    if c.holder is not None:
        return _slow_for(c, c.holder)
    return c.decision("braking", f"{-c.a_x:.1f} m/s²", "no faster plan is certified")


def _keep(c: _Cycle) -> Decision:
    n = _ahead(c)
    numbers, vehicle = "no vehicle ahead", None
    if n is not None:
        numbers, vehicle = f"{n.id} {c.position(n)}", n.id if n is c.lead else None
    if c.a_x > (0.0 if c.v < _STANDS else 3.0 * _NOISE):
        wanted = math.sqrt(max(float(np.interp(c.s, *c.profile)), 0.0))
        if wanted > c.v + _UNEXPLAINED:
            return c.decision(f"speeding up to {wanted:.1f} m/s", numbers, vehicle=vehicle)
    return c.decision("standing" if c.stands else f"keeping lane at {c.v:.1f} m/s", numbers, vehicle=vehicle)


_Rule = Callable[[_Cycle], Decision | None]

_IN_LANE: tuple[_Rule, ...] = (
    _yield, _follow, _hold, _wait_for_lane, _approach, _slow_for_route, _release, _brake,
)  # fmt: skip
"""The first one that applies gives the reason; without one the ego keeps its speed."""

_AWAY: tuple[_Rule, ...] = (_change_lane, _pass, _return)
"""The same while the ego changes its lane, passes or returns; one of them applies."""


def _brakes_hard(c: _Cycle) -> bool:
    return c.brakes and (c.mode is Mode.BRAKE or c.a_x < -c.setup.limits.b_comfort - _NOISE)


def _starts_later(c: _Cycle) -> bool:
    return c.plan.path.kind.is_evasive and not c.plan.path.has_begun(c.s)


def _alternative(c: _Cycle) -> str:
    """When vehicles are passed, or why they are not."""
    path = c.plan.path
    if _starts_later(c):
        side = "left" if path.kind is PathKind.LEFT else "right"
        return f"passing on the {side} starts in {path.begin - c.s:.0f} m"
    if c.plan.waiting is not None:
        return f"{c.plan.waiting}: {c.plan.waiting.cause}"
    return _why_not_passing(c)


def _why_not_passing(c: _Cycle) -> str:
    """Why vehicles are not passed, other vehicles first; nothing if only a side without a lane is known."""
    first = "" if c.holder is None else c.holder.id
    found = [r for r in c.plan.rejections if r.side or r.vehicle_id == first]
    found.sort(key=lambda r: r.vehicle_id in ("", first))
    is_known = len({r.side for r in found}) > 1 or any(r.kind is not RejectionKind.NO_LANE for r in found)
    return not_passing(found) if is_known else ""


def _ahead(c: _Cycle) -> FrenetVehicle | None:
    """Return the next vehicle ahead in the ego lane."""
    lane, ahead, nearest = c.setup.road.ego_lane, None, math.inf
    for n in c.observation.vehicles:
        in_lane = lane.right < n.d + n.half_width and n.d - n.half_width < lane.left
        if in_lane and n.rear < nearest and c.gap(n) > 0.0:
            ahead, nearest = n, n.rear
    return ahead

"""One cycle: decide, bend the route, follow it.

The state of a maneuver, its renewal and the fall-back ladder belong together, so this module is longer
than others.
"""

import logging
import math
from collections.abc import Iterable
from dataclasses import replace
from importlib import import_module
from types import NoneType

import numpy as np

from cca_core._checks import check_real
from cca_core.decide import Action, Candidate, Conflict, Decision, LeadVehicle, choose_action
from cca_core.errors import InputError, Status
from cca_core.follow import (
    PreviewController,
    SpeedSettings,
    friction_limited,
    jerk_limited,
    profile_acceleration,
    squared_speed_limit,
)
from cca_core.path import Path, Road, interpolate_path
from cca_core.planner.abort import delay_return, return_deceleration, vehicle_alongside
from cca_core.planner.command import Command
from cca_core.planner.frenet import FrenetEgo, FrenetVehicle, invalid_input_reason, to_frenet
from cca_core.planner.lead import BLOCKING_GAP, find_lead, oncoming_assumed_in_lane, vehicles_to_follow
from cca_core.planner.maneuver import Maneuver
from cca_core.planner.replan import maneuver_levels, plan_candidates, replan
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.yielding import find_yield_conflict, virtual_lead
from cca_core.vehicle import GRAVITY, RemoteVehicle, VehicleParams, VehicleState

__all__ = ["Command", "Planner"]

_LOG = logging.getLogger(__name__)
_OFF_ROUTE = 15.0  # farther from the route than this the planner does not know where it is [m]
_FOLLOW_THRESHOLD = (
    -0.5
)  # acceleration asked for by a leader from which on a way around it is looked for [m/s^2]
_RELEVANCE_MARGIN = 1.5  # beyond the road's edges and the clearance nobody matters who does not cross [m]
_PERIOD = 0.1  # between two looks at the same vehicles [s]
_CANCEL_BRAKE_FRACTION = 0.3  # share of the brakes within which a swerve is given up for following
_FALLBACK_BRAKE = 4.0  # [m/s^2]
_COMFORTABLE = 2.0  # deceleration up to which a stop behind who stands is preferred to a swerve [m/s^2]
_GRIP, _EMERGENCY_GRIP_FRACTION = 0.9, 0.98  # shares of the tires' grip used for braking, and in an emergency
_HARD_BRAKING_FRACTION = (
    0.7  # share of the brakes from which on jerk is not spared, as from twice the comfortable share
)
_CURVE_ACCELERATION = 2.5  # lateral acceleration for which speed is cut in bends [m/s^2]


class Planner:
    """Cooperative collision avoidance of one vehicle.

    Parameters
    ----------
    vehicle : VehicleParams
        The ego.
    road : Road or Path
        Route and lanes; a bare path is one lane of 3.5 m.
    cruise_speed : float
        Wanted speed [m/s].
    evasion : EvasionSettings, optional
        How others are passed.
    speed : SpeedSettings, optional
        How the ego accelerates, follows and brakes.
    controller : PreviewController, optional
        Steering law; the default is made for `vehicle`.

    Raises
    ------
    InputError
        If an argument has the wrong type or is out of range. After that, `step` never raises.
    """

    def __init__(
        self,
        vehicle: VehicleParams,
        road: Road | Path,
        *,
        cruise_speed: float,
        evasion: EvasionSettings | None = None,
        speed: SpeedSettings | None = None,
        controller: PreviewController | None = None,
        _leader_only: bool = False,
    ) -> None:
        for name, value, kinds in (
            ("vehicle", vehicle, (VehicleParams,)),
            ("road", road, (Road, Path)),
            ("evasion", evasion, (EvasionSettings, NoneType)),
            ("speed", speed, (SpeedSettings, NoneType)),
            ("controller", controller, (PreviewController, NoneType)),
        ):
            if not isinstance(value, kinds):
                raise InputError(f"{name} must be {kinds[0].__name__}, was {type(value).__name__}")
        self.vehicle = vehicle
        self.road = road if isinstance(road, Road) else Road(road)
        self.cruise_speed = check_real("cruise_speed", cruise_speed, gt=0.0)
        self.evasion = evasion or EvasionSettings()
        self.speed = speed or SpeedSettings()
        self._swerves = maneuver_levels(self.evasion, vehicle)
        self._controller = controller or PreviewController(vehicle)
        self._leader_only = _leader_only
        self._speed_profile = squared_speed_limit(
            self.road.path, min(self.cruise_speed, self.road.speed_limit), _CURVE_ACCELERATION, self.speed
        )
        # what is slow to import or to build is there before the first cycle
        interpolate_path([[0.0, 0.0], [1.0, 0.0]])
        import_module("scipy.interpolate")
        self.road.path.project(self.road.path.position(self.road.path.start))
        self._t = -math.inf
        self._s: float | None = None
        self._command: Command | None = None
        self._last_s: dict[str, float] = {}
        self._known_range = math.inf
        room = self.evasion.clearance + _RELEVANCE_MARGIN
        self._lateral_range = self.road.right_edge - room, self.road.left_edge + room
        self._seen_ids: frozenset[tuple[str, frozenset[str]]] = frozenset()
        self._t_decided = -math.inf
        self._decision = Decision(action=Action.KEEP, reason="starting")
        self._maneuver: Maneuver | None = None
        self._within_lane = True
        self._returning = False
        self._conflict: Conflict | None = None
        self._stopping_for: set[str] = set()
        self._followed_ids: set[str] = set()
        self._was_on_route: dict[str, bool] = {}
        self._status = Status.OK

    def __repr__(self) -> str:
        action = self._decision.action.value
        return f"Planner({self.road!r}, cruise_speed={self.cruise_speed:g}, {action} at t={self._t:g})"

    def step(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        *,
        awareness_range: float = math.inf,
    ) -> Command:
        """Compute steering and acceleration for this cycle.

        Parameters
        ----------
        t : float
            Time [s], increasing from call to call.
        state : VehicleState
            The ego's motion now.
        remotes : iterable of RemoteVehicle
            What is known of other vehicles, dead-reckoned to `t`.
        awareness_range : float
            Distance up to which they are all that there are [m], where that is less than the settings say:
            0 while `Tracker.is_saturated`.

        Returns
        -------
        command : Command
            Steering, acceleration, and why. It never raises and never holds NaN: inputs that cannot be
            used are dropped with a reason, or lead to braking with `Status.INVALID_INPUT`.
        """
        defect = invalid_input_reason(t, self._t, state)
        if defect:
            return self._safe_stop(defect)
        try:
            self._known_range = awareness_range if awareness_range >= 0.0 else 0.0
            return self._cycle(float(t), state, remotes)
        except Exception as error:  # no input and no defect may leave the car without a command
            _LOG.exception("internal error at t = %s s", t)
            return self._safe_stop(f"internal error: {error!r}")

    def _cycle(self, t: float, state: VehicleState, remotes: Iterable[RemoteVehicle]) -> Command:
        dt = min(t - self._t, 0.1)
        self._t = t
        path = self.road.path
        near = self._s if self._s is not None else float(path.project((state.x, state.y))[0])
        s, d, heading, _ = path.foot_point(state.x, state.y, near)
        if not abs(d) < _OFF_ROUTE:
            return self._safe_stop(f"the ego is not on its route (d = {d:.1f} m)")
        if math.cos(state.psi - heading) < 0.0:
            headings = f"{state.psi:.2f} instead of {heading:.2f} rad"
            return self._safe_stop(f"the ego heads against its route ({headings})")
        self._s = s
        neighbors, dropped = to_frenet(remotes, path, self._last_s, self._lateral_range)
        blockers = self._blocking_vehicles(neighbors, s)
        v_target = math.sqrt(max(float(np.interp(s, *self._speed_profile)), 0.0))
        leader = self._select_lead(blockers, s, state.v_x)
        if self._maneuver is not None:
            half = 0.5 * self.vehicle.width
            own = self.road.ego_lane
            self._within_lane = self._within_lane and own.right < d - half and d + half < own.left
            if s >= self._maneuver.end:
                self._maneuver, self._returning = None, False
                self._status = Status.OK
                self._decision = Decision(action=Action.KEEP, reason="back on the route")
                self._t_decided = -math.inf
        if not (self._decision.action.is_evading or self._returning):
            self._status = Status.OK
        if self._replan_due(t, neighbors):
            ego = FrenetEgo(
                vehicle=self.vehicle, s=s, v_x=max(state.v_x, 0.0), v_target=v_target, speed=self.speed
            )
            self._conflict = find_yield_conflict(ego, self.road, neighbors, self._conflict)
            leader = self._select_lead(blockers, s, state.v_x)
            self._decide(ego, leader, blockers, neighbors)
        if self._maneuver is not None and self._decision.action.is_evading:
            late, at = self._status is not Status.OK, self._maneuver.offset_at
            kept = [n for n in neighbors if n.remote.id in self._followed_ids]
            if late:  # whoever is in the way of the swerve is kept behind, as seen from it
                # not for what may be of one unheard: braking endangers those that are being passed
                likely = [n.nominal() if n.is_stale else n for n in neighbors if n not in kept]
                kept += [replace(n, d=n.d - at(n.s)) for n in likely if self._is_blocking(n, at(n.s))]
            leader = self._select_lead(sorted(kept, key=lambda n: n.s), s, state.v_x)
        reference = path if self._maneuver is None else self._maneuver.reference
        most = math.inf
        if self._returning:
            most = -return_deceleration(reference, s, state.v_x)
            if vehicle_alongside(self.vehicle, self.road, s, neighbors):
                most = min(most, 0.0)
        a_x = self._acceleration(s, state.v_x, state.r, leader, dt, most)
        delta = self._controller.steer(state, reference, dt, s_guess=s)
        return self._emit(Command(
            delta=delta, a_x=float(a_x), decision=self._decision, reference=reference, status=self._status,
            band=None if self._maneuver is None else self._maneuver.band, dropped=dropped,
        ))  # fmt: skip

    def _replan_due(self, t: float, neighbors: list[FrenetVehicle]) -> bool:
        """Whether to decide again: once a period, and at once when a vehicle or one of its events is new."""
        seen = frozenset((n.remote.id, n.remote.events) for n in neighbors)
        if t - self._t_decided < _PERIOD - 1e-6 and seen == self._seen_ids:
            return False
        self._seen_ids, self._t_decided = seen, t
        return True

    def _blocking_vehicles(self, neighbors: list[FrenetVehicle], s: float) -> list[FrenetVehicle]:
        """Vehicles on the route whose front is not behind the ego's rear, nearest first."""
        rear = s + self.vehicle.rear
        beside = oncoming_assumed_in_lane(neighbors, self.vehicle, self._was_on_route)
        found = [
            n
            for n in neighbors
            if n.s + n.half_length > rear and self._is_blocking(n, 0.0) and n.remote.id not in beside
        ]
        return sorted(found, key=lambda n: n.s)

    def _is_blocking(self, other: FrenetVehicle, d: float) -> bool:
        """Whether a vehicle leaves too little room beside the ego at lateral coordinate `d`."""
        return abs(other.d - d) < 0.5 * self.vehicle.width + BLOCKING_GAP + other.half_width

    def _select_lead(self, blockers: list[FrenetVehicle], s: float, v_x: float) -> LeadVehicle | None:
        """Return what demands most of the ego: on the route, or crossing it."""
        leader = find_lead(blockers, s, v_x, self.vehicle, self.speed, self._stopping_for)
        if self._conflict is None:
            return leader
        crosses = virtual_lead(self._conflict, s, v_x, self.speed)
        if leader is None or crosses.required_deceleration > leader.required_deceleration:
            return crosses
        return leader

    def _decide(
        self,
        ego: FrenetEgo,
        leader: LeadVehicle | None,
        blockers: list[FrenetVehicle],
        neighbors: list[FrenetVehicle],
    ) -> None:
        """Renew the maneuver that is under way, or choose whether to begin one."""
        if self._maneuver is not None:
            if self._returning:
                self._maneuver = delay_return(ego, self.road, self._maneuver, neighbors)
            else:
                self._replan(ego, self._maneuver, leader, neighbors)
            return
        plans: dict[str, Maneuver] = {}
        candidates: list[Candidate] = []
        status = Status.OK
        waiting = self._decision.action in (Action.FOLLOW, Action.BRAKE)
        looks = (
            leader is not None
            and leader.kind != "crossing"
            and leader.comfort_stop_deceleration > _COMFORTABLE
        )
        if leader is not None and looks and (waiting or leader.follow_acceleration < _FOLLOW_THRESHOLD):
            ahead = [b for b in blockers if b.s > ego.s]
            kept = vehicles_to_follow(ahead, leader, ego)
            self._followed_ids = {n.remote.id for n in kept}
            others = [] if self._leader_only else _excluding(neighbors, ahead)
            ahead = _excluding(ahead, kept)
            if leader.v_x > ego.v_target - self.evasion.min_speed_advantage:
                candidates.append(Candidate(side="left", rejection=f"{leader.id} is almost as fast"))
            else:
                brakes = min(self.speed.b_max, _EMERGENCY_GRIP_FRACTION * self.vehicle.mu * GRAVITY)
                helpless = leader.required_deceleration > brakes
                ways = (self._swerves[0], self._swerves[-1]) if helpless else self._swerves[:1]
                plans, candidates, status = plan_candidates(
                    ego, self.road, ahead, others, ways, start_now=waiting, braking_insufficient=helpless,
                    awareness_range=self._known_range,
                )  # fmt: skip
        self._decision = choose_action(
            leader, candidates, previous=self._decision.action, follow_threshold=_FOLLOW_THRESHOLD,
            comfort_deceleration=_COMFORTABLE,
        )  # fmt: skip
        if (
            leader is not None
            and leader.comfort_stop_deceleration < math.inf
            and not self._decision.action.is_evading
        ):
            self._stopping_for.add(leader.id)
        if self._decision.action.is_evading:
            side = "left" if self._decision.action is Action.EVADE_LEFT else "right"
            self._maneuver, self._within_lane, self._status = plans[side], True, status

    def _replan(
        self, ego: FrenetEgo, maneuver: Maneuver, leader: LeadVehicle | None, neighbors: list[FrenetVehicle]
    ) -> None:
        """Go on with the maneuver for what is known now, or give it up."""
        neighbors = [n for n in neighbors if n.remote.id not in self._followed_ids]
        passing = [n for n in neighbors if self._is_blocking(n, 0.0) and n.s + n.half_length > maneuver.start]
        if not passing:
            return
        need = 0.0 if leader is None else leader.required_deceleration
        now = replan(
            ego, self.road, maneuver, sorted(passing, key=lambda n: n.s),
            [] if self._leader_only else _excluding(neighbors, passing), self._swerves, within_lane=self._within_lane,
            following_feasible=need < _CANCEL_BRAKE_FRACTION * self.speed.b_max, awareness_range=self._known_range,
        )  # fmt: skip
        self._maneuver, self._status = now.maneuver, now.status
        if now.reason:
            self._decision = Decision(action=Action.FOLLOW, reason=now.reason)
            self._returning = now.maneuver is not None

    def _acceleration(
        self, s: float, v_x: float, yaw_rate: float, leader: LeadVehicle | None, dt: float, a_limit: float
    ) -> float:
        wanted = min(profile_acceleration(s, v_x, self._speed_profile, self.speed), a_limit)
        action = self._decision.action
        if leader is not None:
            stops = leader.comfort_stop_deceleration <= _COMFORTABLE
            if action is Action.BRAKE and not (stops and leader.required_deceleration < _FALLBACK_BRAKE):
                wanted = -min(max(leader.required_deceleration, _FALLBACK_BRAKE), self.speed.b_max)
            elif action is not Action.KEEP:
                wanted = min(wanted, leader.follow_acceleration, 0.0 if action is Action.BRAKE else math.inf)
        last = 0.0 if self._command is None else self._command.a_x
        emergency = wanted < -min(2.0 * self.speed.b_comfort, _HARD_BRAKING_FRACTION * self.speed.b_max)
        share = _EMERGENCY_GRIP_FRACTION if emergency else _GRIP
        if emergency and leader is not None:
            grip = self.vehicle.mu * GRAVITY
            share = min(max(leader.required_deceleration / grip, share), 1.0)  # all of it where less hits
        limited = friction_limited(wanted, v_x * yaw_rate, self.vehicle.mu, grip_fraction=share)
        # brakes let go slowly would make the ego slower on its way around than that is meant for
        lets_go = self._maneuver is not None and last < min(limited, 0.0)
        return jerk_limited(limited, last, dt, self.speed, emergency=emergency or lets_go)

    def _safe_stop(self, reason: str) -> Command:
        """Hold the steering and brake: the lowest rung of the ladder."""
        last = self._command
        return self._emit(Command(
            delta=0.0 if last is None else last.delta, a_x=-_FALLBACK_BRAKE,
            decision=Decision(action=Action.BRAKE, reason=reason), band=None,
            reference=self.road.path, status=Status.INVALID_INPUT,
        ))  # fmt: skip

    def _emit(self, command: Command) -> Command:
        """Remember a command as the last one; log it where the action or the status changes."""
        last, self._command = self._command, command
        new = command.decision
        if last is None or last.decision.action is not new.action or last.status is not command.status:
            _LOG.debug("t = %.2f s: %s, %s (%s)", self._t, new.action.value, new.reason, command.status.name)
        return command


def _excluding(neighbors: list[FrenetVehicle], others: list[FrenetVehicle]) -> list[FrenetVehicle]:
    left_out = {n.remote.id for n in others}
    return [n for n in neighbors if n.remote.id not in left_out]

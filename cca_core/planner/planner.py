"""Planner: decide, plan the maneuver, follow it, once a cycle."""

import logging
import math
from collections.abc import Iterable
from importlib import import_module

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.decide import (
    Action,
    Conflict,
    Decision,
    LeadVehicle,
    choose_action,
)
from cca_core.decide.action import explained
from cca_core.errors import Status
from cca_core.follow import PreviewController, SpeedSettings, squared_speed_limit
from cca_core.frenet import INCOMPLETE, FrenetEgo, FrenetVehicle, to_frenet
from cca_core.frenet.branches import Branches
from cca_core.kernel import bind
from cca_core.kernel.speed import interpolated, profile_acceleration
from cca_core.path import Path, Road, interpolate_path
from cca_core.planner.abort import delay_return, return_deceleration, vehicle_alongside
from cca_core.planner.actuation import limit_acceleration, requested_acceleration
from cca_core.planner.blocking import blocking_vehicles, blocks_offset, excluding, vehicles_on_maneuver
from cca_core.planner.candidates import Plans, maneuver_levels, plan_around_lead
from cca_core.planner.command import Command
from cca_core.planner.inputs import (
    CycleClock,
    RadioHealth,
    check_arguments,
    first_station,
    invalid_state_reason,
    is_list,
    usable_range,
    vehicles_on_level,
    warn_of_tight_bend,
)
from cca_core.planner.last_known import LastKnown
from cca_core.planner.lead import find_lead, oncoming_assumed_in_lane
from cca_core.planner.maneuver import Maneuver
from cca_core.planner.replan import Outcome, replan
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.yielding import find_yield_conflict, virtual_lead
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

__all__ = ["Command", "Planner"]

_interpolated, _profile_acceleration = bind(interpolated), bind(profile_acceleration)
_LOG = logging.getLogger(__name__)


class Planner:
    """Cooperative collision avoidance of one vehicle.

    Parameters
    ----------
    vehicle : VehicleParams
        The ego.
    road : Road or Path
        Route and lanes; a bare path is one lane of 3.5 m.
    cruise_speed : float
        Target speed [m/s]. It can be set between two steps; the ego approaches it in comfort.
    evasion : EvasionSettings, optional
        How other vehicles are passed, followed and yielded to.
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
    ) -> None:
        check_arguments(vehicle, road, evasion, speed, controller)
        self.vehicle = vehicle
        self.road = road if isinstance(road, Road) else Road(road)
        warn_of_tight_bend(self.road.path, vehicle)
        self._cruise_speed = check_real("cruise_speed", cruise_speed, gt=0.0)
        self.evasion = evasion or EvasionSettings()
        self.speed = speed or SpeedSettings()
        self._levels = maneuver_levels(self.evasion, vehicle)
        self._controller = controller or PreviewController(vehicle)
        self._speed_profile = self._profile(self._cruise_speed)
        # what is slow to import or to build exists before the first cycle
        interpolate_path([[0.0, 0.0], [1.0, 0.0]])
        import_module("scipy.interpolate")
        self.road.path.project(self.road.path.position(self.road.path.start))
        margin = self.evasion.clearance + self.evasion.decision.relevance_margin
        self._lateral_range = self.road.right_edge - margin, self.road.left_edge + margin
        branches = Branches(self.road.path)
        self._branches = branches if branches.passes_itself else None
        self._clock = CycleClock()
        self._s: float | None = None
        self._v_x = 0.0
        self._command: Command | None = None
        self._a_x = 0.0  # of the last cycle that was no safe stop
        self._input_faults: tuple[str, ...] = ()
        self._is_blind = False
        self._last_s: dict[str, float] = {}
        self._last_known = LastKnown(self.evasion.decision.memory_time)
        self._awareness_range = math.inf
        self._known_events: frozenset[tuple[str, frozenset[str]]] = frozenset()
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
        return f"Planner({self.road!r}, cruise_speed={self.cruise_speed:g}, {action} at t={self._clock.t:g})"

    @property
    def cruise_speed(self) -> float:
        """Target speed [m/s]; a speed that is not positive and finite raises `InputError`."""
        return self._cruise_speed

    @cruise_speed.setter
    def cruise_speed(self, value: float) -> None:
        value = check_real("cruise_speed", value, gt=0.0)
        if value == self._cruise_speed:
            return
        self._cruise_speed = value
        stations, target = self._profile(value)
        if self._s is not None and self._v_x > value:  # slow down in comfort from here
            b, v = self.speed.b_comfort, self._v_x
            begin = self._s + 0.5 * v * b / self.speed.jerk  # while the deceleration builds up
            ramp = v * v - 2.0 * b * (stations - begin)
            target = np.minimum(self._profile(v)[1], np.maximum(target, ramp))
        self._speed_profile = stations, target

    def _profile(self, cruise: float) -> tuple[Array, Array]:
        """Speed profile of the route for a cruise speed."""
        max_speed = min(cruise, self.road.speed_limit)
        curve_acceleration = self.evasion.actuation.curve_acceleration
        return squared_speed_limit(self.road.path, max_speed, curve_acceleration, self.speed)

    @property
    def maneuver(self) -> Maneuver | None:
        """The ongoing maneuver, None while the ego keeps its route."""
        return self._maneuver

    def step(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        *,
        awareness_range: float = math.inf,
        radio: RadioHealth | None = None,
    ) -> Command:
        """Compute steering and acceleration for this cycle.

        Parameters
        ----------
        t : float
            Time [s], increasing from call to call. After a stamp that is none, repeats or steps back the
            planner goes on with its last period, for at most 1 s in a row.
        state : VehicleState
            The ego's motion now. If `state.t` is given, a state older than `DecisionSettings.max_state_age`
            counts as lost.
        remotes : iterable of RemoteVehicle
            The other vehicles, dead-reckoned to `t`.
        awareness_range : float
            Awareness range in this cycle [m]; overrides the setting if smaller.
        radio : TrackerHealth, optional
            `Tracker.health(t)`, or any object with `trusted` and `reason`. While it is not to be trusted, the
            awareness range is 0 and the command says why.

        Returns
        -------
        command : Command
            Steering, acceleration and their reason. It never raises and never holds NaN: invalid vehicles
            are dropped with a reason; other wrong inputs are listed in `Command.input_faults`; an invalid
            state leads to a safe stop with `Status.INVALID_INPUT`.
        """
        try:
            dt, fault = self._clock.advance(t)
            self._awareness_range, faults = usable_range(awareness_range, radio, remotes)
            self._is_blind, self._input_faults = bool(faults), (*faults, fault) if fault else faults
            reason = invalid_state_reason(self._clock.now, state, self.evasion.decision.max_state_age)
            if not reason and self._clock.is_lost:
                reason = f"no usable time for {self._clock.lost_time:.1f} s: {fault}"
            if reason:
                return self._safe_stop(reason)
            return self._cycle(dt, state, remotes)
        except Exception as error:  # no input and no defect may leave the vehicle without a command
            _LOG.exception("internal error at t = %.2f s", self._clock.t)
            return self._safe_stop(f"internal error: {error!r}")

    def _cycle(self, dt: float, state: VehicleState, remotes: Iterable[RemoteVehicle]) -> Command:
        path = self.road.path
        s_guess = first_station(path, state) if self._s is None else self._s
        s, d, heading, _ = path.foot_point(state.x, state.y, s_guess)
        max_distance = self.evasion.decision.max_route_distance
        if not abs(d) < max_distance:
            return self._safe_stop(f"ego {abs(d):.1f} m off the route (limit {max_distance:.1f} m)")
        if math.cos(state.psi - heading) < 0.0:
            return self._safe_stop(f"ego heading {state.psi:.2f} rad, route {heading:.2f} rad (degrees?)")
        self._s, self._v_x, (stations, squared) = s, max(state.v_x, 0.0), self._speed_profile
        v_target = math.sqrt(max(_interpolated(len(stations), stations, squared, s), 0.0))
        ego = FrenetEgo(
            vehicle=self.vehicle, s=s + self.vehicle.box_offset, d=d, v_x=self._v_x,
            v_target=v_target, speed=self.speed,
        )  # fmt: skip
        branches = None if self._branches is None else (self._branches, s)
        vehicles, dropped = to_frenet(remotes, path, self._last_s, self._lateral_range, branches)
        vehicles += self._recall(remotes, vehicles, dropped, branches)
        vehicles, off_level, faults = vehicles_on_level(vehicles, self.road, self.evasion.decision)
        dropped, self._input_faults = dropped + off_level, self._input_faults + faults
        lead_settings = self.evasion.lead
        in_lane = oncoming_assumed_in_lane(vehicles, self.vehicle, self._was_on_route, lead_settings)
        blocking = blocking_vehicles(vehicles, ego, lead_settings, in_lane)
        self._end_maneuver(ego)
        lead = self._select_lead(blocking, ego)
        if self._replan_due(self._clock.t, vehicles):
            self._conflict = find_yield_conflict(
                ego, self.road, vehicles, self.evasion.crossing, self._conflict
            )
            lead = self._select_lead(blocking, ego)
            self._decide(ego, lead, blocking, vehicles)
        if self._maneuver is not None and self._decision.action.is_evading:
            kept = vehicles_on_maneuver(
                self._maneuver, vehicles, ego, lead_settings, self._followed_ids,
                degraded=self._status is not Status.OK,
            )  # fmt: skip
            lead = self._select_lead(kept, ego)
        reference = path if self._maneuver is None else self._maneuver.reference
        self._a_x = float(self._acceleration(ego, state.r, lead, vehicles, reference, dt))
        delta = self._controller.steer(state, reference, dt, s_guess=s)
        return self._emit(Command(
            delta=delta, a_x=self._a_x, decision=self._decision, reference=reference, status=self._status,
            band=None if self._maneuver is None else self._maneuver.band, dropped=dropped,
            input_faults=self._input_faults,
        ))  # fmt: skip

    def _recall(
        self,
        remotes: object,
        vehicles: list[FrenetVehicle],
        dropped: tuple[tuple[str, str], ...],
        branches: tuple[Branches, float] | None,
    ) -> list[FrenetVehicle]:
        """Return vehicles that are not reported, but may be there."""
        incomplete = [reason for _, reason in dropped if reason.startswith(INCOMPLETE)]
        recalled, faults = self._last_known.recall(
            self._clock.t, vehicles, dropped, lost=bool(incomplete) or not is_list(remotes),
            blind=self._is_blind,
        )  # fmt: skip
        if self._last_known.is_listening(self._clock.t):
            self._awareness_range = 0.0
        if incomplete or faults:
            self._input_faults = (*self._input_faults, *incomplete, *faults)
        return to_frenet(recalled, self.road.path, {}, self._lateral_range, branches)[0] if recalled else []

    def _end_maneuver(self, ego: FrenetEgo) -> None:
        """Note whether the body is still inside the ego lane; end a maneuver behind its window."""
        if self._maneuver is not None:
            half, lane, d = 0.5 * self.vehicle.width, self.road.ego_lane, ego.d
            self._within_lane = self._within_lane and lane.right < d - half and d + half < lane.left
            if ego.s_cg >= self._maneuver.end:
                self._maneuver, self._returning = None, False
                self._status = Status.OK
                self._decision = Decision(action=Action.KEEP, reason="maneuver complete: back in ego lane")
                self._t_decided = -math.inf
        if not (self._decision.action.is_evading or self._returning):
            self._status = Status.OK

    def _replan_due(self, t: float, vehicles: list[FrenetVehicle]) -> bool:
        """Whether to decide again: once a period, and at once when a vehicle or one of its events is new."""
        events = frozenset((n.id, n.remote.events) for n in vehicles)
        if t - self._t_decided < self.evasion.decision.period - 1e-6 and events == self._known_events:
            return False
        self._known_events, self._t_decided = events, t
        return True

    def _select_lead(self, blocking: list[FrenetVehicle], ego: FrenetEgo) -> LeadVehicle | None:
        """Return what demands most of the ego: a vehicle on the route, or the stop point of a conflict."""
        lead = find_lead(blocking, ego, self.evasion.lead, self._stopping_for)
        if self._conflict is None:
            return lead
        virtual = virtual_lead(self._conflict, ego, self.evasion.lead)
        if lead is None or virtual.required_deceleration > lead.required_deceleration:
            return virtual
        return lead

    def _decide(
        self,
        ego: FrenetEgo,
        lead: LeadVehicle | None,
        blocking: list[FrenetVehicle],
        vehicles: list[FrenetVehicle],
    ) -> None:
        """Replan the ongoing maneuver, or choose whether to start one."""
        if self._maneuver is not None:
            if self._returning:
                abort = self.evasion.abort
                self._maneuver = delay_return(ego, self.road, self._maneuver, vehicles, abort)
            else:
                self._replan(ego, self._maneuver, lead, vehicles)
            return
        decision = self.evasion.decision
        waiting = self._decision.action in (Action.FOLLOW, Action.BRAKE)
        plans: Plans = {}, [], Status.OK
        if (
            lead is not None
            and lead.kind != "crossing"
            and lead.comfort_stop_deceleration > decision.comfort_deceleration
            and (waiting or lead.follow_acceleration < -decision.follow_threshold)
        ):
            plans, self._followed_ids = plan_around_lead(
                ego, self.road, lead, blocking, vehicles, self._levels, start_now=waiting,
                awareness_range=self._awareness_range,
            )  # fmt: skip
        maneuvers, candidates, status = plans
        self._decision = choose_action(
            lead, candidates, previous=self._decision.action, follow_threshold=-decision.follow_threshold,
            comfort_deceleration=decision.comfort_deceleration,
        )  # fmt: skip
        if self._decision.action.is_evading:
            side = "left" if self._decision.action is Action.EVADE_LEFT else "right"
            self._maneuver, self._within_lane, self._status = maneuvers[side], True, status
        elif lead is not None and lead.comfort_stop_deceleration < math.inf:
            self._stopping_for.add(lead.id)

    def _replan(
        self, ego: FrenetEgo, maneuver: Maneuver, lead: LeadVehicle | None, vehicles: list[FrenetVehicle]
    ) -> None:
        """Replan, cancel or abort the ongoing maneuver."""
        vehicles = [n for n in vehicles if n.id not in self._followed_ids]
        overtaken = [
            n for n in vehicles if blocks_offset(n, 0.0, ego, self.evasion.lead) and n.front > maneuver.start
        ]
        if not overtaken:
            return
        need = 0.0 if lead is None else lead.required_deceleration
        result = replan(
            ego, self.road, maneuver, sorted(overtaken, key=lambda n: n.s), excluding(vehicles, overtaken),
            self._levels, within_lane=self._within_lane, awareness_range=self._awareness_range,
            following_feasible=need < self.evasion.replan.cancel_brake_fraction * self.speed.b_max,
        )  # fmt: skip
        self._maneuver, self._status = result.maneuver, result.status
        if result.outcome is not Outcome.CONTINUED:
            self._decision = explained(Action.FOLLOW, result.outcome.value, str(result.rejection))
            self._returning = result.maneuver is not None

    def _acceleration(
        self,
        ego: FrenetEgo,
        yaw_rate: float,
        lead: LeadVehicle | None,
        vehicles: list[FrenetVehicle],
        reference: Path,
        dt: float,
    ) -> float:
        """Acceleration for the action, within the limits of the return, friction and jerk."""
        (stations, squared), speed = self._speed_profile, self.speed
        cruise = _profile_acceleration(
            len(stations), stations, squared, ego.s_cg, ego.v_x, speed.a_max, speed.b_comfort, speed.b_max
        )
        if self._returning:
            abort = self.evasion.abort
            cruise = min(cruise, -return_deceleration(reference, ego.s_cg, ego.v_x, abort))
            if vehicle_alongside(ego, self.road, vehicles, abort):
                cruise = min(cruise, 0.0)
        requested = requested_acceleration(cruise, self._decision.action, lead, self.speed, self.evasion)
        return limit_acceleration(
            requested, self._a_x, ego.v_x * yaw_rate, dt, lead, self.vehicle, self.speed, self.evasion,
            maneuvering=self._maneuver is not None,
        )  # fmt: skip

    def _safe_stop(self, reason: str) -> Command:
        """Hold the steering and brake."""
        last, self._a_x = self._command, min(self._a_x, 0.0)  # the brakes are released as they were applied
        return self._emit(Command(
            delta=0.0 if last is None else last.delta, band=None, reference=self.road.path,
            a_x=-self.evasion.actuation.safe_stop_deceleration, status=Status.INVALID_INPUT,
            decision=Decision(action=Action.BRAKE, reason=f"safe stop: {reason}"),
            input_faults=self._input_faults,
        ))  # fmt: skip

    def _emit(self, command: Command) -> Command:
        """Keep a command as the last one; log it if the action or the status changes."""
        last, self._command = self._command, command
        new = command.decision
        if last is None or last.decision.action is not new.action or last.status is not command.status:
            _LOG.debug(
                "t = %.2f s: %s, %s (%s)", self._clock.t, new.action.value, new.reason, command.status.name
            )
        return command

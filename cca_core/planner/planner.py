"""Planner: see, enumerate, certify, choose, act, once a cycle."""

import gc
import logging
import math
from collections.abc import Iterable

import numpy as np

from cca_core._checks import check_real
from cca_core.decide import Decision
from cca_core.errors import Status
from cca_core.follow import PreviewController, SpeedSettings
from cca_core.frenet import INCOMPLETE, to_frenet
from cca_core.path import Path, Road
from cca_core.planner import modes
from cca_core.planner.actuate import dead_reckon, planned_acceleration, since, stop_acceleration
from cca_core.planner.certificate import Grade
from cca_core.planner.command import Command
from cca_core.planner.deliberation import Deliberation
from cca_core.planner.inputs import (
    CycleClock,
    RadioHealth,
    check_arguments,
    check_road,
    first_station,
    invalid_state_reason,
    is_list,
    usable_range,
    vehicles_on_level,
    warn_of_foreign_gains,
    warn_of_tight_bend,
)
from cca_core.planner.lanes import LaneChoice
from cca_core.planner.last_known import recall
from cca_core.planner.reasons import explain
from cca_core.planner.records import (
    DrivenPlan,
    LateralPath,
    Level,
    Mode,
    Observation,
    PathKind,
    PlannerState,
)
from cca_core.planner.route_change import carry_plan, is_same_road, station_on
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.setup import Setup
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

__all__ = ["Command", "Planner"]

_LOG = logging.getLogger(__name__)
_TOO_FAST = 1.0  # above the speed profile, from which on the ego slows anew from where it is [m/s]


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
        Steering law; the default uses the shipped gains of a preset. Any other vehicle is steered with those
        of the BMW 320i, and the planner warns of it: pass
        ``PreviewController(vehicle, design_gains(vehicle))``.

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
        self._setup = Setup.make(vehicle, self.road, self.evasion, self.speed)
        self._setup.warm_up()
        self._limits = self._setup.limits
        if controller is None:
            warn_of_foreign_gains(vehicle)
        self._controller = controller or PreviewController(vehicle)
        self._lanes = LaneChoice(self._setup)
        self._last_s: dict[str, float] = {}
        self._clock = CycleClock()
        self._command: Command | None = None
        self._input_faults: tuple[str, ...] = ()
        self._stop_path: tuple[DrivenPlan | None, Path] = None, self.road.path  # that of a lost state
        self._state = PlannerState()
        self._speed_profile = self._setup.speed_profile(self._cruise_speed, None)

    def __repr__(self) -> str:
        mode = self._state.mode.value
        return f"Planner({self.road!r}, cruise_speed={self.cruise_speed:g}, {mode} at t={self._clock.t:g})"

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
        self._ease_speed(self._state.s, self._state.v)

    def set_route(self, road: Road | Path) -> None:
        """Go on along another route, or with other lanes and limits of the same one.

        It can be called between two steps, at any speed and within a maneuver. Steering and acceleration do
        not jump: the path that is being driven is carried over, and the ego returns from it to the new route
        in comfort. To lower speeds it brakes in comfort. The next step decides anew.

        Parameters
        ----------
        road : Road or Path
            Route and lanes from now on; a bare path is one lane of 3.5 m. A road that equals the last one
            changes nothing.

        Raises
        ------
        InputError
            If `road` is neither a `Road` nor a `Path`. An ego that is off the new route, or heads against it,
            makes a safe stop in the next step.
        """
        check_road(road)
        last, self.road = self.road, road if isinstance(road, Road) else Road(road)
        if is_same_road(last, self.road):
            return
        warn_of_tight_bend(self.road.path, self.vehicle)
        setup = Setup.make(self.vehicle, self.road, self.evasion, self.speed)
        self._lanes, plan = LaneChoice(setup), self._state.plan
        self._drive_along(setup, goes_on=plan is None or plan.path.to_lane is None)

    @property
    def lane(self) -> float:
        """Lateral offset on `road` of the lane that the ego keeps to [m]; 0 unless another was requested."""
        return self._lanes.offset(self._lanes.here)

    @property
    def requested_lane(self) -> float | None:
        """Lateral offset on `road` of the lane to which the ego is to change [m]; None if it is there."""
        lanes = self._lanes
        return None if lanes.wanted == lanes.here else lanes.offset(lanes.wanted)

    def request_lane(self, d: float | None) -> None:
        """Change to another lane for good, as soon as it is clear.

        The change is checked like every maneuver: the lane must be known to be clear (eq 11), drivers behind
        in it must have the time to react, and the plan is certified. Until then the ego drives on. If a
        vehicle alongside is about as fast, the ego falls back to a speed up to 2.5 m/s lower than that
        vehicle's and lets it pass (`LaneChangeSettings`). The reason names the vehicle that it waits for.
        Once its body is inside the lane, that is the ego lane, and obstacles are evaded from there. Several
        lanes are changed one by one. A request replaces the last one, also within a change; a change that
        has begun is then aborted if the way back is clear.

        Parameters
        ----------
        d : float or None
            Lateral offset of the lane's center on `road` [m], left positive, or any other offset within the
            lane. 0 or None is the lane of the route. `set_route` ends a request.

        Raises
        ------
        InputError
            If there is no lane at `d`, if it or one on the way to it has another direction, or if a curve of
            the route is tighter than `d`.
        """
        if self._lanes.request(d, max(self._clock.t, 0.0)):
            self._state = self._state._replace(t_decided=-math.inf)

    def _drive_along(self, setup: Setup, *, goes_on: bool) -> None:
        """Change the route that is driven along, under way."""
        last, self._setup = self._setup.road, setup
        state = self._state = self._state._replace(memory=self._state.memory.on_other_route())
        self._last_s = {}
        if state.s is not None and state.estimate is not None:
            s, plan = station_on(setup.road.path, state.estimate, state.s), state.plan
            if plan is not None:
                plan = carry_plan(plan, last, setup.road, state.s, s, state.v, self._limits, goes_on)
            self._state = state._replace(s=s, plan=plan, t_decided=-math.inf)
        self._ease_speed(self._state.s, self._state.v)

    def _ease_speed(self, s: float | None, v: float) -> None:
        """Make the speed profile anew, so that a faster ego slows in comfort from here."""
        start = None if s is None else (s, v)
        self._speed_profile = self._setup.speed_profile(self._cruise_speed, start)

    @property
    def maneuver(self) -> LateralPath | None:
        """The path around other vehicles or back to the route that is being driven, None on the route."""
        plan, s = self._state.plan, self._state.s
        if plan is None or s is None or not plan.path.begin <= s < plan.path.end:
            return None
        return plan.path

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
        dt, collects = 0.02, gc.isenabled()
        gc.disable()  # a collection waits until the command is there
        try:
            dt, fault = self._clock.advance(t)
            known, faults = usable_range(awareness_range, radio, remotes)
            is_blind, self._input_faults = bool(faults), (*faults, fault) if fault else faults
            reason = invalid_state_reason(self._clock.now, state, self.evasion.decision.max_state_age)
            if not reason and self._clock.is_lost:
                reason = f"no usable time for {self._clock.lost_time:.1f} s: {fault}"
            if reason:
                return self._safe_stop(reason, dt)
            if self._state.plan is not None and self._state.s is not None:
                plan, lane = self._state.plan, self._lanes.enter(self._state.plan, self._state.s)
                if lane is not None:
                    self._drive_along(lane, goes_on=plan.path.to_lane is not None)
            observation, dropped = self._see(state, remotes, known, is_blind=is_blind)
            if isinstance(observation, str):
                return self._safe_stop(observation, dt)
            if self._is_due(observation):
                self._decide(observation)
            return self._act(observation, state, dt, dropped)
        except Exception as error:  # no input and no defect may leave the vehicle without a command
            _LOG.exception("internal error at t = %.2f s", self._clock.t)
            return self._safe_stop(f"internal error: {error!r}", dt)
        finally:
            if collects:
                gc.enable()

    def _see(
        self, state: VehicleState, remotes: Iterable[RemoteVehicle], known: float, *, is_blind: bool
    ) -> tuple[Observation | str, tuple[tuple[str, str], ...]]:
        """Return the ego and the other vehicles on the route, or why the ego is not on it."""
        setup, settings = self._setup, self.evasion.decision
        path = setup.road.path
        guess = first_station(path, state) if self._state.s is None else self._state.s
        s, d, heading, kappa = path.foot_point(state.x, state.y, guess)
        if not abs(d) < settings.max_route_distance:
            return f"ego {abs(d):.1f} m off the route (limit {settings.max_route_distance:.1f} m)", ()
        if math.cos(state.psi - heading) < 0.0:
            return f"ego heading {state.psi:.2f} rad, route {heading:.2f} rad (degrees?)", ()
        branches = None if setup.branches is None else (setup.branches, s)
        vehicles, dropped = to_frenet(remotes, path, self._last_s, setup.lateral_range, branches)
        incomplete = tuple([reason for _, reason in dropped if reason.startswith(INCOMPLETE)])
        memory, missing, assumed = recall(
            self._state.memory, self._clock.t, vehicles, dropped, settings,
            lost=bool(incomplete) or not is_list(remotes), blind=is_blind,
        )  # fmt: skip
        if missing:
            vehicles += to_frenet(missing, path, {}, setup.lateral_range, branches)[0]
        vehicles, off_level, faults = vehicles_on_level(vehicles, setup.road, settings)
        dropped, self._input_faults = (
            dropped + off_level,
            (*self._input_faults, *incomplete, *assumed, *faults),
        )
        known = 0.0 if memory.is_listening(self._clock.t) else known
        v_y = state.v_y or setup.vehicle.l_r * state.r  # in a tight turn it does not move where it points
        course = state.psi + math.atan(v_y / max(state.v_x, 1.0))
        angle = math.remainder(course - heading, 2.0 * math.pi)
        return Observation(
            t=self._clock.t, s=s, d=d, angle=angle, v=max(state.v_x, 0.0),
            bend=state.r / max(state.v_x, 3.0) - kappa, vehicles=tuple(vehicles),
            awareness_range=min(known, self.evasion.awareness_range), memory=memory,
        ), dropped  # fmt: skip

    def _is_due(self, observation: Observation) -> bool:
        """Whether to decide again: once a period, and at once when a vehicle or one of its events is new."""
        state = self._state
        seen = frozenset([(n.remote.id, n.remote.events) for n in observation.vehicles])
        if observation.t - state.t_decided < self.evasion.decision.period - 1e-6 and seen == state.seen:
            return False
        has_news = not seen <= state.seen
        self._state = state._replace(seen=seen, has_news=has_news, t_decided=observation.t)
        return True

    def _decide(self, observation: Observation) -> None:
        """Enumerate, certify and choose."""
        state = self._state
        limit = max(float(np.interp(observation.s, *self._speed_profile)), 0.0)
        if observation.v > math.sqrt(limit) + _TOO_FAST:  # it was faster at the start, or was driven so
            self._ease_speed(observation.s, observation.v)
        deliberation = Deliberation(
            self._setup, state, observation, self._speed_profile, self._cruise_speed,
            self._lanes.wish(observation.t),
        )  # fmt: skip
        self._state = state._replace(plan=deliberation.decide())

    def _act(
        self, observation: Observation, state: VehicleState, dt: float, dropped: tuple[tuple[str, str], ...]
    ) -> Command:
        """Follow the plan and explain it."""
        plan = self._state.plan
        if plan is None:  # the first decision precedes the first command
            return self._safe_stop("no plan", dt)
        a_x = planned_acceleration(
            plan, observation.t + dt, observation.v, state.v_x * state.r, self._limits, self.vehicle.mu
        )
        delta = self._controller.steer(state, plan.reference, dt, s_guess=observation.s)
        wish = modes.wished_mode(plan, self._state.mode, observation.s, a_x, self.evasion.decision)
        lag = 1.0 - math.exp(-dt / self.evasion.certificate.lag)
        a_true = self._state.a_true + (a_x - self._state.a_true) * lag
        self._state = modes.advance(
            self._state, observation.t, wish, s=observation.s, v=observation.v, a_x=a_x, a_true=a_true,
            delta=delta, estimate=state, memory=observation.memory,
        )  # fmt: skip
        mode = self._state.mode
        decision = explain(mode, plan, observation, a_x, self._setup, self._speed_profile, self._command)
        beyond_comfort = plan.grade >= Grade.NOMINAL or plan.path.level is not Level.COMFORT
        degraded = beyond_comfort and plan.path.kind is not PathKind.ROUTE
        return self._emit(Command(
            delta=delta, a_x=a_x, decision=decision, reference=plan.reference,
            status=Status.DEGRADED if degraded else Status.OK, band=plan.path.band, dropped=dropped,
            input_faults=self._input_faults, mode=mode, certificate=plan.certificate,
            safe_stop=since(plan.safe_stop, observation.t - plan.t),
        ))  # fmt: skip

    def _safe_stop(self, reason: str, dt: float) -> Command:
        """Follow the safe stop of the last plan on a dead-reckoned state; without one, brake straight on."""
        state = self._state
        a_x, delta = -self.evasion.actuation.safe_stop_deceleration, state.delta
        reference, plan, estimate = self._setup.road.path, state.plan, state.estimate
        a_x = max(a_x, -self._limits.b_max)
        if plan is not None and estimate is not None and "internal" not in reason:
            a_x = max(
                stop_acceleration(plan.safe_stop, self._clock.t + dt - plan.t, a_x), -self._limits.b_max
            )
            estimate = dead_reckon(estimate, state.delta, a_x, dt, self.vehicle)
            if self._stop_path[0] is not plan:
                self._stop_path = plan, plan.safe_stop.path() or plan.reference
            reference = self._stop_path[1]
            delta = self._controller.steer(estimate, reference, dt)
        self._state = modes.advance(
            state, self._clock.t, Mode.SAFE_STOP, a_x=min(state.a_x, 0.0), delta=delta, estimate=estimate,
            t_decided=-math.inf,
        )  # fmt: skip
        return self._emit(Command(
            delta=delta, a_x=a_x, band=None, reference=reference, status=Status.INVALID_INPUT,
            decision=Decision(action=modes.ACTIONS[Mode.SAFE_STOP], reason=f"safe stop: {reason}"),
            input_faults=self._input_faults, mode=Mode.SAFE_STOP,
            safe_stop=None if plan is None else since(plan.safe_stop, self._clock.t - plan.t),
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

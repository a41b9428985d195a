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
from cca_core.decide import Action, Candidate, Conflict, Decision, Leader, choose_action
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
from cca_core.planner.abort import is_beside, put_off, slow_enough
from cca_core.planner.command import Command
from cca_core.planner.frenet import Ego, Neighbor, locate, unusable
from cca_core.planner.lead import IN_THE_WAY, kept_behind, leader_ahead, oncoming_beside
from cca_core.planner.maneuver import Evasion
from cca_core.planner.replan import renew, swerves_of, ways_around
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.yielding import conflict_ahead, leader_at
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

__all__ = ["Command", "Planner"]

_LOG = logging.getLogger(__name__)
_OFF_ROUTE = 15.0  # farther from the route than this the planner does not know where it is [m]
_SLOWED = -0.5  # acceleration asked for by a leader from which on a way around it is looked for [m/s^2]
_BESIDE = 1.5  # beyond the road's edges and the clearance nobody matters who does not cross [m]
_PERIOD = 0.1  # between two looks at the same vehicles [s]
_STILL_FOLLOWED = 0.3  # share of the brakes within which a swerve is given up for following
_FALLBACK_BRAKE = 4.0  # [m/s^2]
_COMFORTABLE = 2.0  # deceleration up to which a stop behind who stands is preferred to a swerve [m/s^2]
_GRIP, _GRIP_IN_NEED = 0.9, 0.98  # shares of the tires' grip used for braking, and in an emergency
_HARD = 0.7  # share of the brakes from which on jerk is not spared, as from twice the comfortable share
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
        self.cruise_speed = check_real("cruise_speed", cruise_speed, above=0.0)
        self.evasion = evasion or EvasionSettings()
        self.speed = speed or SpeedSettings()
        self._swerves = swerves_of(self.evasion, vehicle)
        self._controller = controller or PreviewController(vehicle)
        self._leader_only = _leader_only
        self._cap = squared_speed_limit(
            self.road.path, min(self.cruise_speed, self.road.speed_limit), _CURVE_ACCELERATION, self.speed
        )
        # what is slow to import or to build is there before the first cycle
        interpolate_path([[0.0, 0.0], [1.0, 0.0]])
        import_module("scipy.interpolate")
        self.road.path.project(self.road.path.position(self.road.path.start))
        self._t = -math.inf
        self._s: float | None = None
        self._command: Command | None = None
        self._places: dict[str, float] = {}
        self._known_range = math.inf
        room = self.evasion.clearance + _BESIDE
        self._matters = self.road.right_edge - room, self.road.left_edge + room
        self._seen: frozenset[tuple[str, frozenset[str]]] = frozenset()
        self._decided = -math.inf
        self._decision = Decision(action=Action.KEEP, reason="starting")
        self._maneuver: Evasion | None = None
        self._inside = True
        self._retreating = False
        self._conflict: Conflict | None = None
        self._stopping: set[str] = set()
        self._kept: set[str] = set()
        self._met: dict[str, bool] = {}
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
        known_range: float = math.inf,
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
        known_range : float
            Distance up to which they are all that there are [m], where that is less than the settings say:
            0 while `Tracker.is_saturated`.

        Returns
        -------
        command : Command
            Steering, acceleration, and why. It never raises and never holds NaN: inputs that cannot be
            used are dropped with a reason, or lead to braking with `Status.INVALID_INPUT`.
        """
        defect = unusable(t, self._t, state)
        if defect:
            return self._give_up(defect)
        try:
            self._known_range = known_range if known_range >= 0.0 else 0.0
            return self._cycle(float(t), state, remotes)
        except Exception as error:  # no input and no defect may leave the car without a command
            _LOG.exception("internal error at t = %s s", t)
            return self._give_up(f"internal error: {error!r}")

    def _cycle(self, t: float, state: VehicleState, remotes: Iterable[RemoteVehicle]) -> Command:
        dt = min(t - self._t, 0.1)
        self._t = t
        path = self.road.path
        near = self._s if self._s is not None else float(path.project((state.x, state.y))[0])
        s, d, heading, _ = path.foot_point(state.x, state.y, near)
        if not abs(d) < _OFF_ROUTE:
            return self._give_up(f"the ego is not on its route (d = {d:.1f} m)")
        if math.cos(state.psi - heading) < 0.0:
            headings = f"{state.psi:.2f} instead of {heading:.2f} rad"
            return self._give_up(f"the ego heads against its route ({headings})")
        self._s = s
        neighbors, dropped = locate(remotes, path, self._places, self._matters)
        blockers = self._blockers(neighbors, s)
        v_target = math.sqrt(max(float(np.interp(s, *self._cap)), 0.0))
        leader = self._leader(blockers, s, state.v_x)
        if self._maneuver is not None:
            half = 0.5 * self.vehicle.width
            own = self.road.own_lane
            self._inside = self._inside and own.right < d - half and d + half < own.left
            if s >= self._maneuver.end:
                self._maneuver, self._retreating = None, False
                self._status = Status.OK
                self._decision = Decision(action=Action.KEEP, reason="back on the route")
                self._decided = -math.inf
        if not (self._decision.action.evades or self._retreating):
            self._status = Status.OK
        if self._is_news(t, neighbors):
            ego = Ego(vehicle=self.vehicle, s=s, v_x=max(state.v_x, 0.0), v_target=v_target, speed=self.speed)
            self._conflict = conflict_ahead(ego, self.road, neighbors, self._conflict)
            leader = self._leader(blockers, s, state.v_x)
            self._decide(ego, leader, blockers, neighbors)
        if self._maneuver is not None and self._decision.action.evades:
            late, at = self._status is not Status.OK, self._maneuver.offset_at
            kept = [n for n in neighbors if n.remote.id in self._kept]
            if late:  # whoever is in the way of the swerve is kept behind, as seen from it
                # not for what may be of one unheard: braking endangers those that are being passed
                likely = [n.likely() if n.unheard else n for n in neighbors if n not in kept]
                kept += [replace(n, d=n.d - at(n.s)) for n in likely if self._blocks(n, at(n.s))]
            leader = self._leader(sorted(kept, key=lambda n: n.s), s, state.v_x)
        reference = path if self._maneuver is None else self._maneuver.reference
        most = math.inf
        if self._retreating:
            most = -slow_enough(reference, s, state.v_x)
            if is_beside(self.vehicle, self.road, s, neighbors):
                most = min(most, 0.0)
        a_x = self._acceleration(s, state.v_x, state.r, leader, dt, most)
        delta = self._controller.steer(state, reference, dt, near=s)
        return self._given(Command(
            delta=delta, a_x=float(a_x), decision=self._decision, reference=reference, status=self._status,
            band=None if self._maneuver is None else self._maneuver.band, dropped=dropped,
        ))  # fmt: skip

    def _is_news(self, t: float, neighbors: list[Neighbor]) -> bool:
        """Whether to decide again: once a period, and at once when a vehicle or one of its events is new."""
        seen = frozenset((n.remote.id, n.remote.events) for n in neighbors)
        if t - self._decided < _PERIOD - 1e-6 and seen == self._seen:
            return False
        self._seen, self._decided = seen, t
        return True

    def _blockers(self, neighbors: list[Neighbor], s: float) -> list[Neighbor]:
        """Vehicles on the route whose front is not behind the ego's rear, nearest first."""
        rear = s + self.vehicle.box_offset - 0.5 * self.vehicle.length
        beside = oncoming_beside(neighbors, self.vehicle, self._met)
        found = [
            n
            for n in neighbors
            if n.s + n.half_length > rear and self._blocks(n, 0.0) and n.remote.id not in beside
        ]
        return sorted(found, key=lambda n: n.s)

    def _blocks(self, other: Neighbor, d: float) -> bool:
        """Whether a vehicle leaves too little room beside the ego at lateral coordinate `d`."""
        return abs(other.d - d) < 0.5 * self.vehicle.width + IN_THE_WAY + other.half_width

    def _leader(self, blockers: list[Neighbor], s: float, v_x: float) -> Leader | None:
        """Return what demands most of the ego: on the route, or crossing it."""
        leader = leader_ahead(blockers, s, v_x, self.vehicle, self.speed, self._stopping)
        if self._conflict is None:
            return leader
        crosses = leader_at(self._conflict, s, v_x, self.speed)
        if leader is None or crosses.required_deceleration > leader.required_deceleration:
            return crosses
        return leader

    def _decide(
        self,
        ego: Ego,
        leader: Leader | None,
        blockers: list[Neighbor],
        neighbors: list[Neighbor],
    ) -> None:
        """Renew the maneuver that is under way, or choose whether to begin one."""
        if self._maneuver is not None:
            if self._retreating:
                self._maneuver = put_off(ego, self.road, self._maneuver, neighbors)
            else:
                self._renew(ego, self._maneuver, leader, neighbors)
            return
        plans: dict[str, Evasion] = {}
        candidates: list[Candidate] = []
        status = Status.OK
        waiting = self._decision.action in (Action.FOLLOW, Action.BRAKE)
        looks = leader is not None and leader.kind != "crossing" and leader.stop_in_comfort > _COMFORTABLE
        if leader is not None and looks and (waiting or leader.follow_acceleration < _SLOWED):
            ahead = [b for b in blockers if b.s > ego.s]
            kept = kept_behind(ahead, leader, ego)
            self._kept = {n.remote.id for n in kept}
            others = [] if self._leader_only else _without(neighbors, ahead)
            ahead = _without(ahead, kept)
            if leader.v_x > ego.v_target - self.evasion.speed_floor:
                candidates.append(Candidate(side="left", obstruction=f"{leader.id} is almost as fast"))
            else:
                brakes = min(self.speed.b_max, _GRIP_IN_NEED * self.vehicle.mu * 9.81)
                helpless = leader.required_deceleration > brakes
                ways = (self._swerves[0], self._swerves[-1]) if helpless else self._swerves[:1]
                plans, candidates, status = ways_around(
                    ego, self.road, ahead, others, ways, at_once=waiting, helpless=helpless,
                    known_range=self._known_range,
                )  # fmt: skip
        self._decision = choose_action(
            leader, candidates, previous=self._decision.action, follow_below=_SLOWED,
            comfortable=_COMFORTABLE,
        )  # fmt: skip
        if leader is not None and leader.stop_in_comfort < math.inf and not self._decision.action.evades:
            self._stopping.add(leader.id)
        if self._decision.action.evades:
            side = "left" if self._decision.action is Action.EVADE_LEFT else "right"
            self._maneuver, self._inside, self._status = plans[side], True, status

    def _renew(self, ego: Ego, maneuver: Evasion, leader: Leader | None, neighbors: list[Neighbor]) -> None:
        """Go on with the maneuver for what is known now, or give it up."""
        neighbors = [n for n in neighbors if n.remote.id not in self._kept]
        passing = [n for n in neighbors if self._blocks(n, 0.0) and n.s + n.half_length > maneuver.start]
        if not passing:
            return
        need = 0.0 if leader is None else leader.required_deceleration
        now = renew(
            ego, self.road, maneuver, sorted(passing, key=lambda n: n.s),
            [] if self._leader_only else _without(neighbors, passing), self._swerves, inside=self._inside,
            can_follow=need < _STILL_FOLLOWED * self.speed.b_max, known_range=self._known_range,
        )  # fmt: skip
        self._maneuver, self._status = now.maneuver, now.status
        if now.reason:
            self._decision = Decision(action=Action.FOLLOW, reason=now.reason)
            self._retreating = now.maneuver is not None

    def _acceleration(
        self, s: float, v_x: float, yaw_rate: float, leader: Leader | None, dt: float, most: float
    ) -> float:
        wanted = min(profile_acceleration(s, v_x, self._cap, self.speed), most)
        action = self._decision.action
        if leader is not None:
            stops = leader.stop_in_comfort <= _COMFORTABLE
            if action is Action.BRAKE and not (stops and leader.required_deceleration < _FALLBACK_BRAKE):
                wanted = -min(max(leader.required_deceleration, _FALLBACK_BRAKE), self.speed.b_max)
            elif action is not Action.KEEP:
                wanted = min(wanted, leader.follow_acceleration, 0.0 if action is Action.BRAKE else math.inf)
        last = 0.0 if self._command is None else self._command.a_x
        emergency = wanted < -min(2.0 * self.speed.b_comfort, _HARD * self.speed.b_max)
        share = _GRIP_IN_NEED if emergency else _GRIP
        if emergency and leader is not None:
            grip = self.vehicle.mu * 9.81
            share = min(max(leader.required_deceleration / grip, share), 1.0)  # all of it where less hits
        limited = friction_limited(wanted, v_x * yaw_rate, self.vehicle.mu, share=share)
        # brakes let go slowly would make the ego slower on its way around than that is meant for
        lets_go = self._maneuver is not None and last < min(limited, 0.0)
        return jerk_limited(limited, last, dt, self.speed, emergency=emergency or lets_go)

    def _give_up(self, reason: str) -> Command:
        """Hold the steering and brake: the lowest rung of the ladder."""
        last = self._command
        return self._given(Command(
            delta=0.0 if last is None else last.delta, a_x=-_FALLBACK_BRAKE,
            decision=Decision(action=Action.BRAKE, reason=reason), band=None,
            reference=self.road.path, status=Status.INVALID_INPUT,
        ))  # fmt: skip

    def _given(self, command: Command) -> Command:
        """Remember a command as the last one; log it where the action or the status changes."""
        last, self._command = self._command, command
        new = command.decision
        if last is None or last.decision.action is not new.action or last.status is not command.status:
            _LOG.debug("t = %.2f s: %s, %s (%s)", self._t, new.action.value, new.reason, command.status.name)
        return command


def _without(neighbors: list[Neighbor], others: list[Neighbor]) -> list[Neighbor]:
    left_out = {n.remote.id for n in others}
    return [n for n in neighbors if n.remote.id not in left_out]

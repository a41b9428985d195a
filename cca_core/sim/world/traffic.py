"""How scripted road users move."""

import math

from cca_core.geometry import quintic_step
from cca_core.path import Path
from cca_core.sim.scenarios.road_user import BrakeAction, LateralShiftAction, ReactToLeadAction, RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.vehicle import VehicleParams, VehicleState

__all__ = ["CYCLE_TIME", "Traffic", "TrafficAgent"]

CYCLE_TIME = 0.02
"""Step of the closed loop [s]."""

_LIGHTS = -0.25  # acceleration at which brake lights are on [m/s^2]
_HARDEST = 7.0  # brakes of everybody [m/s^2]
_SPARE = 2.0  # gap that a follower wants to have left [m]
_LOOKS = 6.0  # time to contact within which a driver takes the ego to be in his way [s]


class TrafficAgent:
    """One road user on its way; its attributes are its motion now.

    Parameters
    ----------
    user : RoadUser
        What it is and does.
    path : Path
        Its way.
    own_route : bool
        Whether that is the ego's route.

    Attributes
    ----------
    s, d : float
        Place on its way [m].
    v, a : float
        Speed and acceleration [m/s, m/s^2].
    pose : tuple of float
        x, y [m], psi [rad], yaw rate [rad/s].
    """

    def __init__(self, user: RoadUser, path: Path, own_route: bool) -> None:
        self.user, self.path, self.on_route = user, path, own_route
        self.s, self.d, self.v, self.a = user.s, user.d, user.v_x, 0.0
        self.near = user.s  # foot point of the ego on its way
        self._alarmed = math.inf  # since when something has been in the way
        self._lights = math.inf  # when the leader's brake lights went on
        self._warned = math.inf
        self._swerved: dict[int, float] = {}
        self._turning = 0.0  # sideways speed
        self.pose = self._place()

    @property
    def is_shifting(self) -> bool:
        """Whether it moves sideways."""
        return self._turning != 0.0

    @property
    def warning_received(self) -> bool:
        """Whether the leader's message of hard braking has been delivered."""
        return self._warned < math.inf

    def deliver_warning(self, t: float) -> None:
        """Deliver the leader's message of hard braking.

        Parameters
        ----------
        t : float
            Now [s].
        """
        self._warned = min(self._warned, t)

    def step(self, t: float, ego: VehicleState, vehicle: VehicleParams, others: "Traffic") -> None:
        """Move on.

        Parameters
        ----------
        t : float
            Now [s].
        ego : VehicleState
            The ego now.
        vehicle : VehicleParams
            Its body.
        others : Traffic
            All road users.
        """
        wanted = 0.0
        for i, act in enumerate(self.user.actions):
            if isinstance(act, LateralShiftAction):
                if i not in self._swerved and self.user.direction * (self.s - act.s_start) >= 0.0:
                    self._swerved[i] = t
            elif isinstance(act, BrakeAction):
                wanted = min(wanted, -act.deceleration if t >= act.t - 1e-9 else 0.0)
            else:
                wanted = min(wanted, self._following(t, act, others.by_id[act.lead_id]))
        if math.isfinite(self.user.reaction_time):
            wanted = min(wanted, self._reacting(ego, vehicle))
        if self.v == 0.0:
            wanted = 0.0 if wanted < 0.0 else wanted
            self.a = 0.0
        step = self.user.jerk * CYCLE_TIME
        self.a = min(max(wanted, self.a - step), self.a + step)
        v = max(self.v + self.a * CYCLE_TIME, 0.0)
        if self.v == v == 0.0 and not self._swerved:
            return
        self.s += self.user.direction * 0.5 * (self.v + v) * CYCLE_TIME
        self.v = v
        self._shift(t + CYCLE_TIME)
        self.pose = self._place()

    def _shift(self, t: float) -> None:
        """Sideways place and speed, the sum of all swerves."""
        self.d, self._turning = self.user.d, 0.0
        for i, begun in self._swerved.items():
            act = self.user.actions[i]
            if isinstance(act, LateralShiftAction):
                z = min((t - begun) / act.duration, 1.0)
                self.d += quintic_step(z, act.offset)
                self._turning += act.offset * 30.0 * z * z * (1.0 - z) ** 2 / act.duration

    def _place(self) -> tuple[float, float, float, float]:
        x, y, tx, ty, nx, ny = self.path._cubics.at(self.s)
        norm = math.hypot(tx, ty)
        kappa = (tx * ny - ty * nx) / norm**3
        along = self.user.direction
        psi = math.atan2(ty, tx) + (0.0 if along > 0 else math.pi)
        if self._turning:
            psi += along * math.atan2(self._turning, max(self.v, 1.0))
        r = along * kappa * self.v / (1.0 - self.d * kappa)
        return x - self.d * ty / norm, y + self.d * tx / norm, psi, r

    def _following(self, t: float, act: ReactToLeadAction, leader: "TrafficAgent") -> float:
        if leader.a <= _LIGHTS:
            self._lights = min(self._lights, t)
        if t < min(self._lights + act.reaction_time, self._warned + act.warning_delay) - 1e-9:
            return 0.0
        gap = self.user.direction * (leader.s - self.s) - 0.5 * (leader.user.length + self.user.length)
        room = gap - _SPARE + leader.v**2 / (2.0 * _HARDEST)
        need = self.v**2 / (2.0 * room) if room > 0.0 else _HARDEST
        return -min(max(act.deceleration, need), _HARDEST)

    def _reacting(self, ego: VehicleState, vehicle: VehicleParams) -> float:
        user, along = self.user, self.user.direction
        self.near, d, heading, _ = self.path.foot_point(ego.x, ego.y, self.near)
        gap = along * (self.near - self.s) - 0.5 * (user.length + vehicle.length)
        closing = self.v - along * ego.v_x * math.cos(ego.psi - heading)
        beside = abs(d - self.d) >= 0.5 * (user.width + vehicle.width)
        if gap < 0.0 or beside or closing <= 0.0 or gap > _LOOKS * closing:
            self._alarmed = math.inf
        elif math.isinf(self._alarmed):
            self._alarmed = 0.0
        else:
            self._alarmed += CYCLE_TIME
        return -user.deceleration if user.reaction_time <= self._alarmed < math.inf else 0.0


class Traffic:
    """All road users of a scenario.

    Parameters
    ----------
    scenario : Scenario
        Who they are, and the route of the ego.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._route, self._vehicle = scenario.road.path, scenario.vehicle
        self.movers = [TrafficAgent(u, u.route or self._route, u.route is None) for u in scenario.road_users]
        self.by_id = {mover.user.id: mover for mover in self.movers}
        self._feet: dict[str, float] = {}

    def rows(self) -> list[tuple[float, float, float, float, float, float]]:
        """Motion of each.

        Returns
        -------
        rows : list of tuple
            x, y [m], psi [rad], speed [m/s], acceleration [m/s^2], yaw rate [rad/s].
        """
        return [(*m.pose[:3], m.v, m.a, m.pose[3]) for m in self.movers]

    def places(self) -> list[tuple[float, float]]:
        """Place of each on the ego's route.

        Returns
        -------
        places : list of tuple
            s, d [m].
        """
        found = []
        for m in self.movers:
            if m.on_route:
                found.append((m.s, m.d))
                continue
            x, y = m.pose[:2]
            near = self._feet.get(m.user.id)
            if near is None:
                near = float(self._route.project((x, y))[0])
            near, d, _, _ = self._route.foot_point(x, y, near)
            self._feet[m.user.id] = near
            found.append((near, d))
        return found

    def step(self, t: float, ego: VehicleState) -> None:
        """Move all on by one cycle.

        Parameters
        ----------
        t : float
            Now [s].
        ego : VehicleState
            The ego now.
        """
        for mover in self.movers:
            mover.step(t, ego, self._vehicle, self)

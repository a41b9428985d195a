"""Traffic: motion of scripted road users."""

import math
from collections.abc import Sequence
from typing import Protocol

from cca_core.geometry import quintic_step
from cca_core.path import Path
from cca_core.sim.scenarios.road_user import (
    BrakeAction,
    LateralShiftAction,
    ReactToLeadAction,
    RoadUser,
    SpeedAction,
)
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.vehicle import VehicleParams, VehicleState

CYCLE_TIME = 0.02
"""Step of the closed loop [s]."""

_MAX_DECELERATION = 7.0  # of every road user [m/s^2]


class AgentMotion(Protocol):
    """Motion of one road user now."""

    @property
    def user(self) -> RoadUser:
        """The road user."""

    @property
    def v(self) -> float:
        """Speed [m/s]."""

    @property
    def a(self) -> float:
        """Acceleration [m/s^2]."""

    @property
    def is_shifting(self) -> bool:
        """Whether it moves laterally."""


class TrafficMotion(Protocol):
    """Motion of all road users now, as a log records it."""

    @property
    def agents(self) -> Sequence[AgentMotion]:
        """Each road user."""

    def rows(self) -> list[tuple[float, float, float, float, float, float]]:
        """Return x, y [m], psi [rad], speed, acceleration and yaw rate of each, in SI units."""

    def frenet(self) -> list[tuple[float, float]]:
        """Return s, d [m] of each on the ego's route."""


class TrafficAgent:
    """Motion of one road user along its path."""

    def __init__(self, user: RoadUser, path: Path, on_route: bool) -> None:
        self.user, self.path, self.on_route = user, path, on_route
        self.s, self.d, self.v, self.a = user.s, user.d, user.v_x, 0.0
        self.s_ego = user.s  # station of the ego on its path
        self._blocked_time = math.inf  # since the ego blocks its path
        self._t_lights = math.inf  # when the lead's brake lights went on
        self._t_warning = math.inf
        self._t_shifts: dict[int, float] = {}
        self._v_lateral = 0.0
        speeds = [act for act in user.actions if isinstance(act, SpeedAction)]
        self._speeds = sorted(speeds, key=lambda act: act.t)
        self.pose = self._pose()

    @property
    def is_shifting(self) -> bool:
        """Whether it moves laterally."""
        return self._v_lateral != 0.0

    @property
    def warning_received(self) -> bool:
        """Whether the lead's message of hard braking has been delivered."""
        return self._t_warning < math.inf

    def deliver_warning(self, t: float) -> None:
        """Deliver the lead's message of hard braking."""
        self._t_warning = min(self._t_warning, t)

    def step(self, t: float, ego: VehicleState, vehicle: VehicleParams, traffic: "Traffic") -> None:
        """Advance by one cycle."""
        a_x = self._approaching(t) if self._speeds else 0.0
        for i, act in enumerate(self.user.actions):
            if isinstance(act, LateralShiftAction):
                if i not in self._t_shifts and self.user.direction * (self.s - act.s_start) >= 0.0:
                    self._t_shifts[i] = t
            elif isinstance(act, BrakeAction):
                a_x = min(a_x, -act.deceleration if t >= act.t - 1e-9 else 0.0)
            elif isinstance(act, ReactToLeadAction):
                a_x = min(a_x, self._following(t, act, traffic.by_id[act.lead_id]))
        if math.isfinite(self.user.reaction_time):
            a_x = min(a_x, self._reacting(ego, vehicle))
        if self.v == 0.0:
            a_x = 0.0 if a_x < 0.0 else a_x
            self.a = 0.0
        step = self.user.jerk * CYCLE_TIME
        self.a = min(max(a_x, self.a - step), self.a + step)
        v = max(self.v + self.a * CYCLE_TIME, 0.0)
        if self.v == v == 0.0 and not self._t_shifts:
            return
        self.s += self.user.direction * 0.5 * (self.v + v) * CYCLE_TIME
        self.v = v
        self._shift(t + CYCLE_TIME)
        self.pose = self._pose()

    def _shift(self, t: float) -> None:
        """Update lateral offset and speed, the sum of all lateral shifts."""
        self.d, self._v_lateral = self.user.d, 0.0
        for i, begun in self._t_shifts.items():
            act = self.user.actions[i]
            if isinstance(act, LateralShiftAction):
                z = min((t - begun) / act.duration, 1.0)
                self.d += quintic_step(z, act.offset)
                self._v_lateral += act.offset * 30.0 * z * z * (1.0 - z) ** 2 / act.duration

    def _pose(self) -> tuple[float, float, float, float]:
        """Return x, y [m], psi [rad] and yaw rate [rad/s]."""
        x, y, tx, ty, nx, ny = self.path._cubics.at(self.s)
        norm = math.hypot(tx, ty)
        kappa = (tx * ny - ty * nx) / norm**3
        along = self.user.direction
        psi = math.atan2(ty, tx) + (0.0 if along > 0 else math.pi)
        if self._v_lateral:
            psi += along * math.atan2(self._v_lateral, max(self.v, 1.0))
        r = along * kappa * self.v / (1.0 - self.d * kappa)
        return x - self.d * ty / norm, y + self.d * tx / norm, psi, r

    def _approaching(self, t: float) -> float:
        """Return the acceleration toward the speed of the last action begun [m/s^2]."""
        begun = [act for act in self._speeds if t >= act.t - 1e-9]
        if not begun:
            return 0.0
        missing = begun[-1].v_x - self.v
        if missing == 0.0:
            return 0.0
        # with a finite jerk it must be let go before the speed is reached
        limit = min(begun[-1].acceleration, math.sqrt(2.0 * self.user.jerk * abs(missing)))
        return math.copysign(min(limit, abs(missing) / CYCLE_TIME), missing)

    def _following(self, t: float, act: ReactToLeadAction, lead: "TrafficAgent") -> float:
        """Return the acceleration of a driver that reacts to its lead [m/s^2]."""
        if lead.a <= -0.25:  # [m/s^2], brake lights are on
            self._t_lights = min(self._t_lights, t)
        if t < min(self._t_lights + act.reaction_time, self._t_warning + act.warning_delay) - 1e-9:
            return 0.0
        gap = self.user.direction * (lead.s - self.s) - 0.5 * (lead.user.length + self.user.length)
        available = gap - 2.0 + lead.v**2 / (2.0 * _MAX_DECELERATION)
        required = self.v**2 / (2.0 * available) if available > 0.0 else _MAX_DECELERATION
        return -min(max(act.deceleration, required), _MAX_DECELERATION)

    def _reacting(self, ego: VehicleState, vehicle: VehicleParams) -> float:
        """Return the acceleration of a driver that reacts to the ego on its path [m/s^2]."""
        user, along = self.user, self.user.direction
        self.s_ego, d, heading, _ = self.path.foot_point(ego.x, ego.y, self.s_ego)
        gap = along * (self.s_ego - self.s) - 0.5 * (user.length + vehicle.length)
        closing = self.v - along * ego.v_x * math.cos(ego.psi - heading)
        is_clear = abs(d - self.d) >= 0.5 * (user.width + vehicle.width)
        if gap < 0.0 or is_clear or closing <= 0.0 or gap > 6.0 * closing:  # [s]
            self._blocked_time = math.inf
        elif math.isinf(self._blocked_time):
            self._blocked_time = 0.0
        else:
            self._blocked_time += CYCLE_TIME
        return -user.deceleration if user.reaction_time <= self._blocked_time < math.inf else 0.0


class Traffic:
    """All road users of a scenario."""

    def __init__(self, scenario: Scenario) -> None:
        self._route, self._vehicle = scenario.road.path, scenario.vehicle
        self.agents: list[TrafficAgent] = [
            TrafficAgent(u, u.route or self._route, u.route is None) for u in scenario.road_users
        ]
        self.by_id = {agent.user.id: agent for agent in self.agents}
        self._stations: dict[str, float] = {}

    def rows(self) -> list[tuple[float, float, float, float, float, float]]:
        """Return x, y [m], psi [rad], speed, acceleration and yaw rate of each road user, in SI units."""
        return [(*m.pose[:3], m.v, m.a, m.pose[3]) for m in self.agents]

    def frenet(self) -> list[tuple[float, float]]:
        """Return s, d [m] of each road user on the ego's route."""
        coordinates = []
        for m in self.agents:
            if m.on_route:
                coordinates.append((m.s, m.d))
                continue
            x, y = m.pose[:2]
            s = self._stations.get(m.user.id)
            if s is None:
                s = float(self._route.project((x, y))[0])
            s, d, _, _ = self._route.foot_point(x, y, s)
            self._stations[m.user.id] = s
            coordinates.append((s, d))
        return coordinates

    def step(self, t: float, ego: VehicleState) -> None:
        """Advance all road users by one cycle."""
        for agent in self.agents:
            agent.step(t, ego, self._vehicle, self)

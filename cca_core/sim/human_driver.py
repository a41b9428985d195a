"""A human at the wheel, without messages: sees, reacts late, and brakes as hard as the car can."""

import math
from collections.abc import Iterable

import numpy as np

from cca_core.decide import Action, CrossingSettings, Decision, find_conflict
from cca_core.errors import Status
from cca_core.follow import (
    PreviewController,
    SpeedSettings,
    jerk_limited,
    profile_acceleration,
    squared_speed_limit,
)
from cca_core.frenet import FrenetVehicle, to_frenet
from cca_core.path import Road
from cca_core.planner.command import Command
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

__all__ = ["CURVE_ACCELERATION", "Driver"]

CURVE_ACCELERATION = 2.5
"""Lateral acceleration for which the driver slows down in bends [m/s^2], as the planner does."""

_LIGHTS = -0.25  # acceleration at which brake lights are on [m/s^2]
_LOOKS = 6.0  # time to contact within which something in the way alarms [s]
_HORIZON = 6.0  # of crossing traffic [s]
_PERIOD = 0.1  # between two looks at crossing traffic [s]
_CROSSING = CrossingSettings(a_max=0.0, b_max=0.0, min_pet=0.5)


class Driver:
    """Alert driver: keeps his lane and speed until he sees a danger, then brakes fully to a standstill.

    A danger is a body in his way that brakes, or would be reached within 6 s, or one that crosses his way at
    the same time as he. Once he has seen one he brakes, a reaction time later.

    Parameters
    ----------
    vehicle : VehicleParams
        His car.
    road : Road
        His way.
    cruise_speed : float
        The speed that he keeps [m/s].
    speed : SpeedSettings
        Brakes: `b_max` and `jerk_emergency`.
    reaction : float
        From the first sight of a danger to the brakes [s]; 1.25 s is that of an alert driver to brake
        lights.
    """

    def __init__(
        self,
        vehicle: VehicleParams,
        road: Road,
        *,
        cruise_speed: float,
        speed: SpeedSettings | None = None,
        reaction: float = 1.25,
    ) -> None:
        self.vehicle, self.road, self.cruise_speed = vehicle, road, cruise_speed
        self.speed, self.reaction = speed or SpeedSettings(), reaction
        self._controller = PreviewController(vehicle)
        limit = min(cruise_speed, road.speed_limit)
        self._cap = squared_speed_limit(road.path, limit, CURVE_ACCELERATION, self.speed)
        self._s: float | None = None
        self._places: dict[str, float] = {}
        self._alarmed = math.inf
        self._danger = ""
        self._looked = -math.inf
        self._t, self._a_x = -math.inf, 0.0

    def step(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        *,
        awareness_range: float = math.inf,
    ) -> Command:
        """Steer and brake for one cycle.

        Parameters
        ----------
        t : float
            Time [s].
        state : VehicleState
            The car now.
        remotes : iterable of RemoteVehicle
            Those whom he sees.
        awareness_range : float
            Of the messages, which he does not hear [m].

        Returns
        -------
        command : Command
            KEEP, or BRAKE once he has reacted.
        """
        path = self.road.path
        near = self._s if self._s is not None else float(path.project((state.x, state.y))[0])
        s = self._s = path.foot_point(state.x, state.y, near)[0]
        dt, self._t = min(t - self._t, 0.1), t
        if math.isinf(self._alarmed):
            self._danger = self._look(t, s, state, remotes)
            if self._danger:
                self._alarmed = t
        brakes = t >= self._alarmed + self.reaction - 1e-9
        wanted = -self.speed.b_max if brakes else profile_acceleration(s, state.v_x, self._cap, self.speed)
        self._a_x = jerk_limited(wanted, self._a_x, dt, self.speed, emergency=brakes)
        if brakes:
            reason = f"{self._danger}, seen {self.reaction:g} s ago"
            decision = Decision(action=Action.BRAKE, reason=reason)
        else:
            decision = Decision(action=Action.KEEP, reason="no danger seen")
        return Command(
            delta=self._controller.steer(state, path, dt), a_x=float(self._a_x), decision=decision, band=None,
            reference=path, status=Status.OK,
        )  # fmt: skip

    def _look(self, t: float, s: float, state: VehicleState, remotes: Iterable[RemoteVehicle]) -> str:
        """Name a danger in words; empty if there is none."""
        neighbors, _ = to_frenet(remotes, self.road.path, self._places)
        front = s + self.vehicle.front
        for n in neighbors:
            gap = n.s - n.half_length - front
            if gap < -self.vehicle.length or abs(n.d) >= 0.5 * self.vehicle.width + n.half_width:
                continue
            if n.remote.a_x <= _LIGHTS and n.v_s >= 0.0:
                return f"{n.remote.id} brakes"
            if gap < _LOOKS * (state.v_x - n.v_s):
                return f"{n.remote.id} is in the way"
        if t - self._looked >= _PERIOD - 1e-6:
            self._looked = t
            return self._crosses(s, state.v_x, neighbors)
        return ""

    def _crosses(self, s: float, v_x: float, neighbors: list[FrenetVehicle]) -> str:
        v = max(v_x, 1.0)
        for n in neighbors:
            conflict = find_conflict(
                self.road.path, s, np.array([s, s + _HORIZON * v]), np.array([0.0, _HORIZON]), self.vehicle,
                n.remote, horizon=_HORIZON, settings=_CROSSING,
            )  # fmt: skip
            if conflict is not None and not conflict.is_clear:
                return f"{n.remote.id} crosses"
        return ""

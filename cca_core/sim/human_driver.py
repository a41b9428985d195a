"""Human driver without V2V: sees a hazard, reacts late, and brakes fully."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.decide import Action, CrossingSettings, Decision, find_conflict
from cca_core.decide.action import explained
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
from cca_core.planner import Command
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

CURVE_ACCELERATION = 2.5
"""Lateral acceleration that limits the speed in curves [m/s^2], as that of the planner."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverSettings:
    """What a driver takes for a hazard.

    Parameters
    ----------
    brake_light_deceleration : float
        Deceleration above which brake lights are on [m/s^2].
    alarm_time : float
        Time to collision below which a vehicle ahead is a hazard [s].
    crossing_horizon : float
        Time within which crossing vehicles are considered [s].
    min_pet : float
        Post-encroachment time below which a crossing vehicle is a hazard [s].

    Raises
    ------
    InputError
        If a value is not finite or negative.
    """

    brake_light_deceleration: float = 0.25
    alarm_time: float = 6.0
    crossing_horizon: float = 6.0
    min_pet: float = 0.5

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in self.__slots__:
            check_real(name, getattr(self, name), ge=0.0)


class Driver:
    """Alert human driver: keep lane and speed until they see a hazard, then brake fully to standstill.

    A hazard is a vehicle ahead that brakes or is closer than 6 s, or one that crosses at the same time as
    the ego. The brakes follow one reaction time later.

    Parameters
    ----------
    vehicle : VehicleParams
        The ego.
    road : Road
        Route and lanes.
    cruise_speed : float
        Target speed [m/s].
    speed : SpeedSettings
        Brakes: `b_max` and `jerk_emergency`.
    reaction_time : float
        Time from the first sight of a hazard to the brakes [s]; 1.25 s is that of an alert driver to brake
        lights.
    settings : DriverSettings, optional
        What is a hazard.

    Raises
    ------
    InputError
        If `cruise_speed` is not finite, or negative.
    """

    def __init__(
        self,
        vehicle: VehicleParams,
        road: Road,
        *,
        cruise_speed: float,
        speed: SpeedSettings | None = None,
        reaction_time: float = 1.25,
        settings: DriverSettings | None = None,
    ) -> None:
        self.vehicle, self.road, self.cruise_speed = vehicle, road, cruise_speed
        self.speed, self.reaction_time = speed or SpeedSettings(), reaction_time
        self.settings = settings or DriverSettings()
        self._crossing = CrossingSettings(a_max=0.0, b_max=0.0, min_pet=self.settings.min_pet)
        self._controller = PreviewController(vehicle)
        limit = min(check_real("cruise_speed", cruise_speed, ge=0.0), road.speed_limit)
        self._speed_profile = squared_speed_limit(
            road.path, limit, CURVE_ACCELERATION, self.speed, road.speed_limits
        )
        self._s: float | None = None
        self._last_s: dict[str, float] = {}
        self._t_alarmed = math.inf
        self._hazard: tuple[str, str] | None = None
        self._t_crossing = -math.inf
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
            The ego's motion now.
        remotes : iterable of RemoteVehicle
            The visible vehicles.
        awareness_range : float
            Awareness range of V2V [m], which has no effect here.

        Returns
        -------
        command : Command
            KEEP, or BRAKE from the reaction on.
        """
        path = self.road.path
        s_guess = self._s if self._s is not None else float(path.project((state.x, state.y))[0])
        s = self._s = path.foot_point(state.x, state.y, s_guess)[0]
        dt, self._t = min(t - self._t, 0.1), t
        if math.isinf(self._t_alarmed):
            self._hazard = self._find_hazard(t, s, state, remotes)
            if self._hazard:
                self._t_alarmed = t
        braking = t >= self._t_alarmed + self.reaction_time - 1e-9
        cruise = profile_acceleration(s, state.v_x, self._speed_profile, self.speed)
        requested = -self.speed.b_max if braking else cruise
        self._a_x = jerk_limited(requested, self._a_x, dt, self.speed, emergency=braking)
        if braking:
            vehicle_id, hazard = self._hazard or ("", "")
            seen = f"{hazard} (seen {self.reaction_time:g} s ago)"
            decision = explained(Action.BRAKE, f"braking for {vehicle_id}", seen)
        else:
            decision = Decision(action=Action.KEEP, reason="keeping lane: no hazard seen")
        return Command(
            delta=self._controller.steer(state, path, dt), a_x=float(self._a_x), decision=decision, band=None,
            reference=path, status=Status.OK,
        )  # fmt: skip

    def _find_hazard(
        self, t: float, s: float, state: VehicleState, remotes: Iterable[RemoteVehicle]
    ) -> tuple[str, str] | None:
        """Vehicle and kind of a hazard in words; None if there is none."""
        vehicles, _ = to_frenet(remotes, self.road.path, self._last_s)
        front, half_width = s + self.vehicle.front, 0.5 * self.vehicle.width
        for n in vehicles:
            gap = n.rear - front
            if gap < -self.vehicle.length or abs(n.d) >= half_width + n.half_width:
                continue
            if n.remote.a_x <= -self.settings.brake_light_deceleration and n.v_s >= 0.0:
                return n.id, "brake lights"
            if gap < self.settings.alarm_time * (state.v_x - n.v_s):
                return n.id, f"{max(gap, 0.0):.0f} m ahead"
        if t - self._t_crossing >= 0.1 - 1e-6:  # ten times a second suffices
            self._t_crossing = t
            return self._find_crossing(s, max(state.v_x, 1.0), vehicles)
        return None

    def _find_crossing(self, s: float, v: float, vehicles: list[FrenetVehicle]) -> tuple[str, str] | None:
        """Vehicle that crosses at the same time as the ego; None if there is none."""
        horizon = self.settings.crossing_horizon
        for n in vehicles:
            conflict = find_conflict(
                self.road.path, s, np.array([s, s + horizon * v]), np.array([0.0, horizon]), self.vehicle,
                n.remote, horizon=horizon, settings=self._crossing,
            )  # fmt: skip
            if conflict is not None and not conflict.is_clear:
                return n.id, "crossing"
        return None

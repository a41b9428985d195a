"""Actuation: acceleration along the plan, the safe stop, and dead reckoning of a lost state."""

import math
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.follow import friction_limited
from cca_core.planner.limits import Limits
from cca_core.planner.records import DrivenPlan, SafeStop
from cca_core.planner.scene import TIMES
from cca_core.vehicle import VehicleParams, VehicleState

_STOP_TIME = 5.0  # [s]
_STOP_STEP = 0.1  # [s]
_HOLD = 1.0  # deceleration that holds a stationary vehicle [m/s^2]


def planned_acceleration(
    plan: DrivenPlan, t: float, v: float, a_y: float, limits: Limits, mu: float
) -> float:
    """Return the acceleration of the plan at a time, within the friction [m/s^2]."""
    at = np.append(0.0, TIMES[1:])
    a = float(np.interp(t - plan.t, at, np.append(plan.a_0, plan.a[:-1])))
    a = friction_limited(a, a_y, mu, grip_fraction=limits.grip / (mu * 9.81))
    return max(a, -_HOLD) if v < 0.05 and a < 0.0 else a


def safe_stop(
    route: dict[str, Array], d: Array, s: Array, v: Array, a: Array, vehicle: VehicleParams
) -> SafeStop:
    """Return steering and braking that follow a motion along a path, stations relative to the first."""
    standing = np.flatnonzero(v <= 0.0)
    rest = float(TIMES[standing[0]]) if len(standing) else float(TIMES[-1])
    t = np.arange(0.0, max(rest, _STOP_TIME) + 0.5 * _STOP_STEP, _STOP_STEP)
    at, speed = np.interp(t, TIMES, s), np.interp(t, TIMES, v)
    first = max(math.floor(at[0]) - 3, 0)
    part = slice(first, math.ceil(at[-1] + speed[-1] * vehicle.steering_lag) + 4)
    psi, offset, grid = route["psi"][part], d[part], first + np.arange(float(len(route["psi"][part])))
    x, y = route["x"][part] - offset * np.sin(psi), route["y"][part] + offset * np.cos(psi)
    heading = psi + np.arctan2(np.gradient(offset), np.maximum(1.0 - route["kappa"][part] * offset, 0.1))
    kappa = np.gradient(heading) / np.hypot(np.gradient(x), np.gradient(y))
    later = np.interp(t + vehicle.steering_lag, t, at, right=at[-1] + speed[-1] * vehicle.steering_lag)
    turn = vehicle.wheelbase + vehicle.understeer_gradient * speed * speed
    delta = np.arctan(turn * np.interp(later, grid, kappa))
    return SafeStop(
        t=t, delta=np.clip(delta, -vehicle.delta_max, vehicle.delta_max), a_x=np.interp(t, TIMES, a), v=speed,
        poses=np.column_stack([np.interp(at, grid, row) for row in (x, y, heading)]),
    )  # fmt: skip


def since(stop: SafeStop, elapsed: float) -> SafeStop:
    """Return a safe stop as seen some time after its decision."""
    return stop if elapsed < 1e-6 else replace(stop, t=stop.t - elapsed)


def dead_reckon(
    state: VehicleState, delta: float, a_x: float, dt: float, vehicle: VehicleParams
) -> VehicleState:
    """Return the state after a time by the kinematic single-track model with understeer."""
    v = max(state.v_x + a_x * dt, 0.0)
    mean = 0.5 * (state.v_x + v)
    lag = 1.0 - math.exp(-dt / max(vehicle.steering_lag, 1e-3))
    wheel = state.delta + (delta - state.delta) * lag
    turn = vehicle.wheelbase + vehicle.understeer_gradient * mean * mean
    r = mean * math.tan(wheel) / turn
    beta = math.atan(
        r
        * (vehicle.l_r - vehicle.l_f * vehicle.m * mean * mean / (vehicle.C_r * vehicle.wheelbase))
        / max(mean, 0.5)
    )
    psi = state.psi + r * dt
    course = state.psi + 0.5 * r * dt + beta
    return VehicleState(
        x=state.x + mean * dt * math.cos(course), y=state.y + mean * dt * math.sin(course), psi=psi, v_x=v,
        v_y=v * math.tan(beta), r=r, delta=wheel, a_x=a_x,
    )  # fmt: skip

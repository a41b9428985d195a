"""Actuation: acceleration along the plan, the safe stop, and dead reckoning of a lost state."""

import math
from bisect import bisect_right

import numpy as np

from cca_core._checks import Array
from cca_core.follow import friction_limited
from cca_core.planner.certificate import Grade, SafeStop
from cca_core.planner.limits import Limits
from cca_core.planner.records import DrivenPlan
from cca_core.planner.scene import TIMES
from cca_core.vehicle import GRAVITY, VehicleParams, VehicleState

_TIMES = tuple(TIMES.tolist())
_FULL = 0.99  # of the braking that plans may use: the plan brakes fully [-]
_STOP_TIME = 5.0  # [s]
_STOP_STEP = 0.1  # [s]
_HOLD = 1.0  # deceleration that holds a stationary vehicle [m/s^2]


def planned_acceleration(
    plan: DrivenPlan, t: float, v: float, a_y: float, limits: Limits, mu: float
) -> float:
    """Return the acceleration of the plan at a time, within the friction [m/s^2]."""
    elapsed = min(max(t - plan.t, 0.0), _TIMES[-1])
    i = min(bisect_right(_TIMES, elapsed), len(_TIMES) - 1)  # the plan's acceleration is the one of steps
    before, after = plan.a_0 if i == 1 else plan.a.item(i - 2), plan.a.item(i - 1)
    a = (after - before) / (_TIMES[i] - _TIMES[i - 1]) * (elapsed - _TIMES[i - 1]) + before
    fraction = limits.grip / (mu * GRAVITY)
    if plan.grade >= Grade.RESPONSE and after <= -_FULL * limits.b_max:  # less is not known to be enough
        is_full = before <= -_FULL * limits.b_max  # else the ramp to full braking goes on to its end
        a = -limits.b_emergency if is_full else before - limits.jerk_emergency * (elapsed - _TIMES[i - 1])
        a, fraction = max(a, -limits.b_emergency), 1.0
    a = friction_limited(a, a_y, mu, grip_fraction=fraction)
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
    if elapsed < 1e-6:
        return stop
    return SafeStop(t=stop.t - elapsed, delta=stop.delta, a_x=stop.a_x, v=stop.v, poses=stop.poses)


def stop_acceleration(stop: SafeStop, elapsed: float, after: float) -> float:
    """Return the acceleration of a safe stop some time after its decision, another one after its end."""
    if elapsed > stop.t[-1] or not np.interp(elapsed, stop.t, stop.v) > 0.0:
        return after
    return float(np.interp(elapsed, stop.t, stop.a_x))


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

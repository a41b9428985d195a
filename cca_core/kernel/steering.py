"""Preview steering: the single-track model inverted along a path, and PD control of the error ahead."""

import math
from typing import Annotated

from cca_core.kernel.constants import GRAVITY
from cca_core.kernel.curve import Curve, curvature_at, foot_point
from cca_core.kernel.types import Flag, Int, Real, Reals

__all__ = ["IdealCar", "Steering", "advance", "find_passed", "front_slip", "steer"]

ROLLING_SPEED = 3.0  # below it the tires roll without slip [m/s]
INTEGRAL_TIME = 3.0  # slow: it corrects what the model omits, such as load and alignment [s]
INTEGRAL_LIMIT = 0.02  # [rad]
SMALL_OFFSET = 0.1  # larger offsets are transients and not integrated [m]
SIDESLIP_FRACTION = 0.3  # of the measured sideslip in the reference [-]
MAX_STEP = 0.005  # of the integration [s]
MAX_STEPS = 1000
MAX_CYCLE = 5.0  # in which steps of that size fit [s]
MAX_MOTION = 100.0  # of the ideal car, yaw rate and lateral speed, which no car has [rad/s, m/s]
MAX_FRACTION = 0.97  # of the grip, where the slip is finite [-]
MAX_GRIP = 0.8  # beyond, a car on a slippery road spins [-]
MAX_JUMP = 20.0  # beyond, the car is on another stretch of the path [m]
TRACE = 1024  # passed points that are kept: as many as a second of delay holds at 1 kHz

Gains = Annotated[Reals, "count"]
Trace = Annotated[Reals, 1024]


class IdealCar:
    """The model whose center of gravity stays on the path, and its states where it has passed."""

    l_f: Real
    l_r: Real
    m: Real
    inertia: Real
    c_f: Real
    c_r: Real
    mu: Real
    started: Flag
    s: Real
    kappa: Real
    v_y: Real
    r: Real
    delta: Real  # last steering angle
    held: Flag  # whether the last input was dropped
    first: Int  # of the ring of passed points
    count: Int
    trace_s: Trace
    trace_beta: Trace
    trace_r: Trace


class Steering:
    """Gains, limits and states of the steering law."""

    delta_max: Real
    delta_rate_max: Real
    steering_lag: Real
    understeer: Real
    delay: Real
    a_y_max: Real
    ahead: Flag  # whether the error refers to the path at the preview point
    count: Int
    speeds: Gains
    k_p: Gains
    k_d: Gains
    l_s: Gains
    s: Real  # station at the last call
    integral: Real
    started: Flag
    delta: Real


def rear_force(car: IdealCar, v: Real) -> Real:
    """Side force of the rear axle from its slip angle."""
    grip = car.mu * GRAVITY * car.m * car.l_f / (car.l_f + car.l_r)
    z = -car.c_r * (car.v_y - car.l_r * car.r) / (v * grip)
    z = min(max(z, -3.0), 3.0)
    return grip * z * (1.0 - abs(z) / 3.0 + z * z / 27.0)


def front_slip(car: IdealCar, fraction: Real) -> Real:
    """Slip angle at which the front tires carry a fraction of their grip."""
    grip = car.mu * GRAVITY * car.m * car.l_r / (car.l_f + car.l_r)
    limited = min(max(fraction, -MAX_FRACTION), MAX_FRACTION)
    slip = 3.0 * (1.0 - math.pow(1.0 - abs(limited), 1.0 / 3.0)) * grip / car.c_f
    return math.copysign(math.atan(slip), limited)


def integrate(car: IdealCar, kappa: Real, v: Real, dt: Real) -> None:
    """Integrate the zero dynamics over a cycle, while the curvature changes linearly."""
    n = 1
    for _ in range(MAX_STEPS):
        if n >= dt / MAX_STEP - 1e-9:
            break
        n += 1
    h = dt / n
    for i in range(n):
        a_y = v * v * (car.kappa + (i + 0.5) / n * (kappa - car.kappa))
        r_dot = (car.l_f * car.m * a_y - (car.l_f + car.l_r) * rear_force(car, v)) / car.inertia
        v_y_dot = a_y - v * car.r
        car.r += h * r_dot
        car.v_y += h * v_y_dot


def start_steady(car: IdealCar, kappa: Real, v: Real) -> None:
    """Set the states to the steady turn of a curvature."""
    car.first = 0
    car.count = 0
    car.r = v * kappa
    rolling = 0.0 if v < ROLLING_SPEED else car.l_f * car.m * v * v / (car.c_r * (car.l_f + car.l_r))
    car.v_y = v * kappa * (car.l_r - rolling)
    if not abs(car.r) + abs(car.v_y) < MAX_MOTION:  # of a speed or curvature that no road has
        car.r = 0.0
        car.v_y = 0.0


def ring_index(car: IdealCar, i: Int) -> Int:
    """Where entry i of the trace lies in its ring."""
    at = car.first + i
    return at - TRACE if at >= TRACE else at


def advance(car: IdealCar, s: Real, kappa: Real, v_x: Real, dt: Real) -> Real:
    """Move the ideal car along the path; return the steering angle that it needs there.

    An input that is no number is dropped: the car stays, and the last angle is held.
    """
    size = abs(s) + abs(kappa) + abs(v_x) + abs(dt)
    finite = size < math.inf
    car.held = not finite
    if not finite:
        return car.delta
    v = max(v_x, 0.0)
    follows = car.started and abs(s - car.s) <= MAX_JUMP and 0.0 <= dt <= MAX_CYCLE
    if follows and v >= ROLLING_SPEED:
        integrate(car, kappa, v, dt)
    else:
        start_steady(car, kappa, v)
    if not abs(car.r) + abs(car.v_y) < MAX_MOTION:  # what a wrong speed has left must not stay
        start_steady(car, kappa, v)
    car.started = True
    car.s = s
    car.kappa = kappa
    if car.count == TRACE:
        car.first = ring_index(car, 1)
        car.count -= 1
    last = ring_index(car, car.count)
    car.trace_s[last] = s
    car.trace_beta[last] = math.atan2(car.v_y, max(v, 0.1))
    car.trace_r[last] = car.r
    car.count += 1
    delta = math.atan((car.l_f + car.l_r) * kappa)
    if v >= ROLLING_SPEED:
        rest = car.m * v * v * kappa - rear_force(car, v)
        grip = car.mu * GRAVITY * car.m * car.l_r / (car.l_f + car.l_r)
        delta = math.atan2(car.v_y + car.l_f * car.r, v) + front_slip(car, rest / grip)
    if not abs(delta) < math.inf:
        car.held = True
        return car.delta
    car.delta = delta
    return delta


def find_passed(car: IdealCar, s: Real) -> tuple[Real, Real]:
    """Sideslip and yaw rate of the ideal car at a station that it has passed; older ones are dropped."""
    for _ in range(TRACE):
        if car.count < 2 or not car.trace_s[ring_index(car, 1)] <= s:
            break
        car.first = ring_index(car, 1)
        car.count -= 1
    a = ring_index(car, 0)
    b = ring_index(car, 1)
    beta = car.trace_beta[a]
    r = car.trace_r[a]
    if car.count > 1 and s > car.trace_s[a]:
        fraction = (s - car.trace_s[a]) / (car.trace_s[b] - car.trace_s[a])
        beta += fraction * (car.trace_beta[b] - beta)
        r += fraction * (car.trace_r[b] - r)
    return beta, r


def gain_at(gains: Gains, i: Int, fraction: Real) -> Real:
    """Gain between two grid speeds."""
    return gains[i] if fraction == 0.0 else gains[i] + fraction * (gains[i + 1] - gains[i])


def limited(law: Steering, car: IdealCar, target: Real, v_x: Real, v_y: Real, r: Real, dt: Real) -> Real:
    """Steering angle within the limits of lateral acceleration, angle and rate."""
    v = max(v_x, 1.0)
    reach = car.l_f + car.l_r + max(law.understeer, 0.0) * v * v
    steady = math.atan(reach * law.a_y_max / (v * v))
    motion = math.atan2(v_y + car.l_f * r, v)  # of the front wheels
    slip = front_slip(car, min(law.a_y_max / (car.mu * GRAVITY), MAX_GRIP))
    low = max(min(-steady, motion - slip), -law.delta_max)
    high = min(max(steady, motion + slip), law.delta_max)
    delta = min(max(target, low), high)
    if not -law.delta_max <= delta <= law.delta_max:  # what is no number leaves the wheel where it is
        delta = law.delta
    if law.started:
        step = law.delta_rate_max * max(0.0, dt)  # none in a time that is no number
        delta = min(max(delta, law.delta - step), law.delta + step)
    return delta


def steer(
    law: Steering, car: IdealCar, curve: Curve, s_guess: Real, x: Real, y: Real, psi: Real,
    v_x: Real, v_y: Real, r: Real, dt: Real,
) -> Real:  # fmt: skip
    """Road-wheel angle for this cycle; `law.s` becomes the station of the vehicle."""
    v = max(v_x, 0.0)
    s, d, heading, kappa = foot_point(curve, x, y, s_guess)
    law.s = s
    at = s + v * (law.delay + law.steering_lag)
    feedforward = advance(car, at, curvature_at(curve, at), v, dt)
    beta, passed_r = find_passed(car, s)
    if v > ROLLING_SPEED:
        beta += SIDESLIP_FRACTION * (math.atan2(v_y, v) - beta)
    i = 0
    for k in range(1, law.count):
        if law.speeds[k] <= v:
            i = k
    fraction = 0.0
    if i < law.count - 1 and v > law.speeds[i]:
        fraction = (v - law.speeds[i]) / (law.speeds[i + 1] - law.speeds[i])
    k_p = gain_at(law.k_p, i, fraction)
    k_d = gain_at(law.k_d, i, fraction)
    l_s = gain_at(law.l_s, i, fraction)
    e_psi = math.remainder(psi - heading, 2.0 * math.pi)
    if e_psi >= math.pi:
        e_psi = -math.pi
    sine = math.sin(e_psi)
    error = d + l_s * (sine + math.sin(beta))
    if law.ahead:
        _, d_ahead, _, _ = foot_point(curve, x + l_s * math.cos(psi), y + l_s * math.sin(psi), s + l_s)
        error = d_ahead + l_s * math.sin(beta) + 0.5 * kappa * l_s * l_s
    rate = v * sine + v_y * math.cos(e_psi) + l_s * (r - passed_r)
    target = feedforward - k_p * error - k_d * rate - law.integral
    delta = limited(law, car, target, v_x, v_y, r, dt)
    small = abs(d) < SMALL_OFFSET and 0.0 <= dt <= MAX_CYCLE
    if delta == target and small and v > 1.0:
        law.integral = min(max(law.integral + k_p * d * dt / INTEGRAL_TIME, -INTEGRAL_LIMIT), INTEGRAL_LIMIT)
    law.delta = delta
    law.started = True
    return delta

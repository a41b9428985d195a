"""A single-track car on tires that can slide, integrated by the classical Runge-Kutta scheme."""

import math

from cca_core.kernel.constants import GRAVITY
from cca_core.kernel.types import Real

__all__ = ["SingleTrackCar", "drive", "fiala_force"]

MIN_SLIP_SPEED = 1.0  # below it the car rolls without slip [m/s]
SLOW = 5.0  # below it the lateral dynamics are faster, and the step is half [m/s]
MAX_STEP = 0.01  # [s]
MAX_STEPS = 1000
MAX_GRIP = 0.99  # fraction that drive and brakes take at most [-]
MIN_SIDE = 0.1  # fraction of the grip that remains for side forces [-]
SMALLEST_SPEED = 1e-6  # of a wheel along itself [m/s]


class SingleTrackCar:
    """Constants and states of the car."""

    l_f: Real
    l_r: Real
    m: Real
    inertia: Real
    c_f: Real
    c_r: Real
    mu: Real
    delta_rate_max: Real
    steering_lag: Real
    drive_lag: Real
    x: Real
    y: Real
    psi: Real
    v_x: Real
    v_y: Real
    r: Real
    delta: Real
    a_x: Real
    a_y: Real


def fiala_force(stiffness: Real, slip: Real, f_max: Real) -> Real:
    """Side force for the tangent of the slip angle [N]."""
    z = stiffness * slip / f_max
    if z >= 3.0 or z <= -3.0:
        return -math.copysign(f_max, z)
    return -f_max * z * (1.0 - abs(z) / 3.0 + z * z / 27.0)


def rates(
    car: SingleTrackCar,
    psi: Real,
    v_x: Real,
    v_y: Real,
    r: Real,
    angle: Real,
    force: Real,
    delta: Real,
    a_x: Real,
) -> tuple[Real, Real, Real, Real, Real, Real, Real, Real]:
    """Rates of change of the eight states; they do not depend on the position."""
    grip = car.mu * GRAVITY
    front = car.l_r / (car.l_f + car.l_r)  # share of load and drive
    hardest = MAX_GRIP * grip
    rate = min(max((delta - angle) / car.steering_lag, -car.delta_rate_max), car.delta_rate_max)
    drive_rate = (min(max(a_x, -hardest), hardest) - force) / car.drive_lag
    c = math.cos(psi)
    s = math.sin(psi)
    if v_x < MIN_SLIP_SPEED:
        return v_x * c - v_y * s, v_x * s + v_y * c, r, force, 0.0, 0.0, rate, drive_rate
    side = math.sqrt(max(grip * grip - force * force, MIN_SIDE * grip * (MIN_SIDE * grip)))
    c_d = math.cos(angle)
    s_d = math.sin(angle)
    v_f = v_y + car.l_f * r
    v_r = v_y - car.l_r * r
    slip = (v_f * c_d - v_x * s_d) / max(abs(v_x * c_d + v_f * s_d), SMALLEST_SPEED)
    f_f = fiala_force(car.c_f, slip, car.m * car.l_r / (car.l_f + car.l_r) * side)
    f_r = fiala_force(car.c_r, v_r / v_x, car.m * car.l_f / (car.l_f + car.l_r) * side)
    pull = car.m * front * force  # of the front axle, along its wheels
    front_x = pull * c_d - f_f * s_d
    front_y = pull * s_d + f_f * c_d
    return (
        v_x * c - v_y * s,
        v_x * s + v_y * c,
        r,
        force * (1.0 - front) + front_x / car.m + v_y * r,
        (front_y + f_r) / car.m - v_x * r,
        (car.l_f * front_y - car.l_r * f_r) / car.inertia,
        rate,
        drive_rate,
    )


def roll(car: SingleTrackCar) -> None:
    """Remove slip and reversing at low speed."""
    car.v_x = max(car.v_x, 0.0)
    if car.v_x == 0.0:
        car.a_x = max(car.a_x, 0.0)
    car.r = car.v_x * math.tan(car.delta) / (car.l_f + car.l_r)
    car.v_y = car.l_r * car.r


def runge_kutta(car: SingleTrackCar, delta: Real, a_x: Real, h: Real) -> None:
    """Advance by one step of the integration."""
    psi = car.psi
    v = car.v_x
    w = car.v_y
    r = car.r
    angle = car.delta
    force = car.a_x
    m = 0.5 * h
    ax, ay, ap, av, aw, ar, aa, af = rates(car, psi, v, w, r, angle, force, delta, a_x)
    bx, by, bp, bv, bw, br, ba, bf = rates(
        car, psi + m * ap, v + m * av, w + m * aw, r + m * ar, angle + m * aa, force + m * af, delta, a_x
    )
    cx, cy, cp, cv, cw, cr, ca, cf = rates(
        car, psi + m * bp, v + m * bv, w + m * bw, r + m * br, angle + m * ba, force + m * bf, delta, a_x
    )
    dx, dy, dp, dv, dw, dr, da, df = rates(
        car, psi + h * cp, v + h * cv, w + h * cw, r + h * cr, angle + h * ca, force + h * cf, delta, a_x
    )
    sixth = h / 6.0
    car.x += sixth * (ax + 2.0 * bx + 2.0 * cx + dx)
    car.y += sixth * (ay + 2.0 * by + 2.0 * cy + dy)
    car.psi = psi + sixth * (ap + 2.0 * bp + 2.0 * cp + dp)
    car.v_x = v + sixth * (av + 2.0 * bv + 2.0 * cv + dv)
    car.v_y = w + sixth * (aw + 2.0 * bw + 2.0 * cw + dw)
    car.r = r + sixth * (ar + 2.0 * br + 2.0 * cr + dr)
    car.delta = angle + sixth * (aa + 2.0 * ba + 2.0 * ca + da)
    car.a_x = force + sixth * (af + 2.0 * bf + 2.0 * cf + df)


def drive(car: SingleTrackCar, delta: Real, a_x: Real, dt: Real) -> None:
    """Advance a moving car by a time step with a commanded angle and acceleration."""
    step = MAX_STEP if car.v_x > SLOW else 0.5 * MAX_STEP
    n = 1
    for _ in range(MAX_STEPS):
        if n >= dt / step - 1e-9:
            break
        n += 1
    for _ in range(n):
        runge_kutta(car, delta, a_x, dt / n)
        if car.v_x < MIN_SLIP_SPEED:
            roll(car)
    _, _, _, _, v_y_dot, _, _, _ = rates(
        car, car.psi, car.v_x, car.v_y, car.r, car.delta, car.a_x, delta, a_x
    )
    car.a_y = v_y_dot + car.v_x * car.r

"""Two planners for comparison of run times, each prepared for one problem on a straight road.

Both plan from (0, 0) along +x at 20 m/s past stationary cars of 4.5 x 1.8 m.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import pytest

LENGTH, WIDTH, SPEED = 4.5, 1.8, 20.0
WHEELBASE = 2.7  # [m]
AROUND = np.sqrt(2.0) * np.array([LENGTH, WIDTH])  # half axes of the ellipse around a car [m]
Point = tuple[float, float]  # center of a car [m]


@dataclass(frozen=True)
class Peer:
    """A planner that is ready to run, and the reader of its result."""

    run: Callable[[], Any]  # plans once; this is timed
    trajectory: Callable[[Any], np.ndarray | None]  # of a result: x, y, heading, curvature (n, 4), or None


def _installed(module: str) -> Any:
    """Return a module that only this comparison needs; its absence is a failure, not a reason to skip."""
    try:
        return import_module(module)
    except ImportError:
        pytest.fail(
            f"{module} is not installed: pip install --editable '.[all]' --group bench", pytrace=False
        )


def nmpc(length: float, cars: Sequence[Point], lefts: Sequence[bool], intervals: int = 20) -> Peer:
    """Nonlinear model predictive control in CasADi and IPOPT, from a guess on the given side of every car.

    Kinematic bicycle, multiple shooting by a Runge-Kutta step an interval, acceleration and steering rate as
    inputs, which makes the curvature continuous, and IPOPT's own tolerances. A car is the smallest ellipse
    around the positions at which boxes along the road overlap; every node stays outside.
    """
    casadi = _installed("casadi")
    n, step = intervals, length / SPEED / intervals

    def rate(x: Any, u: Any) -> Any:
        turn = x[3] / WHEELBASE * casadi.tan(x[4])
        return casadi.vertcat(x[3] * casadi.cos(x[2]), x[3] * casadi.sin(x[2]), turn, u[0], u[1])

    def after(x: Any, u: Any, t: float) -> Any:
        a = rate(x, u)
        b = rate(x + 0.5 * t * a, u)
        c = rate(x + 0.5 * t * b, u)
        return x + t / 6.0 * (a + 2.0 * b + 2.0 * c + rate(x + t * c, u))

    x, u = casadi.SX.sym("x", 5, n + 1), casadi.SX.sym("u", 2, n)  # x, y, heading, speed, steering angle
    cost, links, outside = 0.0, [], []
    for k in range(n):
        links.append(x[:, k + 1] - after(x[:, k], u[:, k], step))
        cost += casadi.dot(casadi.DM([0.1, 100.0]), u[:, k] ** 2)
        off = x[:, k + 1] - casadi.DM([0.0, 0.0, 0.0, SPEED, 0.0])
        cost += casadi.dot(casadi.DM([0.0, 0.1, 1.0, 0.1, 100.0]), off**2)
        outside += [
            ((x[0, k + 1] - p) / AROUND[0]) ** 2 + ((x[1, k + 1] - q) / AROUND[1]) ** 2 for p, q in cars
        ]
    solver = casadi.nlpsol(
        "nmpc", "ipopt",
        {"x": casadi.veccat(x, u), "f": cost, "g": casadi.vertcat(*links, *outside)},
        {"print_time": 0, "ipopt.print_level": 0, "ipopt.sb": "yes"},
    )  # fmt: skip

    guess = _guess(np.linspace(0.0, length, n + 1), cars, lefts)
    low = np.tile([[-np.inf], [-5.0], [-0.8], [0.0], [-0.5]], n + 1)
    high = np.tile([[np.inf], [5.0], [0.8], [30.0], [0.5]], n + 1)
    low[:, 0] = high[:, 0] = [0.0, 0.0, 0.0, SPEED, 0.0]
    given = {
        "x0": np.concatenate((guess.ravel("F"), np.zeros(2 * n))),
        "lbx": np.concatenate((low.ravel("F"), np.tile([-6.0, -0.5], n))),
        "ubx": np.concatenate((high.ravel("F"), np.tile([3.0, 0.5], n))),
        "lbg": np.concatenate((np.zeros(5 * n), np.ones(len(outside)))),
        "ubg": np.concatenate((np.zeros(5 * n), np.full(len(outside), np.inf))),
    }
    fine = 40
    state, act = casadi.SX.sym("state", 5), casadi.SX.sym("act", 2)
    onward = casadi.Function("onward", [state, act], [after(state, act, step / fine)])

    def trajectory(solution: Any) -> np.ndarray | None:
        if not solver.stats()["success"]:
            return None
        found = np.asarray(solution["x"]).ravel()
        nodes, inputs = found[: 5 * (n + 1)].reshape(-1, 5), found[5 * (n + 1) :].reshape(-1, 2)
        states = []
        for node, held in zip(nodes[:-1], inputs, strict=True):
            states.append(node)
            for _ in range(fine - 1):
                states.append(np.asarray(onward(states[-1], held)).ravel())
        x, y, heading, _, steering = np.array(states).T
        return np.column_stack((x, y, heading, np.tan(steering) / WHEELBASE))

    return Peer(lambda: solver(**given), trajectory)


def _guess(x: np.ndarray, cars: Sequence[Point], lefts: Sequence[bool]) -> np.ndarray:
    """Smooth states past every car on its side: x, y, heading, speed, steering angle."""
    y = np.zeros_like(x)
    for (p, q), left in zip(cars, lefts, strict=True):
        passing = q + AROUND[1] if left else q - AROUND[1]
        if (passing > 0.0) == left:
            y += passing * np.exp(-(((x - p) / 8.0) ** 2))
    heading = np.gradient(y, x)
    return np.stack((x, y, heading, np.full_like(x, SPEED), np.arctan(WHEELBASE * np.gradient(heading, x))))


def fiss(cars: Sequence[Point], *, min_ttc: float | None) -> Peer:
    """FISS on a road with a second lane on the left, guided by its last plan.

    `min_ttc` [s] relaxes that safety rule, whose default of 1.5 s rejects every trajectory that starts 50 m
    before a car; None turns all safety rules off.
    """
    fiss_planner = _installed("fiss_planner")
    x = np.arange(0.0, 301.0, 5.0)
    road = fiss_planner.ReferenceLine(x, np.zeros_like(x))
    lanes = fiss_planner.Corridor.parallel_lanes(0.0, 300.0, 3.5, 1, 0)
    vehicle = fiss_planner.VehicleParams()
    vehicle.length, vehicle.width = LENGTH, WIDTH
    config = fiss_planner.make_config("fiss")
    if min_ttc is None:
        config.safety.enabled = False
    else:
        config.safety.min_ttc = min_ttc
    planner = fiss_planner.make_planner(config, vehicle)
    others = [
        fiss_planner.predict_constant_velocity(i, x, y, 0.0, 0.0, LENGTH, WIDTH, horizon=6.0, dt=0.1)
        for i, (x, y) in enumerate(cars)
    ]
    start = fiss_planner.FrenetState(s=0.0, s_d=SPEED)

    def trajectory(plan: Any) -> np.ndarray | None:
        if not plan.success:
            return None
        found = plan.trajectory
        t = np.asarray(found.t)
        fine = np.linspace(t[0], t[-1], 400)
        return np.column_stack([np.interp(fine, t, v) for v in (found.x, found.y, found.yaw, found.kappa)])

    return Peer(lambda: planner.plan(start, road, lanes, others, target_speed=SPEED), trajectory)

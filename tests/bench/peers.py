"""Two planners to compare run times with, each set up beforehand for one problem on a straight road.

Both plan from (0, 0) along +x at 20 m/s and take every car for one of 4.5 x 1.8 m that stands still.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
import pytest

LENGTH, WIDTH, SPEED = 4.5, 1.8, 20.0
Place = tuple[float, float]  # middle of a car [m]


@dataclass(frozen=True)
class Peer:
    """A planner, ready to run, and how to read what it returns.

    Parameters
    ----------
    run : callable
        Plans once; this is what is to be timed.
    driven : callable
        What `run` returned as an array of shape (n, 4): x, y [m], heading [rad], curvature [1/m], finely
        sampled; None if it found nothing.
    """

    run: Callable[[], Any]
    driven: Callable[[Any], np.ndarray | None]


def _installed(module: str) -> Any:
    """Return a module that only the comparison needs; its absence is a failure, not a reason to skip."""
    try:
        return import_module(module)
    except ImportError:
        pytest.fail(
            f"{module} is not installed: pip install --editable '.[all]' --group bench", pytrace=False
        )


def nmpc(length: float, cars: Sequence[Place], lefts: Sequence[bool], intervals: int = 20) -> Peer:
    """Nonlinear model predictive control in CasADi and IPOPT, begun on the given side of every car.

    Kinematic bicycle, multiple shooting by a Runge-Kutta step an interval, acceleration and steering rate as
    inputs (so that the curvature is continuous), IPOPT's own tolerances. A car is the smallest ellipse around
    the places where boxes with the road's heading overlap, to be kept out of at every node.
    """
    casadi = _installed("casadi")
    wheelbase, n = 2.7, intervals
    step = length / SPEED / n
    around = np.sqrt(2.0) * np.array([LENGTH, WIDTH])

    def rate(x: Any, u: Any) -> Any:
        turn = x[3] / wheelbase * casadi.tan(x[4])
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
            ((x[0, k + 1] - p) / around[0]) ** 2 + ((x[1, k + 1] - q) / around[1]) ** 2 for p, q in cars
        ]
    solver = casadi.nlpsol(
        "nmpc", "ipopt",
        {"x": casadi.veccat(x, u), "f": cost, "g": casadi.vertcat(*links, *outside)},
        {"print_time": 0, "ipopt.print_level": 0, "ipopt.sb": "yes"},
    )  # fmt: skip

    guess = np.zeros((5, n + 1))
    guess[0], guess[3] = np.linspace(0.0, length, n + 1), SPEED
    for (p, q), left in zip(cars, lefts, strict=True):
        beside = q + around[1] if left else q - around[1]
        if (beside > 0.0) == left:
            guess[1] += beside * np.exp(-(((guess[0] - p) / 8.0) ** 2))
    guess[2] = np.gradient(guess[1], guess[0])
    guess[4] = np.arctan(wheelbase * np.gradient(guess[2], guess[0]))
    least = np.tile([[-np.inf], [-5.0], [-0.8], [0.0], [-0.5]], n + 1)
    most = np.tile([[np.inf], [5.0], [0.8], [30.0], [0.5]], n + 1)
    least[:, 0] = most[:, 0] = [0.0, 0.0, 0.0, SPEED, 0.0]
    given = {
        "x0": np.concatenate((guess.ravel("F"), np.zeros(2 * n))),
        "lbx": np.concatenate((least.ravel("F"), np.tile([-6.0, -0.5], n))),
        "ubx": np.concatenate((most.ravel("F"), np.tile([3.0, 0.5], n))),
        "lbg": np.concatenate((np.zeros(5 * n), np.ones(len(outside)))),
        "ubg": np.concatenate((np.zeros(5 * n), np.full(len(outside), np.inf))),
    }
    fine = 40
    state, act = casadi.SX.sym("state", 5), casadi.SX.sym("act", 2)
    onwards = casadi.Function("onwards", [state, act], [after(state, act, step / fine)])

    def driven(solution: Any) -> np.ndarray | None:
        if not solver.stats()["success"]:
            return None
        found = np.asarray(solution["x"]).ravel()
        nodes, inputs = found[: 5 * (n + 1)].reshape(-1, 5), found[5 * (n + 1) :].reshape(-1, 2)
        states = []
        for node, held in zip(nodes[:-1], inputs, strict=True):
            states.append(node)
            for _ in range(fine - 1):
                states.append(np.asarray(onwards(states[-1], held)).ravel())
        x, y, heading, _, steering = np.array(states).T
        return np.column_stack((x, y, heading, np.tan(steering) / wheelbase))

    return Peer(lambda: solver(**given), driven)


def fiss(cars: Sequence[Place], *, least_time_to_collision: float | None) -> Peer:
    """FISS on a road with one more lane to the left, guided by its last plan.

    Of its safety rules the least time to collision [s] is relaxed (1.5 s by default, which finds nothing
    where the way around begins 50 m before a car); None turns them all off.
    """
    fiss_planner = _installed("fiss_planner")
    x = np.arange(0.0, 301.0, 5.0)
    road = fiss_planner.ReferenceLine(x, np.zeros_like(x))
    lanes = fiss_planner.Corridor.parallel_lanes(0.0, 300.0, 3.5, 1, 0)
    vehicle = fiss_planner.VehicleParams()
    vehicle.length, vehicle.width = LENGTH, WIDTH
    config = fiss_planner.make_config("fiss")
    if least_time_to_collision is None:
        config.safety.enabled = False
    else:
        config.safety.min_ttc = least_time_to_collision
    planner = fiss_planner.make_planner(config, vehicle)
    others = [
        fiss_planner.predict_constant_velocity(i, x, y, 0.0, 0.0, LENGTH, WIDTH, horizon=6.0, dt=0.1)
        for i, (x, y) in enumerate(cars)
    ]
    start = fiss_planner.FrenetState(s=0.0, s_d=SPEED)

    def driven(plan: Any) -> np.ndarray | None:
        if not plan.success:
            return None
        found = plan.trajectory
        t = np.asarray(found.t)
        fine = np.linspace(t[0], t[-1], 400)
        return np.column_stack([np.interp(fine, t, v) for v in (found.x, found.y, found.yaw, found.kappa)])

    return Peer(lambda: planner.plan(start, road, lanes, others, target_speed=SPEED), driven)

"""One judge for the plans of all methods, who knows none of them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.problem import Plan, Problem
from cca_core.geometry import Boxes, box_gap

__all__ = ["Tolerances", "Verification", "jerk_of", "reversals", "verify_plan"]

_LOOK = 0.005  # between two looks at the boxes [s]
_EDGES = 5  # looks between two at the edges
_REACH = 0.5  # half the way over which curvature is taken [m]
_JERK = 0.1  # over which the change of lateral acceleration is taken [s]
_SWING = 0.5  # lateral acceleration that counts as a swing [m/s^2]
_COARSEST = 0.25  # between samples of a plan [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """By how much a plan may miss what was asked, the same for every method.

    Parameters
    ----------
    distance : float
        Of the clearance and of the edges [m].
    a_y : float
        Share of the lateral acceleration [-].
    speed : float
        Share of the wanted speed [-].
    position : float
        Distance to the route at start and goal [m].
    heading : float
        Angle to the route there [rad].
    """

    distance: float = 0.05
    a_y: float = 0.05
    speed: float = 0.1
    position: float = 0.1
    heading: float = 0.03


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """What the judge saw.

    Parameters
    ----------
    violations : tuple of str
        What is missed by more than the tolerances; empty if the plan is confirmed.
    clearance : float
        Least distance between the bodies [m]; infinite without others, negative where they overlap.
    edge : float
        Least distance of the body to the edges [m], negative outside.
    a_y : float
        Largest lateral acceleration [m/s^2], without sign.
    jerk : float
        Largest change of it within 0.1 s, over this time [m/s^3].
    a_y_reversals : int
        Times that the lateral acceleration, less that of the route, changes to the other side by more than
        0.5 m/s^2.
    length : float
        Length of the way [m].
    """

    violations: tuple[str, ...]
    clearance: float
    edge: float
    a_y: float
    jerk: float
    a_y_reversals: int
    length: float

    @property
    def passed(self) -> bool:
        """Whether nothing is missed."""
        return not self.violations


def verify_plan(problem: Problem, plan: Plan, tolerances: Tolerances | None = None) -> Verification:
    """Look at a plan from outside.

    Parameters
    ----------
    problem : Problem
        What was asked.
    plan : Plan
        A trajectory, whatever its status claims.
    tolerances : Tolerances, optional
        What is forgiven.

    Returns
    -------
    verdict : Verdict
        What it keeps and what it misses.

    Notes
    -----
    A cubic spline is laid through the samples over time. The body points along it; every 5 ms its distance
    to each box is taken, every 25 ms its corners against the edges. Curvature is that of the circle through
    three points half a meter apart, so that a jump of curvature, as in Dubins curves, is no fault in itself.
    """
    from scipy.interpolate import CubicSpline  # slow to import

    own = tolerances or Tolerances()
    t, xy = plan.t, plan.xy
    if (
        len(t) < 4
        or t[0] != 0.0
        or not (np.isfinite(t).all() and np.isfinite(xy).all())
        or not 0.0 < np.diff(t).min() <= np.diff(t).max() <= _COARSEST
    ):
        return Verification(
            violations=("no trajectory",), clearance=-np.inf, edge=-np.inf, a_y=np.inf, jerk=np.inf, a_y_reversals=0,
            length=0.0,
        )  # fmt: skip
    way = CubicSpline(t, xy)
    at = np.linspace(0.0, t[-1], max(round(t[-1] / _LOOK), 2) + 1)
    place, course = way(at), way(at, 1)
    body = body_along(problem, place, np.arctan2(course[:, 1], course[:, 0]))
    clearance = min((float(box_gap(body, b).min()) for b in problem.boxes_at(at)), default=np.inf)
    edge = edge_distance(problem, body, _EDGES)
    moved = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(place, axis=0).T))))
    kappa = _curvature(at, place, moved)
    speed = np.gradient(moved, at)
    a_y = speed**2 * kappa
    route = problem.road.path
    s = route.project(place)[0]
    faults = _faults(problem, own, way, clearance, edge, a_y, kappa, speed, s)
    return Verification(
        violations=tuple(faults), clearance=clearance, edge=edge, a_y=float(np.abs(a_y).max()),
        jerk=jerk_of(at, a_y), a_y_reversals=reversals(a_y - speed**2 * route.curvature(s)), length=float(moved[-1]),
    )  # fmt: skip


def _faults(
    problem: Problem, own: Tolerances, way: Any, clearance: float, edge: float, a_y: Array, kappa: Array,
    speed: Array, s: Array,
) -> list[str]:  # fmt: skip
    route, end, steering = problem.road.path, float(way.x[-1]), problem.vehicle.delta_max
    faults = []
    if clearance < problem.clearance - own.distance:
        faults.append(f"clearance {clearance:.2f} m")
    if edge < -own.distance:
        faults.append(f"{-edge:.2f} m over the edge")
    most = float(np.abs(a_y).max())
    if most > (1.0 + own.a_y) * problem.a_y_max:
        faults.append(f"a_y {most:.1f} m/s^2")
    if float(np.abs(kappa).max()) > np.tan(steering) / problem.vehicle.wheelbase:
        faults.append("steering")
    if np.abs(speed / problem.v_x - 1.0).max() > own.speed:
        faults.append(f"speed {speed[np.abs(speed - problem.v_x).argmax()]:.1f} m/s")
    for name, moment, where, station in (
        ("start", 0.0, route.position(problem.start), problem.start),
        ("end", end, None, float(s[-1])),
    ):
        point, (x, y) = way(moment), way(moment, 1)
        off = np.hypot(*(point - where)) if where is not None else abs(float(route.project(point)[1]))
        angle = np.arctan2(y, x) - float(route.heading(station))
        if off > own.position or abs(np.sin(angle)) > own.heading:
            faults.append(f"{name} {off:.2f} m and {np.degrees(np.sin(angle)):.1f}° off the route")
    if s[-1] < problem.goal - 0.01 * (problem.goal - problem.start):
        faults.append(f"ends {problem.goal - s[-1]:.0f} m before the goal")
    return faults


def body_along(problem: Problem, place: Array, psi: Array) -> Boxes:
    """Boxes of the ego.

    Parameters
    ----------
    problem : Problem
        With the vehicle.
    place : ndarray, shape (n, 2)
        Center of gravity [m].
    psi : ndarray, shape (n,)
        Heading [rad].

    Returns
    -------
    body : Boxes
        One for each place.
    """
    return problem.vehicle.body_at(place[:, 0], place[:, 1], psi)


def edge_distance(problem: Problem, body: Boxes, every: int = 1) -> float:
    """Least distance of corners to the edges of the road.

    Parameters
    ----------
    problem : Problem
        With the road.
    body : Boxes
        Boxes of the ego.
    every : int
        Every how manyth box is looked at [-].

    Returns
    -------
    distance : float
        Negative outside [m].
    """
    d = problem.road.path.project(body.corners()[::every].reshape(-1, 2))[1]
    return float(min(problem.road.left_edge - d.max(), d.min() - problem.road.right_edge))


def _curvature(t: Array, place: Array, moved: Array) -> Array:
    """Curvature of the circle through places half a meter behind, at and half a meter ahead."""
    middle = np.clip(moved, _REACH, moved[-1] - _REACH)
    a, b, c = (
        np.column_stack([np.interp(middle + off, moved, place[:, i]) for i in (0, 1)])
        for off in (-_REACH, 0.0, _REACH)
    )
    one, two = b - a, c - b
    cross = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    kappa: Array = 2.0 * cross / (np.hypot(*one.T) * np.hypot(*two.T) * np.hypot(*(c - a).T))
    return kappa


def jerk_of(t: Array, a_y: Array) -> float:
    """Largest change of lateral acceleration within 0.1 s.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times [s], increasing.
    a_y : ndarray, shape (n,)
        Lateral accelerations [m/s^2].

    Returns
    -------
    jerk : float
        The change over 0.1 s [m/s^3].
    """
    later = np.interp(t + _JERK, t, a_y)
    return float(np.abs(later - a_y).max() / _JERK)


def reversals(a_y: Array) -> int:
    """Count how often an acceleration changes to the other side.

    Parameters
    ----------
    a_y : ndarray, shape (n,)
        Lateral accelerations [m/s^2].

    Returns
    -------
    swings : int
        Changes between more than 0.5 and less than -0.5 m/s^2.
    """
    sides = np.sign(a_y[np.abs(a_y) > _SWING])
    return int(np.count_nonzero(np.diff(sides)))

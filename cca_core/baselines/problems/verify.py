"""Verification of plans: clearance, edges and limits, measured from the samples of the plan alone."""

from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core._repr import short_repr
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.geometry import Boxes, arc_length, box_gap


@dataclass(frozen=True, slots=True, kw_only=True)
class Tolerances:
    """Amounts by which a plan may miss the limits of its problem; the same for every method.

    Parameters
    ----------
    distance : float
        Of the clearance and of the distance to the edges [m].
    a_y : float
        Fraction of the lateral acceleration [-].
    speed : float
        Fraction of the wanted speed [-].
    position : float
        Lateral offset at start and goal [m].
    heading : float
        Heading relative to the route at start and goal [rad].
    """

    distance: float = 0.05
    a_y: float = 0.05
    speed: float = 0.1
    position: float = 0.1
    heading: float = 0.03


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """Measured figures of a plan, and the limits that it violates.

    Parameters
    ----------
    violations : tuple of str
        Limits that are missed by more than the tolerances; empty if the plan passes.
    clearance : float
        Smallest distance between the bodies [m]; infinite without other vehicles, negative on overlap.
    edge : float
        Smallest distance of the body to the road edges [m], negative outside.
    a_y : float
        Largest absolute lateral acceleration [m/s^2].
    jerk : float
        Largest change of the lateral acceleration within 0.1 s, divided by this time [m/s^3].
    a_y_reversals : int
        Number of sign changes of the lateral acceleration relative to the route, counted beyond
        0.5 m/s^2.
    length : float
        Length of the trajectory [m].
    """

    violations: tuple[str, ...]
    clearance: float
    edge: float
    a_y: float
    jerk: float
    a_y_reversals: int
    length: float

    __repr__ = short_repr

    @property
    def passed(self) -> bool:
        """Whether no limit is violated."""
        return not self.violations


def verify_plan(problem: Problem, plan: Plan, tolerances: Tolerances | None = None) -> Verification:
    """Measure a plan against the limits of its problem.

    Parameters
    ----------
    problem : Problem
        The problem.
    plan : Plan
        Its trajectory; the status is ignored.
    tolerances : Tolerances, optional
        Default: `Tolerances()`.

    Returns
    -------
    verification : Verification
        Figures and violations. A plan without a usable trajectory has the violation ``"no trajectory"``.

    Notes
    -----
    A cubic spline over time interpolates the samples; the body heads along it. The gaps to the boxes are
    computed every 5 ms, those of the corners to the road edges every 25 ms. Curvature is that of the circle
    through three points at 0.5 m distance, which bridges the curvature jumps of Dubins curves.
    """
    if not _is_trajectory(plan):
        return Verification(
            violations=("no trajectory",), clearance=-np.inf, edge=-np.inf, a_y=np.inf, jerk=np.inf,
            a_y_reversals=0, length=0.0,
        )  # fmt: skip
    motion = _Motion.of(problem, plan)
    body = problem.vehicle.body_at(motion.xy[:, 0], motion.xy[:, 1], motion.heading)
    clearance = min((float(box_gap(body, b).min()) for b in problem.boxes_at(motion.t)), default=np.inf)
    edge = edge_distance(problem, body, every=5)
    violations = [
        *_distance_violations(problem, tolerances or Tolerances(), clearance, edge),
        *_motion_violations(problem, tolerances or Tolerances(), motion),
        *_end_violations(problem, tolerances or Tolerances(), motion),
    ]
    a_y, route = motion.speed**2 * motion.kappa, problem.road.path
    return Verification(
        violations=tuple(violations), clearance=clearance, edge=edge, a_y=float(np.abs(a_y).max()),
        jerk=max_jerk(motion.t, a_y), length=float(motion.distance[-1]),
        a_y_reversals=count_reversals(a_y - motion.speed**2 * route.curvature(motion.s)),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _Motion:
    """A plan resampled every 5 ms, with its derivatives."""

    t: Array
    xy: Array
    heading: Array
    distance: Array  # traveled
    speed: Array
    kappa: Array
    s: Array

    @classmethod
    def of(cls, problem: Problem, plan: Plan) -> "_Motion":
        """Resample a plan."""
        from scipy.interpolate import CubicSpline  # slow to import

        spline = CubicSpline(plan.t, plan.xy)
        end = float(plan.t[-1])
        t = np.linspace(0.0, end, max(round(end / 0.005), 2) + 1)
        xy, velocity = spline(t), spline(t, 1)
        distance = arc_length(xy)
        return cls(
            t, xy, np.arctan2(velocity[:, 1], velocity[:, 0]), distance, np.gradient(distance, t),
            _circle_curvature(xy, distance, 0.5), problem.road.path.project(xy)[0],
        )  # fmt: skip


def _is_trajectory(plan: Plan) -> bool:
    """Return whether times and positions are finite, ordered and at most 0.25 s apart."""
    t = plan.t
    return (
        len(t) >= 4
        and t[0] == 0.0
        and bool(np.isfinite(t).all() and np.isfinite(plan.xy).all())
        and bool(0.0 < np.diff(t).min() <= np.diff(t).max() <= 0.25)
    )


def _distance_violations(problem: Problem, allowed: Tolerances, clearance: float, edge: float) -> list[str]:
    """Violations of the clearance and of the road edges."""
    found = []
    if clearance < problem.clearance - allowed.distance:
        found.append(f"clearance {clearance:.2f} m")
    if edge < -allowed.distance:
        found.append(f"{-edge:.2f} m over the edge")
    return found


def _motion_violations(problem: Problem, allowed: Tolerances, motion: _Motion) -> list[str]:
    """Violations of lateral acceleration, steering angle and speed."""
    found = []
    a_y = float(np.abs(motion.speed**2 * motion.kappa).max())
    if a_y > (1.0 + allowed.a_y) * problem.a_y_max:
        found.append(f"a_y {a_y:.1f} m/s^2")
    if float(np.abs(motion.kappa).max()) > np.tan(problem.vehicle.delta_max) / problem.vehicle.wheelbase:
        found.append("steering")
    speed = motion.speed
    if np.abs(speed / problem.v_x - 1.0).max() > allowed.speed:
        found.append(f"speed {speed[np.abs(speed - problem.v_x).argmax()]:.1f} m/s")
    return found


def _end_violations(problem: Problem, allowed: Tolerances, motion: _Motion) -> list[str]:
    """Violations of position and heading at both ends, and of the goal."""
    found, route = [], problem.road.path
    start_offset = float(np.hypot(*(motion.xy[0] - route.position(problem.start))))
    end_offset = abs(float(route.project(motion.xy[-1])[1]))
    for name, i, offset, station in (
        ("start", 0, start_offset, problem.start), ("end", -1, end_offset, float(motion.s[-1])),
    ):  # fmt: skip
        sine = np.sin(motion.heading[i] - float(route.heading(station)))
        if offset > allowed.position or abs(sine) > allowed.heading:
            found.append(f"{name} {offset:.2f} m and {np.degrees(sine):.1f}° off the route")
    if motion.s[-1] < problem.goal - 0.01 * (problem.goal - problem.start):
        found.append(f"ends {problem.goal - motion.s[-1]:.0f} m before the goal")
    return found


def edge_distance(problem: Problem, body: Boxes, every: int = 1) -> float:
    """Smallest distance of the corners of every n-th box to the road edges [m], negative outside."""
    d = problem.road.path.project(body.corners()[::every].reshape(-1, 2))[1]
    return float(min(problem.road.left_edge - d.max(), d.min() - problem.road.right_edge))


def _circle_curvature(xy: Array, distance: Array, reach: float) -> Array:
    """Curvature of the circle through the points `reach` behind, at and `reach` ahead of each position."""
    middle = np.clip(distance, reach, distance[-1] - reach)
    a, b, c = (
        np.column_stack([np.interp(middle + off, distance, xy[:, i]) for i in (0, 1)])
        for off in (-reach, 0.0, reach)
    )
    one, two = b - a, c - b
    cross = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    kappa: Array = 2.0 * cross / (np.hypot(*one.T) * np.hypot(*two.T) * np.hypot(*(c - a).T))
    return kappa


def max_jerk(t: Array, a_y: Array, window: float = 0.1) -> float:
    """Largest change of the lateral acceleration within a time window [s], divided by it [m/s^3]."""
    later = np.interp(t + window, t, a_y)
    return float(np.abs(later - a_y).max() / window)


def count_reversals(a_y: Array, threshold: float = 0.5) -> int:
    """Count sign changes of the lateral acceleration between values beyond a threshold [m/s^2]."""
    sides = np.sign(a_y[np.abs(a_y) > threshold])
    return int(np.count_nonzero(np.diff(sides)))

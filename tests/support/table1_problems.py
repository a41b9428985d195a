"""Problems on straight and curved roads, and distances of plans measured by shapely."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import shapely
from shapely import affinity

from cca_core import Lane, RemoteVehicle, Road, VehicleParams
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.path import Path, fit_path

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8, box_offset=0.1)
LENGTH = 400.0
Car = tuple[float, float, float]  # s, d [m], speed along the road [m/s]


@cache
def road(radius: float = np.inf, lanes: tuple[float, ...] = (0.0, 3.5)) -> Road:
    """Road with lanes of 3.5 m; a positive radius curves to the left."""
    if np.isinf(radius):
        path = Path([0.0, LENGTH], [[[0, 0, LENGTH, 0], [0, 0, 0, 0]]])
    else:
        angle = np.arange(0.0, LENGTH + 1.0, 5.0) / radius
        path = fit_path(radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle))), tolerance=0.01)
    return Road(path, [Lane(d=d) for d in lanes])


def problem(cars: list[Car], *, goal: float = 120.0, on: Road | None = None, **values: Any) -> Problem:
    """Problem of the ego at 20 m/s with cars on a road."""
    on = on or road()
    others = []
    for i, (s, d, v) in enumerate(cars):
        x, y = on.path.to_cartesian(s, d).tolist()
        psi = float(on.path.heading(s)) + (np.pi if v < 0.0 else 0.0)
        others.append(RemoteVehicle(id=f"{i}", x=x, y=y, psi=psi, v_x=abs(v)))
    given = {"name": "test", "road": on, "vehicle": CAR, "start": 0.0, "goal": goal, "v_x": 20.0} | values
    return Problem(others=tuple(others), **given)


CASES = {
    "stationary": problem([(50.0, 0.0, 0.0)]),
    "slower": problem([(40.0, 0.0, 8.0)], goal=200.0),
    "oncoming": problem([(50.0, 0.0, 0.0), (210.0, 3.5, -15.0)], goal=150.0),
    "adjacent car": problem(
        [(60.0, 0.0, 0.0), (5.0, 3.5, 20.0)], goal=150.0, on=road(lanes=(-3.5, 0.0, 3.5))
    ),
    "left curve": problem([(60.0, 0.0, 0.0), (115.0, 3.5, 0.0)], goal=170.0, on=road(200.0), v_x=18.0),
    "right curve": problem([(60.0, 0.0, 0.0)], goal=140.0, on=road(-200.0), v_x=18.0),
    "slow": problem([(25.0, 0.0, 0.0)], goal=60.0, v_x=7.0),
}
SLALOM = problem([(35.0, 0.0, 0.0), (60.0, 3.5, 0.0), (85.0, 0.0, 0.0)])
BLOCKED = problem([(60.0, 0.0, 0.0), (60.0, 3.5, 0.0)])


def measured_distances(problem: Problem, plan: Plan) -> tuple[float, float]:
    """Smallest distance to the other vehicles, by shapely, and to the edges; asserts the motion limits."""
    xy, t = plan.xy, plan.t
    assert t[0] == 0.0
    assert (np.diff(t) > 0.0).all()
    path, v_x = problem.road.path, plan.v_x
    np.testing.assert_allclose(xy[0], path.position(problem.start), atol=1e-6)
    np.testing.assert_allclose(xy[-1], path.position(problem.goal), atol=1e-6)
    np.testing.assert_allclose(v_x, problem.v_x, rtol=0.06)
    step = np.diff(xy, axis=0)
    chord = np.hypot(*step.T)
    np.testing.assert_allclose(chord / np.diff(t), 0.5 * (v_x[1:] + v_x[:-1]), rtol=5e-3)
    heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    spacing = 0.5 * (chord[1:] + chord[:-1])
    curvature = np.diff(heading) / spacing
    even = (spacing > 0.1) & (np.abs(chord[1:] - chord[:-1]) < 0.02)
    assert np.abs(curvature[even]).max() <= 1.01 * problem.kappa_max
    assert np.abs(curvature * v_x[1:-1] ** 2)[even].max() <= 1.01 * problem.a_y_max
    ends = np.array((heading[0], heading[-1])) - path.heading([problem.start, problem.goal])
    turned = 0.51 * problem.kappa_max * chord[[0, -1]]  # by the middle of the first and last step
    assert (np.abs(np.sin(ends)) <= turned + 5e-4).all()
    grid = np.linspace(0.0, t[-1], round(t[-1] / 0.004))
    x, y = np.interp(grid, t, xy[:, 0]), np.interp(grid, t, xy[:, 1])
    psi = np.interp(grid, 0.5 * (t[1:] + t[:-1]), heading)
    half, wide = 0.5 * CAR.length, 0.5 * CAR.width
    body = shapely.box(CAR.box_offset - half, -wide, CAR.box_offset + half, wide)
    boxes = problem.boxes_at(grid)
    gap, edge = np.inf, np.inf
    for k in range(len(grid)):
        ego = affinity.translate(affinity.rotate(body, psi[k], origin=(0, 0), use_radians=True), x[k], y[k])
        for box in boxes:
            other = shapely.Polygon(
                [
                    (
                        box.x[k] + a * np.cos(box.psi[k]) - b * np.sin(box.psi[k]),
                        box.y[k] + a * np.sin(box.psi[k]) + b * np.cos(box.psi[k]),
                    )
                    for a, b in ((2.25, 0.9), (-2.25, 0.9), (-2.25, -0.9), (2.25, -0.9))
                ]
            )
            gap = min(gap, ego.distance(other))
        if k % 10 == 0:
            _, d = path.project(np.array(ego.exterior.coords))
            edge = min(edge, problem.road.left_edge - d.max(), d.min() - problem.road.right_edge)
    return float(gap), float(edge)

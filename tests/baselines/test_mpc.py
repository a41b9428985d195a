"""Predictive controllers: model, optimum, limits, symmetry, status of failures."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cca_core import InputError, Lane, MissingExtraError, Path, RemoteVehicle, Road, Status, VehicleParams
from cca_core.baselines.methods.mpc.horizon import FrenetState, Horizon, MpcSettings
from cca_core.baselines.methods.mpc.linear import LinearMpc
from cca_core.baselines.methods.mpc.nonlinear import NonlinearMpc
from cca_core.baselines.methods.mpc.side_choice import side_choices
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.geometry import Boxes, box_gap
from cca_core.path import interpolate_path

pytestmark = pytest.mark.requires("casadi", "piqp")

CAR = dataclasses.replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
LINE = Path([0.0, 2000.0], [[[0, 0, 2000, 0], [0, 0, 0, 0]]])
LEFT, RIGHT = (Lane(d=0.0), Lane(d=3.5)), (Lane(d=0.0), Lane(d=-3.5))


def by_fatrop(settings: MpcSettings) -> NonlinearMpc:
    return NonlinearMpc(dataclasses.replace(settings, solver="fatrop"))


PLANNERS = [LinearMpc, NonlinearMpc, by_fatrop]
COARSE = MpcSettings(intervals=24)
V = 20.0


def car(name: str, x: float, y: float, v: float = 0.0, psi: float = 0.0) -> RemoteVehicle:
    return RemoteVehicle(id=name, x=x, y=y, psi=psi, v_x=v)


def problem(
    *others: RemoteVehicle, goal: float = 120.0, lanes: tuple[Lane, ...] = LEFT, path: Path = LINE
) -> Problem:
    return Problem(
        name="test", road=Road(path, lanes), vehicle=CAR, others=others, start=0.0, goal=goal, v_x=V
    )


STANDING = problem(car("a", 50.0, 0.0), goal=100.0)
SLALOM = problem(car("a", 35.0, 0.0), car("b", 60.0, 3.5), car("c", 85.0, 0.0))
SLOW = problem(car("a", 40.0, 0.0, 12.0), goal=200.0)
ONCOMING = problem(car("a", 50.0, 0.0), car("o", 330.0, 3.5, 20.0, math.pi))
PROBLEM = pytest.mark.parametrize(
    "given", [STANDING, SLALOM, SLOW, ONCOMING], ids=["a", "slalom", "slow", "on"]
)
BOTH = pytest.mark.parametrize("planner", PLANNERS, ids=["linear", "ipopt", "fatrop"])


def curve(radius: float) -> Path:
    phi = np.linspace(0.0, 400.0 / abs(radius), 201)
    nodes = np.column_stack((abs(radius) * np.sin(phi), radius * (1.0 - np.cos(phi))))
    return interpolate_path(nodes, start_tangent=[1.0, 0.0])


def motion(plan: Plan) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speed, heading and curvature of a plan from its positions alone."""
    v = np.gradient(plan.xy, plan.t, axis=0, edge_order=2)
    a = np.gradient(v, plan.t, axis=0, edge_order=2)
    speed = np.hypot(v[:, 0], v[:, 1])
    return speed, np.unwrap(np.arctan2(v[:, 1], v[:, 0])), (v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0]) / speed**3


@BOTH
@PROBLEM
def test_plan_keeps_limits_and_clearance(planner: Any, given: Problem) -> None:
    plan = planner(COARSE).plan(given)
    assert plan.status is Status.OK, plan.message
    assert plan.t[0] == 0.0
    assert np.allclose(plan.xy[0], [given.start, 0.0])
    assert plan.xy[-1, 0] >= given.goal - 0.01
    assert abs(plan.xy[-1, 1]) < 0.03
    speed, psi, kappa = motion(plan)
    assert np.abs(speed - plan.v_x)[2:-2].max() < 0.15
    assert np.abs(speed**2 * kappa)[2:-2].max() < 1.05 * given.a_y_max
    assert abs(psi[-1]) < 0.02
    x, y = plan.xy.T
    length, width = np.array(CAR.length), np.array(CAR.width)
    ego = Boxes(x, y, psi, length, width)
    for box in given.boxes_at(plan.t):
        assert box_gap(ego, box).min() > given.clearance - 0.05
    corners = ego.corners().reshape(-1, 2)
    assert given.road.right_edge - 0.05 < corners[:, 1].min()
    assert corners[:, 1].max() < given.road.left_edge + 0.05


@BOTH
def test_plan_on_empty_road_is_straight_at_wanted_speed(planner: Any) -> None:
    plan = planner(COARSE).plan(problem())
    assert plan.status is Status.OK
    assert np.abs(plan.xy[:, 1]).max() < 1e-4
    assert np.abs(plan.v_x - V).max() < 0.02


@BOTH
@pytest.mark.parametrize("radius", [300.0, -300.0])
def test_plan_on_empty_curve_follows_route(planner: Any, radius: float) -> None:
    path = curve(radius)
    plan = planner(COARSE).plan(problem(path=path))
    assert plan.status is Status.OK, plan.message
    _, d = path.project(plan.xy)
    assert np.abs(d).max() < 0.1


@BOTH
def test_mirrored_problem_gives_mirrored_plan(planner: Any) -> None:
    given = problem(car("a", 45.0, 0.3), goal=100.0)
    mirrored = problem(car("a", 45.0, -0.3), goal=100.0, lanes=RIGHT)
    one, other = planner(COARSE).plan(given), planner(COARSE).plan(mirrored)
    assert one.status is other.status is Status.OK
    assert np.abs(one.xy * [1.0, -1.0] - other.xy).max() < 1e-3


@BOTH
def test_blocked_road_is_not_ok(planner: Any) -> None:
    plan = planner(COARSE).plan(problem(car("a", 60.0, 0.0), car("b", 60.0, 3.5)))
    assert plan.status is not Status.OK
    assert plan.message


@BOTH
def test_iteration_limit_is_not_converged(planner: Any) -> None:
    plan = planner(MpcSettings(intervals=24, iterations=1)).plan(SLALOM)
    assert plan.status is Status.NOT_CONVERGED
    assert plan.message
    assert len(plan.t) == 0


@BOTH
def test_plan_does_not_depend_on_earlier_plans(planner: Any) -> None:
    again = planner(COARSE)
    first = again.plan(STANDING)
    again.plan(SLOW)
    second = again.plan(STANDING)
    assert np.abs(first.xy - second.xy).max() < 1e-6


def test_nonlinear_solution_is_fixed_point() -> None:
    planner = NonlinearMpc(COARSE)
    horizon = Horizon.of(STANDING, COARSE.intervals)
    v = np.full(len(horizon.t), V)
    start = FrenetState(s=0.0, v=V)
    guess = LinearMpc(COARSE).solve(horizon, start, V * horizon.t, v)
    first = planner.solve(horizon, start, *guess.nodes(len(v)), v)
    again = planner.solve(horizon, start, *first.nodes(len(v)), v)
    assert first.status is again.status is Status.OK
    assert np.abs(first.d - again.d).max() < 0.01
    assert np.abs(first.v - again.v).max() < 0.01


@pytest.mark.parametrize("radius", [math.inf, 200.0])
def test_nonlinear_plan_is_motion_of_bicycle(radius: float) -> None:
    """Its steering and acceleration, integrated in x, y and psi, reproduce its positions."""
    path = LINE if math.isinf(radius) else curve(radius)
    x, y = path.to_cartesian(45.0, 0.0).tolist()
    given = problem(car("a", x, y, 0.0, float(path.heading(45.0))), goal=100.0, path=path)
    horizon = Horizon.of(given, COARSE.intervals)
    start = FrenetState(s=0.0, v=V, kappa=path.curvature_at(0.0))
    v = np.full(len(horizon.t), V)
    guess = LinearMpc(COARSE).solve(horizon, start, V * horizon.t, v)
    trajectory = NonlinearMpc(COARSE).solve(horizon, start, *guess.nodes(len(v)), v)
    assert trajectory.status is not Status.NOT_CONVERGED

    def rate(t: float, z: np.ndarray) -> list[float]:
        delta, a_x = np.interp(t, trajectory.t, trajectory.delta), np.interp(t, trajectory.t, trajectory.a_x)
        gain = CAR.wheelbase + CAR.understeer_gradient * z[3] ** 2
        return [z[3] * math.cos(z[2]), z[3] * math.sin(z[2]), z[3] * delta / gain, a_x]

    driven = solve_ivp(
        rate, (0.0, trajectory.t[-1]), [0.0, 0.0, 0.0, V], t_eval=trajectory.t, rtol=1e-8, max_step=0.05
    ).y
    # the curvature of the road is held at each node over an interval
    assert np.abs(trajectory.xy(path).T - driven[:2]).max() < (2e-3 if math.isinf(radius) else 0.1)


def test_unlimited_linear_motion_is_quadratic_optimum() -> None:
    """From 1 m off the route: cost |W z|^2 over the jerks alone, d, w, a by double sums."""
    settings = MpcSettings(intervals=20)
    n, h = 20, 0.25
    horizon = Horizon(
        road=Road(LINE, (Lane(d=0.0, width=40.0),)), vehicle=CAR, t=h * np.arange(n + 1), others=(),
        v_wanted=V, clearance=0.3, a_y_max=100.0, final_d=(-20.0, 20.0),
    )  # fmt: skip
    v = np.full(n + 1, V)
    trajectory = LinearMpc(settings).solve(
        horizon, FrenetState(s=100.0, d=1.0, v=V), 100.0 + V * horizon.t, v
    )
    step = np.array([[1.0, h, h * h / 2], [0.0, 1.0, h], [0.0, 0.0, 1.0]])
    push = np.array([h**3 / 6, h * h / 2, h])
    free, driven = np.empty((n + 1, 3)), np.zeros((n + 1, 3, n))
    free[0] = [1.0, 0.0, 0.0]
    for k in range(n):
        free[k + 1], driven[k + 1] = step @ free[k], step @ driven[k]
        driven[k + 1, :, k] += push
    scale = np.sqrt([settings.weight_d, settings.weight_a])
    rows = np.concatenate((scale[0] * driven[:, 0], scale[1] * driven[:, 2]))
    rows = np.vstack((rows, math.sqrt(settings.weight_jerk) * np.eye(n)))
    right = -np.concatenate((scale[0] * free[:, 0], scale[1] * free[:, 2], np.zeros(n)))
    jerk = np.linalg.lstsq(rows, right, rcond=None)[0]
    assert np.abs(trajectory.d[::5] - (free + driven @ jerk)[:, 0]).max() < 1e-3


def test_side_choices_are_free_of_contradiction() -> None:
    horizon = Horizon.of(SLALOM, 24)
    found = side_choices(horizon, V * horizon.t, np.full(25, V), 0.0)
    assert len(found) == 1  # left, right, left: all others leave the road or contradict themselves
    assert found[0].overlap == 0.0
    wide = dataclasses.replace(horizon, road=Road(LINE, (Lane(d=0.0, width=14.0),)))
    found = side_choices(wide, V * horizon.t, np.full(25, V), 0.0)
    assert len(found) > 2
    assert all((p.lower <= p.upper + 1e-9).all() for p in found)


def test_both_solvers_find_same_trajectory() -> None:
    plans = [planner(COARSE).plan(STANDING) for planner in (NonlinearMpc, by_fatrop)]
    assert np.abs(plans[0].xy - plans[1].xy).max() < 0.05


@BOTH
def test_missing_extra_is_named(planner: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cca_core._optional.find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match="pip install"):
        planner(COARSE)


@pytest.mark.parametrize(
    "wrong",
    [{"intervals": 4}, {"intervals": 20.0}, {"iterations": 0}, {"horizon": 0.0}, {"a_y_max": -1.0},
     {"clearance": math.nan}, {"solver": "other"}, {"weight_d": 0.0}, {"weight_v": -1.0}, {"cpu_time": 0.0},
     {"corridor_margins": ()}, {"a_y_fraction": 1.5}, {"max_side_choices": 0}, {"vehicle_penalty": 0.0}],
)  # fmt: skip
def test_error_names_setting(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        MpcSettings(**wrong)


def test_body_ends_stay_in_corridor() -> None:
    """The bound starts half an interval before the front is alongside the other vehicle."""
    horizon = Horizon.of(STANDING, 40)
    v, s = np.full(41, V), V * horizon.t
    choice = side_choices(horizon, s, v, 0.0)[0]
    reach = 0.5 * 4.5 + STANDING.clearance + 0.5 * V * horizon.step
    for bound, offset in zip(choice.lower, (-2.25, 2.25), strict=True):
        alongside = np.abs(s + offset - 50.0) <= reach
        assert alongside.any()
        assert np.allclose(bound[alongside], 1.8 + STANDING.clearance)
        assert np.allclose(bound[~alongside][:-1], horizon.edges[0])
    start = FrenetState(s=0.0, v=V)
    trajectory = LinearMpc(MpcSettings()).solve(horizon, start, s, v)
    d, tan = trajectory.d[::5], np.tan(trajectory.angle[::5])
    for bound, offset in zip(choice.lower, (-2.25, 2.25), strict=True):
        assert (d + offset * tan - bound)[1:].min() > -1e-3
    assert min((d + o * tan - b).min() for b, o in zip(choice.lower, (-2.25, 2.25), strict=True)) < 0.1

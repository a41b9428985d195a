"""Bands smoothed by quadratic programming: hard limits, and the result of a failure."""

import math
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

from cca_core.band import Band, relax_band, smooth_band
from cca_core.errors import InputError, MissingExtraError, Status
from cca_core.geometry import boxes
from tests.support.band_cases import Case, case
from tests.support.band_measure import curvature_at
from tests.support.band_scenes import CAR, assert_certified, bend, moving, on, relax, scene, straight

pytestmark = [pytest.mark.requires(module) for module in ("qpsolvers", "piqp", "osqp")]
both = pytest.mark.parametrize("solver", ["piqp", "osqp"])


def rate(band: Band) -> float:
    """Largest change of the driven curve's curvature from node to node, per length [1/m^2]."""
    n = len(band)
    return float(np.abs(np.diff(curvature_at(band.nodes, np.arange(2.0, n - 2.0)))).max()) / band.spacing


def roughness(band: Band) -> float:
    """Cost: squared change of curvature by the displacement, summed."""
    return float((np.diff(np.pad(band.displacement, 2), 3) ** 2).sum()) / band.spacing**5


def one(d: float = 0.3, route: np.ndarray | None = None, **problem: Any) -> Case:
    nodes = straight() if route is None else route
    return scene(nodes, [on(nodes, len(nodes) // 2, d, 0.05)], **problem)


@both
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("route", [straight(), bend(150.0), straight(160.0, 2.0), straight(100.0, 0.5)])
def test_smoothed_band_is_smoother_and_certified(solver: Any, side: str, route: np.ndarray) -> None:
    problem = one(route=route)
    band = relax(problem, side=side)
    smooth = smooth_band(band, solver=solver)
    assert smooth.status is Status.OK, smooth.message
    assert_certified(smooth, problem)
    assert smooth.sides == band.sides
    ratio = np.abs(smooth.displacement).max() / np.abs(band.displacement).max()  # contacts yield a little
    assert roughness(smooth) < ratio**2 * roughness(band)
    np.testing.assert_array_equal(smooth.displacement[[0, -1]], 0.0)
    assert smooth.qp_residual is not None
    assert smooth.qp_residual < 1e-3
    assert band.qp_residual is None


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("seed", range(5))
def test_smoothed_random_cases_are_certified(count: int, seed: int) -> None:
    problem = case(np.random.default_rng([9, count, seed]), count)
    band = relax(problem)
    smooth = smooth_band(band)
    if not smooth.ok:
        np.testing.assert_array_equal(smooth.nodes, band.nodes)
        return
    assert_certified(smooth, problem)
    assert smooth.clearance >= problem.clearance - 1e-9
    assert (smooth.passes_left == band.passes_left).all()


def test_moving_obstacle() -> None:
    route = straight(200.0)
    problem = scene(route, [moving(route, 60.0, (60.0, 0.0), (0.5, 0.0))])
    smooth = smooth_band(relax(problem, side="left"))
    assert smooth.status is Status.OK, smooth.message
    assert_certified(smooth, problem)


@both
def test_curvature_rate_limit_is_satisfied(solver: Any) -> None:
    band = relax(one(), side="left")
    free = smooth_band(band, solver=solver)
    steepest = float(np.abs(np.diff(np.pad(free.displacement, 2), 3)).max())  # at the pins
    for fraction in (0.95, 0.8):
        problem = fraction * steepest
        smooth = smooth_band(band, curvature_rate_limit=problem, solver=solver)
        if fraction == 0.95:
            assert smooth.status is Status.OK, smooth.message
        if smooth.ok:
            assert rate(smooth) <= 1.02 * problem
            assert_certified(smooth, one())
        else:
            assert smooth.status is Status.DEGRADED


def test_rate_limit_includes_changes_of_route() -> None:
    """The limit holds for route and displacement together."""
    s = np.arange(151.0)
    psi = np.cumsum(0.01 * np.cos(s / 15.0))
    route = np.cumsum(np.column_stack((np.cos(psi), np.sin(psi))), axis=0)
    band = relax(scene(route, []))
    route_rate = rate(band)
    np.testing.assert_allclose(
        smooth_band(band, curvature_rate_limit=1.2 * route_rate).displacement, 0.0, atol=1e-5
    )
    smooth = smooth_band(band, curvature_rate_limit=0.9 * route_rate)
    assert smooth.ok, smooth.message
    assert rate(smooth) <= 0.92 * route_rate


def test_smoothing_meets_limit_that_band_exceeds() -> None:
    free = smooth_band(relax(one(), side="left"))
    band = relax(one(), side="left", stiffness=None)
    limit = 1.02 * free.curvature
    problem = one(curvature_limit=limit)
    smooth = smooth_band(relax(problem, side="left"))
    assert smooth.status is Status.OK, smooth.message
    assert smooth.curvature <= limit
    assert band.curvature > limit
    assert_certified(smooth, problem)


@both
def test_failed_smoothing_returns_given_band(solver: Any) -> None:
    band = relax(one(), side="left")
    result = smooth_band(band, curvature_rate_limit=1e-5, solver=solver)
    assert result.status is Status.DEGRADED
    assert not result.ok
    assert "not smoothed" in result.message
    assert result.qp_residual is None
    for name in ("nodes", "displacement", "lower", "upper", "passes_left"):
        np.testing.assert_array_equal(getattr(result, name), getattr(band, name))
    for name in ("clearance", "edge_clearance", "curvature", "active_constraint", "sides"):
        assert getattr(result, name) == getattr(band, name)


def test_infeasible_band_stays_infeasible() -> None:
    band = relax(one(corridor=(-2.0, 2.0)))
    result = smooth_band(band)
    assert result.status is band.status is Status.INFEASIBLE
    assert band.message in result.message
    np.testing.assert_array_equal(result.nodes, band.nodes)


@pytest.mark.parametrize("d", [-0.5, 0.0, 0.8])
@pytest.mark.parametrize("route", [straight(), bend(200.0)])
def test_solvers_agree(d: float, route: np.ndarray) -> None:
    band = relax(one(d, route))
    first, other = (smooth_band(band, solver=solver) for solver in ("piqp", "osqp"))  # type: ignore[arg-type]
    assert first.ok
    assert other.ok
    np.testing.assert_allclose(other.displacement, first.displacement, rtol=0.0, atol=2e-3)


def test_weights_trade_curvature_for_its_rate() -> None:
    """More weight on curvature: less of it in total, but more change."""
    band = relax(one(), side="left")
    even, flat = smooth_band(band), smooth_band(band, weights=(1.0, 0.0))
    assert even.ok
    assert flat.ok

    def bending(b: Band) -> float:
        return float((np.diff(np.pad(b.displacement, 1), 2) ** 2).sum())

    assert bending(flat) < bending(even)
    assert roughness(flat) > roughness(even)


def test_mirror_invariance() -> None:
    route = bend(200.0)
    o = on(route, 75, 0.4, 0.1)
    flipped = boxes(o.x, -o.y, -o.psi, o.length, o.width)
    left = smooth_band(relax(scene(route, [o]), side="left"))
    right = smooth_band(relax(scene(route * [1.0, -1.0], [flipped]), side="right"))
    np.testing.assert_allclose(right.displacement, -left.displacement, rtol=0.0, atol=1e-5)
    assert right.status is left.status is Status.OK


def test_free_route_has_zero_displacement() -> None:
    smooth = smooth_band(relax(scene(bend(200.0), [])))
    assert smooth.status is Status.OK
    np.testing.assert_allclose(smooth.displacement, 0.0, atol=1e-6)


def test_missing_extra_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    band = relax(one())
    monkeypatch.setattr(
        "cca_core._optional.find_spec", lambda name: None if name == "qpsolvers" else find_spec(name)
    )
    with pytest.raises(MissingExtraError, match=r"pip install .*cca-planner\[qp\]"):
        smooth_band(band)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"band": None}, "^band must be a Band, was NoneType"),
        ({"curvature_rate_limit": 0.0}, "^curvature_rate_limit must be greater than 0"),
        ({"curvature_rate_limit": math.nan}, "^curvature_rate_limit must"),
        ({"solver": "simplex"}, "^solver must be 'piqp' or 'osqp'"),
        ({"weights": (-1.0, 1.0)}, "^weights must"),
        ({"weights": (0.0, 0.0)}, "^weights must"),
        ({"weights": (math.nan, 1.0)}, "^weights must"),
        ({"weights": 1.0}, "^weights must"),
    ],
)
def test_invalid_argument_raises(changes: dict, words: str) -> None:
    arguments = {"band": relax(one()), **changes}
    with pytest.raises(InputError, match=words):
        smooth_band(arguments.pop("band"), **arguments)


def test_smoothing_a_batch_raises() -> None:
    many = relax_band(np.array([straight(), bend()]), vehicle=CAR)
    with pytest.raises(InputError, match=r"^band must be a single band"):
        smooth_band(many)


def test_infeasible_smoothing_message() -> None:
    result = smooth_band(relax(one(), side="left"), curvature_rate_limit=1e-9)
    assert result.status is Status.DEGRADED
    assert result.message.startswith("not smoothed (no band within these bounds); ")

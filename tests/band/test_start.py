"""Bands that begin off their route: tails of a band that is being driven."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cca_core.band import BandStiffness, relax_band, smooth_band
from cca_core.errors import InputError, Status
from cca_core.geometry import Boxes, boxes
from tests.support.band_scenes import CAR, assert_certified, bend, moving, on, relax, scene, straight


def tail(nodes: np.ndarray, obstacles: list[Boxes], k: int) -> tuple[np.ndarray, list[Boxes]]:
    """Nodes and moving obstacles from node k on."""
    fields = ("x", "y", "psi", "length", "width")
    later = [
        Boxes(*(getattr(o, f)[k:] if np.ndim(o.x) else getattr(o, f) for f in fields)) for o in obstacles
    ]
    return nodes[k:], later


@pytest.mark.parametrize("nodes", [straight(), bend(), bend(-120.0)])
@pytest.mark.parametrize("k", [1, 20, 45, 70, 75, 90, 130])
def test_tail_of_optimal_band_is_optimal(nodes: np.ndarray, k: int) -> None:
    case = scene(nodes, [on(nodes, 75, 0.3), on(nodes, 110, 3.6)], curvature_limit=0.04)
    whole = relax(case, side="left")
    assert whole.ok
    part = relax_band(
        nodes[k:], case.obstacles, side="left", vehicle=CAR, curvature_limit=0.04,
        corridor=(case.corridor[0][k:], case.corridor[1][k:]), start=whole.displacement[k - 1 : k + 2],
    )  # fmt: skip
    assert part.ok
    np.testing.assert_allclose(part.displacement, whole.displacement[k:], atol=1e-7)
    assert part.residual < 1e-6


@example(d=-1.0, v=-1.0, met=73.6875, k=40, k_s=5e-5)
@example(d=0.0, v=-1.0, met=60.0, k=51, k_s=5e-5)  # first met between nodes
@given(
    d=st.floats(-1.0, 1.0), v=st.floats(-1.0, 0.6), met=st.floats(60.0, 100.0), k=st.integers(1, 120),
    k_s=st.sampled_from([0.0, 5e-5, 1e-2]),
)  # fmt: skip
def test_tail_is_optimal_past_moving_obstacle(d: float, v: float, met: float, k: int, k_s: float) -> None:
    nodes, stiffness = straight(), BandStiffness(k_s=k_s)
    car = moving(nodes, met, (80.0, d), (v, 0.0), psi=0.0)
    whole = relax_band(nodes, [car], side="left", vehicle=CAR, stiffness=stiffness)
    left, later = tail(nodes, [car], k)
    part = relax_band(
        left, later, side="left", vehicle=CAR, stiffness=stiffness, start=whole.displacement[k - 1 : k + 2]
    )
    if whole.n_solves == part.n_solves == 1 or (whole.ok and part.ok):
        assert np.abs(part.displacement - whole.displacement[k:]).max() < 0.03


def test_start_fixes_position_heading_and_curvature() -> None:
    nodes = bend(300.0)
    start = np.array([1.0, 1.08, 1.17])
    band = relax_band(nodes, [on(nodes, 60, 0.0)], side="left", vehicle=CAR, start=start)
    assert band.displacement[:2] == pytest.approx(start[1:], abs=1e-12)
    path = band.path()
    _, first, second = (row[0] for row in path.derivatives(np.zeros(1)))
    route = np.diff(nodes[:2], axis=0)[0]
    turn = np.arctan2(first[1], first[0]) - np.arctan2(route[1], route[0])
    assert turn == pytest.approx(0.085, abs=0.01)
    kappa = (first[0] * second[1] - first[1] * second[0]) / np.hypot(*first) ** 3
    assert kappa == pytest.approx(1 / 300.0 + 0.01, abs=5e-4)


@pytest.mark.parametrize("radius", [60.0, -100.0, 400.0])
@pytest.mark.parametrize("k", [30, 55, 75])
def test_tail_on_curve_has_curve_of_whole_band(radius: float, k: int) -> None:
    nodes = bend(radius)
    whole = relax_band(nodes, [on(nodes, 75, 0.0)], side="left", vehicle=CAR)
    part = relax_band(
        nodes[k:], [on(nodes, 75, 0.0)], side="left", vehicle=CAR, start=whole.displacement[k - 1 : k + 2]
    )
    np.testing.assert_allclose(part.nodes[0], whole.nodes[k], atol=2e-4)
    before, after = whole.path(), part.path()
    s, _ = before.project(part.nodes[:6])
    s_1, _ = after.project(part.nodes[:6])
    bent = before.curvature(s)
    assert np.abs(after.curvature(s_1) - bent).max() < 0.02 * np.abs(bent).max()
    assert np.abs(after.heading(s_1) - before.heading(s)).max() < 1e-3


def test_long_bands_are_accurate() -> None:
    """Without tension it is the quintic lane change."""
    nodes = straight(1000.0)
    stiffness = BandStiffness(k_s=0.0)
    band = relax_band(nodes, vehicle=CAR, stiffness=stiffness, start=(3.0, 3.0, 3.0))
    x = np.clip((nodes[:, 0] - 0.5) / 999.0, 0.0, 1.0)
    np.testing.assert_allclose(
        band.displacement, 3.0 * (1.0 - x**3 * (10.0 - 15.0 * x + 6.0 * x * x)), atol=5e-3
    )
    with pytest.raises(InputError, match="nodes must be fewer"):
        relax_band(straight(3000.0), vehicle=CAR, stiffness=stiffness, start=(3.0, 3.0, 3.0))


def test_start_without_obstacles_returns_to_route() -> None:
    band = relax_band(straight(), vehicle=CAR, start=(3.0, 3.0, 3.0))
    assert band.ok
    assert band.n_solves == 1
    assert band.displacement[0] == 3.0
    assert band.displacement[-1] == 0.0
    assert np.abs(band.displacement).max() < 3.01
    assert band.clearance == np.inf


def test_start_is_mirror_invariant() -> None:
    left = relax_band(
        straight(), [boxes(60.0, 0.2, 0.0, 4.5, 1.8)], side="left", vehicle=CAR, start=(0.5, 0.6, 0.7)
    )
    right = relax_band(
        straight(), [boxes(60.0, -0.2, 0.0, 4.5, 1.8)], side="right", vehicle=CAR, start=(-0.5, -0.6, -0.7)
    )
    np.testing.assert_allclose(right.displacement, -left.displacement, atol=1e-12)


def test_sides_depend_on_start() -> None:
    """A band that begins on the right passes there, although left is shorter from the route."""
    car = boxes(40.0, -0.2, 0.0, 4.5, 1.8)
    assert relax_band(straight(), [car], vehicle=CAR).sides == ("left",)
    assert relax_band(straight(), [car], vehicle=CAR, start=(-2.5, -2.5, -2.5)).sides == ("right",)


@pytest.mark.parametrize("side", ["left", "right"])
def test_band_with_start_is_certified(side: str) -> None:
    case = scene(straight(), [boxes(60.0, 0.0, 0.2, 4.5, 1.8), boxes(90.0, 3.6, 0.0, 4.5, 1.8)])
    sign = 1.0 if side == "left" else -1.0
    assert_certified(relax(case, side=side, start=sign * np.array([0.2, 0.25, 0.3])), case)


def test_obstacle_at_start_is_reported() -> None:
    """The route is clear, the start is not; and vice versa."""
    adjacent = boxes(0.0, 3.0, 0.0, 4.5, 1.8)
    assert relax_band(straight(), [adjacent], side="right", vehicle=CAR).ok
    band = relax_band(straight(), [adjacent], side="right", vehicle=CAR, start=(1.0, 1.0, 1.0))
    assert band.status is Status.INFEASIBLE
    assert "obstacle 0, at a pinned end" in band.message
    on_route = boxes(0.0, 0.0, 0.0, 4.5, 1.8)
    assert not relax_band(straight(), [on_route], side="left", vehicle=CAR).ok
    assert relax_band(straight(), [on_route], side="left", vehicle=CAR, start=(3.0, 3.0, 3.0)).ok


def test_batch_of_starts_equals_single_bands() -> None:
    car, starts = (
        boxes(60.0, 0.0, 0.0, 4.5, 1.8),
        np.array([[0.0, 0.0, 0.0], [0.4, 0.5, 0.6], [3.0, 3.0, 3.0]]),
    )
    many = relax_band(np.stack([straight()] * 3), [car], side="left", vehicle=CAR, start=starts)
    for band, start in zip((many[i] for i in range(3)), starts, strict=True):
        alone = relax_band(straight(), [car], side="left", vehicle=CAR, start=start)
        np.testing.assert_array_equal(band.displacement, alone.displacement)


@pytest.mark.parametrize(
    "start",
    [(1.0, 2.0), "far out", (1.0, np.nan, 1.0), np.zeros((2, 3)), (1.0, np.inf, 0.0), (0.0, 0.0, 1e308)],
)
def test_bad_start_raises(start: object) -> None:
    with pytest.raises(InputError, match="start must"):
        relax_band(straight(), vehicle=CAR, start=start)  # type: ignore[arg-type]


def test_smoothing_of_band_with_start_raises() -> None:
    band = relax_band(straight(), vehicle=CAR, start=(1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="must begin on its route"):
        smooth_band(band)

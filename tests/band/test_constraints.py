"""Active constraint, reasons of infeasible bands, and moving lead vehicles."""

import math

import numpy as np
import pytest

from cca_core.errors import InfeasibleError, Status
from cca_core.geometry import Boxes, boxes
from tests.support.band_scenes import CAR, assert_certified, bend, moving, relax, scene, straight

CROSSWISE = boxes(75.0, 0.0, 0.0, 4.5, 1.8)


def test_active_constraint_is_nearest_obstacle() -> None:
    obstacles = [boxes(40.0, 9.0, 0.0, 4.5, 1.8), CROSSWISE, boxes(110.0, -9.0, 0.0, 4.5, 1.8)]
    band = relax(scene(straight(), obstacles))
    assert (band.active_constraint, band.active_obstacle) == ("obstacle 1", 1)
    assert relax(scene(straight(), obstacles[::-1][:2])).active_constraint == "obstacle 1"
    assert relax(scene(straight(), [CROSSWISE, *obstacles[::2]])).active_constraint == "obstacle 0"


def test_active_constraint_is_nearer_edge() -> None:
    body = 0.9 + 1.0 + CAR.width  # width that the body needs next to the obstacle
    for side, corridor in (("left", (-20.0, body + 0.2)), ("right", (-body - 0.2, 20.0))):
        band = relax(scene(straight(), [CROSSWISE], corridor=corridor), side=side)
        assert band.ok, band.message
        assert band.active_constraint in ("obstacle 0", f"{side} edge")
        assert band.edge_clearance < 0.25
    narrowed = np.where(np.abs(straight()[:, 0] - 75.0) < 5.0, 0.5, -20.0)
    band = relax(scene(straight(), [boxes(75.0, 9.0, 0.0, 4.5, 1.8)], corridor=(narrowed, 20.0)))
    assert band.ok, band.message
    assert (band.active_constraint, band.active_obstacle) == ("right edge", None)


def test_empty_interval_message_names_both_obstacles() -> None:
    edge = 0.9 + 1.0 + CAR.width - 0.05
    left = relax(scene(straight(), [CROSSWISE], corridor=(-20.0, edge)), side="left")
    assert (left.status, left.active_constraint) == (Status.INFEASIBLE, "obstacle 0")
    assert left.message.startswith("no space between obstacle 0 and the left edge")
    right = relax(scene(straight(), [CROSSWISE], corridor=(-edge, 20.0)), side="right")
    assert right.message.startswith("no space between the right edge and obstacle 0")
    both = [boxes(75.0, 1.5, 0.0, 4.5, 1.8), boxes(75.0, -1.5, 0.0, 4.5, 1.8)]
    gate = relax(scene(straight(), both), side=["right", "left"])
    assert gate.message.startswith("no space between obstacle 1 and obstacle 0")
    for band in (left, right, gate):
        with pytest.raises(InfeasibleError) as caught:
            band.require()
        assert caught.value.result is band
        assert str(caught.value) == band.message


def test_excess_curvature_message() -> None:
    free = relax(scene(straight(), [CROSSWISE]), side="left")
    tight = relax(scene(straight(), [CROSSWISE], curvature_limit=0.1 * free.curvature), side="left")
    assert tight.status is Status.INFEASIBLE
    assert "obstacle 0" in tight.message or tight.active_constraint == "curvature"
    road = relax(scene(bend(100.0), [], curvature_limit=0.009))
    assert (road.status, road.active_constraint) == (Status.INFEASIBLE, "curvature")
    assert road.message == "curvature is 0.0100 1/m (limit 0.0090 1/m)"


def test_curvature_limit_is_satisfied_if_feasible() -> None:
    free = relax(scene(straight(), [CROSSWISE]), side="left")
    for fraction in (1.01, 0.95, 0.9):
        case = scene(straight(), [CROSSWISE], curvature_limit=fraction * free.curvature)
        band = relax(case, side="left")
        assert band.ok, band.message
        assert band.curvature <= fraction * free.curvature
        assert_certified(band, case)


@pytest.mark.parametrize("x", [1.0, 149.0, -3.0])
def test_obstacle_on_fixed_end_is_infeasible(x: float) -> None:
    case = scene(straight(), [boxes(x, 0.0, 0.0, 4.5, 1.8)])
    band = relax(case)
    assert (band.status, band.active_constraint) == (Status.INFEASIBLE, "obstacle 0")
    assert band.clearance < 0.0
    assert_certified(band, case)


@pytest.mark.parametrize("x", [0.0, 3.0, 147.0, 150.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_obstacle_near_fixed_end(x: float, sign: float) -> None:
    """An obstacle at clearance leaves the route unchanged. A closer one is infeasible."""
    far = 1.0 + 0.9 + 0.5 * CAR.width
    clear = scene(straight(), [boxes(x, sign * (far + 0.05), 0.0, 4.5, 1.8)])
    band = relax(clear)
    assert band.ok, band.message
    np.testing.assert_array_equal(band.displacement, 0.0)
    near = scene(straight(), [boxes(x, sign * (far - 0.3), 0.0, 4.5, 1.8)])
    band = relax(near)
    assert (band.status, band.active_constraint) == (Status.INFEASIBLE, "obstacle 0")
    assert f"obstacle 0, at a pinned end, {band.clearance:.3f} m (limit 1.000 m)" in band.message
    assert_certified(band, near)


def test_obstacle_at_fixed_end_fails_without_search() -> None:
    """The other obstacle can be passed, but that takes a search."""
    blocked = scene(straight(), [boxes(x, 0.0, 0.0, 4.5, 1.8) for x in (75.0, 148.0)])
    band = relax(blocked)
    assert (band.status, band.active_constraint, band.n_solves) == (Status.INFEASIBLE, "obstacle 1", 1)
    assert "obstacle 1, at a pinned end" in band.message
    assert_certified(band, blocked)
    assert relax(scene(straight(), [boxes(75.0, 0.0, 0.0, 4.5, 1.8)])).ok


def test_pin_outside_edges_is_infeasible() -> None:
    band = relax(scene(straight(), [], corridor=(0.0, 20.0)))
    assert (band.status, band.active_constraint) == (Status.INFEASIBLE, "right edge")
    assert "right edge" in band.message
    assert -1.0 < band.edge_clearance < -0.8  # half the body at the pins


# --- lead vehicles ------------------------------------------------------------------------------------


def lead(route: np.ndarray, ratio: float, ahead: float = 30.0) -> Boxes:
    """Lead vehicle at a fraction of the ego's speed."""
    h = float(route[1, 0] - route[0, 0])
    return moving(route, 0.0, (ahead, 0.0), (ratio * h, 0.0))


def test_lead_is_passed_at_arrival_time() -> None:
    """At half the ego's speed and 30 m ahead: overtaken around s = 60, not at s = 30."""
    route = straight(200.0)
    case = scene(route, [lead(route, 0.5)])
    band = relax(case, side="left")
    assert band.ok, band.message
    assert 50.0 < np.argmax(band.displacement) < 75.0
    assert_certified(band, case)


@pytest.mark.parametrize("ratio", [0.8, 0.9, 0.95, 1.0])
def test_lead_almost_as_fast_is_infeasible(ratio: float) -> None:
    """The ego passes it beyond the end of the stretch, or never."""
    route = straight(150.0)
    case = scene(route, [lead(route, ratio)])
    band = relax(case)
    if 30.0 / (1.0 - ratio + 1e-12) > 150.0 + 30.0:
        # never reached within the stretch
        assert band.ok
    else:
        assert (band.status, band.active_constraint) == (Status.INFEASIBLE, "obstacle 0")
        assert "obstacle 0" in band.message
    assert_certified(band, case)
    assert np.abs(band.displacement).max() < 20.0


def test_vehicle_that_crosses_earlier_is_ignored() -> None:
    """A stationary vehicle at its present position would block the route."""
    route = straight()
    case = scene(route, [moving(route, 5.0, (75.0, 0.0), (0.0, 0.75))])
    band = relax(case)
    np.testing.assert_array_equal(band.displacement, 0.0)
    assert band.clearance > 10.0
    assert np.abs(relax(scene(route, [boxes(75.0, 0.0, math.pi / 2, 4.5, 1.8)])).displacement).max() > 3.0


def test_displacement_above_30_m_is_infeasible() -> None:
    """A box that stays alongside and drifts across displaces the band beyond any road."""
    route = straight(120.0, 2.0)
    for ratio, course in ((1.59, 0.82), (2.42, 1.16), (1.79, 0.99), (2.05, 1.05)):
        met = 30.4
        velocity = (2.0 * ratio * math.cos(course), 2.0 * ratio * math.sin(course))
        case = scene(
            route, [moving(route, met, (2.0 * met, 0.5), velocity)], clearance=0.5, corridor=(-1e3, 1e3),
            curvature_limit=1e3,
        )  # fmt: skip
        band = relax(case)
        assert np.isfinite(band.nodes).all()
        assert np.abs(band.displacement).max() > 30.0
        assert (band.status, band.active_constraint) == (Status.INFEASIBLE, "obstacle 0")
        assert band.message.endswith(" m (limit 30 m)")

"""Certified clearance against dense measurement by shapely."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cca_core.band import Band
from cca_core.errors import InfeasibleError, Status
from cca_core.geometry import boxes
from tests.support.band_cases import Case
from tests.support.band_cases import case as random_case
from tests.support.band_measure import remeasure
from tests.support.band_scenes import CAR, assert_certified, bend, moving, on, relax, scene, straight

NEAR = 1e-2  # above the clearance asked: such gaps do not limit the band [m]
EXACT = 5e-3  # error of the certificate, without the bulge of the band between nodes [m]

box = st.tuples(
    st.floats(45.0, 105.0),
    st.floats(-4.0, 4.0),
    st.floats(-3.2, 3.2),
    st.floats(0.3, 12.0),
    st.floats(0.3, 2.5),
)
sides = st.sampled_from([None, "left", "right"])
meshes = st.sampled_from([0.5, 1.0, 2.0])


def assert_tight(band: Band, case: Case) -> None:
    """A clearance that limits the band is close to the measured one."""
    if band.clearance > case.clearance + NEAR:
        return
    bulge = 0.125 * band.spacing**2 * band.curvature * (1.0 + 0.5 * case.vehicle.length * band.curvature)
    assert band.clearance >= remeasure(band.nodes, case) - EXACT - bulge


@given(box, sides, st.floats(0.0, 1.5), st.sampled_from([0.0, 1.2, -0.5]), meshes)
@example((76.0, 0.0, 0.0, 3.0, 1.0), None, 1.0, CAR.box_offset, 2.0)  # one end of an interval rises steeply
def test_one_obstacle_on_an_open_plane(
    obstacle: tuple, side: str | None, clearance: float, offset: float, h: float
) -> None:
    car = dataclasses.replace(CAR, box_offset=offset)
    case = scene(straight(h=h), [boxes(*obstacle)], clearance=clearance, vehicle=car)
    band = relax(case, side=side)
    assert_certified(band, case)
    assert_tight(band, case)
    assert band.status is Status.OK, band.message


@given(box, box, sides, st.floats(0.0, 1.5), st.sampled_from([20.0, 2.6, 6.0]), meshes)
def test_two_obstacles_in_a_corridor(
    one: tuple, two: tuple, side: str | None, clearance: float, edge: float, h: float
) -> None:
    case = scene(straight(h=h), [boxes(*one), boxes(*two)], clearance=clearance, corridor=(-edge, edge))
    band = relax(case, side=side)
    assert_certified(band, case)
    if not band.ok:
        with pytest.raises(InfeasibleError):
            band.require()


@pytest.mark.parametrize("seed", range(12))
def test_curved_route_with_a_coarse_mesh(seed: int) -> None:
    rng = np.random.default_rng(seed)
    route = bend(float(rng.choice([-1.0, 1.0])) * rng.uniform(40.0, 300.0), h=2.0)
    i, d, psi = int(rng.integers(25, 50)), rng.uniform(-3.0, 3.0), rng.uniform(-1.0, 1.0)
    case = scene(route, [on(route, i, d, psi, rng.uniform(0.3, 10.0))], clearance=0.5)
    band = relax(case, side=str(rng.choice(["left", "right"])))
    assert band.status is Status.OK, band.message
    assert_certified(band, case)
    assert_tight(band, case)


@pytest.mark.parametrize(("count", "number"), [(2, 137), (3, 81), (3, 197), (5, 129)])
def test_dip_within_part_of_a_step_is_certified(count: int, number: int) -> None:
    """A gap that falls steeply and then rises slowly, closest between two samples of a step."""
    case = random_case(np.random.default_rng([4, count, number]), count)
    assert_certified(relax(case), case)


@given(
    st.floats(0.0, 2.5),
    st.floats(-math.pi, math.pi),
    st.one_of(st.none(), st.floats(-math.pi, math.pi)),
    st.tuples(st.floats(-6.0, 6.0), st.floats(-6.0, 6.0)),
    st.floats(0.0, 1.0),
    st.floats(0.0, 1.0),
    meshes,
    sides,
)
def test_moving_obstacle(
    ratio: float,
    course: float,
    psi: float | None,
    offset: tuple[float, float],
    phase: float,
    clearance: float,
    h: float,
    side: str | None,
) -> None:
    """Any course and heading, as fast as the ego to 2.5 times as fast."""
    route = straight(120.0, h)
    velocity = (ratio * h * math.cos(course), ratio * h * math.sin(course))
    met = len(route) // 2 + phase
    o = moving(route, met, (met * h + offset[0], offset[1]), velocity, psi)
    case = scene(route, [o], clearance=clearance)
    assert_certified(relax(case, side=side), case)


@pytest.mark.parametrize("seed", range(4))
def test_turning_obstacle_is_certified(seed: int) -> None:
    """Cars and trucks on circles: a corner swings between nodes."""
    rng = np.random.default_rng([31, seed])
    for _ in range(25):
        h = float(rng.choice((0.5, 1.0, 2.0)))
        route = straight(120.0, h)
        radius, psi = float(rng.choice((-1.0, 1.0))) * rng.uniform(8.0, 60.0), rng.uniform(-math.pi, math.pi)
        at = (60.0 + rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0))
        travel = rng.uniform(0.0, 2.5) * h * (np.arange(len(route)) - len(route) // 2 - rng.random())
        heading = psi + travel / radius
        x = at[0] + radius * (np.sin(heading) - math.sin(psi))
        y = at[1] - radius * (np.cos(heading) - math.cos(psi))
        size = (np.full(len(route), side) for side in ((12.0, 2.5) if rng.random() < 0.3 else (4.5, 1.8)))
        case = scene(route, [boxes(x, y, heading, *size)], clearance=float(rng.choice((0.2, 0.5, 1.0))))
        assert_certified(relax(case), case)


@pytest.mark.parametrize("block", range(6))
def test_closest_between_nodes(block: int) -> None:
    """Fast crossing, diagonal and oncoming boxes, long trucks among them, on a coarse mesh."""
    rng = np.random.default_rng([30, block])
    for _ in range(50):
        h = float(rng.choice((1.0, 2.0)))
        route = straight(120.0, h)
        ratio, course = rng.uniform(0.3, 2.5), rng.uniform(-math.pi, math.pi)
        met = len(route) // 2 + rng.random()
        position = (met * h + rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0))
        psi = None if rng.random() < 0.5 else rng.uniform(-math.pi, math.pi)
        long, wide = (16.5, 2.55) if rng.random() < 0.3 else (4.5, 1.8)
        velocity = (ratio * h * math.cos(course), ratio * h * math.sin(course))
        o = moving(route, met, position, velocity, psi, long, wide)
        case = scene(route, [o], clearance=float(rng.choice((0.05, 0.2, 0.5, 1.0))), curvature_limit=0.2)
        assert_certified(relax(case), case)


@pytest.mark.parametrize("h", [1.0, 2.0])
@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 0.71])
def test_fast_oncoming_box_is_certified_between_nodes(h: float, phase: float) -> None:
    """A box across its course is 3 h closer at the next node: it may jump over the ego."""
    route = straight(120.0, h)
    met = len(route) // 2 + phase
    for lateral in np.arange(-2.0, 2.1, 0.5):
        o = moving(
            route, met, (met * h, lateral), (-2.0 * h, 0.05 * h), psi=math.pi / 2, length=1.8, width=0.5
        )
        case = scene(route, [o], clearance=0.2)
        assert_certified(relax(case), case)


@pytest.mark.parametrize("clearance", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("excess", [-0.015, 0.005])
def test_corner_gap_between_nodes_is_exact(clearance: float, excess: float) -> None:
    """Two corners are closest for a part of a step; their gap is known in closed form."""
    route = straight(120.0, 2.0)
    course = np.array((-2.0, 6.0)) / math.hypot(2.0, 6.0)  # of the box relative to the ego
    normal = np.array((course[1], -course[0]))
    corner = 0.5 * np.array((CAR.length + 1.0, CAR.width + 1.0))
    for phase in np.linspace(0.0, 1.0, 9):
        met = 30 + phase
        position = (2.0 * met, 0.0) + corner + (clearance + excess) * normal
        o = moving(route, met, tuple(position), (0.0, 6.0), psi=0.0, length=1.0, width=1.0)
        case = scene(route, [o], clearance=clearance)
        band = relax(case)
        assert_certified(band, case)
        assert np.abs(band.displacement).max() > 0.0 or band.clearance <= clearance + excess + 1e-9
        if excess < 0.0:
            assert np.abs(band.displacement).max() > 0.0 or not band.ok


@pytest.mark.parametrize("phase", [0.2, 0.5, 0.8])
def test_overlap_between_nodes_is_certified(phase: float) -> None:
    """A crossing box that runs into the ego between nodes, next to a pinned end."""
    route = straight(40.0, 2.0)
    met = 2 + phase
    o = moving(route, met, (2.0 * met, 0.0), (0.0, 6.0))
    case = scene(route, [o], clearance=0.2)
    band = relax(case)
    assert not band.ok
    assert_certified(band, case)


@pytest.mark.parametrize("length", [12.0, 16.5, 25.0])
@pytest.mark.parametrize("psi", [0.0, 0.3, -0.8, math.pi / 2])
def test_long_trucks(length: float, psi: float) -> None:
    """Of the obstacle and of the ego."""
    truck = dataclasses.replace(CAR, length=length, width=2.5, box_offset=0.2 * length)
    route = straight(240.0, 2.0)
    for case in (
        scene(route, [boxes(120.0, -1.0, psi, length, 2.5)], clearance=0.5),
        scene(route, [boxes(120.0, -1.0, psi, 4.5, 1.8)], clearance=0.5, vehicle=truck),
    ):
        band = relax(case)
        assert_certified(band, case)
        assert band.status is Status.OK, band.message


def test_distant_obstacle_has_lower_bound_only() -> None:
    case = scene(straight(), [boxes(75.0, 9.0, 0.0, 4.5, 1.8)])
    band = relax(case)
    assert band.ok
    assert 1.0 <= band.clearance <= 9.0 - 0.9 - 0.5 * CAR.width + 1e-9

"""Side assignment: given, chosen by energy and corridor, stable under replanning."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core.band import Band, band_energy
from cca_core.band.solver import measure
from cca_core.errors import InputError, Status
from cca_core.geometry import boxes
from tests.support.band_cases import Case
from tests.support.band_scenes import CAR, assert_certified, bend, moving, relax, scene, straight


def energy(band: Band) -> float:
    """Energy of the band between the bounds of its sides, before tightening."""
    found = measure(band.problem, passes_left=band.passes_left)
    return float(
        band_energy(
            band.displacement,
            lower=found.lower,
            upper=found.upper,
            spacing=band.spacing,
            stiffness=band.problem.stiffness,
        )
    )


def every_assignment(case: Case) -> list[Band]:
    return [
        relax(case, side=list(sides))
        for sides in itertools.product(("left", "right"), repeat=len(case.obstacles))
    ]


@pytest.mark.parametrize("d", [-1.5, -0.3, -0.01, 0.01, 0.3, 1.5])
def test_nearer_side_is_chosen(d: float) -> None:
    band = relax(scene(straight(), [boxes(75.0, d, 0.0, 4.5, 1.8)]))
    assert band.ok
    assert band.sides == (("left",) if d < 0.0 else ("right",))
    assert band.side == band.sides[0]


def test_left_is_chosen_of_two_equals() -> None:
    assert relax(scene(straight(), [boxes(75.0, 0.0, 0.0, 4.5, 1.8)])).sides == ("left",)


@pytest.mark.parametrize("d", [-0.5, 0.5])
def test_sides_allowed_by_corridor(d: float) -> None:
    """The costlier side if the cheaper one is closed."""
    o = [boxes(75.0, d, 0.0, 4.5, 1.8)]
    for corridor, expected in (((-20.0, 2.0), "right"), ((-2.0, 20.0), "left")):
        case = scene(straight(), o, corridor=corridor)
        band = relax(case)
        assert band.ok, band.message
        assert band.sides == (expected,)
        assert_certified(band, case)


def test_both_sides_blocked_is_infeasible() -> None:
    band = relax(scene(straight(), [boxes(75.0, 0.0, 0.0, 4.5, 1.8)], corridor=(-2.0, 2.0)))
    assert band.status is Status.INFEASIBLE
    assert band.active_constraint == "obstacle 0"
    assert "no space" in band.message


def test_sides_allowed_by_curvature_limit() -> None:
    """Two obstacles in close succession: no slalom above the curvature limit."""
    obstacles = [boxes(65.0, -1.0, 0.0, 4.5, 1.8), boxes(85.0, 1.0, 0.0, 4.5, 1.8)]
    free = relax(scene(straight(), obstacles, clearance=0.5))
    weave = relax(scene(straight(), obstacles, clearance=0.5), side=["left", "right"])
    around = relax(scene(straight(), obstacles, clearance=0.5), side="left")
    assert around.curvature < 0.7 * weave.curvature
    limit = 1.2 * around.curvature
    case = scene(straight(), obstacles, clearance=0.5, curvature_limit=limit)
    band = relax(case)
    assert band.ok, band.message
    assert band.sides in (("left", "left"), ("right", "right"))
    assert_certified(band, case)
    assert free.ok


@given(
    st.lists(
        st.tuples(st.floats(50.0, 170.0), st.floats(-3.0, 3.0), st.floats(-0.2, 0.2)), min_size=1, max_size=3
    ),
    st.sampled_from([3.5, 5.0, 20.0]),
)
def test_chosen_sides_have_minimal_energy(obstacle_poses: list, edge: float) -> None:
    obstacles = [boxes(x, d, psi, 4.5, 1.8) for x, d, psi in obstacle_poses]
    case = scene(straight(220.0), obstacles, clearance=0.5, corridor=(-edge, edge), curvature_limit=0.1)
    band = relax(case)
    feasible = [other for other in every_assignment(case) if other.ok]
    assert band.ok == bool(feasible), band.message
    if feasible:
        assert energy(band) <= 1.05 * min(energy(other) for other in feasible) + 1e-9


def test_slalom_passes_each_on_its_side() -> None:
    """A slalom, though every obstacle could be passed on one side."""
    obstacles = [boxes(x, 0.0, 0.0, 4.5, 1.8) for x in (70.0, 120.0, 170.0)]
    case = scene(straight(240.0), obstacles, clearance=0.5)
    for sides in itertools.product(("left", "right"), repeat=3):
        band = relax(case, side=list(sides))
        assert band.ok, band.message
        assert band.sides == sides
        for x, side in zip((70, 120, 170), sides, strict=True):
            need = 0.9 + 0.5 + 0.5 * CAR.width
            assert (1.0 if side == "left" else -1.0) * band.displacement[x] > need - 0.02
        assert_certified(band, case)


def test_obstacles_next_to_route_keep_their_side() -> None:
    """Obstacles at clearance from the route stay on their side."""
    route = straight(220.0)
    obstacles = [boxes(80.0, -4.0, 0.0, 4.5, 5.0), boxes(140.0, 4.0, 0.0, 4.5, 5.0)]
    band = relax(scene(route, obstacles, clearance=0.6), side="left")
    np.testing.assert_array_equal(band.displacement, 0.0)
    assert band.sides == ("left", "right")
    narrowed = scene(
        route, obstacles, clearance=0.6,
        corridor=(
            np.where(np.abs(route[:, 0] - 80.0) < 4.0, 0.2, -20.0),
            np.where(np.abs(route[:, 0] - 140.0) < 4.0, -0.2, 20.0),
        ),
    )  # fmt: skip
    band = relax(narrowed, side="left")
    assert band.displacement[80] > 1.0
    assert band.displacement[140] < -1.0
    assert band.ok, band.message
    assert_certified(band, narrowed)


@pytest.mark.parametrize(("side", "sign"), [("left", 1.0), ("right", -1.0)])
def test_blocking_obstacles_are_passed_on_given_side(side: str, sign: float) -> None:
    obstacles = [boxes(80.0, sign * -0.8, 0.0, 4.5, 1.8), boxes(140.0, sign * 0.5, 0.1, 4.5, 1.8)]
    case = scene(straight(220.0), obstacles, clearance=0.5)
    band = relax(case, side=side)
    assert band.sides == (side, side)
    assert band.ok, band.message
    assert sign * band.displacement[140] > 0.5 + 0.9 + 0.5 + 0.5 * CAR.width - 0.02
    assert_certified(band, case)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_sides_are_stable_under_replanning(sign: float) -> None:
    """Noise about the center does not change the side; a large offset does."""

    def case(d: float) -> Case:
        return scene(straight(), [boxes(75.0, sign * d, 0.0, 4.5, 1.8)])

    first = relax(case(-0.3))
    band, chosen = first, []
    for d in (0.05, -0.05, 0.1, 0.05, -0.1, 0.1):
        band = relax(case(d), previous=band)
        assert band.ok
        chosen.append(band.sides)
    assert set(chosen) == {first.sides}
    assert relax(case(0.1)).sides != first.sides  # without the previous band it changes
    assert relax(case(1.5), previous=band).sides != first.sides
    closed = scene(
        straight(),
        [boxes(75.0, sign * 0.05, 0.0, 4.5, 1.8)],
        corridor=(-20.0, 2.0) if sign > 0 else (-2.0, 20.0),
    )
    flipped = relax(closed, previous=band)
    assert flipped.ok
    assert flipped.sides != first.sides


def test_previous_band_of_other_obstacles_is_ignored() -> None:
    one = relax(scene(straight(), [boxes(75.0, 0.3, 0.0, 4.5, 1.8)]))
    two = scene(straight(), [boxes(75.0, -0.1, 0.0, 4.5, 1.8), boxes(110.0, -0.1, 0.0, 4.5, 1.8)])
    assert relax(two, previous=one).sides == relax(two).sides


def test_replanning_past_lead_is_steady() -> None:
    """At 10 Hz the side stays and d(s) changes by less than 5 cm a cycle."""
    speed, cycle = 15.0, 0.1
    route = straight(200.0)
    last: Band | None = None
    for k in range(60):
        t = k * cycle
        # a lead at a third of the speed, relative to the ego
        o = moving(route, speed * t, (60.0 + speed / 3.0 * t, 0.03 * math.sin(k)), (1.0 / 3.0, 0.0))
        band = relax(scene(route, [o]), previous=last)
        assert band.ok, band.message
        if last is not None:
            assert band.sides == last.sides
            assert np.abs(band.displacement - last.displacement).max() < 0.05
        last = band


@pytest.mark.parametrize("route", [straight(220.0), bend(200.0, 220.0)])
def test_six_obstacles(route: np.ndarray) -> None:
    rng = np.random.default_rng(8)
    indices = np.linspace(40, 180, 6).astype(int)
    normal = np.column_stack((-np.gradient(route[:, 1]), np.gradient(route[:, 0])))
    spots = route[indices] + rng.choice((-1.0, 1.0), 6)[:, None] * 1.5 * normal[indices]
    obstacles = [
        boxes(x, y, math.atan2(-normal[i, 0], normal[i, 1]), 4.5, 1.8)
        for i, (x, y) in zip(indices, spots, strict=True)
    ]
    case = scene(route, obstacles, clearance=0.3, curvature_limit=0.1)
    band = relax(case)
    assert band.ok, band.message
    assert_certified(band, case)


@pytest.mark.parametrize(
    "side", ["up", 1, ["left"], ["left", "up"], ("left", "right", "left"), [True, False]]
)
def test_invalid_side_raises(side: object) -> None:
    obstacles = [boxes(x, 0.0, 0.0, 4.5, 1.8) for x in (50.0, 100.0)]
    with pytest.raises(InputError, match=r"^side must be 'left', 'right' or a list of 2, one for each"):
        relax(scene(straight(), obstacles), side=side)

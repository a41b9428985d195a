"""Sides on which obstacles are passed: given, chosen by energy and corridor, kept from cycle to cycle."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core.band import Band, band_energy
from cca_core.errors import InputError, Status
from cca_core.geometry import boxes
from tests.support.band_cases import Case
from tests.support.band_scenes import CAR, assert_certified, bend, moving, relax, scene, straight


def energy(band: Band) -> float:
    """Energy of the band between the bounds that its sides ask for, before they were pushed."""
    lower, upper = (bound[0] for bound in band.problem.corridor.bounds(band.passes_left[:, None]))
    return float(
        band_energy(
            band.displacement,
            lower=lower,
            upper=upper,
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
def test_the_shorter_way_round(d: float) -> None:
    band = relax(scene(straight(), [boxes(75.0, d, 0.0, 4.5, 1.8)]))
    assert band.ok
    assert band.sides == (("left",) if d < 0.0 else ("right",))
    assert band.side == band.sides[0]


def test_left_of_two_equals() -> None:
    assert relax(scene(straight(), [boxes(75.0, 0.0, 0.0, 4.5, 1.8)])).sides == ("left",)


@pytest.mark.parametrize("d", [-0.5, 0.5])
def test_sides_allowed_by_corridor(d: float) -> None:
    """The dearer side where the cheaper one is closed."""
    o = [boxes(75.0, d, 0.0, 4.5, 1.8)]
    for corridor, expected in (((-20.0, 2.0), "right"), ((-2.0, 20.0), "left")):
        case = scene(straight(), o, corridor=corridor)
        band = relax(case)
        assert band.ok, band.message
        assert band.sides == (expected,)
        assert_certified(band, case)


def test_none_where_both_sides_are_closed() -> None:
    band = relax(scene(straight(), [boxes(75.0, 0.0, 0.0, 4.5, 1.8)], corridor=(-2.0, 2.0)))
    assert band.status is Status.INFEASIBLE
    assert band.active_constraint == "obstacle 0"
    assert "no room" in band.message


def test_what_the_curvature_limit_allows() -> None:
    """Two obstacles close behind each other: not in and out again where the car cannot turn so fast."""
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
def test_no_assignment_of_sides_that_keeps_everything_is_much_cheaper(places: list, edge: float) -> None:
    obstacles = [boxes(x, d, psi, 4.5, 1.8) for x, d, psi in places]
    case = scene(straight(220.0), obstacles, clearance=0.5, corridor=(-edge, edge), curvature_limit=0.1)
    band = relax(case)
    usable = [other for other in every_assignment(case) if other.ok]
    assert band.ok == bool(usable), band.message
    if usable:
        assert energy(band) <= 1.05 * min(energy(other) for other in usable) + 1e-9


def test_one_side_for_each_obstacle() -> None:
    """Slalom: in and out again, though every obstacle could be passed on one side."""
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


def test_one_side_for_all_moves_only_what_is_in_the_way() -> None:
    """Obstacles beside the route stay on the side on which they are."""
    route = straight(220.0)
    obstacles = [boxes(80.0, -4.0, 0.0, 4.5, 5.0), boxes(140.0, 4.0, 0.0, 4.5, 5.0)]
    band = relax(scene(route, obstacles, clearance=0.6), side="left")
    np.testing.assert_array_equal(band.displacement, 0.0)
    assert band.sides == ("left", "right")
    pushed = scene(
        route, obstacles, clearance=0.6,
        corridor=(
            np.where(np.abs(route[:, 0] - 80.0) < 4.0, 0.2, -20.0),
            np.where(np.abs(route[:, 0] - 140.0) < 4.0, -0.2, 20.0),
        ),
    )  # fmt: skip
    band = relax(pushed, side="left")
    assert band.displacement[80] > 1.0
    assert band.displacement[140] < -1.0
    assert band.ok, band.message
    assert_certified(band, pushed)


@pytest.mark.parametrize(("side", "sign"), [("left", 1.0), ("right", -1.0)])
def test_all_that_is_in_the_way_is_passed_on_the_given_side(side: str, sign: float) -> None:
    obstacles = [boxes(80.0, sign * -0.8, 0.0, 4.5, 1.8), boxes(140.0, sign * 0.5, 0.1, 4.5, 1.8)]
    case = scene(straight(220.0), obstacles, clearance=0.5)
    band = relax(case, side=side)
    assert band.sides == (side, side)
    assert band.ok, band.message
    assert sign * band.displacement[140] > 0.5 + 0.9 + 0.5 + 0.5 * CAR.width - 0.02
    assert_certified(band, case)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_sides_are_stable_under_replanning(sign: float) -> None:
    """What wobbles about the middle does not make the band flip; what moves far to one side does."""

    def case(d: float) -> Case:
        return scene(straight(), [boxes(75.0, sign * d, 0.0, 4.5, 1.8)])

    first = relax(case(-0.3))
    band, kept = first, []
    for d in (0.05, -0.05, 0.1, 0.05, -0.1, 0.1):
        band = relax(case(d), previous=band)
        assert band.ok
        kept.append(band.sides)
    assert set(kept) == {first.sides}
    assert relax(case(0.1)).sides != first.sides  # without the memory it would have flipped
    assert relax(case(1.5), previous=band).sides != first.sides
    closed = scene(
        straight(),
        [boxes(75.0, sign * 0.05, 0.0, 4.5, 1.8)],
        corridor=(-20.0, 2.0) if sign > 0 else (-2.0, 20.0),
    )
    flipped = relax(closed, previous=band)
    assert flipped.ok
    assert flipped.sides != first.sides


def test_previous_of_other_obstacles_is_not_used() -> None:
    one = relax(scene(straight(), [boxes(75.0, 0.3, 0.0, 4.5, 1.8)]))
    two = scene(straight(), [boxes(75.0, -0.1, 0.0, 4.5, 1.8), boxes(110.0, -0.1, 0.0, 4.5, 1.8)])
    assert relax(two, previous=one).sides == relax(two).sides


def test_replanning_past_one_obstacle_is_steady() -> None:
    """Constant world at 10 Hz: the side stays, and d(s) of the stretch moves by less than 5 cm a cycle."""
    speed, cycle = 15.0, 0.1
    route = straight(200.0)
    last: Band | None = None
    for k in range(60):
        t = k * cycle
        # a leader at a third of the speed, seen from where the ego is now
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
    places = np.linspace(40, 180, 6).astype(int)
    normal = np.column_stack((-np.gradient(route[:, 1]), np.gradient(route[:, 0])))
    spots = route[places] + rng.choice((-1.0, 1.0), 6)[:, None] * 1.5 * normal[places]
    obstacles = [
        boxes(x, y, math.atan2(-normal[i, 0], normal[i, 1]), 4.5, 1.8)
        for i, (x, y) in zip(places, spots, strict=True)
    ]
    case = scene(route, obstacles, clearance=0.3, curvature_limit=0.1)
    band = relax(case)
    assert band.ok, band.message
    assert_certified(band, case)


@pytest.mark.parametrize(
    "side", ["up", 1, ["left"], ["left", "up"], ("left", "right", "left"), [True, False]]
)
def test_bad_side(side: object) -> None:
    obstacles = [boxes(x, 0.0, 0.0, 4.5, 1.8) for x in (50.0, 100.0)]
    with pytest.raises(InputError, match=r"^side must be 'left', 'right' or a list of 2, one for each"):
        relax(scene(straight(), obstacles), side=side)

"""Bands around obstacles in plain scenes, and invalid arguments."""

import dataclasses
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from cca_core.band import BandSettings, BandStiffness, relax_band
from cca_core.errors import InputError, Status
from cca_core.geometry import Boxes, boxes
from tests.support.band_cases import Case
from tests.support.band_measure import peak_curvature
from tests.support.band_scenes import (
    CAR,
    SOFT,
    assert_certified,
    bend,
    dense_stiffness,
    on,
    relax,
    scene,
    straight,
)

GOOD = boxes(75.0, 0.0, 0.0, 4.5, 1.8)
each_side = pytest.mark.parametrize(("side", "sign"), [("left", 1.0), ("right", -1.0)])


# --- without blocking obstacles -----------------------------------------------------------------------


@pytest.mark.parametrize("route", [straight(), bend(), bend(-80.0)])
@pytest.mark.parametrize("side", [None, "left", "right", []])
def test_route_without_obstacles_is_unchanged(route: np.ndarray, side: object) -> None:
    band = relax_band(route, side=side, vehicle=CAR)  # type: ignore[arg-type]
    np.testing.assert_array_equal(band.nodes, route)
    np.testing.assert_array_equal(band.displacement, 0.0)
    assert band.status is Status.OK
    assert band.ok
    assert band.clearance == band.edge_clearance == math.inf
    assert band.active_constraint == ""
    assert band.sides == ()
    assert band.require() is band
    assert len(band) == len(route)


@pytest.mark.parametrize("d", [4.0, -4.0])
@pytest.mark.parametrize("side", [None, "left", "right"])
def test_distant_obstacle_leaves_route_unchanged(d: float, side: str | None) -> None:
    band = relax(scene(straight(), [boxes(75.0, d, 0.0, 4.5, 1.8)]), side=side)
    np.testing.assert_array_equal(band.displacement, 0.0)
    assert band.clearance == pytest.approx(4.0 - 0.9 - 0.5 * CAR.width, abs=1e-12)
    assert band.sides == ("right" if d > 0.0 else "left",)


def test_curvature_of_circle() -> None:
    assert relax(scene(bend(200.0), [])).curvature == pytest.approx(1 / 200.0, rel=1e-4)
    assert relax(scene(straight(), [])).curvature == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("h", [0.5, 1.0, 2.0])
def test_curvature_equals_that_of_path(h: float) -> None:
    for route in (straight(150.0, h), bend(100.0, 150.0, h)):
        band = relax(scene(route, [on(route, len(route) // 2, 0.2)]))
        assert band.curvature == pytest.approx(peak_curvature(band.nodes), rel=0.02)


def test_wide_corridor_equals_none() -> None:
    for side in ("left", None):
        wide, none = (
            relax_band(straight(), [GOOD], side=side, vehicle=CAR, corridor=corridor)  # type: ignore[arg-type]
            for corridor in ((-100.0, 100.0), None)
        )
        np.testing.assert_array_equal(wide.nodes, none.nodes)
        assert none.edge_clearance == math.inf


# --- one obstacle -------------------------------------------------------------------------------------


@pytest.mark.parametrize("route", [straight(), bend(), bend(-150.0)])
@each_side
@pytest.mark.parametrize("d", [0.0, 0.7, -0.7])
def test_blocking_obstacle_is_passed_on_given_side(
    route: np.ndarray, side: str, sign: float, d: float
) -> None:
    case = scene(route, [on(route, 75, d)])
    band = relax(case, side=side)
    need = sign * d + 0.9 + 1.0 + 0.5 * CAR.width
    assert band.status is Status.OK
    assert band.side == side
    assert sign * band.displacement[75] >= need - 0.02
    assert (sign * band.displacement).max() <= need + 0.5  # and little more
    assert_certified(band, case)


def test_constant_box_equals_box_per_node() -> None:
    route, o = straight(), boxes(70.0, 0.4, 0.1, 4.5, 1.8)
    full = Boxes(*(np.full(151, float(v)) for v in (o.x, o.y, o.psi, o.length, o.width)))
    a, b = (relax(scene(route, [each]), side="left") for each in (o, full))
    np.testing.assert_array_equal(a.displacement, b.displacement)


@pytest.mark.parametrize("lead", [0.0, 20.0])
def test_lead_distance_widens_the_displaced_stretch(lead: float) -> None:
    case = scene(straight(200.0), [boxes(110.0, 0.0, 0.0, 4.5, 1.8)])
    band = relax(case, side="left", lead_distance=lead)
    displaced_from = 110.0 - 2.25 - 0.5 * CAR.length - 1.0 - lead
    need = 0.9 + 1.0 + 0.5 * CAR.width
    assert band.displacement[math.ceil(displaced_from)] >= need - 0.1
    if lead:
        short = relax(case, side="left")
        assert short.displacement[math.ceil(displaced_from)] < need - 0.3
        np.testing.assert_allclose(band.displacement[130:], short.displacement[130:], atol=0.6)


# --- edges --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("route", [straight(), bend(60.0), bend(-60.0)])
@each_side
def test_edges_bound_the_corners_of_the_body(route: np.ndarray, side: str, sign: float) -> None:
    """Corners of a rotated body protrude: in a narrow corridor they limit the band."""
    need = 0.3 + 0.9 + 1.0 + CAR.width  # to the far side of the body
    for slack in (0.15, 0.3, 0.6):
        edges = (-20.0, need + slack) if sign > 0.0 else (-need - slack, 20.0)
        case = scene(route, [on(route, 75, 0.3 * sign)], corridor=edges)
        band = relax(case, side=side)
        assert_certified(band, case)
        if slack > 0.2:
            assert band.ok, band.message
            assert band.edge_clearance >= -1e-9


@pytest.mark.parametrize("seed", range(12))
def test_narrow_corridor_is_satisfied_or_infeasible(seed: int) -> None:
    rng = np.random.default_rng(seed)
    edge = rng.uniform(3.3, 3.8)  # the body needs up to 3.51 m, more where it rotates
    case = scene(
        straight(),
        [boxes(75.0, rng.uniform(-0.3, 0.0), 0.0, rng.uniform(2.0, 10.0), 1.8)],
        corridor=(-edge, edge),
    )
    band = relax(case, side="left")
    assert_certified(band, case)
    assert band.ok or edge < 3.51 + 0.25


def test_narrowing_edge_displaces_band() -> None:
    x = straight()[:, 0]
    right = np.interp(x, (60.0, 70.0, 80.0, 90.0), (-3.0, 0.0, 0.0, -3.0))
    case = scene(straight(), [], corridor=(right, 6.0))
    band = relax(case)
    assert band.ok, band.message
    assert band.displacement[75] >= 0.5 * CAR.width - 1e-9
    assert band.active_constraint == "right edge"
    assert_certified(band, case)


# --- forces -------------------------------------------------------------------------------------------


@each_side
def test_internal_forces_act_at_contacts_only(side: str, sign: float) -> None:
    route = straight()
    band = relax(scene(route, [boxes(75.0, 0.3, 0.1, 4.5, 1.8)]), side=side)
    forces = sign * dense_stiffness(SOFT, 1.0, len(route)) @ band.displacement[2:-2]
    reach = 0.5 * CAR.length + 1.0 + 0.5 * (4.5 + 1.8 * 0.1) + 0.1
    free = np.abs(route[2:-2, 0] - 75.0) > reach
    assert np.abs(forces[free]).max() < 1e-9
    assert forces[~free].min() > -1e-9
    assert forces[~free].max() > 1e-6


@pytest.mark.parametrize("stiffness", [SOFT, BandStiffness(k_s=1e-3, k_b=0.05, k_c=0.5, k_e=1e-2)])
def test_residual_of_equilibrium_is_zero(stiffness: BandStiffness) -> None:
    case = scene(straight(), [GOOD, boxes(110.0, 1.0, 0.1, 4.5, 1.8)])
    band = relax(case, side="left", stiffness=stiffness)
    assert band.ok, band.message
    assert band.residual < 1e-8
    assert 1 <= band.n_solves <= 60


def test_number_of_solves_is_small() -> None:
    solves = [
        relax(scene(straight(), [boxes(75.0, d, 0.1, 4.5, 1.8)])).n_solves for d in np.linspace(-2, 2, 21)
    ]
    assert np.median(solves) <= 12


def test_settings_limit_the_search() -> None:
    case = scene(straight(), [boxes(75.0, 0.3, 0.4, 4.5, 1.8)], curvature_limit=0.004)
    band, first, smooth = (
        relax(case, side="left", settings=settings)
        for settings in (None, BandSettings(max_tightenings=1), BandSettings(curvature_margin=0.02))
    )
    assert band.ok
    assert smooth.ok
    assert not first.ok
    assert first.n_solves < band.n_solves
    assert smooth.curvature < 0.995 * band.curvature


@pytest.mark.parametrize(
    "values",
    [
        {"max_free_sides": 17},
        {"max_solves": 0},
        {"max_stalls": 1.5},
        {"min_progress": 1.1},
        {"clearance_margin": -1.0},
    ],
)
def test_invalid_settings_raise(values: dict) -> None:
    with pytest.raises(InputError, match=next(iter(values))):
        BandSettings(**values)


def test_finite_limit_next_to_infinite_one() -> None:
    """A limit on a part of the route bounds the curvature there."""
    limit = np.full(151, math.inf)
    limit[:90] = 0.0028
    band = relax_band(straight(), [GOOD], side="left", vehicle=CAR, curvature_limit=limit)
    free = relax_band(straight(), [GOOD], side="left", vehicle=CAR)
    assert band.ok, band.message
    assert free.curvature > 0.003
    assert np.abs(np.diff(band.displacement, n=2))[:88].max() <= 0.0028
    assert np.isfinite(band.displacement).all()


HUGE = [1e9, 1e200, 1e308]


@pytest.mark.parametrize("start", [0.0, (0.5, 0.6, 0.7)])
@pytest.mark.parametrize(
    "changes",
    [
        {"corridor": (math.inf, math.inf)},
        {"corridor": (-math.inf, -math.inf)},
        *({"corridor": (huge, huge)} for huge in HUGE),
        *({"clearance": huge} for huge in HUGE),
        *({"lead_distance": huge} for huge in HUGE),
        *({"obstacles": [boxes(75.0, huge, 0.0, 4.5, 1.8)]} for huge in HUGE),
        *({"obstacles": [boxes(75.0, 0.0, huge, 4.5, 1.8)]} for huge in HUGE),
        *({"obstacles": [boxes(75.0, 0.0, 0.0, huge, huge)]} for huge in HUGE),
        *({"curvature_limit": tiny} for tiny in (1e-300, 1e-9)),
        {"stiffness": BandStiffness(k_s=1e-300, k_c=1e-320)},
        {"stiffness": BandStiffness(k_e=1e300)},
        {"stiffness": BandStiffness(k_s=1e300, k_c=0.0)},
    ],
)
@pytest.mark.parametrize("side", [None, "left"])
def test_extreme_arguments_give_finite_bands(changes: dict, side: object, start: object) -> None:
    band = relax_band(
        **{"nodes": straight(), "obstacles": [GOOD], "vehicle": CAR, "side": side, "start": start, **changes}
    )
    assert np.isfinite(band.nodes).all()
    assert np.isfinite(band.displacement).all()
    assert np.isfinite(band.moment_over_6).all()
    assert not math.isnan(band.clearance)
    if band.ok:
        assert band.clearance >= changes.get("clearance", 1.0) - 1e-9
        assert band.edge_clearance >= -1e-9


def test_huge_settings_are_no_limits() -> None:
    huge = BandSettings(max_solves=10**12, max_tightenings=10**12, max_certified_sides=10**12)
    case = scene(straight(), [boxes(75.0, 0.3, 0.4, 4.5, 1.8)], curvature_limit=0.004)
    band, plain = relax(case, settings=huge), relax(case)
    assert plain.ok
    np.testing.assert_array_equal(band.displacement, plain.displacement)


def test_number_of_solves_is_bounded() -> None:
    settings = BandSettings(max_tightenings=1000, max_stalls=1000, max_solves=100)
    solves = [
        relax(scene(straight(), [boxes(75.0, d, 0.3, 4.5, 1.8)], curvature_limit=0.003), settings=settings)
        for d in np.linspace(-1.5, 1.5, 15)
    ]
    assert max(band.n_solves for band in solves) <= 160


def test_settings_of_one_call_do_not_stay() -> None:
    """Calls one after the other, of one size, with all that a call may change."""
    problem = scene(straight(), [boxes(75.0, 0.2, 0.6, 4.5, 1.8)])
    truck = dataclasses.replace(CAR, length=9.0, width=2.5, box_offset=-0.3)
    settings = BandSettings(max_tightenings=1, clearance_margin=0.2)
    changes: list[dict] = [
        {}, {"clearance": 0.4}, {"vehicle": truck}, {"stiffness": BandStiffness(k_b=5.0)},
        {"settings": settings}, {"lead_distance": 9.0}, {"corridor": (-9.0, 9.0)}, {"start": 0.4},
        {"side": "left"},
    ]  # fmt: skip
    alone = []
    for each in changes:
        with ThreadPoolExecutor(1) as fresh:  # whose memory holds nothing
            alone.append(fresh.submit(relax, problem, **each).result().displacement.tolist())
    assert len({tuple(u) for u in alone}) >= len(changes) - 2  # most of them matter
    for first in range(len(changes)):
        for second in (first - 1, first, (first + 2) % len(changes)):
            relax(problem, **changes[first])
            assert relax(problem, **changes[second]).displacement.tolist() == alone[second]


def test_result_is_read_only_and_input_unchanged() -> None:
    route = straight()
    before = route.copy()
    band = relax_band(route, [GOOD], side="left", vehicle=CAR)
    np.testing.assert_array_equal(route, before)
    for array in (band.nodes, band.displacement, band.lower, band.upper, band.passes_left):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_repr() -> None:
    case: Case = scene(straight(), [GOOD])
    assert repr(relax(case, side="left")).startswith("Band(OK, 151 nodes, left by 2.")


# --- invalid arguments --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"nodes": []}, r"^nodes must have shape \(\.\.\., n, 2\)"),
        ({"nodes": np.zeros((0, 2))}, r"^nodes must have shape .* at least 5 nodes, had \(0, 2\)"),
        ({"nodes": straight()[:4]}, "^nodes must have shape .* at least 5 nodes"),
        ({"nodes": np.zeros((10, 3))}, r"^nodes must have shape \(\.\.\., n, 2\)"),
        ({"nodes": np.zeros((10, 2))}, "^nodes must"),
        ({"nodes": np.where(straight() == 7.0, math.nan, straight())}, "^nodes must be finite"),
        ({"nodes": np.repeat(straight(20.0), 2, axis=0)}, "^nodes must"),
        ({"nodes": np.insert(straight(20.0), 5, straight()[5], axis=0)}, "^nodes must"),
        ({"nodes": np.cumsum(np.ones((30, 2)) * np.r_[np.ones(15), 9 * np.ones(15)][:, None], axis=0)},
         "^nodes must be equally spaced"),
        ({"side": "up"}, "^side must be 'left', 'right' or a list of 1, one for each obstacle, was 'up'"),
        ({"side": ["left", "left"]}, "^side must"),
        ({"side": 1}, "^side must"),
        ({"clearance": -0.1}, r"^clearance must be at least 0, was -0\.1"),
        ({"clearance": math.nan}, "^clearance must be finite"),
        ({"clearance": math.inf}, "^clearance must be finite"),
        ({"curvature_limit": 0.0}, "^curvature_limit must be greater than 0"),
        ({"curvature_limit": math.nan}, "^curvature_limit must"),
        ({"curvature_limit": np.ones(7)}, "^curvature_limit must have shape"),
        ({"curvature_limit": "small"}, "^curvature_limit must"),
        ({"lead_distance": [1.0, 2.0]}, r"^lead_distance must have shape \(\) or \(1,\)"),
        ({"lead_distance": math.nan}, "^lead_distance must"),
        ({"lead_distance": "far"}, "^lead_distance must"),
        ({"lead_distance": [[1.0]]}, "^lead_distance must"),
        ({"lead_distance": -5.0}, "^lead_distance must"),
        ({"obstacles": [boxes(math.nan, 0.0, 0.0, 4.5, 1.8)]}, "^obstacles must be finite"),
        ({"obstacles": [boxes(75.0, 0.0, math.inf, 4.5, 1.8)]}, "^obstacles must be finite"),
        ({"obstacles": [boxes(np.zeros(7), 0.0, 0.0, 4.5, 1.8)]}, "^obstacles must have fields of real"),
        ({"obstacles": [boxes(75.0, 0.0, 0.0, -4.5, 1.8)]}, "^obstacles must"),
        ({"obstacles": [(75.0, 0.0)]}, "^obstacles must"),
        ({"obstacles": GOOD}, "^obstacles must be a list of Boxes, as made by cca_core.geometry.boxes, was"),
        ({"corridor": (1.0, math.nan)}, "^corridor must"),
        ({"corridor": (np.zeros(7), 2.0)}, r"^corridor must have edges .* had shape \(7,\)"),
        ({"corridor": (-2.0,)}, "^corridor must"),
        ({"corridor": (-2.0, 0.0, 2.0)}, "^corridor must"),
        ({"corridor": 2.0}, "^corridor must"),
        ({"corridor": (5.25, -1.75)}, "^corridor must be the right edge and then the left one"),
        ({"stiffness": 1.0}, "^stiffness must"),
        ({"previous": 1.0}, "^previous must"),
        ({"vehicle": None}, "^vehicle must"),
        ({"settings": 1}, "^settings must be BandSettings, was int"),
    ],
)  # fmt: skip
def test_invalid_argument_raises(changes: dict, words: str) -> None:
    good = {"nodes": straight(), "obstacles": [GOOD], "vehicle": CAR}
    with pytest.raises(InputError, match=words):
        relax_band(**{**good, **changes})

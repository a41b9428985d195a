"""Path: projection, its inverse, ends, mirror."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cca_core.errors import InputError
from cca_core.path import Lane, Path, Road, fit_path, interpolate_path


def road(sign: float = 1.0, turn: float = 0.0) -> Path:
    x = np.arange(0.0, 601.0, 10.0)
    y = sign * (25.0 * np.sin(x / 80.0) + 0.0005 * x**2)
    R = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    return fit_path(np.column_stack((x, y)) @ R, tolerance=0.05)


WINDING = road()
MIRRORED = road(-1.0)
LINE = Path([5.0, 15.0], [[[0, 0, 10, 0], [0, 0, 0, 0]]])
along = st.floats(0.0, WINDING.length)


@given(along, st.floats(-0.95, 0.95))
def test_round_trip_for_offsets_below_radius(s: float, share: float) -> None:
    """|d kappa| < 1 on the inner side; elsewhere up to 30 m."""
    kappa = float(WINDING.curvature(s))
    d = math.copysign(min(abs(share) / max(abs(kappa), 1e-9), 30.0), share)
    xy = WINDING.to_cartesian(s, d)
    found_s, found_d = WINDING.project(xy, s_guess=s + 0.5)
    assert float(found_s) == pytest.approx(s, abs=1e-6)
    assert float(found_d) == pytest.approx(d, abs=1e-6)


@given(along, st.floats(-10.0, 10.0))
def test_round_trip_without_guess_on_road(s: float, d: float) -> None:
    found_s, found_d = WINDING.project(WINDING.to_cartesian(s, d))
    assert float(found_s) == pytest.approx(s, abs=1e-6)
    assert float(found_d) == pytest.approx(d, abs=1e-6)


@given(st.floats(-60.0, 660.0), st.floats(-200.0, 400.0))
def test_projection_without_guess_finds_nearest_point(x: float, y: float) -> None:
    _, d = WINDING.project([x, y])
    dense = WINDING.position(np.linspace(-300.0, WINDING.length + 300.0, 24_001))
    nearest = float(np.hypot(dense[:, 0] - x, dense[:, 1] - y).min())
    assert abs(float(d)) <= nearest + 1e-3


@given(along, st.floats(-20.0, 20.0), st.floats(-3.0, 3.0))
def test_foot_point_equals_project(s: float, d: float, off: float) -> None:
    kappa = float(WINDING.curvature(s))
    d = max(min(d, 0.8 / max(abs(kappa), 1e-9)), -0.8 / max(abs(kappa), 1e-9))
    x, y = WINDING.to_cartesian(s, d).tolist()
    many = WINDING.project([x, y], s_guess=s + off)
    one = WINDING.foot_point(x, y, s + off)
    assert one[0] == pytest.approx(float(many[0]), abs=1e-8)
    assert one[1] == pytest.approx(float(many[1]), abs=1e-8)
    assert one[2] == pytest.approx(float(WINDING.heading(one[0])), abs=1e-12)
    assert one[3] == pytest.approx(float(WINDING.curvature(one[0])), abs=1e-12)
    assert one[3] == pytest.approx(WINDING.curvature_at(one[0]), abs=1e-15)


@given(st.floats(-100.0, 800.0))
def test_float_queries_equal_array_queries(s: float) -> None:
    assert WINDING.curvature_at(s) == pytest.approx(float(WINDING.curvature(s)), abs=1e-14)


def test_path_is_straight_beyond_its_ends() -> None:
    for end, outwards in ((WINDING.start, -1.0), (WINDING.end, 1.0)):
        unit = np.array([math.cos(WINDING.heading(end)), math.sin(WINDING.heading(end))])
        far = end + outwards * np.array([1e-3, 1.0, 50.0])
        speed = float(np.hypot(*WINDING.derivatives(end)[1]))
        assert speed == pytest.approx(1.0, abs=1e-3)
        expected = WINDING.position(end) + (far - end)[:, None] * unit
        np.testing.assert_allclose(WINDING.position(far), expected, rtol=0.0, atol=50 * 1e-3)
        np.testing.assert_allclose(WINDING.heading(far), WINDING.heading(end), rtol=0.0, atol=1e-12)
        np.testing.assert_array_equal(WINDING.curvature(far), 0.0)
        s, d = WINDING.project(WINDING.to_cartesian(far, 2.0))
        np.testing.assert_allclose(s, far, rtol=0.0, atol=1e-8)
        np.testing.assert_allclose(d, 2.0, rtol=0.0, atol=1e-9)


def test_line_equals_closed_form() -> None:
    assert (LINE.start, LINE.end, LINE.length) == (5.0, 15.0, 10.0)
    np.testing.assert_allclose(LINE.to_cartesian([5.0, 10.0, 25.0, 0.0], [1.0, -2.0, 0.0, 3.0]),
                               [[0.0, 1.0], [5.0, -2.0], [20.0, 0.0], [-5.0, 3.0]], atol=1e-14)  # fmt: skip
    s, d = LINE.project([[3.0, 4.0], [-7.0, -1.0], [30.0, 0.5]])
    np.testing.assert_allclose(s, [8.0, -2.0, 35.0], atol=1e-12)
    np.testing.assert_allclose(d, [4.0, -1.0, 0.5], atol=1e-12)


@pytest.mark.parametrize("radius", [30.0, -30.0])
def test_circle_equals_closed_form(radius: float) -> None:
    phi = np.linspace(0.0, 3.0, 301)
    nodes = np.column_stack((abs(radius) * np.sin(phi), radius * (1.0 - np.cos(phi))))
    path = interpolate_path(
        nodes,
        start_tangent=[1.0, 0.0],
        end_tangent=[math.cos(3.0), math.copysign(1.0, radius) * math.sin(3.0)],
    )
    for angle, r in ((0.5, 25.0), (1.5, 34.0), (2.5, 10.0)):
        xy = np.array([r * math.sin(angle), math.copysign(abs(radius) - r * math.cos(angle), radius)])
        s, d = path.project(xy)
        assert float(s) == pytest.approx(abs(radius) * angle, abs=5e-3)
        assert float(d) == pytest.approx(math.copysign(abs(radius) - r, radius * (abs(radius) - r)), abs=1e-4)
        assert float(path.curvature(s)) == pytest.approx(1.0 / radius, rel=1e-3)


@given(along, st.floats(-8.0, 8.0))
def test_mirrored_path_flips_d_only(s: float, d: float) -> None:
    xy = WINDING.to_cartesian(s, d)
    s0, d0 = WINDING.project(xy)
    s1, d1 = MIRRORED.project(xy * [1.0, -1.0])
    assert float(s1) == pytest.approx(float(s0), abs=1e-9)
    assert float(d1) == pytest.approx(-float(d0), abs=1e-9)
    assert float(MIRRORED.heading(s)) == pytest.approx(-float(WINDING.heading(s)), abs=1e-9)
    assert float(MIRRORED.curvature(s)) == pytest.approx(-float(WINDING.curvature(s)), abs=1e-9)


@settings(max_examples=10)
@given(st.floats(-3.0, 3.0))
def test_projection_is_rotation_invariant(turn: float) -> None:
    R = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    turned = road(turn=turn)
    xy = WINDING.to_cartesian(np.linspace(-20.0, 700.0, 60), 3.0)
    for here, there in zip(WINDING.project(xy), turned.project(xy @ R), strict=True):
        np.testing.assert_allclose(there, here, rtol=0.0, atol=1e-6)


def test_guess_selects_branch_of_self_crossing_road() -> None:
    phi = np.linspace(0.0, 2 * math.pi, 129)
    eight = interpolate_path(np.column_stack((100 * np.sin(phi), 50 * np.sin(2 * phi))))
    crossing = [0.2, 0.1]
    half = 0.5 * eight.length
    assert abs(float(eight.project(crossing, s_guess=1.0)[0])) < 5.0
    assert float(eight.project(crossing, s_guess=half + 1.0)[0]) == pytest.approx(half, abs=5.0)


def test_shapes_broadcast() -> None:
    s = np.linspace(0.0, 500.0, 6).reshape(2, 3)
    assert WINDING.position(s).shape == (2, 3, 2)
    assert WINDING.heading(s).shape == WINDING.curvature(s).shape == (2, 3)
    assert WINDING.to_cartesian(s, 1.0).shape == (2, 3, 2)
    assert WINDING.to_cartesian(100.0, [1.0, 2.0]).shape == (2, 2)
    found = WINDING.project(WINDING.to_cartesian(s, 1.0))
    assert found[0].shape == found[1].shape == (2, 3)
    s_guess = WINDING.project(WINDING.to_cartesian(s, 1.0), s_guess=s)
    np.testing.assert_allclose(s_guess[0], s, atol=1e-6)
    assert WINDING.project(np.zeros((0, 2)))[0].shape == (0,)
    assert WINDING.project([0.0, 0.0])[0].shape == ()


@pytest.mark.parametrize("spacing", [0.5, 1.0, 7.0, 1e4])
def test_sample_is_equidistant_within_spacing(spacing: float) -> None:
    nodes = WINDING.sample(spacing)
    np.testing.assert_allclose(nodes[[0, -1]], WINDING.position([WINDING.start, WINDING.end]), atol=1e-12)
    s, d = WINDING.project(nodes)
    np.testing.assert_allclose(d, 0.0, atol=1e-9)
    steps = np.diff(s)
    assert steps.max() <= spacing * (1 + 1e-6)
    assert steps.max() - steps.min() < 1e-6
    assert len(nodes) == max(2, math.ceil(WINDING.length / spacing) + 1)


def test_sample_adds_no_node_for_rounding() -> None:
    assert len(LINE.sample(1.0)) == 11
    assert len(LINE.sample(10.0 / 3.0)) == 4


def test_path_is_read_only_and_copies_arrays() -> None:
    coefficients = np.zeros((1, 2, 4))
    coefficients[0, 0, 2] = 10.0
    path = Path([0.0, 10.0], coefficients)
    coefficients[:] = 7.0
    np.testing.assert_allclose(path.position(5.0), [5.0, 0.0])
    with pytest.raises(ValueError, match="read-only"):
        path.coefficients[0, 0, 0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        path.breaks[0] = 1.0


@pytest.mark.parametrize(
    ("breaks", "coefficients"),
    [
        ([0.0], np.zeros((0, 2, 4))),
        ([0.0, 1.0], np.zeros((2, 2, 4))),
        ([0.0, 1.0], np.zeros((1, 4, 2))),
        ([0.0, 0.0], np.ones((1, 2, 4))),
        ([1.0, 0.0], np.ones((1, 2, 4))),
        ([0.0, math.nan], np.ones((1, 2, 4))),
        ([0.0, 1.0], np.full((1, 2, 4), math.nan)),
        (["a", "b"], np.ones((1, 2, 4))),
        ([0.0, 1.0], "abc"),
    ],
)
def test_invalid_path_raises(breaks: object, coefficients: object) -> None:
    with pytest.raises(InputError, match=r"breaks|coefficients"):
        Path(breaks, coefficients)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "xy", [5.0, [1.0, 2.0, 3.0], [[math.nan, 0.0]], [math.inf, 0.0], "ab", [[1.0], [1.0, 2.0]]]
)
def test_projection_of_invalid_points_raises(xy: object) -> None:
    with pytest.raises(InputError, match=r"^xy must"):
        WINDING.project(xy)  # type: ignore[arg-type]


@pytest.mark.parametrize("s_guess", [math.nan, math.inf, [1.0, 2.0, 3.0], "a"])
def test_invalid_guess_raises(s_guess: object) -> None:
    with pytest.raises(InputError, match=r"^s_guess must"):
        WINDING.project([[0.0, 0.0], [1.0, 0.0]], s_guess=s_guess)  # type: ignore[arg-type]


@pytest.mark.parametrize("spacing", [0.0, -1.0, math.nan, None])
def test_invalid_spacing_raises(spacing: object) -> None:
    with pytest.raises(InputError, match=r"^spacing must"):
        WINDING.sample(spacing)  # type: ignore[arg-type]


def test_queries_far_away_stay_finite() -> None:
    rng = np.random.default_rng(0)
    s, d = WINDING.project(rng.uniform(-1e5, 1e5, (200, 2)))
    assert np.isfinite(s).all()
    assert np.isfinite(d).all()


# --- lanes --------------------------------------------------------------------------------------------


def test_road_has_edges_and_lanes() -> None:
    left, own, right = Lane(d=3.6, width=3.7, direction=-1), Lane(d=0.0, width=3.5), Lane(d=-3.0, width=2.5)
    here = Road(LINE, lanes=[left, own, right], speed_limit=30.0)
    assert here.lanes == (right, own, left)
    assert here.ego_lane is own
    assert here.right_edge == pytest.approx(-4.25)
    assert here.left_edge == pytest.approx(3.6 + 1.85)
    assert here.lane_at(4.0) is left
    assert here.lane_at(-2.0) is right
    assert here.lane_at(9.0) is None
    assert (own.right, own.left) == (-1.75, 1.75)


def test_bare_road_is_one_lane() -> None:
    here = Road(LINE)
    assert (here.right_edge, here.left_edge) == (-1.75, 1.75)
    assert here.ego_lane.direction == 1


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"path": [[0.0, 0.0], [1.0, 0.0]]}, r"^path must be a Path, was list"),
        ({"lanes": []}, r"^lanes must"),
        ({"lanes": [Lane(d=3.5)]}, r"^lanes must"),
        ({"lanes": [Lane(d=0.0, direction=-1)]}, r"^lanes must"),
        ({"lanes": ["left"]}, r"^lanes must"),
        ({"lanes": Lane(d=0.0)}, r"^lanes must be a sequence of Lane, was Lane"),
        ({"speed_limit": 0.0}, r"^speed_limit must be greater than 0"),
        ({"speed_limit": -5.0}, r"^speed_limit must"),
        ({"speed_limit": math.nan}, r"^speed_limit must"),
    ],
)
def test_invalid_road_raises(changes: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Road(**{"path": LINE, **changes})


@pytest.mark.parametrize(
    ("changes", "words"),
    [({"d": math.nan}, "^d must"), ({"width": 0.0}, "^width must"), ({"width": -3.5}, "^width must"),
     ({"direction": 0}, "^direction must be 1 or -1, was 0"), ({"direction": None}, "^direction must")],
)  # fmt: skip
def test_invalid_lane_raises(changes: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        Lane(**{"d": 0.0, **changes})

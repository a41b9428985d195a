"""Shape of the band: mesh, offset of the obstacle, pins, rotation and mirror."""

import math

import numpy as np
import pytest

from cca_core.band import Band, BandStiffness, equilibrium
from cca_core.errors import InputError, Status
from cca_core.geometry import Boxes, boxes
from tests.support.band_scenes import CAR, bend, on, relax, scene, straight

MESHES = [0.25, 0.5, 1.0, 2.0]
ON_ROUTE = 5e-6  # what the curvature at a pin may differ from the route's [1/m]


def heading(nodes: np.ndarray) -> np.ndarray:
    return np.unwrap(np.arctan2(*np.diff(nodes, axis=0).T[::-1]))


# --- mesh ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("d", [0.0, -1.0, -1.5])
@pytest.mark.parametrize("shift", [0.0, 0.37])
@pytest.mark.parametrize("psi", [0.0, 0.05])
def test_peak_is_mesh_independent(d: float, shift: float, psi: float) -> None:
    peaks, midway = [], []
    for h in MESHES:
        route = straight(160.0, h)
        band = relax(scene(route, [boxes(80.0 + shift, d, psi, 4.5, 1.8)]), side="left")
        assert band.ok, band.message
        peaks.append(band.displacement.max())
        midway.append(np.interp(50.0, route[:, 0], band.displacement))
    assert max(peaks) <= 1.02 * min(peaks)
    assert midway == pytest.approx([midway[0]] * 4, rel=0.04)


@pytest.mark.parametrize("radius", [100.0, -150.0])
def test_peak_is_mesh_independent_on_curve(radius: float) -> None:
    peaks = []
    for h in MESHES:
        route = bend(radius, 160.0, h)
        band = relax(scene(route, [on(route, len(route) // 2, -0.4)]), side="left")
        assert band.ok, band.message
        peaks.append(band.displacement.max())
    assert max(peaks) <= 1.02 * min(peaks)


@pytest.mark.parametrize(("speed", "max_step"), [(0.0, 0.02), (0.6, 0.03)])
@pytest.mark.parametrize("lead", [0.0, 5.0])
def test_band_moves_continuously_with_obstacle(speed: float, max_step: float, lead: float) -> None:
    """An end of the overlap that passes a node does not make the band jump.

    At 0.6 of the ego's speed the ego is alongside over a stretch that moves 2.5 times as far as the obstacle.
    """
    route = straight(160.0)
    motion = speed * (route[:, 0] - 70.0)
    bands = []
    for x in np.arange(70.0, 72.5, 0.02):
        case = scene(route, [boxes(x + motion, np.zeros(161), 0.0, 4.5, 1.8)])
        bands.append(relax(case, side="left", lead_distance=lead).displacement)
    assert np.abs(np.diff(bands, axis=0)).max() < max_step


# --- offset of the obstacle ---------------------------------------------------------------------------

OFFSETS = np.linspace(-2.0, 2.0, 161)


@pytest.mark.parametrize("h", [0.5, 1.0, 2.0])
@pytest.mark.parametrize(("side", "sign"), [("left", 1.0), ("right", -1.0)])
def test_peak_grows_with_offset_toward_given_side(side: str, sign: float, h: float) -> None:
    """Steadily, without a dead zone or a jump at 0."""
    route = straight(150.0, h)
    bands = [relax(scene(route, [boxes(75.0, d, 0.0, 4.5, 1.8)]), side=side) for d in OFFSETS]
    assert all(band.ok for band in bands)
    peaks = np.array([(sign * band.displacement).max() for band in bands])
    if sign < 0.0:
        peaks = peaks[::-1]
    step = OFFSETS[1] - OFFSETS[0]
    assert (np.diff(peaks) > 0.5 * step).all()
    assert (np.diff(peaks) < 1.5 * step).all()
    assert peaks[80] == pytest.approx(0.9 + 1.0 + 0.5 * CAR.width, abs=0.06)


def test_peak_on_chosen_side_falls_with_offset() -> None:
    """Passed on the nearer side, always far enough: least where the obstacle is farthest off."""
    route = straight()
    bands = [relax(scene(route, [boxes(75.0, d, 0.0, 4.5, 1.8)])) for d in OFFSETS]
    assert all(band.ok for band in bands)
    assert [band.side for band in bands] == ["left" if d <= 0.0 else "right" for d in OFFSETS]
    peaks = np.array([np.abs(band.displacement).max() for band in bands])
    assert (np.diff(peaks[:81]) > 0.0).all()
    assert (np.diff(peaks[81:]) < 0.0).all()
    assert peaks.min() > 0.5
    np.testing.assert_allclose(peaks, peaks[::-1], rtol=0.0, atol=1e-9)


# --- pins ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "route",
    [
        straight(), bend(100.0), bend(-80.0), straight(80.0), bend(60.0, 80.0), straight(80.0, 0.5),
        straight(150.0, 0.25), straight(150.0, 0.5), bend(-100.0, 120.0, 0.5), straight(160.0, 2.0),
        bend(100.0, 160.0, 2.0), straight(300.0, 2.0),
    ],
)  # fmt: skip
@pytest.mark.parametrize("side", ["left", "right"])
def test_heading_and_curvature_are_continuous_at_pins(route: np.ndarray, side: str) -> None:
    """Measured on the curve that is driven, against the route's own at the pins."""
    band = relax(scene(route, [on(route, len(route) // 2, 0.3)]), side=side)
    assert band.ok, band.message
    pins = [0, 1, -2, -1]
    np.testing.assert_array_equal(band.displacement[pins], 0.0)
    np.testing.assert_allclose(band.nodes[pins], route[pins], rtol=0.0, atol=1e-12)
    path, own = band.path(), relax(scene(route, [])).path()
    for s, on_route in ((path.start, own.start), (path.end, own.end)):
        jump = math.degrees(float(path.heading(s) - own.heading(on_route)))
        assert abs(math.remainder(jump, 360.0)) < 0.05
    bent = path.curvature(path.breaks) - own.curvature(own.breaks)
    np.testing.assert_allclose(bent[[0, -1]], 0.0, rtol=0.0, atol=ON_ROUTE)
    steps = np.abs(np.diff(np.pad(bent, 1)))  # beyond the pins it is the route's
    assert steps[[0, -1]].max() <= steps[1:-1].max()
    assert steps.max() <= 1.5 * steps[2:-2].max() + ON_ROUTE  # nor does it spring up between two pinned nodes
    assert np.abs(np.degrees(heading(band.nodes) - heading(route))).max() > 1.0  # yet it swerves


@pytest.mark.parametrize("h", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("radius", [60.0, -100.0, 300.0])
def test_path_begins_and_ends_along_curved_route(radius: float, h: float) -> None:
    """Along the circle itself, not along the first chord of the nodes; no kink of curvature either."""
    route = bend(radius, 150.0, h)
    for obstacles in ([], [on(route, len(route) // 2, 0.3)]):
        band = relax(scene(route, obstacles))
        assert band.ok, band.message
        path = band.path()
        for s, expected in ((path.start, 0.0), (path.end, 150.0 / radius)):
            jump = math.degrees(math.remainder(float(path.heading(s)) - expected, 2.0 * math.pi))
            assert abs(jump) < 0.05
            assert float(path.curvature(s)) == pytest.approx(1.0 / radius, rel=1e-3)
        assert band.curvature == pytest.approx(np.abs(path.curvature(path.breaks)).max(), rel=0.02)


def test_pins_are_flat_in_slope_and_curvature() -> None:
    """u(h) ~ h^3 at a pin: displacement, heading change and curvature change are zero there."""
    first, bent = [], []
    for h in (1.0, 0.5):
        band = relax(scene(straight(150.0, h), [boxes(75.0, 0.0, 0.0, 4.5, 1.8)]), side="left")
        first.append(band.displacement[2])
        path = band.path()
        assert float(path.curvature(path.start)) == 0.0
        bent.append(float(path.curvature(path.breaks[1])))
    assert first[0] / first[1] == pytest.approx(8.0, rel=0.3)
    assert bent[0] / bent[1] == pytest.approx(2.0, rel=0.1)


# --- symmetry -----------------------------------------------------------------------------------------


def mirrored(o: Boxes) -> Boxes:
    return Boxes(o.x, -o.y, -o.psi, o.length, o.width)


def assert_mirrored(band: Band, other: Band) -> None:
    np.testing.assert_allclose(other.displacement, -band.displacement, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(other.nodes, band.nodes * [1.0, -1.0], rtol=0.0, atol=1e-9)
    assert other.clearance == pytest.approx(band.clearance, abs=1e-9)
    assert other.edge_clearance == pytest.approx(band.edge_clearance, abs=1e-9)
    assert other.curvature == pytest.approx(band.curvature, abs=1e-9)
    assert other.status is band.status
    names = {"left edge": "right edge", "right edge": "left edge"}
    assert other.active_constraint == names.get(band.active_constraint, band.active_constraint)


@pytest.mark.parametrize("h", MESHES)
@pytest.mark.parametrize("radius", [None, 150.0])
@pytest.mark.parametrize("share", [0.3, 0.5])
@pytest.mark.parametrize(("d", "status"), [(-0.3, Status.OK), (0.0, Status.OK), (1.2, Status.INFEASIBLE)])
def test_mirror_invariance(h: float, radius: float | None, share: float, d: float, status: Status) -> None:
    route = straight(h=h) if radius is None else bend(radius, h=h)
    o = on(route, round(share * (len(route) - 1)), d, 0.1)
    right, left = -2.5, np.linspace(3.8, 4.2, len(route))
    band = relax(scene(route, [o], corridor=(right, left)), side="left")
    flipped = scene(route * [1.0, -1.0], [mirrored(o)], corridor=(-left, -right))
    assert band.status is status
    assert (np.abs(band.displacement).max() > 0.5) == (status is Status.OK)
    assert_mirrored(band, relax(flipped, side="right"))


@pytest.mark.parametrize("d", [-1.1, -0.2, 0.3, 1.7])
def test_chosen_side_is_mirror_invariant(d: float) -> None:
    route = bend(200.0)
    obstacles = [on(route, 50, d, 0.1), on(route, 100, -0.7 * d, -0.05)]
    band = relax(scene(route, obstacles))
    assert band.ok, band.message
    other = relax(scene(route * [1.0, -1.0], [mirrored(o) for o in obstacles]))
    np.testing.assert_array_equal(other.passes_left, ~band.passes_left)
    assert_mirrored(band, other)


@pytest.mark.parametrize("radius", [None, 150.0])
@pytest.mark.parametrize("h", MESHES)
@pytest.mark.parametrize("turn", [0.7, 2.0, -1.3])
def test_rotation_invariance(radius: float | None, h: float, turn: float) -> None:
    route = straight(h=h) if radius is None else bend(radius, h=h)
    R = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    shift = np.array([300.0, -200.0])
    o = on(route, len(route) // 2, -0.8, 0.1)
    x, y = np.array([float(o.x), float(o.y)]) @ R + shift
    turned = boxes(x, y, o.psi + turn, o.length, o.width)
    here = relax(scene(route, [o]), side="left")
    there = relax(scene(route @ R + shift, [turned]), side="left")
    assert here.displacement.max() > 1.0
    np.testing.assert_allclose(there.displacement, here.displacement, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(there.nodes, here.nodes @ R + shift, rtol=0.0, atol=1e-9)
    assert there.clearance == pytest.approx(here.clearance, abs=1e-9)
    assert there.curvature == pytest.approx(here.curvature, abs=1e-9)


# --- meaning of the stiffness -------------------------------------------------------------------------


def test_curvature_rate_stiffness_gives_quintic() -> None:
    """k_c alone between a stretch held at 0 and one held at w: peak curvature 5.7735 w / L^2."""
    w, length, h = 3.5, 100.0, 0.5
    x = np.arange(0.0, 300.0 + h / 2, h)
    before, there = x <= 100.0, (x >= 100.0 + length) & (x <= 240.0)
    lower = np.select([before, there], [0.0, w], -np.inf)
    upper = np.select([before, there], [0.0, w], np.inf)
    stiff = BandStiffness(k_s=0.0, k_b=0.0, k_c=1.0, k_e=1e3)
    u, _, _ = equilibrium(stiff.stencil(h), stiff.k_e * h, lower, upper)
    part = (x >= 100.0) & (x <= 200.0)
    lam = (x[part] - 100.0) / length
    quintic = w * (10 * lam**3 - 15 * lam**4 + 6 * lam**5)
    np.testing.assert_allclose(u[part], quintic, rtol=0.0, atol=0.03)
    curvature = np.gradient(np.gradient(u, h), h)[part]
    assert np.abs(curvature).max() == pytest.approx(5.7735 * w / length**2, rel=0.05)


def test_tension_widens_the_deformed_span() -> None:
    route, o = straight(200.0), [boxes(100.0, 0.0, 0.0, 4.5, 1.8)]
    widths = [
        (
            relax(scene(route, o), side="left", stiffness=BandStiffness(k_s=k_s, k_e=1e-2)).displacement > 0.5
        ).sum()
        for k_s in (1e-2, 0.0)
    ]
    assert widths[0] > widths[1]


@pytest.mark.parametrize("start", [np.nan, np.inf, 1e17, "0", None])
def test_path_from_no_station_raises(start: object) -> None:
    with pytest.raises(InputError, match="start must be"):
        relax(scene(straight(160.0, 1.0), [])).path(start)


@pytest.mark.parametrize("turn", [0.3, 1.1, 2.0, -0.7])
@pytest.mark.parametrize("seed", range(6))
def test_parallel_box_next_to_turned_one_is_rotated(turn: float, seed: int) -> None:
    """The sense in which a parallel box is turned is that of a rounding error, and decides on nothing."""
    random, sine, cosine = np.random.default_rng(seed), math.sin(turn), math.cos(turn)
    route, matrix = straight(60.0, 1.0), np.array([[cosine, -sine], [sine, cosine]])
    given = [
        (random.uniform(20, 40), random.normal(0, 1), k * 1.1, random.uniform(3, 8), 1.8) for k in (0, 1)
    ]
    turned = [(cosine * x - sine * y, sine * x + cosine * y, psi + turn, a, b) for x, y, psi, a, b in given]
    one = relax(scene(route, [boxes(*box) for box in given]))
    other = relax(scene(route @ matrix.T, [boxes(*box) for box in turned]))
    assert one.status == other.status
    assert other.displacement == pytest.approx(one.displacement, abs=1e-6)

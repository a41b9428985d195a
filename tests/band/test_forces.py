"""Eq 8, and the corridor between obstacles in the frame of the nodes."""

import dataclasses
import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from cca_core.band import external_force, relax_band
from cca_core.band.solver import measure
from cca_core.errors import InputError
from cca_core.geometry import boxes
from cca_core.vehicle import VehicleParams

inside = st.floats(0.01, 3.99)
angle = st.floats(-math.pi, math.pi)
K_E, R_0 = 2.5, 4.0


def force(r: float, phi: float, obstacle: tuple[float, float] = (3.0, -2.0)) -> np.ndarray:
    node = np.array(obstacle) + r * np.array([math.cos(phi), math.sin(phi)])
    return external_force([node], obstacle, k_e=K_E, r_0=R_0)[0]


@given(inside, angle)
def test_eq_8_repels_with_k_e_times_shortfall(r: float, phi: float) -> None:
    F = force(r, phi)
    away = np.array([math.cos(phi), math.sin(phi)])
    assert F @ away == pytest.approx(K_E * (R_0 - r), abs=1e-9)  # repulsion, closed form
    assert abs(F[0] * away[1] - F[1] * away[0]) < 1e-9


@given(st.floats(1e-6, 1e3), angle)
def test_no_force_beyond_the_threshold(excess: float, phi: float) -> None:
    np.testing.assert_array_equal(force(R_0 + excess, phi), [0.0, 0.0])


@given(angle, st.floats(1e-9, 1e-3))
def test_force_is_continuous_at_threshold(phi: float, step: float) -> None:
    assert np.hypot(*force(R_0 - step, phi)) == pytest.approx(K_E * step, abs=1e-12 + 1e-6 * step)
    assert np.hypot(*force(R_0, phi)) < 1e-12


def test_printed_form() -> None:
    rng = np.random.default_rng(0)
    nodes, obstacle = rng.uniform(-3.0, 3.0, (40, 2)), np.array([0.2, 0.1])
    F = external_force(nodes, obstacle, k_e=K_E, r_0=R_0)
    for node, found in zip(nodes, F, strict=True):
        r = node - obstacle
        norm = math.sqrt(r @ r)
        expected = -K_E * (norm - R_0) * r / norm if norm <= R_0 else np.zeros(2)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12)
    assert (np.hypot(*F.T) > 0.0).any()
    assert (np.hypot(*F.T) == 0.0).any()


def test_node_on_the_obstacle_gets_no_force() -> None:
    np.testing.assert_array_equal(external_force([[1.0, 2.0]], [1.0, 2.0], k_e=1.0, r_0=3.0), [[0.0, 0.0]])


def test_zero_stiffness_and_zero_threshold() -> None:
    nodes = [[1.0, 2.0], [0.0, 0.5]]
    np.testing.assert_array_equal(external_force(nodes, [0.0, 0.0], k_e=0.0, r_0=3.0), np.zeros((2, 2)))
    np.testing.assert_array_equal(external_force(nodes, [0.0, 0.0], k_e=1.0, r_0=0.0), np.zeros((2, 2)))


@given(inside, angle, angle)
def test_rotation_and_mirror(r: float, phi: float, turn: float) -> None:
    c, s = math.cos(turn), math.sin(turn)
    R, shift = np.array([[c, s], [-s, c]]), np.array([1.0, 2.0])
    node, obstacle = np.array([[r * math.cos(phi), r * math.sin(phi)]]), np.array([0.0, 0.0])
    F = external_force(node + shift, obstacle + shift, k_e=K_E, r_0=R_0)
    turned = external_force((node + shift) @ R, (obstacle + shift) @ R, k_e=K_E, r_0=R_0)
    np.testing.assert_allclose(turned, F @ R, rtol=0.0, atol=1e-9)
    flip = np.array([1.0, -1.0])
    mirrored = external_force((node + shift) * flip, (obstacle + shift) * flip, k_e=K_E, r_0=R_0)
    np.testing.assert_allclose(mirrored, F * flip, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"nodes": []}, "^nodes must have shape"),
        ({"nodes": np.zeros((0, 2))}, "^nodes must have at least 1"),
        ({"nodes": [[0.0, math.nan]]}, "^nodes must be finite"),
        ({"obstacle": [0.0]}, "^obstacle must have shape"),
        ({"obstacle": [0.0, math.inf]}, "^obstacle must be finite"),
        ({"k_e": -1.0}, "^k_e must be at least 0"),
        ({"r_0": -1.0}, "^r_0 must be at least 0"),
        ({"r_0": math.nan}, "^r_0 must be finite"),
    ],
)
def test_invalid_argument_raises(changes: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        external_force(**{"nodes": [[0.0, 1.0]], "obstacle": [0.0, 0.0], "k_e": 1.0, "r_0": 4.0, **changes})


@pytest.mark.parametrize("lead", [0.0, 1.7])
@given(
    st.floats(-20.0, 20.0), st.floats(-6.0, 6.0), angle, st.floats(0.5, 10.0), st.floats(0.5, 3.0), angle,
    st.floats(0.0, 2.0),
)  # fmt: skip
def test_corridor_equals_polygon_intersection(
    lead: float, x: float, y: float, psi: float, length: float, width: float, heading: float, clearance: float
) -> None:
    """By shapely: the part of the inflated obstacle alongside the ego."""
    car = dataclasses.replace(VehicleParams.bmw_320i(), box_offset=0.4)
    unit = complex(math.cos(heading), math.sin(heading))
    route = (2.0 + 1.0j) + unit * 1e-3 * np.arange(5)  # so short that all nodes see the same
    band = relax_band(
        np.column_stack((route.real, route.imag)), [boxes(x, y, psi, length, width)], side="left",
        vehicle=car, clearance=clearance, lead_distance=lead,
    )  # fmt: skip
    found = measure(band.problem)
    grown = boxes(x, y, psi, length + 2.0 * clearance, width + 2.0 * clearance).corners()
    local = ((grown @ np.array((1.0, 1.0j))) - route[2]) * unit.conjugate() - car.box_offset
    box = shapely.Polygon(np.column_stack((local.real, local.imag)))
    reach = 0.5 * car.length
    strip = shapely.box(-reach, -100.0, reach + lead, 100.0)
    part = box.intersection(strip)
    right, left = float(found.passing_right[0, 2]), float(found.passing_left[0, 2])
    margin = min(abs(local.real.min() - reach - lead), abs(local.real.max() + reach))
    if margin > 2e-3:
        assert math.isfinite(right) == math.isfinite(left) == (not part.is_empty)
    if not part.is_empty and part.area > 1e-9:
        lowest, highest = part.bounds[1] - 0.5 * car.width, part.bounds[3] + 0.5 * car.width
        # the range covers the part alongside the ego, and little more
        assert right <= lowest + 1e-9
        assert left >= highest - 1e-9
        turned = abs(math.sin(psi - heading))
        slack = 1e-9 if 0.03 < turned < 0.999 else 0.02 * (length + width + 4.0 * clearance)
        assert right >= lowest - slack
        assert left <= highest + slack

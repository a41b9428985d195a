"""Committed part of a maneuver and its clearance relaxation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core.geometry import Boxes, box_gap, boxes
from cca_core.planner.committed import (
    committed_nodes,
    first_replannable_node,
    relax_clearance,
    resample_displacement,
)
from cca_core.planner.maneuver_tuning import ReplanSettings

SETTINGS = ReplanSettings()
N = 101
S = np.linspace(0.0, 100.0, N)
T = S / 20.0


def ego(d: float, m: int) -> Boxes:
    return boxes(S[:m], np.full(m, d), np.zeros(m), np.full(m, 4.5), np.full(m, 1.8))


def alongside(d: float) -> Boxes:
    """A vehicle as fast as the ego."""
    return boxes(S, np.full(N, d), np.zeros(N), np.full(N, 4.5), np.full(N, 1.8))


@given(d=st.floats(2.15, 6.0))
def test_relaxation_equals_missing_clearance_and_decays(d: float) -> None:
    m = committed_nodes(T, SETTINGS)
    box = relax_clearance(alongside(d), ego(0.0, m), T, 1.0, SETTINGS)
    gap = box_gap(ego(0.0, N), box)
    assert gap[:m].min() >= 1.0
    regained = T > 2.5
    np.testing.assert_array_equal(box.width[regained], 1.8)
    assert (np.diff(box.width) >= -1e-12).all()
    if d - 1.8 >= 1.05:
        assert box.width is alongside(d).width or (box.width == 1.8).all()


def test_relaxation_never_below_minimum_clearance() -> None:
    box = relax_clearance(alongside(1.3), ego(0.0, 4), T, 1.0, SETTINGS)
    assert box.width[0] == pytest.approx(1.8 - 2.0 * 0.75)
    assert box_gap(ego(0.0, N), box)[:4].min() < 1.0
    narrow = relax_clearance(alongside(1.3), ego(0.0, 4), T, 0.3, SETTINGS)
    assert box_gap(ego(0.0, N), narrow)[:4].min() >= 0.3
    assert narrow.width[-1] == box.width[-1] == 1.8


def test_relaxed_boxes_have_nonnegative_size() -> None:
    thin = boxes(S, np.full(N, 1.0), np.zeros(N), np.full(N, 0.4), np.full(N, 0.2))
    box = relax_clearance(thin, ego(0.0, 4), T, 0.3, SETTINGS)
    assert box.width.min() == box.length.min() == 0.0


def test_relaxation_lasts_over_committed_nodes_at_low_speed() -> None:
    slow = S / 2.0
    box = relax_clearance(alongside(2.4), ego(0.0, 3), slow, 1.0, SETTINGS)
    assert box_gap(ego(0.0, N), box)[:3].min() >= 1.0


@pytest.mark.parametrize(("here", "k"), [(-5.0, 1), (0.0, 1), (0.5, 1), (10.2, 11), (11.0, 11), (99.0, 95)])
def test_replanning_starts_at_first_node_ahead(here: float, k: int) -> None:
    assert first_replannable_node(S, here) == k


def test_committed_nodes_span_half_second_and_minimum_of_three() -> None:
    assert committed_nodes(T, SETTINGS) == 10
    assert committed_nodes(10.0 * S, SETTINGS) == 3


def test_resampling_at_same_stations_is_identity() -> None:
    u = np.sin(S)
    assert resample_displacement(S, S, u) is u


def test_resampling_preserves_curve() -> None:
    def bump(s: np.ndarray) -> np.ndarray:
        x = np.clip(s / 100.0, 0.0, 1.0)
        return 64.0 * 3.5 * x**3 * (1.0 - x) ** 3

    longer = np.linspace(0.0, 117.0, 120)
    resampled = resample_displacement(longer, S, bump(S))
    np.testing.assert_allclose(resampled, bump(longer), atol=1e-4)
    assert (resampled[longer > 100.0] == 0.0).all()
    h = longer[1]
    second_derivative = np.diff(resampled, 2) / h**2
    assert np.abs(second_derivative - np.diff(bump(longer), 2) / h**2).max() < 2e-4

"""Paths of arcs and lines between two poses, and curves replaced by them."""

import math

import numpy as np

from cca_core.path.dubins import WORDS, along_dubins, dubins_lengths
from cca_core.path.interpolate import interpolate_path
from cca_core.path.rounding import round_bends


def test_dubins_paths_join_poses_with_radius() -> None:
    rng = np.random.default_rng(0)
    first, last = (
        np.column_stack((rng.uniform(-20.0, 20.0, (200, 2)), rng.uniform(-3.0, 3.0, 200))) for _ in range(2)
    )
    lengths = dubins_lengths(first, last, 6.0)
    possible = np.isfinite(lengths).all(axis=2)
    assert (possible.sum(axis=1) >= 2).all()
    for word, turns in enumerate(WORDS):
        rows = np.flatnonzero(possible[:, word])
        taken = lengths[rows, word]
        at = taken.sum(axis=1)[:, None] * np.linspace(0.0, 1.0, 1001)
        xy = along_dubins(first[rows], np.tile(turns, (len(rows), 1)), taken, 6.0, at)
        np.testing.assert_allclose(xy[:, 0], first[rows, :2], rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(xy[:, -1], last[rows, :2], rtol=0.0, atol=1e-6)
        steps = np.diff(xy, axis=1)
        psi = np.arctan2(steps[..., 1], steps[..., 0])
        apart = at[:, 1]  # between two positions
        for end, pose in ((0, first), (-1, last)):
            off = (psi[:, end] - pose[rows, 2] + math.pi) % (2.0 * math.pi) - math.pi
            assert (np.abs(off) <= apart / 6.0).all()
        turn = np.abs((np.diff(psi, axis=1) + math.pi) % (2.0 * math.pi) - math.pi)
        assert (turn.max(axis=1) <= apart / 6.0 + 1e-3).all()


def test_only_sharp_curve_is_replaced() -> None:
    path = interpolate_path([*[(5.0 * i, 0.0) for i in range(20)], *[(95.0, 5.0 * i) for i in range(1, 20)]])
    xy = round_bends(path, 1.0 / 8.0, 10.0)
    on = path.sample(0.1)
    off = np.array([np.hypot(*(on - p).T).min() for p in xy])
    np.testing.assert_allclose(xy[[0, -1]], path.position([path.start, path.end]), atol=1e-9)
    assert off.max() <= 0.45 * 10.0
    assert off[np.hypot(*(xy - [95.0, 0.0]).T) > 30.0].max() <= 0.05

"""Paths of arcs and lines between two poses, and curves replaced by them."""

import math

import numpy as np
import pytest

from cca_core.path.dubins import dubins_paths
from cca_core.path.interpolate import interpolate_path
from cca_core.path.rounding import round_bends


@pytest.mark.parametrize("seed", range(20))
def test_dubins_paths_join_poses_with_radius(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, last = ((*rng.uniform(-20.0, 20.0, 2), rng.uniform(-3.0, 3.0)) for _ in range(2))
    paths = list(dubins_paths(first, last, 6.0, 0.1))
    assert len(paths) >= 2
    for xy in paths:
        steps = np.diff(xy, axis=0)
        psi = np.arctan2(steps[:, 1], steps[:, 0])
        np.testing.assert_allclose(xy[[0, -1]], [first[:2], last[:2]], rtol=0.0, atol=1e-6)
        assert abs(math.remainder(psi[0] - first[2], 2.0 * math.pi)) <= 0.02
        assert abs(math.remainder(psi[-1] - last[2], 2.0 * math.pi)) <= 0.02
        turn = np.abs((np.diff(psi) + math.pi) % (2.0 * math.pi) - math.pi)
        assert turn.max() <= 0.1 / 6.0 + 1e-3


def test_only_sharp_curve_is_replaced() -> None:
    path = interpolate_path([*[(5.0 * i, 0.0) for i in range(20)], *[(95.0, 5.0 * i) for i in range(1, 20)]])
    xy = round_bends(path, 1.0 / 8.0, 10.0)
    on = path.sample(0.1)
    off = np.array([np.hypot(*(on - p).T).min() for p in xy])
    np.testing.assert_allclose(xy[[0, -1]], path.position([path.start, path.end]), atol=1e-9)
    assert off.max() <= 0.45 * 10.0
    assert off[np.hypot(*(xy - [95.0, 0.0]).T) > 30.0].max() <= 0.05

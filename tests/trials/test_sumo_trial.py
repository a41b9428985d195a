"""Drives through SUMO's network of several edges; they need SUMO."""

from pathlib import Path

import numpy as np
import pytest


@pytest.mark.requires("libsumo")
def test_junction_is_passed_as_fast_as_by_sumo(tmp_path: Path) -> None:
    from tests.trials.sumo.episode import baseline, episode

    driven = episode("network", 2, tmp_path, 45.0)
    assert not driven["collided"]
    assert driven["v"] * 45.0 > 850.0  # the junction is 790 m ahead
    assert driven["v"] >= 0.95 * baseline("network", 2, tmp_path, 45.0)


@pytest.mark.slow
@pytest.mark.requires("libsumo")
def test_network_is_driven_as_fast_as_by_sumo(tmp_path: Path) -> None:
    from tests.trials.sumo.episode import baseline, episode

    speeds = []
    for seed in range(8):
        driven = episode("network", seed, tmp_path, 300.0)
        assert not driven["collided"]
        assert driven["minutes"] < 4.0  # the ego is at the end of its route
        speeds.append((driven["v"], baseline("network", seed, tmp_path, 300.0)))
    ego, sumo = np.mean(speeds, axis=0)
    assert ego >= 0.95 * sumo

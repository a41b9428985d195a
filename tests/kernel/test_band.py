"""Bands in the kernel: both forms give the same bits."""

import math
from typing import Any

import numpy as np
import pytest

from cca_core.band import BandSettings, BandStiffness
from cca_core.kernel.band_batch import measure_band, relax_bands
from cca_core.kernel.band_workspace import (
    CHEAPEST_SIDES,
    CODES,
    REALS,
    REALS_PER_NODE,
    BandBatch,
    BandWork,
    Equilibrium,
)
from cca_core.kernel.equilibrium_batch import find_equilibria
from tests.support.kernel_forms import FULL, QUICK, Filled, check_forms, needs_c

BANDS, MAX_OBSTACLES = 2, 4


def sample_problem(random: np.random.Generator) -> tuple[Any, ...]:
    """Arguments of the relaxation of two bands on curved routes among moving obstacles."""
    n, m = int(random.integers(5, 40)), int(random.integers(0, MAX_OBSTACLES))
    max_n, max_m = n + int(random.integers(0, 3)), m + 1
    h = random.uniform(0.5, 2.0)
    psi = random.uniform(-3.0, 3.0) + random.normal(0.0, 0.01, (BANDS, 1)) * h * np.arange(n)
    nodes = np.cumsum(h * np.stack((np.cos(psi), np.sin(psi)), axis=-1), axis=1)
    boxes = np.zeros((5, m, BANDS, n))
    for o in range(m):
        k, speed, off = int(random.integers(0, n)), random.choice((0.0, 0.3)), random.normal(0.0, 2.5)
        ahead = np.stack((np.cos(psi[:, k]), np.sin(psi[:, k])), axis=-1)
        moved = speed * h * (np.arange(n) - k)
        boxes[0, o] = nodes[:, k, 0, None] - off * ahead[:, 1, None] + moved * ahead[:, 0, None]
        boxes[1, o] = nodes[:, k, 1, None] + off * ahead[:, 0, None] + moved * ahead[:, 1, None]
        boxes[2, o] = psi[:, k, None] + random.choice((0.0, 0.2))
        boxes[3, o], boxes[4, o] = random.uniform(2.0, 9.0), random.uniform(1.5, 2.6)
    if m > 0 and random.random() < 0.1:
        boxes[:, random.integers(m), 0, random.integers(n)] = random.choice([math.nan, math.inf, -1.0, 0.0])
    edge = random.uniform(2.0, 9.0, (BANDS, 1)) + random.choice((0.0, 0.5)) * random.random((BANDS, n))
    start = random.normal(0.0, 0.5) + random.normal(0.0, 0.02, (BANDS, 3))
    limit = random.choice((0.02, 0.1, math.inf))
    wide = {"right_edge": -edge, "left_edge": edge, "curvature_limit": np.full((BANDS, n), limit)}
    given = {name: padded(value, (BANDS, max_n)) for name, value in wide.items()}
    given |= {
        "nodes": padded(nodes.reshape(BANDS, -1), (BANDS, 2 * max_n)),
        "boxes": padded(boxes.reshape(-1, n), (5 * max_m * BANDS, max_n)).reshape(-1),
        "start": start * random.choice((0.0, 1.0)), "lead_distance": np.full(max_m, 1.0),
        "former": random.integers(0, 2, max_m * BANDS), "passes_left": random.integers(0, 2, max_m * BANDS),
    }  # fmt: skip
    numbers = {
        "n": n, "m": m, "bands": BANDS, "side_rule": int(random.integers(0, CHEAPEST_SIDES + 1)),
        "has_edges": bool(random.random() < 0.7), "has_former": bool(random.random() < 0.5),
    }  # fmt: skip
    stiffness, settings = BandStiffness(), BandSettings()
    asked = {name: getattr(settings, name) for name in settings.__slots__ if name != "max_certified_sides"}
    asked |= {name: getattr(stiffness, name) for name in stiffness.__slots__}
    asked |= {"length": 4.5, "width": 1.6, "box_offset": 0.3, "clearance": 0.5, "max_displacement": 30.0}
    sizes = {"max_n": max_n, "max_m": max_m}
    return (
        Filled(BandBatch, {**sizes, "max_bands": BANDS}, {**given, **numbers}),
        Filled(BandWork, {**sizes, "max_certified": 4}, {**asked, "n_certified": 4}),
        Filled(Equilibrium, {"max_n": max_n}),
        BANDS, columns := REALS + REALS_PER_NODE * n, np.zeros(BANDS * columns),
        np.zeros(BANDS * CODES, dtype=np.int32),
    )  # fmt: skip


def sample_displacement(random: np.random.Generator) -> tuple[Any, ...]:
    """Arguments of the certificate of a displacement."""
    batch, work, equilibrium, _, columns, found, codes = sample_problem(random)
    u = random.normal(0.0, 1.0, batch.values["n"])
    return batch, work, equilibrium, len(u), u, columns, found[:columns], codes[:CODES]


def padded(values: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Values in the corner of a larger array that holds numbers which must not be read."""
    wide = np.full(shape, 1e9)
    wide[tuple(slice(0, n) for n in values.shape)] = values
    return wide


def sample_bounds(random: np.random.Generator) -> tuple[Any, ...]:
    """Arguments of equilibria between random bounds."""
    n, is_bounded = int(random.integers(5, 60)), bool(random.random() < 0.5)
    lower = np.where(random.random((BANDS, n)) < 0.3, random.normal(0.0, 1.0, (BANDS, n)), -math.inf)
    upper = np.where(random.random((BANDS, n)) < 0.3, lower + random.random((BANDS, n)), math.inf)
    stiffness = np.tile(random.choice((0.0, 1.0), 5) * random.random(5), (BANDS, 1))
    stiffness[:, 2:4] += 1e-3
    bound = np.full((BANDS, n), 0.1 * random.random())
    u = np.zeros((BANDS, n))
    solves, converged = np.zeros(BANDS, dtype=np.int32), np.zeros(BANDS, dtype=np.int32)
    given = BANDS, n, is_bounded, stiffness, lower, upper, -bound, bound, u, solves, converged
    return (Filled(Equilibrium, {"max_n": n}), *given)


@needs_c
@pytest.mark.parametrize("count", [QUICK // 4, pytest.param(FULL, marks=pytest.mark.slow)])
def test_band_in_c_equals_python(count: int) -> None:
    check_forms(relax_bands, sample_problem, count)
    check_forms(measure_band, sample_displacement, count)


@needs_c
@pytest.mark.parametrize("count", [QUICK // 10, pytest.param(FULL, marks=pytest.mark.slow)])
def test_equilibrium_in_c_equals_python(count: int) -> None:
    check_forms(find_equilibria, sample_bounds, count)

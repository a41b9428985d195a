"""Random curves for the kernel."""

import math

import numpy as np

from cca_core.kernel.curve import Curve, CurveSamples
from cca_core.path import Path
from tests.support.kernel_forms import Filled


def random_path(random: np.random.Generator) -> Path:
    """One to five cubics of 5 to 60 m that need not be continuous."""
    n = int(random.integers(1, 6))
    breaks = np.cumsum(random.uniform(5.0, 60.0, n + 1))
    coefficients = random.normal(0.0, 3.0, (n, 2, 4))
    coefficients[:, 0, 2] += np.diff(breaks)
    return Path(breaks, coefficients)


def random_curve(random: np.random.Generator) -> tuple[Path, Filled]:
    """A path and its workspace."""
    path = random_path(random)
    n = len(path.breaks) - 1
    powers = path.coefficients / np.diff(path.breaks)[:, None, None] ** np.array([3.0, 2.0, 1.0, 0.0])
    table = powers.transpose(0, 2, 1).reshape(n, 8)
    return path, Filled(Curve, {"segments": n}, {"breaks": path.breaks, "powers": table})


def random_samples(random: np.random.Generator, path: Path) -> Filled:
    """Samples of a path for the search of the nearest point."""
    n = int(random.integers(2, 40))
    s = np.linspace(path.start, path.end, n)
    x, y = path.position(s).T
    numbers = {"stride": math.isqrt(n), "max_gap": 1.5 * float(s[1] - s[0])}
    return Filled(CurveSamples, {"count": n}, {"s": s, "x": x, "y": y, **numbers})

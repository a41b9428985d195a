"""Path fitting."""

import logging
import math
import warnings
from collections.abc import Callable

import numpy as np

from cca_core import InfeasibleError, Path, Planner, Road, fit_path
from cca_core.path import clean_route
from tests.trials.driving import CAR
from tests.trials.faults.table import Check, Table, raised

TABLE = Table()
STATIONARY = np.array(
    [
        *[(0, 0), (-6.7, 0.8), (-6.1, 3.8), (-9, 4.7), (-0.6, -0.8), (8.8, -3.8), (12.9, -7.2), (16, -9.3)],
        *[(19.6, -11), (23.8, -11.4), (28.8, -10.2), (34.3, -8.5)],
    ]
)  # first fixes of a receiver that does not move yet [m]


class WarningRecorder(logging.Handler):
    """Records whether the library warns, in its log or by `warnings`."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.warned = False

    def emit(self, record: logging.LogRecord) -> None:
        """Record a line of the log."""
        self.warned = True

    def call(self, function: Callable):
        """Call a function; return its result and whether it warned."""
        logger = logging.getLogger("cca_core")
        logger.addHandler(self)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            result = function()
        logger.removeHandler(self)
        return result, self.warned or bool(caught)


def drivable(points: np.ndarray, limit: float, **settings) -> list[Check]:
    """Check that the path has no radius below the limit, is refused, or comes with a warning."""

    def fitted() -> Path:
        path = fit_path(clean_route(points).parts[0], **settings)
        Planner(CAR, Road(path, speed_limit=25.0), cruise_speed=20.0)
        return path

    try:
        path, warned = WarningRecorder().call(fitted)
    except InfeasibleError:
        return [("drivable or reported", True, "==", True)]
    radius = 1.0 / max(float(np.abs(path.curvature(np.arange(path.start, path.end, 0.1))).max()), 1e-9)
    return [
        ("min radius", radius, ">=", 0.0),
        ("drivable or reported", radius >= limit or warned, "==", True),
    ]


def winding(n: int, spacing: float, radius: float, seed: int, noise: float) -> np.ndarray:
    """Noisy waypoints of a winding road of a least radius."""
    s = spacing * np.arange(n)
    psi = np.cumsum(np.sin(2.0 * math.pi * s / 700.0)) * spacing / radius
    xy = np.column_stack((np.cumsum(np.cos(psi)), np.cumsum(np.sin(psi)))) * spacing
    return xy + np.random.default_rng(seed).normal(0.0, noise, xy.shape)


def u_turn(length: float, width: float, max_distance: float, limit: float) -> list[Check]:
    """Check that a path out and back passes near all waypoints, or is refused."""
    x = np.arange(0.0, length + 1.0, 10.0)
    points = np.vstack((np.column_stack((x, 0.0 * x)), np.column_stack((x[::-1], 0.0 * x + width))))
    try:
        sampled = fit_path(points, tolerance=1.0, curvature_limit=limit).sample(0.2)
    except InfeasibleError:
        return [("refused", True, "==", True)]
    farthest = max(float(np.hypot(*(sampled - p).T).min()) for p in points)
    return [("farthest waypoint", farthest, "<=", max_distance)]


@TABLE.case(
    "path", "u-turn-with-limit", "a U-turn 4 m wide with curvature_limit: no chord from first to last point"
)
def _():
    return u_turn(300.0, 4.0, 12.0, 0.15)


@TABLE.case(
    "path",
    "noisy-gps-default",
    "receiver noise of 1 m at the default tolerance: half the true radius, or reported",
)
def _():
    return drivable(winding(300, 8.0, 111.0, 1, 1.0), 55.0)


@TABLE.case("path", "standing-receiver", "the receiver is stationary at the start: drivable, or reported")
def _():
    return drivable(STATIONARY, 4.0, tolerance=1.0)


@TABLE.case("path", "tolerance-monotone", "points that can be fitted within 0.5 m can be fitted within more")
def _():
    points = [(0, 0), (-0.1533, -1.1736), (100.65, -14.3058), (429.9056, -162.1269)]
    tried = 0.5, 1.0, 2.0, 5.0, 20.0
    return [
        (
            "tolerances that fail",
            [t for t in tried if raised(lambda t=t: fit_path(points, tolerance=t))],
            "==",
            [],
        )
    ]


@TABLE.case("path", "project-nearest", "project without a guess returns the nearest point of a tight path")
def _():
    points = [(-3.33, 5.51), (-4.38, 6.9), (-3.22, 4.23), (0, 0), (-0.39, 1.49), (-1.6, 1.06)]
    path = fit_path(points, tolerance=0.5)
    true = float(np.hypot(*path.position(np.arange(path.start, path.end, 0.001)).T).min())
    return [("distance beyond the true one", abs(float(path.project((0.0, 0.0))[1])) - true, "<=", 0.01)]

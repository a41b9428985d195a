"""Committed part of an ongoing maneuver, and the clearance relaxation that it needs."""

from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import Boxes, box_gap
from cca_core.planner.maneuver_tuning import ReplanSettings


def resample_displacement(s: Array, stations: Array, displacement: Array) -> Array:
    """Return a displacement at other stations, continuous in curvature; 0 beyond its end."""
    from scipy.interpolate import CubicSpline  # slow to import, and importing the library is to be quick

    if len(s) == len(stations) and s[-1] == stations[-1]:
        return displacement
    resampled: Array = np.where(s <= stations[-1], CubicSpline(stations, displacement)(s), 0.0)
    return resampled


def first_replannable_node(s: Array, s_ego: float) -> int:
    """Return the index of the first node ahead of the ego, at least 1."""
    min_nodes = 6  # of a band
    return min(max(int(np.searchsorted(s, s_ego)), 1), len(s) - min_nodes)


def committed_nodes(t: Array, settings: ReplanSettings) -> int:
    """Return the number of nodes within the committed time, at least 3."""
    return max(int(np.searchsorted(t, settings.committed_time)), 3)


def relax_clearance(boxes: Boxes, body: Boxes, t: Array, clearance: float, settings: ReplanSettings) -> Boxes:
    """Shrink occupancies by the clearance that the committed body lacks, less as time passes."""
    m = len(body.x)
    committed = Boxes(*(f[..., :m] for f in (boxes.x, boxes.y, boxes.psi, boxes.length, boxes.width)))
    tolerance = settings.clearance_tolerance
    shortfall = np.maximum(clearance + tolerance - box_gap(body, committed).min(axis=-1), 0.0)
    if clearance > settings.min_clearance:  # a vehicle that is closer is not passed as if it were farther
        shortfall = np.minimum(shortfall, clearance - settings.min_clearance + tolerance)
    end = max(settings.committed_time, t[m - 1])
    x = np.clip((t - end) / settings.recovery_time, 0.0, 1.0)
    reduction = 2.0 * shortfall[..., None] * (1.0 - x * x * (3.0 - 2.0 * x))
    length, width = np.maximum(boxes.length - reduction, 0.0), np.maximum(boxes.width - reduction, 0.0)
    return replace(boxes, length=length, width=width)

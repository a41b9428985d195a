"""A band problem: the checked arguments of `relax_band`."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, Index, check_any, check_real, is_finite
from cca_core.band.corridor import check_edges, stack_boxes
from cca_core.band.settings import BandSettings
from cca_core.band.stiffness import BandStiffness
from cca_core.errors import InputError
from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams

MAX_DISPLACEMENT = 30.0
"""Largest displacement of a band on a road [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BandProblem:
    """Checked arguments of a batch of bands, flattened to shape (bands, ...)."""

    nodes: Array  # of the undeformed route [m], (bands, n, 2)
    boxes: Array  # x, y, heading, length and width of each obstacle at each node, (5, m, bands, n)
    edges: Array | None  # lateral offset of the right and the left edge [m], (2, bands, n)
    lead_distance: Array  # before each obstacle [m], (m,) or ()
    curvature_limit: Array  # [1/m], (bands, n)
    start: Array  # displacement a node before the first and at the first two [m], (bands, 3)
    vehicle: VehicleParams
    clearance: float  # [m]
    stiffness: BandStiffness
    settings: BandSettings

    def select(self, bands: Index | slice) -> "BandProblem":
        """Return the problem of some bands."""
        return replace(
            self,
            nodes=self.nodes[bands],
            boxes=self.boxes[:, :, bands],
            edges=None if self.edges is None else self.edges[:, bands],
            curvature_limit=self.curvature_limit[bands],
            start=self.start[bands],
        )


def offset_curvature(kappa: Array, u: Array, h: float) -> Array:
    """Return the curvature [1/m] of the curve at lateral offsets, given at three nodes h apart."""
    slope, change = 0.5 * (u[2] - u[0]) / h, (u[2] - 2.0 * u[1] + u[0]) / (h * h)
    along = 1.0 - kappa * u[1]
    turn = along * (change + kappa * along) + 2.0 * kappa * slope**2
    curvature: Array = turn / np.hypot(along, slope) ** 3
    return curvature


def make_problem(
    nodes: ArrayLike,
    obstacles: Sequence[Boxes],
    *,
    vehicle: VehicleParams,
    clearance: float,
    lead_distance: ArrayLike,
    edges: tuple[ArrayLike, ArrayLike] | None,
    curvature_limit: ArrayLike,
    stiffness: BandStiffness,
    start: ArrayLike,
    settings: BandSettings,
) -> tuple[BandProblem, tuple[int, ...]]:
    """Check the arguments of `relax_band`; return the problem and the batch shape of `nodes`."""
    checked = _parse_nodes(nodes)
    _check_kind("stiffness", stiffness, BandStiffness)
    _check_kind("vehicle", vehicle, VehicleParams)
    _check_kind("settings", settings, BandSettings)
    clearance = check_real("clearance", clearance, ge=0.0)
    shape, n = checked.shape[:-1], checked.shape[-2]
    given: object = curvature_limit  # may be anything
    limit = np.empty(shape)
    try:
        limit[...] = curvature_limit
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"curvature_limit must have shape () or {shape}") from None
    if not (given > 0.0 if isinstance(given, float) else (limit > 0.0).all()):
        raise InputError("curvature_limit must be greater than 0")
    boxes = stack_boxes(obstacles, shape)
    lead = check_any("lead_distance", lead_distance)
    m = len(obstacles)
    if lead.shape not in ((), (m,)) or np.count_nonzero(lead < 0.0):
        raise InputError(
            f"lead_distance must have shape () or ({m},) and not be negative, was {lead_distance!r}"
        )
    return BandProblem(
        nodes=checked.reshape(-1, n, 2), boxes=boxes, lead_distance=lead,
        edges=None if edges is None else check_edges(edges, shape),
        curvature_limit=limit.reshape(-1, n), start=_fixed_start(start, shape), vehicle=vehicle,
        clearance=clearance, stiffness=stiffness, settings=settings,
    ), shape[:-1]  # fmt: skip


def _check_kind(name: str, value: object, kind: type) -> None:
    """Raise for an object of another class."""
    if not isinstance(value, kind):
        raise InputError(f"{name} must be {kind.__name__}, was {type(value).__name__}")


def _parse_nodes(nodes: ArrayLike) -> Array:
    """Return nodes of shape (..., n, 2)."""
    try:
        checked = np.array(nodes, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"nodes must be an array of real numbers, was {type(nodes).__name__}") from None
    if checked.ndim < 2 or checked.shape[-1] != 2 or checked.shape[-2] < 5 or not checked.size:
        raise InputError(f"nodes must have shape (..., n, 2) with at least 5 nodes, had {checked.shape}")
    if checked.ndim > 2:  # those of one band are checked by the kernel, which refuses their spacing
        check_nodes(checked)
    return checked


def check_nodes(nodes: Array) -> None:
    """Raise for nodes that are not finite."""
    if not is_finite(nodes):
        index = np.argwhere(~np.isfinite(nodes))[0]
        raise InputError(f"nodes must be finite, was {nodes[tuple(index)]} at {index.tolist()}")


def _fixed_start(start: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return the displacement before the first node and at the first two, shape (bands, 3), checked."""
    fixed, given = np.zeros((math.prod(shape[:-1]), 3)), cast(object, start)
    if isinstance(given, float) and given == 0.0:
        return fixed
    checked = check_any("start", start)
    try:
        fixed.reshape(*shape[:-1], 3)[...] = checked
    except ValueError:
        raise InputError(f"start must have shape {(*shape[:-1], 3)}, had {checked.shape}") from None
    if np.abs(fixed).max() > MAX_DISPLACEMENT:
        raise InputError(f"start must be within {MAX_DISPLACEMENT:g} m, was {np.abs(fixed).max():g}")
    return fixed

"""Clearance, edges and curvature of a band by dense measurement, without the geometry of the library."""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from cca_core.geometry import Boxes
from cca_core.vehicle import VehicleParams

if TYPE_CHECKING:
    from tests.support.band_cases import Case

Array = np.ndarray[Any, np.dtype[np.float64]]

STEP = 0.05  # between two looks at the swept box [m]
CLOSER = 10  # looks between two of those, around a dip
DEEPEST = 0.2  # by which a dip between two looks may be deeper [m]


def displaced(nodes: Array, u: Array) -> Array:
    """Move nodes sideways by u, left positive."""
    normal = left_of(curve_through(nodes)(stations(nodes), 1))
    return nodes + u[:, None] * normal


def remeasure(nodes: Array, case: "Case") -> float:
    """Least distance of the swept ego to any obstacle [m], minus the depth of the deepest overlap.

    Sampled every few centimeters where it may be smallest, and closer around the dips.
    """
    n = len(nodes)
    parts = math.ceil(float(np.diff(stations(nodes)).max()) / STEP)
    coarse = np.arange(n, dtype=float)
    at_nodes = poses(nodes, coarse, case.vehicle)
    smallest = math.inf
    for obstacle in case.obstacles:
        box = interpolated(obstacle, coarse, n)
        gap = _gaps(at_nodes, box)
        smallest = min(smallest, float(gap.min()))
        travel = _travel(at_nodes) + _travel(box)  # the nearer node is at most half of it away
        near = np.flatnonzero(np.minimum(gap[:-1], gap[1:]) - 0.6 * travel < smallest)
        index = near[:, None] + np.arange(parts + 1) / parts
        for step in (1.0 / parts, 1.0 / parts / CLOSER):
            if not index.size:
                break
            rows = index.ravel()
            gap = _gaps(poses(nodes, rows, case.vehicle), interpolated(obstacle, rows, n)).reshape(
                index.shape
            )
            smallest = min(smallest, float(gap.min()))
            wide = np.pad(gap, ((0, 0), (1, 1)), constant_values=math.inf)
            dips = (gap <= wide[:, :-2]) & (gap <= wide[:, 2:]) & (gap < smallest + DEEPEST)
            index = index[dips][:, None] + step * np.linspace(-1.0, 1.0, 2 * CLOSER + 1)
            index = index.clip(0.0, n - 1.0)
    return smallest


def edge_excess(nodes: Array, case: "Case") -> float:
    """Distance of a corner of the swept ego beyond an edge of the road [m], negative inside."""
    n = len(nodes)
    parts = math.ceil(float(np.diff(stations(nodes)).max()) / STEP)
    pose = poses(nodes, np.arange((n - 1) * parts + 1) / parts, case.vehicle)
    index, lateral = road_coordinates(case.nodes, corners(pose).reshape(-1, 2))
    right, left = (np.interp(index, np.arange(n), np.broadcast_to(edge, n)) for edge in case.corridor)
    return float(np.maximum(right - lateral, lateral - left).max())


def curvature_excess(nodes: Array, case: "Case") -> float:
    """Largest excess of the curvature as a fraction of its limit [-], negative below it."""
    n = len(nodes)
    index = np.linspace(0.0, n - 1.0, 8 * n - 7)
    limit = np.interp(index, np.arange(n), np.broadcast_to(case.curvature_limit, n))
    return float((np.abs(curvature_at(nodes, index, case.nodes)) / limit).max()) - 1.0


def peak_curvature(nodes: Array) -> float:
    """Largest curvature of the C2 cubic spline through the nodes [1/m], without sign."""
    return float(np.abs(curvature_at(nodes, np.linspace(0.0, len(nodes) - 1.0, 8 * len(nodes) - 7))).max())


def curvature_at(nodes: Array, index: Array, route: Array | None = None) -> Array:
    """Curvature of that curve at fractional node indices [1/m], to the left positive."""
    s = np.interp(index, np.arange(len(nodes)), stations(nodes))
    curve = curve_through(nodes, route)
    (dx, dy), (ddx, ddy) = curve(s, 1).T, curve(s, 2).T
    curvature: Array = (dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3
    return curvature


def road_coordinates(base: Array, points: Array) -> tuple[Array, Array]:
    """Index along a route, in nodes, and lateral coordinate [m] of points, by the nearest of dense points."""
    tree, index, along = _dense_line(base.tobytes())
    nearest = tree.query(points)[1]
    return index[nearest], ((points - tree.data[nearest]) * left_of(along[nearest])).sum(axis=1)


def stations(nodes: Array) -> Array:
    """Chord length from the first node [m]."""
    steps: Array = np.hypot(*np.diff(nodes, axis=0).T)
    return np.concatenate(([0.0], np.cumsum(steps)))


def curve_through(nodes: Array, route: Array | None = None) -> "CubicSpline[np.float64]":
    """C2 curve through the nodes over chord length, with the curvature of a route at both ends if given."""
    if route is None:
        return CubicSpline(stations(nodes), nodes)
    ends = CubicSpline(stations(route), route)([0.0, stations(route)[-1]], 2)
    return CubicSpline(stations(nodes), nodes, bc_type=((2, ends[0]), (2, ends[1])))


def left_of(vectors: Array) -> Array:
    """Unit vectors a quarter turn to the left of vectors, shape (..., 2)."""
    unit = vectors / np.hypot(vectors[..., 0], vectors[..., 1])[..., None]
    return np.stack((-unit[..., 1], unit[..., 0]), axis=-1)


def poses(nodes: Array, index: Array, vehicle: VehicleParams) -> Array:
    """Center, heading, length and width of the ego's box at fractional node indices, shape (m, 5)."""
    s = np.interp(index, np.arange(len(nodes)), stations(nodes))
    curve = curve_through(nodes)
    along = curve(s, 1)
    along /= np.hypot(*along.T)[:, None]
    center = curve(s) + vehicle.box_offset * along
    psi = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    size = np.broadcast_to((vehicle.length, vehicle.width), (len(s), 2))
    return np.column_stack((center, psi, size))


def corners(pose: Array) -> Array:
    """Corners of boxes, shape (m, 4, 2)."""
    x, y, psi, length, width = pose.T
    t = 0.5 * length[:, None] * np.column_stack((np.cos(psi), np.sin(psi)))
    w = 0.5 * width[:, None] * np.column_stack((-np.sin(psi), np.cos(psi)))
    center = np.column_stack((x, y))
    return np.stack((center + t + w, center - t + w, center - t - w, center + t - w), axis=1)


def interpolated(obstacle: Boxes, index: Array, n: int) -> Array:
    """An obstacle's box at fractional node indices, linear between nodes, shape (m, 5)."""
    fields = (obstacle.x, obstacle.y, np.unwrap(np.atleast_1d(obstacle.psi)), obstacle.length, obstacle.width)
    nodes = np.arange(n)
    return np.column_stack([np.interp(index, nodes, np.broadcast_to(np.squeeze(f), n)) for f in fields])


def _travel(pose: Array) -> Array:
    """Largest displacement of any point of a box between neighboring rows [m]."""
    x, y, psi = np.diff(pose[:, :3], axis=0).T
    moved: Array = np.hypot(x, y) + 0.5 * np.hypot(*pose[1:, 3:].T) * np.abs(psi)
    return moved


def _gaps(a: Array, b: Array) -> Array:
    """Signed distance of boxes, row by row [m]; negative where they overlap: the way apart."""
    corners_a, corners_b = corners(a), corners(b)
    gap: Array = shapely.distance(shapely.polygons(corners_a), shapely.polygons(corners_b))
    deep = np.flatnonzero(gap == 0.0)
    if len(deep):
        difference = (corners_b[deep, :, None] - corners_a[deep, None]).reshape(-1, 16, 2)
        rim = shapely.boundary(shapely.convex_hull(shapely.multipoints(difference)))
        gap[deep] = -shapely.distance(rim, shapely.Point(0.0, 0.0))
    return gap


@lru_cache(maxsize=4)
def _dense_line(data: bytes) -> tuple[cKDTree, Array, Array]:
    """Points of a route every 5 cm, straight on beyond its ends, their index in nodes and unit tangents."""
    base = np.frombuffer(data).reshape(-1, 2)
    n, s = len(base), stations(base)
    parts = math.ceil(float(np.diff(s).max()) / STEP)
    index = np.arange((n - 1) * parts + 1) / parts
    curve, at = curve_through(base), np.interp(index, np.arange(n), s)
    line, t = curve(at), curve(at, 1)
    t /= np.hypot(*t.T)[:, None]
    beyond = np.arange(1.0, 301.0)[:, None] * STEP
    line = np.vstack((line[0] - beyond[::-1] * t[0], line, line[-1] + beyond * t[-1]))
    index = np.pad(index, 300, mode="edge")
    return cKDTree(line), index, np.pad(t, ((300, 300), (0, 0)), mode="edge")

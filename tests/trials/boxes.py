"""Bodies of vehicles as boxes: corners and distances, independent of the library's own."""

import math
from collections.abc import Iterable

import numpy as np

from cca_core import RemoteVehicle, VehicleParams, VehicleState

NEARBY = 40.0  # distance within which gaps are computed [m]


def corners(x: float, y: float, psi: float, length: float, width: float) -> np.ndarray:
    """Corners of a box, counter-clockwise."""
    along = 0.5 * length * np.array((math.cos(psi), math.sin(psi)))
    across = 0.5 * width * np.array((-math.sin(psi), math.cos(psi)))
    return np.array((x, y)) + np.array((along + across, across - along, -along - across, along - across))


def box_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Distance between two boxes given by their corners [m]; 0 if they overlap."""
    separated, distance = False, math.inf
    for one, other in ((a, b), (b, a)):
        begin, edge = one, np.roll(one, -1, axis=0) - one
        size = np.hypot(edge[:, 0], edge[:, 1])
        to = other[None, :, :] - begin[:, None, :]
        along = (to * edge[:, None, :]).sum(2) / size[:, None]
        outwards = (to[:, :, 0] * edge[:, None, 1] - to[:, :, 1] * edge[:, None, 0]) / size[:, None]
        separated = separated or bool((outwards.min(axis=1) > 0.0).any())
        beyond = along - np.clip(along, 0.0, size[:, None])
        distance = min(distance, float(np.hypot(beyond, outwards).min()))
    return distance if separated else 0.0


def ego_gap(state: VehicleState, remotes: Iterable[RemoteVehicle], car: VehicleParams) -> float:
    """Least distance between the ego's box and those of nearby vehicles [m]; infinite if there is none."""
    c, s = math.cos(state.psi), math.sin(state.psi)
    x, y = state.x + car.box_offset * c, state.y + car.box_offset * s
    near = [r for r in remotes if math.hypot(r.x - x, r.y - y) < NEARBY + 0.5 * r.length]
    if not near:
        return math.inf
    ego = corners(x, y, state.psi, car.length, car.width)
    return min(box_distance(ego, corners(r.x, r.y, r.psi, r.length, r.width)) for r in near)

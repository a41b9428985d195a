"""Band problems that were described by what follows from the arguments of `relax_band`."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cca_core.errors import InputError

_KEPT = "vehicle", "clearance", "curvature_limit", "stiffness", "settings", "type"


def stated_problem(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the description of the arguments; distances before obstacles were not kept, and are 0."""
    if "base" not in data and "route_nodes" not in data:
        return data
    try:
        return {**{name: data[name] for name in _KEPT if name in data}, **_arguments(data)}
    except (AttributeError, IndexError, KeyError, TypeError, ValueError):
        raise InputError("a band problem must have route_nodes and a corridor of one shape") from None


def _arguments(data: Mapping[str, Any]) -> dict[str, Any]:
    corridor = data["corridor"]
    nodes = data["base"] if "base" in data else data["route_nodes"]
    half = 0.5 * float(data["vehicle"]["width"])
    free = _numbers(data, "free", "free_displacement")[:, :2]
    start = np.column_stack((_numbers(data, "before", "previous_displacement"), free))
    center, ahead = _numbers(corridor, "centre", "center"), _numbers(corridor, "ahead", "ahead")
    x, y, psi = center[..., 0], center[..., 1], np.arctan2(ahead[..., 1], ahead[..., 0])
    sizes = (2.0 * _numbers(corridor, name, name) for name in ("half_length", "half_width"))
    boxes = np.stack((x, y, psi, *sizes))
    sides = _numbers(corridor, "lower", "lower") - half, _numbers(corridor, "upper", "upper") + half
    edges, has_edges = np.array(sides), corridor["edged"] if "edged" in corridor else corridor["has_edges"]
    return {
        "nodes": nodes, "boxes": boxes.tolist() if boxes.size else {"shape": list(boxes.shape)},
        "edges": edges.tolist() if has_edges else None,
        "lead_distance": 0.0, "start": start.tolist(),
    }  # fmt: skip


def _numbers(data: Mapping[str, Any], first: str, name: str) -> NDArray[np.float64]:
    """Return an array by its name in version 1, or its name since."""
    values = data[first] if first in data else data[name]
    if isinstance(values, Mapping):
        return np.empty(values["shape"])
    return np.array(values).astype(np.float64)

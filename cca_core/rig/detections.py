"""Detections of the ego's sensor as datagrams: one JSON object with a list of vehicles."""

import json
from collections.abc import Sequence
from typing import Any

from cca_core.vehicle import RemoteVehicle

_NUMBERS = ("x", "y", "psi", "v_x", "a_x", "r", "length", "width", "age", "sigma_along", "sigma_across")
_MAX_VEHICLES = 200


def encode_detections(cycle: int, vehicles: Sequence[RemoteVehicle]) -> bytes:
    """Write the detections of a cycle.

    Parameters
    ----------
    cycle : int
        Number of the state that they belong to [-].
    vehicles : sequence of RemoteVehicle
        Visible vehicles.

    Returns
    -------
    data : bytes
        JSON: ``{"cycle": 7, "vehicles": [{"id": "R1", "x": 1.0, ...}]}``, in SI units.
    """
    listed = [{"id": v.id} | {name: getattr(v, name) for name in _NUMBERS} for v in vehicles]
    return json.dumps({"cycle": cycle, "vehicles": listed}).encode("utf-8")


def decode_detections(data: bytes) -> tuple[int, list[RemoteVehicle]] | None:
    """Read the detections of a cycle.

    Parameters
    ----------
    data : bytes
        Any datagram.

    Returns
    -------
    detections : tuple of (int, list of RemoteVehicle) or None
        Cycle and vehicles; None if the content cannot be read. Values are checked by the planner.
    """
    try:
        content = json.loads(data)
        cycle, listed = int(content["cycle"]), content["vehicles"][:_MAX_VEHICLES]
        vehicles = []
        for each in listed:
            numbers: dict[str, Any] = {name: float(each[name]) for name in _NUMBERS}
            vehicles.append(RemoteVehicle(id=str(each["id"]), source="sensor", **numbers))
        return cycle, vehicles
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        return None

"""Roads of maps: OpenDRIVE and nets of SUMO; origins of maps and tracks."""

from collections.abc import Sequence
from pathlib import Path as FilePath

import numpy as np

from cca_core.adapters import read_opendrive, read_sumo_net
from cca_core.adapters.local_origin import Origin, find_origin
from cca_core.errors import InputError
from cca_core.path import Road, Waypoints

__all__ = ["is_map", "read_map_road", "track_origin"]

_OPENDRIVE, _SUMO = ".xodr", ".net.xml"
_SHOWN = 12  # ids in a message


def is_map(file: FilePath) -> bool:
    """Return whether a file is a map by its ending."""
    return file.name.lower().endswith((_OPENDRIVE, _SUMO))


def read_map_road(
    file: FilePath,
    along: Sequence[str],
    lane: int | None,
    speed_limit: float,
    name: str,
    origin: Origin | None = None,
) -> tuple[Road, Origin]:
    """Return the road along roads or edges, and its origin; `name` is that of `along` in messages."""
    if file.name.lower().endswith(_SUMO):
        net = read_sumo_net(file, origin=origin)
        _check_ids(along, net.edge_ids, name)
        return net.road_along(along, lane), net.origin
    roads = read_opendrive(file, origin=origin)
    _check_ids(along, roads.road_ids, name)
    road = roads.road_along(along, -1 if lane is None else lane, speed_limit=speed_limit)
    return road, roads.origin


def track_origin(points: Waypoints) -> Origin | None:
    """Return the origin for a track of x and y; None for one of latitude and longitude."""
    return find_origin(*np.median(points.xy, axis=0).tolist()) if len(points.xy) else None


def _check_ids(along: Sequence[str], known: Sequence[str], name: str) -> None:
    """Raise unless all ids are in the map."""
    more = ", ..." if len(known) > _SHOWN else ""
    has = f"the map has {', '.join(known[:_SHOWN])}{more}"
    if not along:
        raise InputError(f"{name} must list the ids of roads or edges in driving order; {has}")
    for each in along:
        if each not in known:
            raise InputError(f"{name} must be ids of the map, had {each!r}; {has}")

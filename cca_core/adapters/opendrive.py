"""Maps of OpenDRIVE: routes along lanes, as roads."""

import heapq
from collections.abc import Sequence
from pathlib import Path as FilePath

import numpy as np

from cca_core._checks import check_real, shown
from cca_core.adapters.lane_lines import lanes_along
from cca_core.adapters.local_origin import Origin
from cca_core.adapters.opendrive_file import Connection, FileRoad, Link, read_roads
from cca_core.adapters.opendrive_lanes import Line, Piece, path_of, sample
from cca_core.errors import InputError
from cca_core.path import Road

__all__ = ["OpenDriveMap", "read_opendrive"]


class OpenDriveMap:
    """Roads of a file of OpenDRIVE; `read_opendrive` makes it.

    Parameters
    ----------
    roads, junctions : dict
        What the file holds, by id.
    origin : tuple of float
        Position in the file that is x = y = 0 in the roads [m].

    Attributes
    ----------
    road_ids : tuple of str
        Ids of the roads, in the order of the file.
    origin : tuple of float
        As given.
    """

    def __init__(
        self,
        roads: dict[str, FileRoad],
        junctions: dict[str, list[Connection]],
        origin: Origin = (0.0, 0.0),
    ) -> None:
        self._roads, self._junctions, self.origin = roads, junctions, origin
        self.road_ids = tuple(roads)

    def __repr__(self) -> str:
        return f"OpenDriveMap({len(self._roads)} roads, {len(self._junctions)} junctions)"

    def find_road(
        self, start: tuple[str, float, int], end: tuple[str, float, int], *, speed_limit: float = 36.0
    ) -> Road:
        """Make the road along the shortest route between two positions.

        Parameters
        ----------
        start, end : tuple of str, float and int
            Id of the road, station on it [m] and id of the lane: where the route begins and ends.
        speed_limit : float
            Legal speed where the file has none [m/s].

        Returns
        -------
        road : Road
            The lane from start to end. The lane is never changed.

        Raises
        ------
        InputError
            If there is no such road or lane, the end cannot be reached along the lane, or the map is broken
            on the route.
        """
        first, s_start = self._piece("start", start)
        last, s_end = self._piece("end", end)
        pieces = self._find_route(first, s_start, last, s_end)
        if not pieces:
            raise InputError(f"end must be reachable along the lane from {start}, was {end}")
        return self._make(pieces, s_start, s_end, speed_limit)

    def road_along(self, road_ids: Sequence[str], lane_id: int, *, speed_limit: float = 36.0) -> Road:
        """Make the road along whole roads of the map.

        Parameters
        ----------
        road_ids : sequence of str
            Ids of the roads in driving order, with those within junctions.
        lane_id : int
            Id of the lane where the route begins [-]. It gives the direction: lanes with negative ids go
            along s where traffic drives on the right.
        speed_limit : float
            Legal speed where the file has none [m/s].

        Returns
        -------
        road : Road
            The lane from the beginning of the first road to the end of the last one.

        Raises
        ------
        InputError
            If there is no such road or lane, the lane does not lead from a road to the next one, or the map
            is broken on the route.
        """
        if isinstance(road_ids, str) or not road_ids:
            raise InputError(f"road_ids must be a sequence of ids, was {shown(road_ids)}")
        road = self._road("road_ids", road_ids[0])
        is_forward = road.is_forward(lane_id)
        section = 0 if is_forward else len(road.sections) - 1
        if lane_id not in road.sections[section][1]:
            lanes = sorted(road.sections[section][1])
            raise InputError(f"lane_id must be one of {lanes} of road {road.id!r}, was {shown(lane_id)}")
        start = 0.0 if is_forward else road.length
        pieces = [self._piece("lane_id", (road.id, start, lane_id), section)[0]]
        for id_ in road_ids[1:]:
            self._road("road_ids", id_)
            pieces += self._rest_of_road(pieces[-1])
            after = list(self._successors(pieces[-1]))
            onward = [piece for piece in after if piece.road == id_]
            if not onward:
                there = ", ".join(sorted({repr(piece.road) for piece in after})) or "no road"
                raise InputError(
                    f"lane {pieces[-1].lane} of road {pieces[-1].road!r} must lead to road {id_!r}, "
                    f"leads to {there}"
                )
            pieces.append(onward[0])
        pieces += self._rest_of_road(pieces[-1])
        length = self._roads[pieces[-1].road].length
        return self._make(pieces, start, length if pieces[-1].is_forward else 0.0, speed_limit)

    def _road(self, name: str, id_: str) -> FileRoad:
        if id_ not in self._roads:
            raise InputError(f"{name} must be a road of the map, was {shown(id_)}")
        return self._roads[id_]

    def _piece(
        self, name: str, position: tuple[str, float, int], section: int | None = None
    ) -> tuple[Piece, float]:
        """Return the piece at a position, and its station."""
        given: object = position
        if not isinstance(given, tuple | list) or len(given) != 3:
            raise InputError(f"{name} must be a road id, a station and a lane id, was {shown(position)}")
        road = self._road(name, position[0])
        s = check_real(f"station of {name}", position[1], ge=0.0, le=road.length)
        i = road.section_at(s) if section is None else section
        if position[2] not in road.sections[i][1]:
            lanes = sorted(road.sections[i][1])
            raise InputError(
                f"lane of {name} must be one of {lanes} of road {road.id!r}, was {shown(position[2])}"
            )
        return Piece(road.id, i, position[2], road.is_forward(position[2])), s

    def _rest_of_road(self, piece: Piece) -> list[Piece]:
        """Return the pieces of a lane in the further sections of its road."""
        found: list[Piece] = []
        while True:
            onward = [after for after in self._successors(piece) if self._is_inner(piece, after)]
            if not onward:
                return found
            piece = onward[0]
            found.append(piece)

    @staticmethod
    def _is_inner(piece: Piece, after: Piece) -> bool:
        return after.road == piece.road and after.section - piece.section == (1 if piece.is_forward else -1)

    def _successors(self, piece: Piece) -> list[Piece]:
        """Return the pieces into which a lane leads."""
        road = self._roads[piece.road]
        lane = road.sections[piece.section][1][piece.lane]
        targets = lane.successors if piece.is_forward else lane.predecessors
        section = piece.section + (1 if piece.is_forward else -1)
        if 0 <= section < len(road.sections):
            return [
                piece._replace(section=section, lane=id_)
                for id_ in targets
                if id_ in road.sections[section][1]
            ]
        link = road.successor if piece.is_forward else road.predecessor
        if link is None:
            return []
        if link.kind == "road":
            found = [self._entered(link, id_) for id_ in targets]
        else:
            found = [
                self._entered(Link("road", turn.road, turn.at_start), turn.lanes[piece.lane])
                for turn in self._junctions.get(link.id, ())
                if turn.incoming == road.id and piece.lane in turn.lanes
            ]
        return [after for after in found if after is not None]

    def _entered(self, link: Link, lane_id: int) -> Piece | None:
        """Return the piece of a road that is entered at its start or end."""
        road = self._roads.get(link.id)
        if road is None:
            return None
        section = 0 if link.at_start else len(road.sections) - 1
        if lane_id not in road.sections[section][1]:
            return None
        return Piece(road.id, section, lane_id, link.at_start)

    def _find_route(self, first: Piece, s_start: float, last: Piece, s_end: float) -> list[Piece]:
        """Return the shortest route along lanes, by Dijkstra's search; empty if there is none."""
        ahead = s_end - s_start if first.is_forward else s_start - s_end
        if first[:3] == last[:3] and ahead > 0.0:
            return [first]
        queue: list[tuple[float, int, tuple[Piece, ...]]] = [(0.0, 0, (first,))]
        done: set[Piece] = set()
        count = 0
        while queue:
            cost, _, route = heapq.heappop(queue)
            if len(route) > 1 and route[-1][:3] == last[:3]:
                return list(route)
            if route[-1] in done:
                continue
            if len(route) > 1:
                done.add(route[-1])
            for after in self._successors(route[-1]):
                start, end = self._ends(after)
                count += 1
                heapq.heappush(queue, (cost + end - start, count, (*route, after)))
        return []

    def _ends(self, piece: Piece) -> tuple[float, float]:
        road = self._roads[piece.road]
        return road.sections[piece.section][0], road.section_end(piece.section)

    def _make(self, pieces: Sequence[Piece], s_start: float, s_end: float, speed_limit: float) -> Road:
        """Return the road along pieces."""
        speed_limit = check_real("speed_limit", speed_limit, gt=0.0)
        lines, parts = [], []
        for i, piece in enumerate(pieces):
            low, high = self._ends(piece)
            if i == 0:
                low, high = (s_start, high) if piece.is_forward else (low, s_start)
            if i == len(pieces) - 1:
                low, high = (low, s_end) if piece.is_forward else (s_end, high)
            if not high - low > 1e-6:
                continue
            line, lanes = sample(self._roads[piece.road], piece, low, high, speed_limit)
            lines.append(line)
            parts.append(lanes)
        if not lines:
            raise InputError("route must have a length, had none")
        line = Line(*(np.concatenate(rows) for rows in zip(*lines, strict=True)))
        path = path_of(line)
        stations = np.append(0.0, np.cumsum(line.length)) * (path.length / line.length.sum())
        stations[-1] = path.end
        changes = np.append(True, np.diff(line.limit) != 0.0)
        limits = np.column_stack((stations[:-1], line.limit))[changes]
        heights = None
        if line.height.any():
            heights = np.column_stack((stations, np.append(line.height[:, 0], line.height[-1, 1])))
        return Road(
            path, lanes_along(path, parts), float(limits[0, 1]), (), heights, 0.0,
            limits if len(limits) > 1 else None,
        )  # fmt: skip


def read_opendrive(file: str | FilePath, *, origin: Origin | None = None) -> OpenDriveMap:
    """Read a map of ASAM OpenDRIVE.

    Parameters
    ----------
    file : str or pathlib.Path
        File of OpenDRIVE 1.4 to 1.8 (XML), at most 50 MB, without a document type declaration.
    origin : tuple of float, optional
        Position in the file that becomes x = y = 0 [m], such as that of another map. By default it is 0.
        A map whose middle is more than 900 km from there gets an origin near its middle, at whole kilometers.

    Returns
    -------
    map : OpenDriveMap
        Its roads, from which `OpenDriveMap.find_road` and `OpenDriveMap.road_along` make a `Road`, and the
        `origin`. A position in coordinates of the file belongs to x and y less those of the origin.

    Raises
    ------
    InputError
        If the file cannot be read or is not such a map.

    Notes
    -----
    Read are reference lines (line, arc, spiral, poly3, paramPoly3), lane offsets and widths, links,
    junctions, elevations, and speed limits of roads and lanes. Not read are superelevation, lane borders,
    signals, objects, rules of priority, and the offset and geographic reference of the header.

    The route is the center line of the lane, exact to 0.1 mm. Where it has corners of more than 0.02 rad or
    gaps of more than 2 cm, all of it is fitted within 0.1 m.

    References
    ----------
    .. [1] ASAM e.V., *ASAM OpenDRIVE*, version 1.8.0, 2023.
    """
    return OpenDriveMap(*read_roads(file, origin))

"""Lanes along a path."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module

from cca_core._checks import check_real, shown
from cca_core.errors import InputError
from cca_core.path.path import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Lane:
    """One lane of a road.

    Parameters
    ----------
    d : float
        Lateral offset of its center line [m], left of the route positive.
    width : float
        Width [m].
    direction : int
        Direction of travel [-]: 1 along the route, -1 against it.

    Raises
    ------
    InputError
        If a value is not finite, the width is not positive, or the direction is neither 1 nor -1.
    """

    d: float
    width: float = 3.5
    direction: int = 1

    def __post_init__(self) -> None:
        check_real("d", self.d)
        check_real("width", self.width, gt=0.0)
        if self.direction not in (1, -1):
            raise InputError(f"direction must be 1 or -1, was {shown(self.direction)}")

    @property
    def right(self) -> float:
        """Lateral offset of the right lane boundary [m]."""
        return self.d - 0.5 * self.width

    @property
    def left(self) -> float:
        """Lateral offset of the left lane boundary [m]."""
        return self.d + 0.5 * self.width


class Road:
    """A route with its lanes and road edges.

    Parameters
    ----------
    path : Path
        The route: the center line of the ego lane.
    lanes : sequence of Lane, optional
        All lanes; one lane must contain d = 0. The default is the ego lane alone, 3.5 m wide.
    speed_limit : float
        Legal speed [m/s].
    stop_lines : sequence of float
        Stations at which the ego stops to yield to crossing traffic [m].

    Raises
    ------
    InputError
        If `path` is not a `Path`, no lane contains the route, or the speed limit is not positive.
    """

    def __init__(
        self,
        path: Path,
        lanes: Sequence[Lane] | None = None,
        speed_limit: float = 36.0,
        stop_lines: Sequence[float] = (),
    ) -> None:
        if not isinstance(path, Path):
            raise InputError(f"path must be a Path, was {type(path).__name__}")
        self.path = path
        given: object = (Lane(d=0.0),) if lanes is None else lanes
        lanes = tuple(given) if isinstance(given, Iterable) else ()
        if not lanes or not all(isinstance(lane, Lane) for lane in lanes):
            raise InputError(f"lanes must be a sequence of Lane, was {given!r}")
        self.lanes = tuple(sorted(lanes, key=lambda lane: lane.d))
        self.speed_limit = check_real("speed_limit", speed_limit, gt=0.0)
        self.stop_lines = tuple(check_real("stop_lines", line) for line in stop_lines)
        ego_lane = self.lane_at(0.0)
        if ego_lane is None or ego_lane.direction != 1:
            raise InputError("lanes must contain the route (d = 0) in a lane of direction 1")
        self.ego_lane = ego_lane

    def __repr__(self) -> str:
        return f"Road({self.path!r}, {len(self.lanes)} lanes, {self.speed_limit:g} m/s)"

    def _repr_svg_(self) -> str:
        svg: str = import_module("cca_core.plot.svg").to_svg(self)
        return svg

    @property
    def right_edge(self) -> float:
        """Lateral offset of the right road edge [m]."""
        return min(lane.right for lane in self.lanes)

    @property
    def left_edge(self) -> float:
        """Lateral offset of the left road edge [m]."""
        return max(lane.left for lane in self.lanes)

    def lane_at(self, d: float) -> Lane | None:
        """Lane at a lateral offset.

        Parameters
        ----------
        d : float
            Lateral offset [m], left positive.

        Returns
        -------
        lane : Lane or None
            The lane that contains `d`; None off the road.
        """
        return next((lane for lane in self.lanes if lane.right <= d <= lane.left), None)

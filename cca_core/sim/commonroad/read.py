"""CommonRoad scenario files (XML, formats 2018b and 2020a), read with the standard library alone."""

import math
from collections.abc import Callable, Container, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath
from types import MappingProxyType
from xml.etree.ElementTree import Element

import numpy as np

from cca_core._checks import Array, read_real
from cca_core.errors import InputError
from cca_core.geometry import arc_length
from cca_core.sim.commonroad._xml import (
    child,
    frozen,
    identity,
    interval,
    middle,
    number,
    parse,
    points,
    references,
)
from cca_core.sim.commonroad.lanelets import Lanelet
from cca_core.sim.commonroad.obstacles import MAX_TIME_STEP, ROLES, read_obstacle, read_state
from cca_core.sim.commonroad.scenario import CommonRoadScenario, Goal, PlanningProblem, RecordedObstacle
from cca_core.sim.commonroad.shapes import MAX_ANGLE, MIN_SIZE, corners
from cca_core.vehicle import MAX_SPEED, STANDSTILL_SPEED, VehicleState

__all__ = ["read_commonroad"]

_LIMIT_SIGNS = ("274", "R2-1")  # of most countries, and of the USA


def read_commonroad(file: str | FilePath) -> CommonRoadScenario:
    """Read a CommonRoad scenario.

    Parameters
    ----------
    file : str or pathlib.Path
        XML file of format 2018b or 2020a, at most 50 MB and 100 elements deep, without a document type
        declaration (and so without entities).

    Returns
    -------
    scenario : CommonRoadScenario
        Lanelets, obstacles and planning problems. Of traffic signs speed limits are read; lights and
        intersections are not.

    Raises
    ------
    InputError
        If the file cannot be read or is not such a scenario.

    Notes
    -----
    A position is read as the center of the body, which for the cars of this library is their center of
    gravity. Obstacles of several shapes, round or polygonal ones become the box around them, a circular goal
    a polygon of 36 corners within it. Of a region or an interval in a state the middle is taken.

    An element that cannot be read is left out, such as an obstacle that moves without a trajectory; the rest
    of the file is read. `CommonRoadScenario.left_out` and `changed` name all of these elements.

    References
    ----------
    .. [1] M. Althoff, M. Koschi, S. Manzinger, *CommonRoad: Composable benchmarks for motion planning on
       roads*, IEEE Intelligent Vehicles Symposium, 2017, pp. 719-726.
    """
    root = parse(file)
    if root.tag != "commonRoad":
        raise InputError(f"root element must be commonRoad, was {root.tag[:40]!r}")
    version = root.get("commonRoadVersion")
    if version not in ("2018b", "2020a"):
        raise InputError(f"commonRoadVersion must be 2018b or 2020a, was {str(version)[:40]!r}")
    dt = read_real("timeStepSize of commonRoad", root.get("timeStepSize"), ge=1e-3, le=10.0)
    return _Reader(dt).read(root)


class _Reader:
    """Reads the elements of a scenario, and keeps what was left out or changed."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._left_out: list[str] = []
        self._changed: list[str] = []
        self._uses: dict[str, int] = {}  # of ids of obstacles
        self._outlines: dict[int, Array] = {}

    def read(self, root: Element) -> CommonRoadScenario:
        """Return what can be read."""
        lanelets: dict[int, Lanelet] = {}
        obstacles: dict[str, RecordedObstacle] = {}
        problems: dict[int, PlanningProblem] = {}
        limits: dict[int, float] = {}
        for element in root.iterfind("trafficSign"):
            self._try(element, partial(self._add_limit, element, limits))
        for element in root.iterfind("lanelet"):
            self._try(element, partial(self._add_lanelet, element, lanelets, limits))
        lanelets = {lane.id: self._with_known_neighbors(lane, lanelets) for lane in lanelets.values()}
        for element in root:
            if element.tag in ROLES:
                self._try(element, partial(self._add_obstacle, element, obstacles))
            elif element.tag == "planningProblem":
                self._try(element, partial(self._add_problem, element, problems, lanelets))
            elif element.tag.endswith("Obstacle"):
                self._left_out.append(f"{_name(element)}: this kind is not read")
        if not (lanelets or obstacles or problems):
            reason = f": {self._left_out[0]}" if self._left_out else ""
            raise InputError(
                f"commonRoad must hold lanelets, obstacles or planning problems, held none{reason}"
            )
        return CommonRoadScenario(
            name=root.get("benchmarkID", "")[:200], dt=self._dt, lanelets=MappingProxyType(lanelets),
            obstacles=tuple(obstacles.values()), problems=tuple(problems.values()),
            left_out=tuple(self._left_out), changed=tuple(self._changed),
        )  # fmt: skip

    def _try(self, element: Element, read: Callable[[], None]) -> None:
        """Read an element, or name it and the reason why not."""
        n = len(self._changed)
        try:
            read()
        except InputError as error:
            del self._changed[n:]
            self._left_out.append(f"{_name(element)}: {error}")

    def _add_lanelet(
        self, element: Element, lanelets: dict[int, Lanelet], limits: Mapping[int, float]
    ) -> None:
        lane = _lanelet(element, self._changed)
        _check_new(lane.id, lanelets)
        signs = references(element, "trafficSignRef", _name(element))
        limit = min((limits.get(sign, math.inf) for sign in signs), default=math.inf)
        if element.find("speedLimit") is not None:  # format 2018b
            limit = number(element, "speedLimit", _name(element), ge=0.1, le=MAX_SPEED)
        lanelets[lane.id] = replace(lane, speed_limit=limit)

    def _add_limit(self, element: Element, limits: dict[int, float]) -> None:
        """Keep the speed of a sign that limits it."""
        for sign in element.iterfind("trafficSignElement"):
            if (sign.findtext("trafficSignID") or "").strip() in _LIMIT_SIGNS:
                speed = number(sign, "additionalValue", _name(element), ge=0.1, le=MAX_SPEED)
                limits[_id(element)] = speed

    def _with_known_neighbors(self, lane: Lanelet, lanelets: Mapping[int, Lanelet]) -> Lanelet:
        """Return a lanelet without its references to lanelets that are not in the file."""
        sides = [pair for pair in (lane.on_left, lane.on_right) if pair is not None]
        unknown = {*lane.predecessors, *lane.successors, *(pair[0] for pair in sides)} - lanelets.keys()
        if not unknown:
            return lane
        self._left_out += [
            f"lanelet {lane.id}: refers to lanelet {id_}, which is not read" for id_ in sorted(unknown)
        ]
        return replace(
            lane,
            predecessors=tuple(i for i in lane.predecessors if i not in unknown),
            successors=tuple(i for i in lane.successors if i not in unknown),
            on_left=None if lane.on_left is None or lane.on_left[0] in unknown else lane.on_left,
            on_right=None if lane.on_right is None or lane.on_right[0] in unknown else lane.on_right,
        )

    def _add_obstacle(self, element: Element, obstacles: dict[str, RecordedObstacle]) -> None:
        plain = (element.get("id") or "").strip()[:40] or "unnamed"
        number = self._uses[plain] = self._uses.get(plain, 0) + 1
        id_ = plain if number == 1 else f"{plain} ({number})"
        _check_new(id_, obstacles)
        obstacles[id_] = read_obstacle(element, _name(element), id_, self._dt, self._changed)
        if number > 1:
            self._changed.append(f"{_name(element)}: its id was taken, and is {id_!r} now")

    def _add_problem(
        self, element: Element, problems: dict[int, PlanningProblem], lanelets: Mapping[int, Lanelet]
    ) -> None:
        problem = self._problem(element, lanelets)
        _check_new(problem.id, problems)
        problems[problem.id] = problem

    def _problem(self, element: Element, lanelets: Mapping[int, Lanelet]) -> PlanningProblem:
        name, id_ = _name(element), _id(element)
        start = child(element, "initialState", name)
        where = f"initialState of {name}"
        step, x, y, psi, v, is_uncertain = read_state(start, where)
        for tag, value in (("orientation", psi), ("velocity", v)):
            if math.isnan(value):
                raise InputError(f"{where} must hold one {tag}, held 0")
        if v < 0.0:
            raise InputError(f"velocity of {where} must be at least 0, was {v:g}")
        beta, r = (
            middle(start, tag, where, limit) for tag, limit in (("slipAngle", MAX_ANGLE), ("yawRate", 10.0))
        )
        if abs(beta) > 1.5:
            if v > STANDSTILL_SPEED:
                raise InputError(f"slipAngle of {where} must be at most 1.5, was {beta:g}")
            beta = 0.0
            self._changed.append(f"{name}: slip angle at standstill left out")
        if is_uncertain:
            self._changed.append(f"{name}: uncertain state, the middle was taken")
        goals: list[Goal] = []
        for goal in element.iterfind("goalState"):
            self._try(element, partial(self._add_goal, goal, f"goalState of {name}", lanelets, goals))
        if not goals:
            raise InputError(f"{name} must hold a goalState, held none that can be read")
        beta, r = (0.0 if math.isnan(value) else value for value in (beta, r))
        state = VehicleState(x=x, y=y, psi=psi, v_x=v * math.cos(beta), v_y=v * math.sin(beta), r=r)
        return PlanningProblem(id=id_, t=step * self._dt, state=state, goals=tuple(goals))

    def _add_goal(
        self, element: Element, name: str, lanelets: Mapping[int, Lanelet], goals: list[Goal]
    ) -> None:
        first, last = interval(element, "time", name, 0.0, MAX_TIME_STEP)
        v_x, psi = (
            None if element.find(tag) is None else interval(element, tag, name, -limit, limit)
            for tag, limit in (("velocity", MAX_SPEED), ("orientation", MAX_ANGLE))
        )
        regions: list[Array] = []
        ids: tuple[int, ...] = ()
        if element.find("position") is not None:
            position = child(element, "position", name)
            named = tuple(dict.fromkeys(references(position, "lanelet", name)))
            ids = tuple(i for i in named if i in lanelets)
            self._left_out += [
                f"{name}: refers to lanelet {i}, which is not read" for i in named if i not in lanelets
            ]
            for i in ids:  # one array each, however many goals refer to it
                if i not in self._outlines:
                    self._outlines[i] = frozen(lanelets[i].outline)
            regions = [self._outlines[i] for i in ids]
            regions += [corners(shape, name) for shape in position if shape.tag != "lanelet"]
            if not regions:
                raise InputError(f"position of {name} must hold a shape or a known lanelet, held none")
        times = first * self._dt, last * self._dt
        goals.append(Goal(t=times, regions=tuple(map(frozen, regions)), lanelets=ids, v_x=v_x, psi=psi))


def _check_new(id_: object, known: Container[object]) -> None:
    if id_ in known:
        raise InputError(f"id must be unique, {id_} is not; the first one was taken")


def _id(element: Element) -> int:
    return identity(f"id of {element.tag}", element.get("id"))


def _name(element: Element) -> str:
    return f"{element.tag[:40]} {str(element.get('id'))[:40]}"


def _lanelet(element: Element, changed: list[str]) -> Lanelet:
    name = _name(element)
    left, right = (
        points(child(element, tag, name), f"{tag} of {name}") for tag in ("leftBound", "rightBound")
    )
    if len(left) != len(right):
        changed.append(
            f"{name}: rightBound has {len(right)} points, leftBound {len(left)}; both got the same number"
        )
        left, right = _resampled(left, right)
    lane = Lanelet(
        id=_id(element), left=left, right=right,
        predecessors=references(element, "predecessor", name),
        successors=references(element, "successor", name),
        on_left=_adjacent(element, "adjacentLeft", name), on_right=_adjacent(element, "adjacentRight", name),
    )  # fmt: skip
    # a tapering lanelet has no width at one end
    if not (np.hypot(*(left - right).T).max() >= MIN_SIZE and lane.length >= MIN_SIZE):
        raise InputError(f"leftBound and rightBound of {name} must be apart and have a length")
    return lane


def _resampled(left: Array, right: Array) -> tuple[Array, Array]:
    """Return two boundaries with points at the same fractions of their lengths."""
    along = [arc_length(line) / max(float(arc_length(line)[-1]), MIN_SIZE) for line in (left, right)]
    fractions = np.unique(np.concatenate(along))
    lines = [
        frozen(np.column_stack([np.interp(fractions, s, line[:, i]) for i in (0, 1)]))
        for s, line in zip(along, (left, right), strict=True)
    ]
    return lines[0], lines[1]


def _adjacent(element: Element, tag: str, name: str) -> tuple[int, int] | None:
    if element.find(tag) is None:
        return None
    found = child(element, tag, name)
    driving = found.get("drivingDir", "")
    if driving not in ("same", "opposite"):
        raise InputError(f"drivingDir of {tag} of {name} must be 'same' or 'opposite', was {driving[:40]!r}")
    return identity(f"ref of {tag} of {name}", found.get("ref")), 1 if driving == "same" else -1

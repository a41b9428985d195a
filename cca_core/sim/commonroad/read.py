"""CommonRoad scenario files (XML, formats 2018b and 2020a), read with the standard library alone."""

import math
from pathlib import Path as FilePath
from types import MappingProxyType
from xml.etree.ElementTree import Element

import numpy as np

from cca_core._checks import Array, read_real
from cca_core.errors import InputError
from cca_core.sim.commonroad._xml import (
    check_known,
    child,
    exact,
    frozen,
    interval,
    number,
    parse,
    points,
    references,
    whole,
)
from cca_core.sim.commonroad.lanelets import Lanelet
from cca_core.sim.commonroad.scenario import CommonRoadScenario, Goal, PlanningProblem, RecordedObstacle
from cca_core.vehicle import MAX_SPEED, VehicleState

__all__ = ["read_commonroad"]

_ROLES = {"staticObstacle": "static", "dynamicObstacle": "dynamic", "obstacle": None}
_MAX_TIME_STEP = 1e6  # [-]
_MAX_ANGLE = 100.0  # [rad]
_MIN_SIZE = 1e-3  # of a shape [m]


def read_commonroad(file: str | FilePath) -> CommonRoadScenario:
    """Read a CommonRoad scenario.

    Parameters
    ----------
    file : str or pathlib.Path
        XML file of format 2018b or 2020a, at most 50 MB, without a document type declaration (and so
        without entities).

    Returns
    -------
    scenario : CommonRoadScenario
        Lanelets, obstacles and planning problems. Traffic signs, lights and intersections are not read.

    Raises
    ------
    InputError
        If the file cannot be read or is not such a scenario; it names the element.

    Notes
    -----
    A position is read as the center of the body, which for the cars of this library is their center of
    gravity. A round or polygonal obstacle becomes the box around it, a circular goal a polygon of 36
    corners within it. Only one trajectory of exact states is read, no set of occupancies.

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
        raise InputError(f"commonRoadVersion must be 2018b or 2020a, was {version!r}")
    dt = read_real("timeStepSize of commonRoad", root.get("timeStepSize"), ge=1e-3, le=10.0)
    bodies = [element for element in root if element.tag in _ROLES]
    named = [*root.iterfind("lanelet"), *bodies, *root.iterfind("planningProblem")]
    ids = [_id(element) for element in named]
    if len(set(ids)) < len(ids):
        raise InputError(f"id must be unique, {next(i for i in ids if ids.count(i) > 1)} is not")
    lanelets = {lane.id: lane for lane in map(_lanelet, root.iterfind("lanelet"))}
    for lane in lanelets.values():
        adjacent = tuple(pair[0] for pair in (lane.on_left, lane.on_right) if pair is not None)
        check_known((*lane.predecessors, *lane.successors, *adjacent), lanelets, f"lanelet {lane.id}")
    problems = tuple(_problem(element, dt, lanelets) for element in root.iterfind("planningProblem"))
    if not problems:
        raise InputError("commonRoad must hold a planningProblem, held none")
    return CommonRoadScenario(
        name=root.get("benchmarkID", ""), dt=dt, lanelets=MappingProxyType(lanelets),
        obstacles=tuple(_obstacle(element, dt) for element in bodies), problems=problems,
    )  # fmt: skip


def _id(element: Element) -> int:
    return whole(f"id of {element.tag}", element.get("id"))


def _name(element: Element) -> str:
    return f"{element.tag} {element.get('id')}"


def _lanelet(element: Element) -> Lanelet:
    name = _name(element)
    left, right = (
        points(child(element, tag, name), f"{tag} of {name}") for tag in ("leftBound", "rightBound")
    )
    if len(left) != len(right):
        raise InputError(f"rightBound of {name} must have {len(left)} points as leftBound, had {len(right)}")
    lane = Lanelet(
        id=_id(element), left=left, right=right,
        predecessors=references(element, "predecessor", name),
        successors=references(element, "successor", name),
        on_left=_adjacent(element, "adjacentLeft", name), on_right=_adjacent(element, "adjacentRight", name),
    )  # fmt: skip
    if not (lane.width >= _MIN_SIZE and lane.length >= _MIN_SIZE):
        raise InputError(f"leftBound and rightBound of {name} must be apart and have a length")
    return lane


def _adjacent(element: Element, tag: str, name: str) -> tuple[int, int] | None:
    if element.find(tag) is None:
        return None
    found = child(element, tag, name)
    driving = found.get("drivingDir", "")
    if driving not in ("same", "opposite"):
        raise InputError(f"drivingDir of {tag} of {name} must be 'same' or 'opposite', was {driving!r}")
    return whole(f"ref of {tag} of {name}", found.get("ref")), 1 if driving == "same" else -1


def _obstacle(element: Element, dt: float) -> RecordedObstacle:
    name = _name(element)
    role = _ROLES[element.tag] or (child(element, "role", name).text or "").strip()
    if role not in ("static", "dynamic"):
        raise InputError(f"role of {name} must be 'static' or 'dynamic', was {role!r}")
    recorded = [child(element, "initialState", name)]
    if role == "dynamic":
        recorded += child(element, "trajectory", name).findall("state")
    states = np.array([_state(e, f"{e.tag} of {name}", is_static=role == "static") for e in recorded])
    step, x, y, psi, v_x = states.T
    if not (np.diff(step) > 0.0).all():
        raise InputError(f"time of the states of {name} must increase")
    psi = np.unwrap(psi)
    center, turn, length, width = _box(child(element, "shape", name), name)
    x = x + np.cos(psi) * center[0] - np.sin(psi) * center[1]
    y = y + np.sin(psi) * center[0] + np.cos(psi) * center[1]
    return RecordedObstacle(
        id=str(_id(element)), kind=(element.findtext("type") or "").strip(), length=length, width=width,
        t=frozen(step * dt), states=frozen(np.column_stack((x, y, psi + turn, v_x))),
        static=role == "static",
    )  # fmt: skip


def _state(
    element: Element, name: str, *, is_static: bool = False
) -> tuple[float, float, float, float, float]:
    """Time step [-], x, y [m], psi [rad], v_x [m/s]; a static obstacle needs no velocity."""
    step = whole(f"time of {name}", child(child(element, "time", name), "exact", f"time of {name}").text)
    if step > _MAX_TIME_STEP:
        raise InputError(f"time of {name} must be at most {_MAX_TIME_STEP:g}, was {step}")
    point = child(child(element, "position", name), "point", f"position of {name}")
    x, y = (number(point, axis, f"position of {name}") for axis in ("x", "y"))
    psi = exact(element, "orientation", name, _MAX_ANGLE)
    resting = is_static and element.find("velocity") is None
    return step, x, y, psi, 0.0 if resting else exact(element, "velocity", name, MAX_SPEED)


def _box(shape: Element, name: str) -> tuple[tuple[float, float], float, float, float]:
    """Center, heading, length and width of the box around a shape, in the obstacle's own frame."""
    form = _only(shape, f"shape of {name}")
    where = f"{form.tag} of {name}"
    if form.tag == "rectangle":
        return _rectangle(form, where)
    if form.tag == "circle":
        size = 2.0 * number(form, "radius", where, ge=_MIN_SIZE)
        return _center(form, where), 0.0, size, size
    if form.tag == "polygon":
        corners = points(form, where, 3)
        (x, y), (length, width) = 0.5 * (corners.min(0) + corners.max(0)), np.ptp(corners, axis=0)
        if min(length, width) < _MIN_SIZE:
            raise InputError(f"{where} must enclose an area")
        return (float(x), float(y)), 0.0, float(length), float(width)
    raise InputError(f"shape of {name} must be a rectangle, circle or polygon, was {form.tag!r}")


def _only(element: Element, name: str) -> Element:
    if len(element) != 1:
        raise InputError(f"{name} must hold one element, held {len(element)}")
    return element[0]


def _rectangle(form: Element, name: str) -> tuple[tuple[float, float], float, float, float]:
    psi = 0.0
    if form.find("orientation") is not None:
        psi = number(form, "orientation", name, ge=-_MAX_ANGLE, le=_MAX_ANGLE)
    length, width = (number(form, tag, name, ge=_MIN_SIZE) for tag in ("length", "width"))
    return _center(form, name), psi, length, width


def _center(form: Element, name: str) -> tuple[float, float]:
    if form.find("center") is None:
        return 0.0, 0.0
    center = child(form, "center", name)
    return number(center, "x", f"center of {name}"), number(center, "y", f"center of {name}")


def _problem(element: Element, dt: float, lanelets: dict[int, Lanelet]) -> PlanningProblem:
    name = _name(element)
    start = child(element, "initialState", name)
    where = f"initialState of {name}"
    step, x, y, psi, v = _state(start, where)
    beta = exact(start, "slipAngle", where, 1.5) if start.find("slipAngle") is not None else 0.0
    r = exact(start, "yawRate", where, 10.0) if start.find("yawRate") is not None else 0.0
    if v < 0.0:
        raise InputError(f"velocity of {where} must be at least 0, was {v:g}")
    goals = tuple(_goal(goal, f"goalState of {name}", dt, lanelets) for goal in element.iterfind("goalState"))
    if not goals:
        raise InputError(f"{name} must hold a goalState, held none")
    state = VehicleState(x=x, y=y, psi=psi, v_x=v * math.cos(beta), v_y=v * math.sin(beta), r=r)
    return PlanningProblem(id=_id(element), t=step * dt, state=state, goals=goals)


def _goal(element: Element, name: str, dt: float, lanelets: dict[int, Lanelet]) -> Goal:
    first, last = interval(element, "time", name, 0.0, _MAX_TIME_STEP)
    v_x, psi = (
        None if element.find(tag) is None else interval(element, tag, name, -limit, limit)
        for tag, limit in (("velocity", MAX_SPEED), ("orientation", _MAX_ANGLE))
    )
    regions: list[Array] = []
    ids: tuple[int, ...] = ()
    if element.find("position") is not None:
        position = child(element, "position", name)
        ids = references(position, "lanelet", name)
        check_known(ids, lanelets, name)
        regions = [lanelets[i].outline for i in ids]
        regions += [_region(shape, name) for shape in position if shape.tag != "lanelet"]
        if not regions:
            raise InputError(f"position of {name} must hold a shape or a lanelet, held nothing")
    return Goal(
        t=(first * dt, last * dt), regions=tuple(map(frozen, regions)), lanelets=ids, v_x=v_x, psi=psi
    )


def _region(form: Element, name: str) -> Array:
    """Polygon [m] of a shape, shape (n, 2)."""
    where = f"{form.tag} of {name}"
    if form.tag == "rectangle":
        center, psi, length, width = _rectangle(form, where)
        ahead, left = 0.5 * length * np.exp(1j * psi), 0.5j * width * np.exp(1j * psi)
        corners = np.array((ahead + left, left - ahead, -ahead - left, ahead - left))
    elif form.tag == "circle":
        center = _center(form, where)
        radius = number(form, "radius", where, ge=_MIN_SIZE)
        corners = radius * np.exp(2j * np.pi * np.arange(36) / 36)
    elif form.tag == "polygon":
        return points(form, where, 3)
    else:
        raise InputError(f"position of {name} must hold shapes or lanelets, held {form.tag!r}")
    return np.column_stack((corners.real, corners.imag)) + center

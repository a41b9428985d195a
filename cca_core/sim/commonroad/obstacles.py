"""Obstacles in CommonRoad files, and the states of bodies."""

import math
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.sim.commonroad._xml import child, frozen, interval, middle
from cca_core.sim.commonroad.scenario import RecordedObstacle
from cca_core.sim.commonroad.shapes import MAX_ANGLE, box, position
from cca_core.vehicle import MAX_SPEED

ROLES = {"staticObstacle": "static", "dynamicObstacle": "dynamic", "obstacle": None}
MAX_TIME_STEP = 1e6  # [-]


class BodyState(NamedTuple):
    """Time step [-], position [m], heading [rad] and speed [m/s]; NaN where not given."""

    step: float
    x: float
    y: float
    psi: float
    v_x: float
    is_uncertain: bool


def read_state(element: Element, name: str) -> BodyState:
    """Return a state; of a region or an interval its middle."""
    low, high = interval(element, "time", name, 0.0, MAX_TIME_STEP)
    step = math.floor(0.5 * (low + high))
    if low == high != step:
        raise InputError(f"time of {name} must be a whole number, was {low:g}")
    x, y, is_region = position(element, name)
    psi = middle(element, "orientation", name, MAX_ANGLE)
    v_x, v_y = (middle(element, tag, name, MAX_SPEED) for tag in ("velocity", "velocityY"))
    if math.isnan(psi) and math.isfinite(v_x + v_y):  # a point mass
        psi, v_x = math.atan2(v_y, v_x), math.hypot(v_x, v_y)
    tags = [element.find(f"{tag}/intervalStart") for tag in ("time", "orientation", "velocity")]
    return BodyState(step, x, y, psi, v_x, is_region or any(tag is not None for tag in tags))


def read_obstacle(element: Element, name: str, id_: str, dt: float, changed: list[str]) -> RecordedObstacle:
    """Return an obstacle; what is read otherwise than it stands goes to `changed`."""
    role = ROLES[element.tag] or (child(element, "role", name).text or "").strip()
    if role not in ("static", "dynamic"):
        raise InputError(f"role of {name} must be 'static' or 'dynamic', was {role[:40]!r}")
    states = [read_state(child(element, "initialState", name), f"initialState of {name}")]
    if role == "dynamic":
        states += _trajectory(element, name, changed)
        if len(states) == 1:
            _check_standstill(element, states[0], name)
            changed.append(f"{name}: without a trajectory, at standstill")
            role = "static"
    if any(state.is_uncertain for state in states):
        changed.append(f"{name}: uncertain states, the middle was taken")
    states = _in_order(states, name, changed)
    step, x, y, psi, v_x = np.array([state[:5] for state in states], dtype=np.float64).T
    psi, v_x = _completed(step * dt, x, y, psi, v_x, name, is_static=role == "static")
    center, turn, length, width = box(child(element, "shape", name), name)
    x = x + np.cos(psi) * center[0] - np.sin(psi) * center[1]
    y = y + np.sin(psi) * center[0] + np.cos(psi) * center[1]
    return RecordedObstacle(
        id=id_, kind=(element.findtext("type") or "").strip()[:40], length=length, width=width,
        t=frozen(step * dt), states=frozen(np.column_stack((x, y, psi + turn, v_x))),
        static=role == "static",
    )  # fmt: skip


def _trajectory(element: Element, name: str, changed: list[str]) -> list[BodyState]:
    """Return the states of a trajectory that can be read."""
    if element.find("trajectory") is None:
        return []
    states, errors = [], []
    for state in child(element, "trajectory", name).iterfind("state"):
        try:
            states.append(read_state(state, f"state of {name}"))
        except InputError as error:
            errors.append(str(error))
    if len(errors) > len(states):
        raise InputError(errors[0])
    if errors:
        changed.append(f"{name}: {len(errors)} states left out: {errors[0]}")
    return states


def _check_standstill(element: Element, state: BodyState, name: str) -> None:
    """Raise if a body without a trajectory moves: where to is not known."""
    if abs(state.v_x) > 0.1 or element.find("occupancySet") is not None:
        instead = ", and its occupancySet is not read" if element.find("occupancySet") is not None else ""
        raise InputError(f"{name} must hold one trajectory, held 0{instead}")


def _in_order(states: list[BodyState], name: str, changed: list[str]) -> list[BodyState]:
    """Return the states by time, the first one of each time."""
    first: dict[float, BodyState] = {}
    for state in states:
        first.setdefault(state.step, state)
    ordered = sorted(first.values(), key=lambda state: state.step)
    if len(ordered) < len(states) or ordered != states:
        changed.append(
            f"{name}: states in order of time, {len(states) - len(ordered)} repeated ones left out"
        )
    return ordered


def _completed(
    t: Array, x: Array, y: Array, psi: Array, v_x: Array, name: str, *, is_static: bool
) -> tuple[Array, Array]:
    """Fill in headings and speeds that are not given, from the motion."""
    moving = len(t) > 1
    rate = np.gradient(x, t) + 1j * np.gradient(y, t) if moving else np.zeros(1, dtype=np.complex128)
    psi = np.where(np.isnan(psi) & (np.abs(rate) > 0.1), np.angle(rate), psi)
    known = np.flatnonzero(~np.isnan(psi))
    if not len(known):
        raise InputError(f"orientation of {name} must be given or follow from its motion")
    before = np.searchsorted(known, np.arange(len(psi)), side="right") - 1
    psi = np.unwrap(psi[known[np.maximum(before, 0)]])
    if np.isnan(v_x).any() and not (moving or is_static):
        raise InputError(f"velocity of {name} must be given or follow from its motion")
    along = (rate * np.exp(-1j * psi)).real
    return psi, np.clip(np.where(np.isnan(v_x), along, v_x), -MAX_SPEED, MAX_SPEED)

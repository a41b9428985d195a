"""The ego and the others along the route, as the V2V applications see them."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from cca_core._checks import check_real
from cca_core.decide.crossing import Conflict, find_conflict_for_sweep
from cca_core.decide.sweep import Sweep
from cca_core.errors import InputError
from cca_core.geometry import wrap_angle
from cca_core.path import Path, Road
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState
from cca_core.warnings.alert import PARALLEL_ANGLE, AlertSettings, EgoView, Sighting

__all__ = ["warning_view"]

_GRID = 10.0  # distance of places on the route to begin the search for foot points with [m]
_FARTHEST = 1000.0  # nobody beyond is looked at [m]
_AREA = 40.0  # length of a conflict area with a long vehicle, at an angle [m]
_APPROACH = 10.0  # the route's heading this far before a conflict area is that of the approach [m]
_TURN = math.pi / 6.0  # change of heading from which on the route turns [rad]
_CREEPS = 0.1  # an ego slower than this does not reach a crossing [m/s]


def warning_view(
    state: VehicleState,
    vehicle: VehicleParams,
    road: Path | Road,
    remotes: Iterable[RemoteVehicle],
    *,
    intent: Literal["left", "right"] | None = None,
    near: float | None = None,
    settings: AlertSettings | None = None,
) -> tuple[EgoView, tuple[Sighting, ...]]:
    """Bring the ego and the others to the route: what the applications work on.

    Parameters
    ----------
    state : VehicleState
        The ego now.
    vehicle : VehicleParams
        Its body.
    road : Path or Road
        Its route; a path is one lane of 3.5 m.
    remotes : iterable of RemoteVehicle
        What is known of the others; what cannot be used is left out, of two with one id the younger counts.
    intent : {"left", "right"}, optional
        Where the ego means to turn or to change lanes, as by its indicator.
    near : float, optional
        Path coordinate close to the ego [m], such as last cycle's.
    settings : AlertSettings, optional
        Thresholds.

    Returns
    -------
    ego : EgoView
        The ego.
    others : tuple of Sighting
        Each usable vehicle, with the conflict where its way crosses that of the ego.

    Raises
    ------
    InputError
        As for `warn`.
    """
    settings = AlertSettings() if settings is None else settings
    if not isinstance(road, Path | Road):
        raise InputError(f"road must be a Path or a Road, was {type(road).__name__}")
    if intent not in (None, "left", "right"):
        raise InputError(f'intent must be "left", "right" or None, was {intent!r}')
    path, width = (road, 3.5) if isinstance(road, Path) else (road.path, road.ego_lane.width)
    near = float(path.project((state.x, state.y))[0]) if near is None else check_real("near", near)
    s, d, heading, _ = path.foot_point(state.x, state.y, near)
    cos, sin = math.cos(state.psi - heading), math.sin(state.psi - heading)
    s, d = vehicle.center_at(s, d, state.psi - heading)
    ego = EgoView(
        path=path, s=s, d=d,
        v=state.v_x * cos - state.v_y * sin,
        half_length=0.5 * vehicle.length, half_width=0.5 * vehicle.width, lane_width=width, intent=intent,
    )  # fmt: skip
    usable: dict[str, RemoteVehicle] = {}
    for remote in remotes:
        if remote.invalid_reason is not None or remote.age > settings.max_age:
            continue
        if remote.id not in usable or remote.age < usable[remote.id].age:
            usable[remote.id] = remote
    others = _to_frenet(ego, list(usable.values()), settings)
    return ego, tuple(_classify(ego, s, vehicle, others, settings))


def _to_frenet(ego: EgoView, remotes: list[RemoteVehicle], settings: AlertSettings) -> list[Sighting]:
    """Path coordinates of those that are near enough, the foot points around the ego's."""
    if not remotes:
        return []
    fastest = abs(ego.v) + max(abs(remote.v_x) for remote in remotes)
    reach = min(max(settings.eebl_range, settings.dnpw_time * fastest) + 50.0, _FARTHEST)
    grid = np.arange(ego.s - reach, ego.s + reach, _GRID)
    points = ego.path.position(grid)
    nodes = points[:, 0] + 1j * points[:, 1]
    xy = np.array([(remote.x, remote.y) for remote in remotes])
    apart = np.abs((xy[:, 0] + 1j * xy[:, 1])[:, None] - nodes)
    nearest = apart.argmin(axis=1)
    close = np.flatnonzero(apart[np.arange(len(xy)), nearest] < reach)
    s, d = ego.path.project(xy[close], grid[nearest[close]])
    _, first, second = ego.path.derivatives(s)
    bend = 1.0 - d * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    headings = np.arctan2(first[:, 1], first[:, 0])
    found = []
    rows = zip(close.tolist(), s.tolist(), d.tolist(), headings.tolist(), bend.tolist(), strict=True)
    for index, at, side, heading, stretch in rows:
        remote = remotes[index]
        angle = wrap_angle(remote.psi - heading)
        cos, sin = math.cos(angle), math.sin(angle)
        length = 0.5 * (remote.length * abs(cos) + remote.width * abs(sin))
        found.append(
            Sighting(
                remote=remote, gap=at - length - ego.s - ego.half_length, lateral_offset=side - ego.d, angle=angle,
                v=remote.v_x * cos / max(stretch, 0.1), half_length=length,
                half_width=0.5 * (remote.length * abs(sin) + remote.width * abs(cos)),
            )
        )  # fmt: skip
    return found


def _classify(
    ego: EgoView, s: float, vehicle: VehicleParams, others: Sequence[Sighting], settings: AlertSettings
) -> list[Sighting]:
    """Add where ways cross, and who hides a standing vehicle; `s` is that of the center of gravity."""
    v = max(ego.v, settings.turning_speed if ego.intent else 0.0)
    horizon = settings.ima_time + settings.lta_gap
    at, t = np.array((s, s + v * horizon)), np.array((0.0, horizon))
    body = None
    if v > _CREEPS and others:
        # what begins later than ima_time ahead is of no interest
        reach = v * settings.ima_time + vehicle.length + _AREA
        body = Sweep.along_path(ego.path, s, s + reach, vehicle, settings.crossing.clearance)
    judged = []
    for other in others:
        conflict = None
        if body is not None:
            conflict = find_conflict_for_sweep(body, s, at, t, other.remote, horizon, settings.crossing)
        hidden = _hidden_by(other, others) if abs(other.remote.v_x) < settings.standstill_speed else ""
        if body is not None and conflict is not None:
            across = _turns_across(ego.path, body, conflict, other.remote)
            other = replace(other, conflict=conflict, crosses_ego_turn=across)
        judged.append(replace(other, occluded_by=hidden) if hidden else other)
    return judged


def _turns_across(path: Path, body: Sweep, conflict: Conflict, remote: RemoteVehicle) -> bool:
    """Whether the route turns in front of a vehicle that comes toward its approach."""
    at, start = conflict.s_enter - _APPROACH, float(body.station[0])
    before = body.heading_at(at) if at >= start else float(path.heading(at))
    oncoming = abs(wrap_angle(remote.psi - before)) > math.pi - PARALLEL_ANGLE
    return oncoming and abs(wrap_angle(body.heading_at(conflict.s_exit) - before)) > _TURN


def _hidden_by(other: Sighting, others: Iterable[Sighting]) -> str:
    """Id of the first vehicle between the ego's front and another vehicle that is in the line of sight."""
    between = [o for o in others if 0.0 < o.gap and o.gap + 2.0 * o.half_length <= other.gap]
    for o in sorted(between, key=lambda o: o.gap):
        if abs(o.lateral_offset - other.lateral_offset * o.gap / other.gap) < o.half_width:
            return o.remote.id
    return ""

"""View of the road for the V2V applications: the ego and other vehicles along the route."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.decide.crossing import Conflict, find_conflict_for_sweep
from cca_core.decide.sweep import Sweep
from cca_core.errors import InputError
from cca_core.frenet import FrenetEgo, FrenetVehicle, to_frenet
from cca_core.frenet.convert import valid_vehicles
from cca_core.geometry import wrap_angle
from cca_core.path import Path, Road
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState
from cca_core.warnings.alert import AlertSettings

PARALLEL_ANGLE = 0.25 * math.pi
"""Largest angle between a heading and the route, or its opposite, that counts as parallel [rad]."""

_GRID = 10.0  # spacing of the stations at which the search for foot points begins [m]
_MAX_RANGE = 1000.0  # beyond which no vehicle is considered [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleInView:
    """A remote vehicle relative to the ego.

    Parameters
    ----------
    vehicle : FrenetVehicle
        The vehicle at its nominal position, without uncertainty bound.
    gap : float
        Gap from the ego's front to its rear along the route [m]; negative unless it is ahead.
    lateral_offset : float
        Lateral distance from the center of the ego to its center [m], left positive.
    conflict : Conflict, optional
        Conflict of its path with that of the ego.
    crosses_ego_turn : bool
        Whether the ego turns across its lane in this conflict.
    occluded_by : str
        Id of a vehicle in the line of sight; empty if there is none.
    """

    vehicle: FrenetVehicle
    gap: float
    lateral_offset: float
    conflict: Conflict | None = None
    crosses_ego_turn: bool = False
    occluded_by: str = ""

    __repr__ = short_repr


@dataclass(frozen=True, slots=True, kw_only=True)
class WarningView:
    """The ego and the vehicles around it along the route.

    Parameters
    ----------
    path : Path
        The route.
    ego : FrenetEgo
        The ego; it keeps its speed.
    lane_width : float
        Width of its lane [m].
    intent : {"left", "right"}, optional
        Side to which the ego intends to turn or to change lanes.
    vehicles : tuple of VehicleInView
        The other vehicles.
    """

    path: Path
    ego: FrenetEgo
    lane_width: float = 3.5
    intent: Literal["left", "right"] | None = None
    vehicles: tuple[VehicleInView, ...] = ()

    __repr__ = short_repr


def warning_view(
    state: VehicleState,
    vehicle: VehicleParams,
    road: Path | Road,
    remotes: Iterable[RemoteVehicle],
    *,
    intent: Literal["left", "right"] | None = None,
    s_guess: float | None = None,
    settings: AlertSettings | None = None,
) -> WarningView:
    """Convert the ego and other vehicles to the route, on which the applications work.

    Parameters
    ----------
    state : VehicleState
        The ego now.
    vehicle : VehicleParams
        The ego's body.
    road : Path or Road
        Its route; a path is one lane of 3.5 m.
    remotes : iterable of RemoteVehicle
        The other vehicles. Invalid ones are left out; of two with one id the one with the smaller age counts.
    intent : {"left", "right"}, optional
        Side to which the ego intends to turn or to change lanes, as by its indicator.
    s_guess : float, optional
        Station close to the ego [m], such as that of the last cycle.
    settings : AlertSettings, optional
        Thresholds.

    Returns
    -------
    view : WarningView
        The ego and each valid vehicle, with the conflict of its path with that of the ego.

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
    guess = path.project((state.x, state.y))[0] if s_guess is None else check_real("s_guess", s_guess)
    s_cg, d_cg, heading, _ = path.foot_point(state.x, state.y, float(guess))
    angle = state.psi - heading
    s, d = vehicle.center_at(s_cg, d_cg, angle)
    v = state.v_x * math.cos(angle) - state.v_y * math.sin(angle)
    ego = FrenetEgo(vehicle=vehicle, s=s, d=d, v_x=v, v_target=v)
    view = WarningView(path=path, ego=ego, lane_width=width, intent=intent)
    recent = [r for r in valid_vehicles(remotes)[0].values() if r.age <= settings.max_age]
    vehicles = _find_conflicts(view, s_cg, _vehicles_in_view(view, recent, settings), recent, settings)
    return replace(view, vehicles=tuple(vehicles))


def _vehicles_in_view(
    view: WarningView, remotes: list[RemoteVehicle], settings: AlertSettings
) -> list[VehicleInView]:
    """Vehicles that are near enough, with foot points around that of the ego."""
    if not remotes:
        return []
    ego = view.ego
    closing_speed = abs(ego.v_x) + max(abs(remote.v_x) for remote in remotes)
    reach = min(max(settings.eebl_range, settings.dnpw_time * closing_speed) + 50.0, _MAX_RANGE)
    grid = np.arange(ego.s - reach, ego.s + reach, _GRID)
    points = view.path.position(grid)
    xy = np.array([(remote.x, remote.y) for remote in remotes])
    distance = np.hypot(*(xy[:, None, :] - points).transpose(2, 0, 1))
    nearest = distance.argmin(axis=1)
    near = np.flatnonzero(distance[np.arange(len(xy)), nearest] < reach).tolist()
    guesses = {remotes[i].id: float(grid[nearest[i]]) for i in near}
    everywhere = -math.inf, math.inf
    found, _ = to_frenet([remotes[i] for i in near], view.path, guesses, everywhere)
    nominal = [replace(n.nominal(), angle=wrap_angle(n.angle)) for n in found]
    return [VehicleInView(vehicle=n, gap=n.rear - ego.front, lateral_offset=n.d - ego.d) for n in nominal]


def _find_conflicts(
    view: WarningView,
    s_cg: float,
    vehicles: Sequence[VehicleInView],
    remotes: Sequence[RemoteVehicle],
    settings: AlertSettings,
) -> list[VehicleInView]:
    """Add conflicts, and what occludes a stationary vehicle; `s_cg` is the station of the ego [m]."""
    v = max(view.ego.v_x, settings.turning_speed if view.intent else 0.0)
    horizon = settings.ima_time + settings.lta_gap
    stations, t = np.array((s_cg, s_cg + v * horizon)), np.array((0.0, horizon))
    body = None
    if v > settings.min_speed and vehicles:
        # an area that begins later than ima_time ahead is irrelevant; 40 m is one with a long vehicle
        reach = v * settings.ima_time + view.ego.vehicle.length + 40.0
        body = Sweep.along_path(view.path, s_cg, s_cg + reach, view.ego.vehicle, settings.crossing.clearance)
    reported = {remote.id: remote for remote in remotes}
    result = []
    for other in vehicles:
        if abs(other.vehicle.remote.v_x) < settings.standstill_speed:
            other = replace(other, occluded_by=_occluding_vehicle(other, vehicles))
        if body is not None:
            remote = reported[other.vehicle.id]
            conflict = find_conflict_for_sweep(body, s_cg, stations, t, remote, horizon, settings.crossing)
            if conflict is not None:
                crosses = _ego_turns_across(view.path, body, conflict, remote, settings)
                other = replace(other, conflict=conflict, crosses_ego_turn=crosses)
        result.append(other)
    return result


def _ego_turns_across(
    path: Path, body: Sweep, conflict: Conflict, remote: RemoteVehicle, settings: AlertSettings
) -> bool:
    """Whether the route turns across the lane of a vehicle that is oncoming on its approach."""
    s = conflict.s_enter - settings.approach_distance
    before = body.heading_at(s) if s >= float(body.station[0]) else float(path.heading(s))
    oncoming = abs(wrap_angle(remote.psi - before)) > math.pi - PARALLEL_ANGLE
    return oncoming and abs(wrap_angle(body.heading_at(conflict.s_exit) - before)) > settings.turn_angle


def _occluding_vehicle(other: VehicleInView, vehicles: Iterable[VehicleInView]) -> str:
    """Id of the first vehicle in the line of sight from the ego's front; empty if there is none."""
    between = [v for v in vehicles if 0.0 < v.gap and v.gap + 2.0 * v.vehicle.half_length <= other.gap]
    for v in sorted(between, key=lambda v: v.gap):
        if abs(v.lateral_offset - other.lateral_offset * v.gap / other.gap) < v.vehicle.half_width:
            return v.vehicle.id
    return ""


def is_ahead(view: WarningView, other: VehicleInView) -> bool:
    """Return whether the center of a vehicle is ahead of the ego's."""
    return other.gap + 0.5 * view.ego.vehicle.length + other.vehicle.half_length > 0.0


def blocks_ego(view: WarningView, other: VehicleInView, clearance: float = 0.0) -> bool:
    """Return whether a vehicle is closer to the ego's path than a lateral clearance [m]."""
    half_width = 0.5 * view.ego.vehicle.width
    return abs(other.lateral_offset) < half_width + other.vehicle.half_width + clearance

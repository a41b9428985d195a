"""Evasive maneuvers: the band around blocking vehicles, with gap acceptance of the adjacent lane."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.band import Band, Side, relax_band
from cca_core.band.problem import MAX_DISPLACEMENT, offset_curvature
from cca_core.band.solver import measure
from cca_core.decide import Candidate, Rejection, RejectionKind
from cca_core.errors import Status
from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.geometry import Boxes
from cca_core.kernel import bind
from cca_core.kernel.reach import vehicle_boxes
from cca_core.path import Lane, Path, Road, splice_path
from cca_core.planner.committed import (
    committed_nodes,
    first_replannable_node,
    relax_clearance,
    resample_displacement,
)
from cca_core.planner.gap_acceptance import check_adjacent_lane
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.window import Window, assumed_interval, is_following_ego, plan_window
from cca_core.vehicle import GRAVITY

_vehicle_boxes = bind(vehicle_boxes)
_MAX_NODES = 140  # of a band; they are never closer than 1 m
_STEERING_LIMITED_SPEED = 5.0  # below it steering limits the curvature, not the tires [m/s]
_GAP_SAMPLES = 24  # times at which a gap is checked


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Maneuver:
    """An evasive maneuver: its window on the route, its band from the ego on, and what is steered along."""

    side: Side
    start: float  # stations at which it leaves and rejoins the route [m]
    end: float
    band: Band
    displacement: Array  # lateral offsets at equal steps from start to end [m]: driven, then the band
    reference: Path
    candidate: Candidate

    @property
    def stations(self) -> Array:
        """Stations of `displacement` [m]."""
        return np.linspace(self.start, self.end, len(self.displacement))

    def offset_at(self, s: float) -> float:
        """Return the lateral offset at a station [m], 0 outside the window."""
        return float(np.interp(s, self.stations, self.displacement))


class _Stretch(NamedTuple):
    """The part of a maneuver that is planned now."""

    stations: Array  # of the whole maneuver [m]
    driven: Array | None  # displacement so far at these stations [m]; None for a new maneuver
    k: int  # first node that is planned
    t: Array  # arrival times from there on [s]

    @property
    def s(self) -> Array:
        return self.stations[self.k :]


def plan_maneuver(
    ego: FrenetEgo,
    road: Road,
    blocking: Sequence[FrenetVehicle],
    others: Sequence[FrenetVehicle],
    side: Side,
    settings: EvasionSettings,
    current: Maneuver | None = None,
    *,
    start_now: bool = False,
    cancellable: bool = False,
    awareness_range: float = math.inf,
) -> Maneuver | Candidate:
    """Plan a maneuver around blocking vehicles, nearest first, or replan the current one."""
    lane = road.lane_at(road.ego_lane.left + 0.1 if side == "left" else road.ego_lane.right - 0.1)
    kept = None if current is None else (current.start, current.end)
    window = plan_window(ego, road, lane, blocking, side, settings, kept, start_now=start_now)
    if isinstance(window, Rejection):
        return Candidate(side=side, rejection=window)
    check_gap = partial(
        check_adjacent_lane, ego, road, lane, side, [*others, *blocking[1:]], settings,
        min(settings.awareness_range, awareness_range),
    )  # fmt: skip
    if start_now and current is None and window.leaves_lane:  # rejects most gaps before a band is relaxed
        zone, rejection = check_gap(np.linspace(0.0, window.t_last, _GAP_SAMPLES))
        if rejection is not None:
            return Candidate(
                side=side, rejection=rejection, available_distance=window.first,
                required_distance=window.required, danger_zone=zone,
            )  # fmt: skip
    relevant = [o for o in others if not is_following_ego(o, ego, road.ego_lane)]
    stretch = _plan_stretch(ego, window, current)
    problem = _band_problem(ego, road, side, lane, stretch, settings)
    obstacles = _occupancies(ego, road.path, stretch, [*blocking, *relevant], settings)
    half_step = 0.5 * float(stretch.stations[1] - stretch.stations[0])
    # bounds begin a node before
    lead_distances = [max(lead - half_step, 0.0) for lead in window.lead_distances]
    band = problem(obstacles, lead_distance=[*lead_distances, *(0.0 for _ in relevant)])
    outside = (stretch.s - ego.s_cg >= window.first) & (stretch.s - ego.s_cg <= window.last)
    if band.status is Status.OK:
        outside = _outside_lane(ego, road.ego_lane, band)
        if relevant and current is None:
            # an uncertain vehicle pushes the band back sooner, which must not make the gap acceptable
            alone = problem(obstacles[: len(blocking)], lead_distance=lead_distances)
            outside = outside | _outside_lane(ego, road.ego_lane, alone)
    until = 0.0
    zone, rejection = None, None
    if outside.any():
        until = float(stretch.t[np.flatnonzero(outside)[-1]])
        until += ego.vehicle.length / max(window.v_return, 1.0)
        if current is None or cancellable:
            # after waiting the gap must be open now, otherwise once the ego enters the lane
            waited = start_now and current is None
            begin = 0.0 if waited else max(float(stretch.t[np.argmax(outside)]), 0.0)
            zone, rejection = check_gap(np.linspace(begin, until, _GAP_SAMPLES))
    if band.status is not Status.OK and rejection is None:
        rejection = _reject_band(band, side, [*blocking, *relevant], stretch.s - ego.s_cg)
    candidate = Candidate(
        side=side, rejection=rejection, available_distance=window.first, required_distance=window.required,
        t_maneuver=until, danger_zone=zone, cost=float(np.abs(band.displacement).max()),
    )  # fmt: skip
    return _assemble(road.path, side, window, stretch, band, candidate)


def predicted_occupancy(
    path: Path, s: Array, others: Sequence[FrenetVehicle], t: Array, settings: EvasionSettings
) -> Boxes:
    """Return a box for each vehicle, first the overtaken one, and each station of the ego, shape (m, n)."""
    intervals = [assumed_interval(o, t, settings, o is others[0]) for o in others]
    rear, front = (np.array(ends) for ends in zip(*intervals, strict=True))
    d, half_width = np.array([o.d for o in others]), np.array([o.half_width for o in others])
    boxes = np.empty((*rear.shape, 5))
    vehicles, times = rear.shape
    at, rows = np.ascontiguousarray(s), boxes.reshape(-1, 5)
    _vehicle_boxes(path.curve, vehicles, times, at, rear, front, d, half_width, rows)
    return Boxes(*np.moveaxis(boxes, -1, 0))


def _plan_stretch(ego: FrenetEgo, window: Window, current: Maneuver | None) -> _Stretch:
    """Nodes of the window; what has been driven stays, and the band continues from there."""
    n = 1 + min(_MAX_NODES, max(20, math.ceil(window.end - window.start)))
    stations = np.linspace(window.start, window.end, n)
    driven, k = None, 0
    if current is not None and ego.s_cg >= window.start:
        driven = resample_displacement(stations, current.stations, current.displacement)
        k = first_replannable_node(stations, ego.s_cg)
    return _Stretch(stations, driven, k, ego.arrival_times(stations[k:]))


def _committed(stretch: _Stretch, settings: EvasionSettings) -> int:
    return min(committed_nodes(stretch.t, settings.replan), len(stretch.t) - 1)


def _band_problem(
    ego: FrenetEgo, road: Road, side: Side, lane: Lane | None, stretch: _Stretch, settings: EvasionSettings
) -> partial[Band]:
    """`relax_band` with the corridor and the curvature limit; the committed part may stay as it is."""
    s, driven, k = stretch.s, stretch.driven, stretch.k
    right = road.ego_lane.right if side == "left" or lane is None else lane.right
    left = road.ego_lane.left if side == "right" or lane is None else lane.left
    squared_speed = np.maximum(_max_speeds(ego, s), _STEERING_LIMITED_SPEED) ** 2
    curvature_limit = settings.lateral_acceleration_limit / squared_speed
    tolerance = np.zeros(len(s))
    if driven is not None:
        m, replan = _committed(stretch, settings), settings.replan
        h, three = stretch.stations[1] - stretch.stations[0], [driven[k + i : k + i + m] for i in (-1, 0, 1)]
        curvature = np.abs(offset_curvature(road.path.curvature(s[:m]), np.stack(three), h))
        grip = settings.last_resort.grip_fraction * ego.vehicle.mu * GRAVITY / squared_speed[:m]
        allowed = np.minimum((1.0 + replan.curvature_tolerance) * curvature, grip)
        curvature_limit[:m] = np.maximum(curvature_limit[:m], allowed)
        tolerance[: m + math.ceil(ego.vehicle.length / h)] = replan.edge_tolerance  # which the body reaches
    return partial(
        relax_band, road.path.position(s), side=side, vehicle=ego.vehicle, clearance=settings.clearance,
        corridor=(right - tolerance, left + tolerance), curvature_limit=curvature_limit,
        start=0.0 if driven is None else driven[k - 1 : k + 2],
    )  # fmt: skip


def _occupancies(
    ego: FrenetEgo, path: Path, stretch: _Stretch, others: Sequence[FrenetVehicle], settings: EvasionSettings
) -> list[Boxes]:
    """Predicted occupancy of each vehicle, relaxed where the committed part is too close already."""
    occupancy = predicted_occupancy(path, stretch.s, others, stretch.t, settings)
    if stretch.driven is not None:
        m, k = _committed(stretch, settings), stretch.k
        body = ego.swept_boxes(path, stretch.s[:m], stretch.driven[k : k + m])
        occupancy = relax_clearance(occupancy, body, stretch.t, settings.clearance, settings.replan)
    columns = occupancy.x, occupancy.y, occupancy.psi, occupancy.length, occupancy.width
    return [Boxes(*row) for row in zip(*columns, strict=True)]


def _assemble(
    path: Path, side: Side, window: Window, stretch: _Stretch, band: Band, candidate: Candidate
) -> Maneuver:
    """Join what has been driven, the band and the route."""
    displacement, nodes = band.displacement, band.nodes
    if stretch.driven is not None:
        driven = stretch.driven[: stretch.k]
        displacement = np.append(driven, displacement)
        nodes = np.vstack((path.to_cartesian(stretch.stations[: stretch.k], driven), nodes))
    return Maneuver(
        side=side, start=window.start, end=window.end, band=band, displacement=displacement,
        candidate=candidate, reference=splice_path(path, stretch.stations, nodes),
    )  # fmt: skip


def _reject_band(band: Band, side: Side, vehicles: Sequence[FrenetVehicle], ahead: Array) -> Rejection:
    """Rejection of a band that is not OK, from the constraint that decides."""
    kinds, obstacle = RejectionKind, band.active_obstacle
    if band.status is not Status.INFEASIBLE:
        return Rejection(kind=kinds.NOT_CONVERGED, side=side)
    if band.active_constraint == "curvature":
        limit = float(np.min(band.problem.curvature_limit))
        return Rejection(kind=kinds.CURVATURE, side=side, value=band.curvature, limit=limit)
    if band.active_constraint in ("left edge", "right edge"):
        return Rejection(kind=kinds.ROAD_EDGE, side=side, value=max(-band.edge_clearance, 0.0))
    vehicle_id = "" if obstacle is None else vehicles[obstacle].id
    measured = measure(band.problem, passes_left=band.passes_left)
    overlap = measured.lower - measured.upper
    if (overlap > 0.0).any():
        distance = float(ahead[int(np.argmax(overlap))])
        return Rejection(kind=kinds.NO_SPACE, side=side, vehicle_id=vehicle_id, distance=distance)
    offset = float(np.abs(band.displacement).max())
    if offset > MAX_DISPLACEMENT:
        return Rejection(kind=kinds.LATERAL_OFFSET, side=side, value=offset, limit=MAX_DISPLACEMENT)
    return Rejection(
        kind=kinds.CLEARANCE, side=side, vehicle_id=vehicle_id, value=band.clearance,
        limit=band.problem.clearance,
    )  # fmt: skip


def _max_speeds(ego: FrenetEgo, s: Array) -> Array:
    """Highest speed of the ego at stations [m/s]."""
    reached = np.sqrt(ego.v_x**2 + 2.0 * ego.speed.a_max * np.maximum(s - ego.s_cg, 0.0))
    speeds: Array = np.maximum(np.minimum(reached, ego.v_target), ego.v_x)
    return speeds


def _outside_lane(ego: FrenetEgo, lane: Lane, band: Band) -> Mask:
    """Where the ego's body is not wholly inside a lane."""
    u, half_width = band.displacement, 0.5 * ego.vehicle.width
    outside: Mask = (u + half_width > lane.left) | (u - half_width < lane.right)
    return outside

"""Ways around what stands in the way: where to swerve, the band to drive, whether the lane beside is free.

Where to swerve, what is kept of a swerve under way and whether the lane beside is free are one decision about
one band, so this module is a little longer than others.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.band import Band, Side, relax_band
from cca_core.band.problem import offset_curve
from cca_core.decide import Candidate
from cca_core.errors import Status
from cca_core.geometry import Boxes
from cca_core.path import Lane, Path, Road, splice_path
from cca_core.planner.committed import (
    committed_nodes,
    first_replannable_node,
    relax_clearance,
    resample_displacement,
)
from cca_core.planner.frenet import HORIZON, FrenetEgo, FrenetVehicle
from cca_core.planner.gap_acceptance import check_adjacent_lane
from cca_core.planner.settings import EvasionSettings
from cca_core.predict import occupancy_boxes
from cca_core.vehicle import GRAVITY

__all__ = ["MANEUVER_GRIP_FRACTION", "EvasionSettings", "Maneuver", "plan_maneuver", "predicted_occupancy"]

MANEUVER_GRIP_FRACTION = 0.8
"""Share of the tires' grip that a swerve may use when it cannot be given up any more."""

_BEHIND = 2.0  # a window starts this far behind the car [m]
_WINDOW_HYSTERESIS = 2.0  # an end that would move on by less stays: it is an effect of rounding [m]
_CURVATURE_TOLERANCE = 1.002  # as a multiple of how it is bent already, what can hardly change may be bent
_EDGE_TOLERANCE = 0.05  # by which an edge is farther for what can hardly change [m]
_NODES = 140  # in a window, at most; never closer than 1 m
_MANEUVERING = 5.0  # slower than this the steering limits curvature, not the tires [m/s]
_QUINTIC = 5.7735  # peak of the second derivative of the quintic step
_GAP_CHECK_SAMPLES = 24  # at which the lane beside is looked at
_AHEAD = np.arange(-_BEHIND, HORIZON, 1.0)  # distances at which the ego is looked at beside others [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Maneuver:
    """A swerve that could be driven.

    Parameters
    ----------
    side : {"left", "right"}
        Side of the route to which it swerves.
    start, end : float
        Window on the route [m], at both ends of which the swerve lies on the route.
    band : Band
        The bent route from the ego on; of a new swerve from `start` on.
    displacement : ndarray, shape (n,)
        Lateral coordinate at equal steps from `start` to `end` [m], left positive: what has been driven, then
        the band.
    reference : Path
        What the steering follows: the same, then the route.
    candidate : Candidate
        The same for the choice of action.
    """

    side: Side
    start: float
    end: float
    band: Band
    displacement: Array
    reference: Path
    candidate: Candidate

    @property
    def stations(self) -> Array:
        """Path coordinates at which `displacement` is told [m]."""
        return np.linspace(self.start, self.end, len(self.displacement))

    def offset_at(self, s: float) -> float:
        """Lateral coordinate of the swerve.

        Parameters
        ----------
        s : float
            Path coordinate [m].

        Returns
        -------
        d : float
            Displacement there [m], left positive; 0 outside the window.
        """
        return float(np.interp(s, self.stations, self.displacement))


def plan_maneuver(
    ego: FrenetEgo,
    road: Road,
    blocking: Sequence[FrenetVehicle],
    others: Sequence[FrenetVehicle],
    side: Side,
    settings: EvasionSettings,
    current: Maneuver | None = None,
    at_once: bool = False,
    awareness_range: float = math.inf,
) -> Maneuver | Candidate:
    """Plan a swerve around what blocks the route.

    Parameters
    ----------
    ego : Ego
        The ego on its route.
    road : Road
        Route, lanes and edges.
    blocking : sequence of Neighbor
        Vehicles in the way, nearest first; at least one.
    others : sequence of Neighbor
        All other vehicles.
    side : {"left", "right"}
        Side to pass on.
    settings : EvasionSettings
        Clearance, comfort and caution.
    current : Evasion, optional
        The maneuver that is being driven: its window is kept, only its end may move on, and what has been
        driven of it stays.
    at_once : bool
        Whether the swerve begins now even if there would be time to drive on; of an ongoing one, whether it
        could still be given up, so that the lane beside must still be free.
    awareness_range : float
        Distance up to which all vehicles are known now [m], where that is less than the settings say.

    Returns
    -------
    evasion : Evasion or Candidate
        The swerve; a bare candidate with its obstruction where no band could be drawn.
    """
    soon = ego.arrival_times(ego.s + _AHEAD)
    leads, contact = zip(
        *(_alongside_interval(ego, b, settings, soon, b is blocking[0]) for b in blocking), strict=True
    )
    first, last = contact[0]
    if current is None and not first < last < HORIZON:
        return Candidate(
            side=side,
            rejection=f"{blocking[0].remote.id} would not be passed in {HORIZON:.0f} m",
        )
    beside = road.lane_at(road.ego_lane.left + 0.1 if side == "left" else road.ego_lane.right - 0.1)
    half_width = 0.5 * ego.vehicle.width
    offset = blocking[0].half_width + half_width + settings.clearance
    offset += blocking[0].d if side == "left" else -blocking[0].d
    room_aside = (road.ego_lane.left if side == "left" else -road.ego_lane.right) - half_width
    if beside is None and offset > room_aside:
        return Candidate(side=side, rejection="there is no lane")
    bend = np.abs(road.path.curvature(np.linspace(ego.s, ego.s + min(last, HORIZON), 20))).max()
    spare = settings.lateral_acceleration - max(ego.v_x, ego.v_target) ** 2 * float(bend)
    duration = math.sqrt(_QUINTIC * max(offset, 0.5) / max(spare, 0.5 * settings.lateral_acceleration))
    v_out, v_back = _speed_after(ego, first), _speed_after(ego, last)
    needed = v_out * (duration + settings.preparation_time)
    delay = 0.0 if at_once else max(first - needed, 0.0)
    start, end = ego.s - _BEHIND + delay, ego.s + last + v_back * duration
    if not at_once:
        start += v_out * settings.preparation_time
    if current is not None:
        start, end = current.start, current.end
    for begins, ends in contact:  # no room to return before the next one: stay out
        until = ego.s + ends + v_back * duration
        if (
            begins < ends < HORIZON
            and ego.s + begins - v_back * duration < end
            and until > end + _WINDOW_HYSTERESIS
        ):
            end = until
    if end > road.path.end:
        return Candidate(side=side, rejection="the route ends before the pass does")
    free = partial(
        check_adjacent_lane, ego, road, beside, [*others, *blocking[1:]], x_safety=settings.x_safety,
        awareness_range=min(settings.awareness_range, awareness_range), stale_after=settings.stale_after,
        braking=settings.assumed_braking, acceleration=settings.assumed_acceleration,
    )  # fmt: skip
    if at_once and current is None and offset > room_aside:  # no band is needed to see who is there now
        zone, obstruction = free(np.linspace(0.0, float(np.interp(last, _AHEAD, soon)), _GAP_CHECK_SAMPLES))
        if obstruction:
            return Candidate(
                side=side,
                rejection=obstruction,
                available_distance=first,
                required_distance=needed,
                danger_zone=zone,
            )
    beside_or_ahead = [
        o for o in others if not o.is_following_ego(ego, road.ego_lane.right, road.ego_lane.left)
    ]
    n = 1 + min(_NODES, max(20, math.ceil(end - start)))
    whole = np.linspace(start, end, n)
    # what has been driven stays as it is, and the band goes on from there
    was = None
    if current is not None and ego.s >= start:
        was = resample_displacement(whole, current.stations, current.displacement)
    k = 0 if was is None else first_replannable_node(whole, ego.s)
    s, t = whole[k:], ego.arrival_times(whole[k:])
    right = road.ego_lane.right if side == "left" or beside is None else beside.right
    left = road.ego_lane.left if side == "right" or beside is None else beside.left
    squared = np.maximum(_max_speeds(ego, s), _MANEUVERING) ** 2
    curvature_limit, room = settings.lateral_acceleration_limit / squared, np.zeros(len(s))
    if was is not None:
        m = min(committed_nodes(t), len(s) - 1)
        h, three = whole[1] - whole[0], np.stack([was[k + i : k + i + m] for i in (-1, 0, 1)])
        bent = _CURVATURE_TOLERANCE * np.abs(offset_curve(road.path.curvature(s[:m]), three, h)[1])
        most = MANEUVER_GRIP_FRACTION * ego.vehicle.mu * GRAVITY / squared[:m]
        curvature_limit[:m] = np.maximum(curvature_limit[:m], np.minimum(bent, most))
        room[: m + math.ceil(ego.vehicle.length / h)] = _EDGE_TOLERANCE  # nodes that the body reaches
    draw = partial(
        relax_band, road.path.position(s), side=side, vehicle=ego.vehicle, clearance=settings.clearance,
        corridor=(right - room, left + room), curvature_limit=curvature_limit,
        start=0.0 if was is None else was[k - 1 : k + 2],
    )  # fmt: skip
    bounds = predicted_occupancy(road.path, s, [*blocking, *beside_or_ahead], t, settings)
    if was is not None:
        bounds = relax_clearance(
            bounds, ego.swept_boxes(road.path, s[:m], was[k : k + m]), t, settings.clearance
        )
    each = zip(bounds.x, bounds.y, bounds.psi, bounds.length, bounds.width, strict=True)
    boxes = [Boxes(*fields) for fields in each]
    band = draw(boxes, lead_distance=[*leads, *(0.0 for _ in beside_or_ahead)])
    found = band.status is Status.OK
    ways = [_leaves_lane(band.displacement, road.ego_lane, half_width)] if found else []
    if found and beside_or_ahead and current is None:
        # who is known less well pushes the band back sooner, which must not make the lane free
        alone = draw(boxes[: len(blocking)], lead_distance=leads)
        ways.append(_leaves_lane(alone.displacement, road.ego_lane, half_width))
    outside = np.any(ways, axis=0) if found else _between(s - ego.s, first, last)
    leaves = bool(outside.any())
    until = float(t[np.flatnonzero(outside)[-1]]) + ego.vehicle.length / max(v_back, 1.0) if leaves else 0.0
    zone, obstruction = None, ""
    if leaves and (current is None or at_once):
        # a waiting ego goes only when the lane is free now, a driving one must find it free on entering it
        begins = 0.0 if at_once and current is None else max(float(t[np.argmax(outside)]), 0.0)
        zone, obstruction = free(np.linspace(begins, until, _GAP_CHECK_SAMPLES))
    if not found:
        obstruction = obstruction or _named(band.message, [*blocking, *beside_or_ahead], s - ego.s)
    candidate = Candidate(
        side=side, rejection=obstruction, available_distance=first, required_distance=needed,
        t_maneuver=until, danger_zone=zone, cost=float(np.abs(band.displacement).max()),
    )  # fmt: skip
    displacement, nodes = band.displacement, band.nodes
    if was is not None:
        displacement = np.append(was[:k], displacement)
        nodes = np.vstack((road.path.to_cartesian(whole[:k], was[:k]), nodes))
    return Maneuver(
        side=side, start=start, end=end, band=band, displacement=displacement, candidate=candidate,
        reference=splice_path(road.path, whole, nodes),
    )  # fmt: skip


def _assumed_interval(
    other: FrenetVehicle, t: Array, settings: EvasionSettings, passed: bool
) -> tuple[Array, Array]:
    """Stretch of the route that another vehicle may cover, within the bounds that are provided for."""
    acceleration = settings.assumed_acceleration_passed if passed else settings.assumed_acceleration
    return other.occupied_interval(t, braking=settings.assumed_braking, acceleration=acceleration)


def predicted_occupancy(
    path: Path,
    s: Array,
    others: Sequence[FrenetVehicle],
    t: Array,
    settings: EvasionSettings,
) -> Boxes:
    """Bounds of other vehicles at the times at which the ego is at places on the route.

    Parameters
    ----------
    path : Path
        The route.
    s : ndarray, shape (n,)
        Places of the ego [m].
    others : sequence of Neighbor
        The vehicles, first the one that is passed first.
    t : ndarray, shape (n,)
        Times from now at which the ego is there [s].
    settings : EvasionSettings
        What others are held capable of.

    Returns
    -------
    boxes : Boxes
        For each vehicle one box for each place, shape (m, n).
    """
    rear, front = np.array([_assumed_interval(o, t, settings, o is others[0]) for o in others]).transpose(
        1, 0, 2
    )
    d, half_width = np.array([(o.d, o.half_width) for o in others]).T[:, :, None]
    return occupancy_boxes(path, s, rear, front, d, half_width)


def _alongside_interval(
    ego: FrenetEgo, other: FrenetVehicle, settings: EvasionSettings, t: Array, passed: bool
) -> tuple[float, tuple[float, float]]:
    """Find where the ego, which is `_AHEAD` at times t, must be beside the other.

    How far behind it already, at the speed that the ego has by then, and the first and last distance ahead;
    infinite if nowhere.
    """
    x = _AHEAD
    rear, front = _assumed_interval(other, t, settings, passed)
    middle = ego.s + x + ego.vehicle.box_offset
    reach = 0.5 * ego.vehicle.length + settings.clearance
    not_past, ahead = front >= middle - reach, rear - middle - reach

    def stretch(lead: float) -> tuple[float, float]:
        abeam = np.flatnonzero(not_past & (ahead <= lead))
        if not len(abeam):
            return math.inf, math.inf
        last = float(x[abeam[-1]])
        return float(x[abeam[0]]), last if abeam[-1] < len(x) - 1 else math.inf

    lead = settings.min_ttc * max(_speed_after(ego, stretch(0.0)[0]) - other.v_s, 0.0)
    return lead, stretch(lead)


def _speed_after(ego: FrenetEgo, distance: float) -> float:
    ahead = min(max(distance, 0.0), HORIZON)
    reached = math.sqrt(ego.v_x**2 + 2.0 * ego.speed.a_max * ahead)
    return max(min(reached, max(ego.v_target, ego.v_x)), 1.0)


def _max_speeds(ego: FrenetEgo, s: Array) -> Array:
    """Highest speed that the ego may have at places on the route."""
    ahead = np.maximum(s - ego.s, 0.0)
    speeds: Array = np.maximum(
        np.minimum(np.sqrt(ego.v_x**2 + 2.0 * ego.speed.a_max * ahead), ego.v_target), ego.v_x
    )
    return speeds


def _named(message: str, others: Sequence[FrenetVehicle], ahead: Array) -> str:
    """Message of a band, with the vehicles' names and the distance ahead of the ego instead of its counts."""
    message = re.sub(r"obstacle (\d+)", lambda found: others[int(found[1])].remote.id, message)
    return re.sub(r"at node (\d+)", lambda found: f"{ahead[int(found[1])]:.0f} m ahead", message)


def _between(x: Array, first: float, last: float) -> Mask:
    between: Mask = (x >= first) & (x <= last)
    return between


def _leaves_lane(u: Array, own: Lane, half_width: float) -> Mask:
    """Where the ego's body is not wholly inside its own lane."""
    outside: Mask = (u + half_width > own.left) | (u - half_width < own.right)
    return outside

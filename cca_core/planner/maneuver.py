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
from cca_core.band.problem import displaced_curve
from cca_core.decide import Candidate
from cca_core.errors import Status
from cca_core.geometry import Boxes
from cca_core.path import Lane, Path, Road, detour_path
from cca_core.planner.committed import first_free, forgiven, resampled, settled
from cca_core.planner.frenet import HORIZON, Ego, Neighbor
from cca_core.planner.gap_acceptance import lane_beside
from cca_core.planner.settings import EvasionSettings
from cca_core.predict import boxes_between

__all__ = ["GRIP_USED", "Evasion", "EvasionSettings", "boxes_of", "plan_evasion"]

GRIP_USED = 0.8
"""Share of the tires' grip that a swerve may use when it cannot be given up any more."""

_BEHIND = 2.0  # a window starts this far behind the car [m]
_GROWTH = 2.0  # an end that would move on by less stays: it is an effect of rounding [m]
_AS_BENT = 1.002  # as a multiple of how it is bent already, what can hardly change may be bent
_BESIDE_EDGE = 0.05  # by which an edge is farther for what can hardly change [m]
_NODES = 140  # in a window, at most; never closer than 1 m
_MANEUVERING = 5.0  # slower than this the steering limits curvature, not the tires [m/s]
_QUINTIC = 5.7735  # peak of the second derivative of the quintic step
_TIMES = 24  # at which the lane beside is looked at
_AHEAD = np.arange(-_BEHIND, HORIZON, 1.0)  # distances at which the ego is looked at beside others [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Evasion:
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
    def places(self) -> Array:
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
        return float(np.interp(s, self.places, self.displacement))


def plan_evasion(
    ego: Ego,
    road: Road,
    blockers: Sequence[Neighbor],
    others: Sequence[Neighbor],
    side: Side,
    settings: EvasionSettings,
    ongoing: Evasion | None = None,
    at_once: bool = False,
    known_range: float = math.inf,
) -> Evasion | Candidate:
    """Plan a swerve around what blocks the route.

    Parameters
    ----------
    ego : Ego
        The ego on its route.
    road : Road
        Route, lanes and edges.
    blockers : sequence of Neighbor
        Vehicles in the way, nearest first; at least one.
    others : sequence of Neighbor
        All other vehicles.
    side : {"left", "right"}
        Side to pass on.
    settings : EvasionSettings
        Clearance, comfort and caution.
    ongoing : Evasion, optional
        The maneuver that is being driven: its window is kept, only its end may move on, and what has been
        driven of it stays.
    at_once : bool
        Whether the swerve begins now even if there would be time to drive on; of an ongoing one, whether it
        could still be given up, so that the lane beside must still be free.
    known_range : float
        Distance up to which all vehicles are known now [m], where that is less than the settings say.

    Returns
    -------
    evasion : Evasion or Candidate
        The swerve; a bare candidate with its obstruction where no band could be drawn.
    """
    soon = ego.times(ego.s + _AHEAD)
    leads, contact = zip(*(_contact(ego, b, settings, soon, b is blockers[0]) for b in blockers), strict=True)
    first, last = contact[0]
    if ongoing is None and not first < last < HORIZON:
        return Candidate(
            side=side,
            obstruction=f"{blockers[0].remote.id} would not be passed in {HORIZON:.0f} m",
        )
    beside = road.lane_at(road.own_lane.left + 0.1 if side == "left" else road.own_lane.right - 0.1)
    half_width = 0.5 * ego.vehicle.width
    offset = blockers[0].half_width + half_width + settings.clearance
    offset += blockers[0].d if side == "left" else -blockers[0].d
    room_aside = (road.own_lane.left if side == "left" else -road.own_lane.right) - half_width
    if beside is None and offset > room_aside:
        return Candidate(side=side, obstruction="there is no lane")
    bend = np.abs(road.path.curvature(np.linspace(ego.s, ego.s + min(last, HORIZON), 20))).max()
    spare = settings.lateral_acceleration - max(ego.v_x, ego.v_target) ** 2 * float(bend)
    duration = math.sqrt(_QUINTIC * max(offset, 0.5) / max(spare, 0.5 * settings.lateral_acceleration))
    v_out, v_back = _speed_after(ego, first), _speed_after(ego, last)
    needed = v_out * (duration + settings.preparation)
    delay = 0.0 if at_once else max(first - needed, 0.0)
    start, end = ego.s - _BEHIND + delay, ego.s + last + v_back * duration
    if not at_once:
        start += v_out * settings.preparation
    if ongoing is not None:
        start, end = ongoing.start, ongoing.end
    for begins, ends in contact:  # no room to return before the next one: stay out
        until = ego.s + ends + v_back * duration
        if begins < ends < HORIZON and ego.s + begins - v_back * duration < end and until > end + _GROWTH:
            end = until
    if end > road.path.end:
        return Candidate(side=side, obstruction="the route ends before the pass does")
    free = partial(
        lane_beside, ego, road, beside, [*others, *blockers[1:]], x_safety=settings.x_safety,
        known_range=min(settings.known_range, known_range), stale_after=settings.stale_after,
        braking=settings.braking, acceleration=settings.acceleration,
    )  # fmt: skip
    if at_once and ongoing is None and offset > room_aside:  # no band is needed to see who is there now
        zone, obstruction = free(np.linspace(0.0, float(np.interp(last, _AHEAD, soon)), _TIMES))
        if obstruction:
            return Candidate(side=side, obstruction=obstruction, lead_in=first, needed=needed, zone=zone)
    beside_or_ahead = [o for o in others if not o.follows(ego, road.own_lane.right, road.own_lane.left)]
    n = 1 + min(_NODES, max(20, math.ceil(end - start)))
    whole = np.linspace(start, end, n)
    # what has been driven stays as it is, and the band goes on from there
    was = None
    if ongoing is not None and ego.s >= start:
        was = resampled(whole, ongoing.places, ongoing.displacement)
    k = 0 if was is None else first_free(whole, ego.s)
    s, t = whole[k:], ego.times(whole[k:])
    right = road.own_lane.right if side == "left" or beside is None else beside.right
    left = road.own_lane.left if side == "right" or beside is None else beside.left
    squared = np.maximum(_speeds(ego, s), _MANEUVERING) ** 2
    curvature_limit, room = settings.lateral_limit / squared, np.zeros(len(s))
    if was is not None:
        m = min(settled(t), len(s) - 1)
        h, three = whole[1] - whole[0], np.stack([was[k + i : k + i + m] for i in (-1, 0, 1)])
        bent = _AS_BENT * np.abs(displaced_curve(road.path.curvature(s[:m]), three, h)[1])
        most = GRIP_USED * ego.vehicle.mu * 9.81 / squared[:m]
        curvature_limit[:m] = np.maximum(curvature_limit[:m], np.minimum(bent, most))
        room[: m + math.ceil(ego.vehicle.length / h)] = _BESIDE_EDGE  # nodes that the body reaches
    draw = partial(
        relax_band, road.path.position(s), side=side, vehicle=ego.vehicle, clearance=settings.clearance,
        corridor=(right - room, left + room), curvature_limit=curvature_limit,
        start=0.0 if was is None else was[k - 1 : k + 2],
    )  # fmt: skip
    bounds = boxes_of(road.path, s, [*blockers, *beside_or_ahead], t, settings)
    if was is not None:
        bounds = forgiven(bounds, ego.swept(road.path, s[:m], was[k : k + m]), t, settings.clearance)
    each = zip(bounds.x, bounds.y, bounds.psi, bounds.length, bounds.width, strict=True)
    boxes = [Boxes(*fields) for fields in each]
    band = draw(boxes, lead=[*leads, *(0.0 for _ in beside_or_ahead)])
    found = band.status is Status.OK
    ways = [_outside(band.displacement, road.own_lane, half_width)] if found else []
    if found and beside_or_ahead and ongoing is None:
        # who is known less well pushes the band back sooner, which must not make the lane free
        alone = draw(boxes[: len(blockers)], lead=leads)
        ways.append(_outside(alone.displacement, road.own_lane, half_width))
    outside = np.any(ways, axis=0) if found else _between(s - ego.s, first, last)
    leaves = bool(outside.any())
    until = float(t[np.flatnonzero(outside)[-1]]) + ego.vehicle.length / max(v_back, 1.0) if leaves else 0.0
    zone, obstruction = None, ""
    if leaves and (ongoing is None or at_once):
        # a waiting ego goes only when the lane is free now, a driving one must find it free on entering it
        begins = 0.0 if at_once and ongoing is None else max(float(t[np.argmax(outside)]), 0.0)
        zone, obstruction = free(np.linspace(begins, until, _TIMES))
    if not found:
        obstruction = obstruction or _named(band.message, [*blockers, *beside_or_ahead], s - ego.s)
    candidate = Candidate(
        side=side, obstruction=obstruction, lead_in=first, needed=needed,
        duration=until, zone=zone, cost=float(np.abs(band.displacement).max()),
    )  # fmt: skip
    displacement, nodes = band.displacement, band.nodes
    if was is not None:
        displacement = np.append(was[:k], displacement)
        nodes = np.vstack((road.path.to_cartesian(whole[:k], was[:k]), nodes))
    return Evasion(
        side=side, start=start, end=end, band=band, displacement=displacement, candidate=candidate,
        reference=detour_path(road.path, whole, nodes),
    )  # fmt: skip


def _span(other: Neighbor, t: Array, settings: EvasionSettings, passed: bool) -> tuple[Array, Array]:
    """Stretch of the route that another vehicle may cover, within the bounds that are provided for."""
    acceleration = settings.passed_acceleration if passed else settings.acceleration
    return other.span(t, braking=settings.braking, acceleration=acceleration)


def boxes_of(
    path: Path,
    s: Array,
    others: Sequence[Neighbor],
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
    rear, front = np.array([_span(o, t, settings, o is others[0]) for o in others]).transpose(1, 0, 2)
    d, half_width = np.array([(o.d, o.half_width) for o in others]).T[:, :, None]
    return boxes_between(path, s, rear, front, d, half_width)


def _contact(
    ego: Ego, other: Neighbor, settings: EvasionSettings, t: Array, passed: bool
) -> tuple[float, tuple[float, float]]:
    """Find where the ego, which is `_AHEAD` at times t, must be beside the other.

    How far behind it already, at the speed that the ego has by then, and the first and last distance ahead;
    infinite if nowhere.
    """
    x = _AHEAD
    rear, front = _span(other, t, settings, passed)
    middle = ego.s + x + ego.vehicle.box_offset
    reach = 0.5 * ego.vehicle.length + settings.clearance
    not_past, ahead = front >= middle - reach, rear - middle - reach

    def stretch(lead: float) -> tuple[float, float]:
        abeam = np.flatnonzero(not_past & (ahead <= lead))
        if not len(abeam):
            return math.inf, math.inf
        last = float(x[abeam[-1]])
        return float(x[abeam[0]]), last if abeam[-1] < len(x) - 1 else math.inf

    lead = settings.lead_time * max(_speed_after(ego, stretch(0.0)[0]) - other.v_s, 0.0)
    return lead, stretch(lead)


def _speed_after(ego: Ego, distance: float) -> float:
    ahead = min(max(distance, 0.0), HORIZON)
    reached = math.sqrt(ego.v_x**2 + 2.0 * ego.speed.a_max * ahead)
    return max(min(reached, max(ego.v_target, ego.v_x)), 1.0)


def _speeds(ego: Ego, s: Array) -> Array:
    """Highest speed that the ego may have at places on the route."""
    ahead = np.maximum(s - ego.s, 0.0)
    speeds: Array = np.maximum(
        np.minimum(np.sqrt(ego.v_x**2 + 2.0 * ego.speed.a_max * ahead), ego.v_target), ego.v_x
    )
    return speeds


def _named(message: str, others: Sequence[Neighbor], ahead: Array) -> str:
    """Message of a band, with the vehicles' names and the distance ahead of the ego instead of its counts."""
    message = re.sub(r"obstacle (\d+)", lambda found: others[int(found[1])].remote.id, message)
    return re.sub(r"at node (\d+)", lambda found: f"{ahead[int(found[1])]:.0f} m ahead", message)


def _between(x: Array, first: float, last: float) -> Mask:
    between: Mask = (x >= first) & (x <= last)
    return between


def _outside(u: Array, own: Lane, half_width: float) -> Mask:
    """Where the ego's body is not wholly inside its own lane."""
    outside: Mask = (u + half_width > own.left) | (u - half_width < own.right)
    return outside

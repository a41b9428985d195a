"""Ways around, and going on with one: in comfort, harder, narrower, as it was, or not at all."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from cca_core.band import Side
from cca_core.decide import Candidate
from cca_core.errors import Status
from cca_core.geometry import box_gap
from cca_core.path import Road
from cca_core.planner.abort import plan_retreat, plan_shortcut
from cca_core.planner.frenet import Ego, Neighbor
from cca_core.planner.maneuver import GRIP_USED, Evasion, boxes_of, plan_evasion
from cca_core.planner.settings import EvasionSettings
from cca_core.vehicle import VehicleParams

__all__ = ["Renewal", "renew", "swerves_of", "ways_around"]

_SIDES: tuple[Side, Side] = ("left", "right")
_NARROW = 0.3  # clearance with which it is driven on then [m]
_LEAD_TIME = 0.1  # time to contact at which it must be beside the other at the latest then [s]
_SHARP = 3.5  # peak lateral acceleration that it aims at then, within half the grip [m/s^2]
_TOUCHES = 0.1  # distance to others' bounds on the old swerve below which a way back is looked for [m]
_BEHIND = 2.0  # nodes this far behind the ego still count [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Renewal:
    """What has become of a swerve.

    Parameters
    ----------
    maneuver : Evasion or None
        What is driven now, None if it was given up inside the own lane.
    status : Status
        `Status.OK` while it is driven in comfort.
    reason : str
        Why it is not driven on, empty if it is.
    """

    maneuver: Evasion | None
    status: Status = Status.OK
    reason: str = ""


def swerves_of(
    settings: EvasionSettings, vehicle: VehicleParams
) -> tuple[tuple[EvasionSettings, Status], ...]:
    """Ways to drive a swerve, the best first.

    Parameters
    ----------
    settings : EvasionSettings
        As it is meant to be driven.
    vehicle : VehicleParams
        The ego.

    Returns
    -------
    swerves : tuple of (EvasionSettings, Status)
        In comfort, with 80 % of the grip, and with that as narrow, late and sharp as it can be.
    """
    grip = vehicle.mu * 9.81
    hard = replace(settings, lateral_limit=GRIP_USED * grip)
    last = replace(
        hard, clearance=min(_NARROW, hard.clearance), lead_time=_LEAD_TIME,
        lateral_acceleration=min(_SHARP, 0.5 * grip),
    )  # fmt: skip
    return (settings, Status.OK), (hard, Status.FALLBACK), (last, Status.FALLBACK)


def ways_around(
    ego: Ego,
    road: Road,
    blockers: Sequence[Neighbor],
    others: Sequence[Neighbor],
    swerves: Sequence[tuple[EvasionSettings, Status]],
    *,
    at_once: bool,
    helpless: bool = False,
    known_range: float = math.inf,
) -> tuple[dict[str, Evasion], list[Candidate], Status]:
    """Plan swerves to both sides, in the first way of driving in which one is free.

    Parameters
    ----------
    ego : Ego
        The ego on its lane.
    road : Road
        Route and lanes.
    blockers : sequence of Neighbor
        Vehicles in the way, nearest first.
    others : sequence of Neighbor
        All other vehicles.
    swerves : sequence of (EvasionSettings, Status)
        Ways to drive, the best first; those that are to be tried.
    at_once : bool
        Whether a swerve begins now even if there would be time to drive on.
    helpless : bool
        Whether those in the way are hit for certain otherwise: at last they are where they most likely are.
    known_range : float
        Distance up to which all vehicles are known now [m].

    Returns
    -------
    plans : dict of Evasion
        Swerves that could be drawn, by side.
    candidates : list of Candidate
        The same for the choice of action; of the best way where none is free.
    status : Status
        How it would be driven.
    """
    found: list[tuple[dict[str, Evasion], list[Candidate], Status]] = []
    tries = [(settings, status, blockers) for settings, status in swerves]
    if helpless:
        tries.append((*swerves[-1], [b.likely() for b in blockers]))
    for settings, status, passed in tries:
        plans: dict[str, Evasion] = {}
        candidates = []
        for side in _SIDES:
            plan = plan_evasion(
                ego, road, passed, others, side, settings, at_once=at_once, known_range=known_range
            )
            if isinstance(plan, Evasion):
                plans[side] = plan
                plan = plan.candidate
            candidates.append(plan)
        found.append((plans, candidates, status))
        if not all(c.obstruction for c in candidates):
            return found[-1]
    return found[0]


def renew(
    ego: Ego,
    road: Road,
    maneuver: Evasion,
    passing: Sequence[Neighbor],
    others: Sequence[Neighbor],
    swerves: Sequence[tuple[EvasionSettings, Status]],
    *,
    inside: bool,
    can_follow: bool,
    known_range: float = math.inf,
) -> Renewal:
    """Bend the band of a swerve for what is known now.

    Parameters
    ----------
    ego : Ego
        The ego, on its way along the swerve.
    road : Road
        Route and lanes.
    maneuver : Evasion
        The swerve as it was.
    passing : sequence of Neighbor
        Vehicles that block the route from its start on, nearest first; at least one.
    others : sequence of Neighbor
        All other vehicles.
    swerves : sequence of (EvasionSettings, Status)
        Ways to drive it, as `swerves_of` gives them.
    inside : bool
        Whether the ego has not left its lane yet.
    can_follow : bool
        Whether it could go on behind what is in front instead.
    known_range : float
        Distance up to which all vehicles are known now [m].

    Returns
    -------
    renewal : Renewal
        The swerve in comfort; else, inside the own lane, given up if the ego can follow; else driven harder
        or narrower; else as it was while that stays clear; else back sooner, in front of those passed by
        then; else the way back behind what was to be passed; and where there is none, as it was.
    """
    obstruction = ""
    for settings, status in swerves:
        plan = plan_evasion(
            ego, road, passing, others, maneuver.side, settings, maneuver, at_once=inside,
            known_range=known_range,
        )  # fmt: skip
        obstruction = plan.candidate.obstruction if isinstance(plan, Evasion) else plan.obstruction
        if isinstance(plan, Evasion) and not obstruction:
            return Renewal(maneuver=plan, status=status)
        if inside and can_follow:
            return Renewal(maneuver=None, reason=f"swerve given up: {obstruction}")
    everybody = sorted((*passing, *others), key=lambda n: n.s)
    if not inside and _room_on(ego, road, maneuver, everybody, swerves[0][0]) < _TOUCHES:
        sooner = plan_shortcut(ego, road, maneuver, everybody, obstruction)
        if sooner is not None:
            return Renewal(maneuver=sooner, status=Status.FALLBACK)
        back = plan_retreat(ego, road, maneuver, everybody, obstruction)
        if back is not None:
            return Renewal(maneuver=back, status=Status.FALLBACK, reason=f"returning: {obstruction}")
    return Renewal(maneuver=maneuver, status=Status.FALLBACK)


def _room_on(
    ego: Ego, road: Road, maneuver: Evasion, others: Sequence[Neighbor], settings: EvasionSettings
) -> float:
    """Least distance between body and bounds [m] if a swerve is driven to its end as it is."""
    left = maneuver.places >= ego.s - _BEHIND
    s = maneuver.places[left]
    if len(s) < 2:
        return math.inf
    t, body = ego.times(s), ego.swept(road.path, s, maneuver.displacement[left])
    near = [o for o in others if not o.follows(ego, road.own_lane.right, road.own_lane.left)]
    if not near:
        return math.inf
    return float(box_gap(body, boxes_of(road.path, s, near, t, settings)).min())

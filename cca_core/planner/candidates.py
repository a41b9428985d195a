"""Candidates: paths by levels, speed profiles, and the motions that they give."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array
from cca_core.band import Side
from cca_core.decide import Rejection, RejectionKind
from cca_core.kernel.memory import Lent
from cca_core.kernel.scene import Scene
from cca_core.path import Lane
from cca_core.planner.maneuvers import plan_path
from cca_core.planner.occupancy import N_STOPS
from cca_core.planner.paths import Surroundings, return_paths, route_path
from cca_core.planner.records import Branch, LateralPath, Level, PathKind, Plan, Profile
from cca_core.planner.scene import FREE_ROW, N_PATHS, N_ROWS, TIMES, find, limit_path, meet, roll, sum_up
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.stretch import adjacent_lanes, highest_speed

_SIDES: dict[Side, tuple[Side, Side]] = {"right": ("left", "right"), "left": ("right", "left")}
"""Sides on which vehicles are passed by the side on which they drive, the preferred one first."""

_MAX_GROUP = 3  # vehicles that are passed at once
_CONFLICT = ("s_enter", "s_exit", "t_enter", "t_exit")
_CONFLICT_MARGIN = 0.5  # gap within which a crossing vehicle conflicts with a station [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stop:
    """Where the ego stops for a vehicle that crosses its route, and until when."""

    vehicle_id: str
    s: float  # of the center of gravity, absolute
    s_exit: float  # behind which its way does not cross the ego's
    has_line: bool  # whether this is a stop line
    t_enter: float
    until: float


def home_paths(around: Surroundings) -> list[LateralPath]:
    """Return the paths along or back to the route."""
    if around.lateral.on_route:
        return [route_path(around.lateral.base)]
    return return_paths(around)


def blocking_rows(around: Surroundings, overtaken: frozenset[str]) -> list[int]:
    """Return the rows of the vehicles that the ego would meet on its route, in the order of meeting."""
    scene, ids = around.traffic.scene, around.traffic.ids
    meet(scene.workspace, FREE_ROW, around.s - around.lateral.base + around.vehicle.rear)
    steps = scene.arrays["met"][: len(ids)].tolist()
    found = [
        (max(step, 0), j) for j, step in enumerate(steps) if step >= 0 or (step == -1 and ids[j] in overtaken)
    ]
    return [j for _, j in sorted(found)]


def maneuver_paths(
    around: Surroundings,
    rollout: "Rollout",
    levels: Sequence[Level],
    last: LateralPath | None,
    max_speed: float,
) -> tuple[list[LateralPath], list[Rejection]]:
    """Return maneuvers around the vehicles that block the route, and why others are rejected.

    A decision bends at most 60 bands: for each of 3 groups, 2 sides and 2 corridors (the ego lane, or with
    the adjacent one) there is a comfortable, a hard and a narrow one; the narrow one is tried twice, and so
    is the comfortable one at walking pace. A comfortable one that is sharp because the ego speeds up has a
    calm one as well.
    """
    traffic, road = around.traffic, around.road
    rows = blocking_rows(around, frozenset() if last is None else last.overtaken)
    paths: list[LateralPath] = []
    rejections: list[Rejection] = []
    preferred = _SIDES[around.settings.traffic_side]
    sides = preferred if last is None else tuple(side for side in preferred if side == last.side)
    for size in range(1, min(len(rows), _MAX_GROUP) + 1):
        group = rows[:size]
        fast = next((j for j in group if traffic.v[j, 0] > max_speed), None)
        if fast is not None:
            rejections.append(
                Rejection(
                    kind=RejectionKind.TOO_FAST, vehicle_id=traffic.ids[fast],
                    value=float(traffic.v[fast, 0]), limit=max_speed,
                )
            )  # fmt: skip
            break
        for side in sides:
            next_to = adjacent_lanes(road, side, around.s)
            if next_to and last is None and not is_passing_allowed(around.settings, side):
                rejections.append(Rejection(kind=RejectionKind.INNER_SIDE, side=side))
                next_to = ()
            lanes: tuple[Lane | None, ...] = (None, *next_to)
            for level in levels:
                for corridor in lanes:
                    found = lane_refusal(around, corridor, side) or plan_path(
                        around, group, side, corridor, level, last
                    )
                    if isinstance(found, Rejection):
                        if corridor is lanes[-1]:
                            rejections.append(found)
                    else:
                        paths.append(found)
                        calm = None if last is not None else rollout.calm_motion(found)
                        slower = None if calm is None else plan_path(calm, group, side, corridor, level, None)
                        if isinstance(slower, LateralPath):
                            paths.append(slower)
                        break
    return paths, rejections


def is_passing_allowed(settings: EvasionSettings, side: Side) -> bool:
    """Return whether vehicles may be passed in the adjacent lane on a side."""
    return settings.inner_passing or side != settings.traffic_side


def lane_rejection(around: Surroundings, kind: PathKind, j: int) -> Rejection:
    """Return the rejection of a gap because of the vehicle that decides."""
    side = kind.value
    if j >= len(around.traffic.ids):
        known = around.settings.awareness_range
        fastest = highest_speed(around.road, around.s, known if math.isfinite(known) else 0.0)
        return Rejection(kind=RejectionKind.BEYOND_AWARENESS, side=side, value=fastest, limit=known)
    n = around.traffic.vehicles[j]
    ahead = n.rear - around.s - around.vehicle.front
    behind = around.s + around.vehicle.rear - n.front
    distance = ahead if ahead > 0.0 else -max(behind, 0.0)
    return Rejection(
        kind=RejectionKind.LANE_BLOCKED, side=side, vehicle_id=n.id, distance=distance, value=abs(n.v_s)
    )


def lane_refusal(around: Surroundings, lane: Lane | None, side: Side) -> Rejection | None:
    """Return why an adjacent lane cannot be known to be free; None if it can, or if there is none."""
    if lane is None:
        return None
    if around.awareness_range == 0.0:
        return Rejection(kind=RejectionKind.UNAWARE, side=side, value=0.0)
    tolerance = around.settings.lane_entry_tolerance
    for n in around.traffic.vehicles:
        in_lane = n.d + n.half_width > lane.right + tolerance and n.d - n.half_width < lane.left - tolerance
        if in_lane and n.remote.age > around.settings.stale_after:
            return Rejection(
                kind=RejectionKind.STALE, side=side, vehicle_id=n.id, value=n.remote.age,
                limit=around.settings.stale_after,
            )  # fmt: skip
    return None


def find_stops(scene: Lent[Scene], around: Surroundings, path: int) -> list[Stop]:
    """Return the points at which the ego lets crossing vehicles pass, in the order of their arrival."""
    traffic, settings, rows = around.traffic, around.settings.crossing, scene.arrays
    crossing = np.flatnonzero(traffic.crosses).tolist()
    if not crossing:
        return []
    base, front = around.lateral.base, around.vehicle.front
    reach = min(settings.range, float(around.free_s[-1] - around.s))
    find(scene.workspace, path, int(reach), _CONFLICT_MARGIN)
    found = []
    for j in crossing:
        enter, s_exit, t_enter, t_exit = (float(rows[name][j]) for name in _CONFLICT)
        enter += base - 1.0
        if not around.s <= enter < math.inf:
            continue
        lines = [line - front for line in around.road.stop_lines if around.s - 0.5 < line - front < enter]
        found.append(
            Stop(
                vehicle_id=traffic.ids[j], s=max(lines, default=enter), has_line=bool(lines),
                s_exit=s_exit + base, t_enter=t_enter, until=t_exit + settings.min_pet + settings.hold_pet,
            )
        )  # fmt: skip
    stops = sorted(found, key=lambda stop: stop.t_enter)[:N_STOPS]
    for i, stop in enumerate(stops):
        rows["stop_s"][i], rows["stop_until"][i] = stop.s - base, stop.until
    return stops


def profiles(
    path: LateralPath, n_stops: int, b_comfort: float, b_max: float, *, eases: bool, kept: bool,
    desperate: bool,
) -> list[Profile]:  # fmt: skip
    """Return the speed profiles of a path; `eases` among other vehicles, to slow early."""
    found = [Profile("go", yields=y) for y in range(n_stops + 1)]
    passes = path.kind.is_evasive and path.to_lane is None
    if passes:  # a vehicle on the path now may have left it when the ego arrives
        found.append(Profile("pass", passes=True, yields=n_stops))
    if not path.kind.is_evasive or path.is_last or desperate:
        gentle, more = (0.5 * b_comfort,) if eases else (), b_max - b_comfort
        for braking in (*gentle, b_comfort, b_comfort + 0.3 * more, b_comfort + 0.5 * more, b_max):
            found.append(
                Profile(
                    f"brake {braking:.0f}", passes=passes, yields=n_stops, braking=braking
                )
            )  # fmt: skip
    if kept:
        found.append(Profile("kept", passes=passes, yields=n_stops, kept=True))
    return found


class Rollout:
    """Motions of candidates in a scene, one row each."""

    def __init__(self, scene: Lent[Scene], around: Surroundings) -> None:
        self.scene, self.around = scene, around
        self.n_rows = self.n_paths = 0

    def add_path(self, path: LateralPath, a_y: float) -> int:
        """Put a path into the scene."""
        rows, i, lateral = self.scene.arrays, self.n_paths, self.around.lateral
        rows["d"][i] = path.on(lateral.base, rows["d"].shape[1])
        rows["overtakes"][i] = 0.0
        end = path.to_lane or self.around.lane
        rows["end_right"][i], rows["end_left"][i] = end.right, end.left
        for j, name in enumerate(self.around.traffic.ids):
            rows["overtakes"][i, j] = name in path.overtaken
        limit_path(self.scene.workspace, i, a_y)
        self.n_paths += 1
        return i

    def calm_motion(self, path: LateralPath) -> Surroundings | None:
        """Return the motion that speeds up where a comfortable path is not sharp; None if it nowhere is."""
        around, rows = self.around, self.scene.arrays
        if path.level is not Level.COMFORT or around.creeps or self.is_full or self.n_rows >= N_ROWS - 1:
            return None
        stations, added = path.stations[1:-1], np.diff(path.d, 2)
        turn = np.where(np.abs(added) > 1e-5, np.abs(added + rows["kappa"][1:-1]), 0.0)
        needed = turn * np.interp(stations, around.free_s, around.free_v) ** 2
        now = float((turn * around.v**2)[stations > around.s].max(initial=0.0))
        a_y = max(around.settings.cost.sharp_from * around.limits.a_y, now)
        if not needed.max() > a_y:
            return None
        i = self.add_path(path, a_y)
        plan = self.drive(path, i, Profile("free", follows=False))
        self.n_paths -= 1  # the next path replaces it
        return replace(around, free_s=plan.s + around.lateral.base, free_v=plan.v, free_row=plan.row, a_y=a_y)

    def add(self, path: LateralPath, i: int, profile: Profile, kept: Array | None = None) -> Plan | None:
        """Drive a path with a profile; None if the scene is full."""
        return None if self.n_rows >= N_ROWS - 1 else self.drive(path, i, profile, kept)

    def drive(self, path: LateralPath, i: int, profile: Profile, kept: Array | None = None) -> Plan:
        """Drive a path with a profile."""
        rows, work, row = self.scene.arrays, self.scene.workspace, self.n_rows
        self.n_rows += 1
        if profile.kept and kept is not None:
            rows["a"][row] = kept
        roll(
            work, row, i, profile.follows, profile.passes, profile.yields, profile.braking, 0.0, profile.kept
        )
        sum_up(work, row, i, self.around.settings.cost.horizon)
        return Plan(
            path=path, row=row, path_row=i, profile=profile, s=rows["s"][row], v=rows["v"][row],
            a=rows["a"][row], d=rows["offset_at"][row], limited_by=int(rows["limited_by"][row]),
            peak=float(rows["terms"][row, 2]),
            branch=Branch(path, i, self.around.settings.certificate.reaction_time, self.around.limits.b_max),
        )  # fmt: skip

    @property
    def is_full(self) -> bool:
        """Whether no further path fits."""
        return self.n_paths >= N_PATHS


def shifted(a: Array, elapsed: float) -> Array:
    """Return an acceleration profile as seen later."""
    return np.interp(TIMES + elapsed, TIMES, a)

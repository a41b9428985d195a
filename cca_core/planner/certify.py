"""Certificates: what a plan keeps against the nominal motion and the worst case of others."""

import math
from collections.abc import Sequence

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.band import Side
from cca_core.decide import Rejection, RejectionKind
from cca_core.kernel.memory import Lent
from cca_core.kernel.scene import Scene
from cca_core.planner.candidates import Stop, lane_refusal, lane_rejection
from cca_core.planner.certificate import Certificate, Grade
from cca_core.planner.lane_entry import entry_rejection
from cca_core.planner.paths import Surroundings
from cca_core.planner.rear_gaps import keeps_rear_gaps
from cca_core.planner.records import Branch, LateralPath, Level, PathKind, Plan
from cca_core.planner.response import ProperResponse
from cca_core.planner.scene import N_ROWS, TIMES, check_gaps, check_worst, roll, set_numbers
from cca_core.planner.stretch import adjacent_lanes
from cca_core.vehicle import STANDSTILL_SPEED

_TAIL = N_ROWS - 1  # row of the braking tail
_BISECTIONS = 3
_SOFTER = 7  # decelerations below the full one that may end behind a crossing vehicle
_SAME = 0.05  # difference of accelerations of the same motion [m/s^2]
_ALL, _ADJACENT = 0, 1  # vehicles of a check
_BETWEEN_STEPS = 0.1  # by which a fast vehicle comes nearer between two steps of a check [m]
_SLACK = 0.05  # by which a gap may shrink before it counts [m]
_IMPACT = 1.0  # least severity of a plan that ends in an impact although the ego brakes fully in time [-]
_GRIP_SHARE = 0.95  # of all tires that a path may use [-]


class Certifier:
    """Certificates of the plans of one decision."""

    def __init__(
        self,
        scene: Lent[Scene],
        around: Surroundings,
        *,
        inside: bool,
        kept: Array | None,
        stops: Sequence[Stop],
        homes: Sequence[tuple[LateralPath, int]],
        valid: float,
    ) -> None:  # fmt: skip
        self._scene, self._around, self._inside = scene, around, inside
        self._settings = around.settings.certificate
        self._kept, self._stops, self._homes = kept, stops, homes
        # deceleration of a safe stop, if no vehicle asks for more
        self._firm = min(around.settings.actuation.safe_stop_deceleration, around.limits.b_max)
        self._valid = valid  # time after which the last certified plan must brake [s]
        self._response = ProperResponse(around, self._exposure)
        self.home_acceleration = 0.0  # least one of the ego in its lane [m/s^2]
        self.count = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Ids of the vehicles by row."""
        return self._around.traffic.ids

    def certify(self, plan: Plan) -> None:
        """Grade a plan."""
        self.count += 1
        self._grade(plan)
        if plan.grade is Grade.NOMINAL and self._goes_on(plan):
            # others have kept within the bounds of its last certificate, whose safe end is still ahead
            plan.grade, plan.is_prolonged = Grade.FULL, True
            plan.braking = self._around.limits.b_max
        elif plan.grade is Grade.NOMINAL:
            plan.exposure = self._exposure(plan)
        if plan.path.to_lane is not None and plan.grade >= Grade.NOMINAL and plan.decides in self.names:
            plan.rejection = lane_rejection(
                self._around, plan.path.kind, self._around.traffic.index(plan.decides)
            )

    def _goes_on(self, plan: Plan) -> bool:
        """Whether a plan is the motion whose certificate is still valid."""
        if not plan.profile.kept or self._kept is None or not self._valid > 0.0:
            return False
        until = TIMES < self._valid
        is_same = bool((np.abs(plan.a - self._kept)[until] < _SAME).all())
        return is_same and (plan.path.is_last or plan.path.kind is PathKind.ROUTE)

    def _grade(self, plan: Plan) -> None:
        plan.branch = Branch(
            plan.path, plan.path_row, self._settings.reaction_time, self._around.limits.b_max
        )
        if self._passes_stop_line(plan):
            plan.grade, plan.is_certified = Grade.REFUSED, True
            return
        around, work, settings = self._around, self._scene.workspace, self._settings
        is_kept = plan.profile.kept or plan.path.is_last
        touch = settings.touch_kept if is_kept else settings.touch
        clearance = around.settings.replan.min_clearance if is_kept else max(plan.path.clearance - 0.15, 0.2)
        plan.grade, plan.rejection, plan.is_certified = Grade.SEVERITY, None, True
        work.margin = 0.0 if is_kept else settings.margin
        pet = around.settings.crossing.min_pet * (0.5 if is_kept else 1.0)
        asked = min(clearance, plan.path.clearance)
        out = self._set_zone(plan)
        met = touch
        if plan.path.kind is not PathKind.ROUTE and (is_kept or not self._inside):
            # what comes towards it is passed as well; no more is asked than there was when it was chosen
            met = min(around.settings.replan.min_clearance + _BETWEEN_STEPS, plan.path.gap - _SLACK)
            met = max(touch, met)
        check_gaps(work, plan.row, plan.path_row, touch, met, asked, settings.duty_delay, pet)
        which, plan.gap = work.which, work.gap if self.names else math.inf
        plan.decides = self._name(which)
        if not work.min_margin >= 0.0:
            self._set_severity(plan, asked)
            plan.impact_id = plan.decides
            if plan.path.kind.is_evasive and plan.decides:
                plan.rejection = Rejection(
                    kind=RejectionKind.CLEARANCE, side=plan.path.side, vehicle_id=plan.decides,
                    value=max(plan.gap, 0.0), limit=asked if plan.decides in plan.path.overtaken else met,
                )  # fmt: skip
            return
        if plan.peak > _GRIP_SHARE * around.limits.grip:
            plan.severity = 0.5 + plan.peak - around.limits.grip
            return
        half, end = 0.5 * around.vehicle.width, float(plan.d[-1])
        lanes = [lane for lane in (around.lane, plan.path.to_lane) if lane is not None]
        if not self._inside:  # it may stay where it drives already, if others there drive as it does
            at, ahead = float(plan.s[-1]) + around.lateral.base, around.lane.direction
            lanes += [n for n in around.road.lanes if n.direction == ahead and n.start <= at <= n.end]
        if not any(lane.right < end - half < end + half < lane.left for lane in lanes):
            plan.severity = 0.0  # it comes to rest, or drives on, where it must not stay
            return
        if out.any() and plan.path.kind.is_evasive:
            self._certify_maneuver(plan, out, touch, clearance)
        else:
            plan.braking = self._needed_braking(plan, touch, clearance)
            self._grade_by_braking(plan, out_now=bool(out[0]))

    def _set_zone(self, plan: Plan) -> Mask:
        """Set when and on which side a plan leaves the lane; return when it is outside."""
        around, half = self._around, 0.5 * self._around.vehicle.width
        lane = around.lane
        left, right = plan.d + half > lane.left + 0.01, plan.d - half < lane.right - 0.01
        out: Mask = left | right
        if plan.path.to_lane is not None:
            end = plan.path.to_lane
            out &= (plan.d + half > end.left + 0.01) | (plan.d - half < end.right - 0.01)
        begins = np.flatnonzero(plan.s + around.lateral.base >= plan.path.begin)
        steps = np.flatnonzero(out)
        is_left = plan.path.kind is PathKind.LEFT or (not plan.path.kind.is_evasive and bool(left.any()))
        set_numbers(
            self._scene,
            begin_from=float(TIMES[begins[0]]) if len(begins) else 0.0,
            zone_from=float(TIMES[steps[0]]) if len(steps) else math.inf,
            zone_side=0 if not len(steps) else 1 if is_left else 2,
        )
        return out

    def _passes_stop_line(self, plan: Plan) -> bool:
        """Whether a plan passes a stop line and goes behind a crossing vehicle without waiting there."""
        s = plan.s + self._around.lateral.base
        for stop in self._stops[plan.profile.yields :]:
            exits = np.flatnonzero(s > stop.s_exit)
            late = not len(exits) or float(TIMES[exits[0]]) > stop.t_enter
            if stop.has_line and late and float(s[-1]) > stop.s + 0.5:
                plan.impact_id = stop.vehicle_id
                return True
        return False

    def _exposure(self, plan: Plan) -> float:
        """Return the impact speed in the worst case if the ego brakes fully after the reaction time."""
        work, decides = self._scene.workspace, plan.decides
        work.margin = 0.0
        here = Branch(plan.path, plan.path_row, self._settings.reaction_time, self._around.limits.b_max)
        safe = self._is_safe(plan, here, 0.0, 0.0)
        plan.decides = decides
        return 0.0 if safe else float(work.impact)

    def _set_severity(self, plan: Plan, clearance: float) -> None:
        """Rate a plan that comes too close: by what is left if the ego brakes fully after the reaction time.

        What it comes to without that is at stake, and costs: less if it comes later.
        """
        plan.severity, plan.at_stake, patience = self._severity(plan, plan.row, clearance)
        if plan.severity >= _IMPACT:
            self._roll(plan, plan.branch)
            severity, _, then = self._severity(plan, _TAIL, clearance)
            plan.severity, plan.patience = min(plan.severity, severity), max(patience, then)

    def _severity(self, plan: Plan, row: int, clearance: float) -> tuple[float, float, float]:
        """Return how bad a motion is, its later impact, and the part of comfort that counts.

        It is as bad as its impact and the overlap, or as the gap that lacks.
        """
        work, settings = self._scene.workspace, self._settings
        check_gaps(
            work, row, plan.path_row, settings.touch, settings.touch, clearance, settings.duty_delay, 0.0
        )
        apart, bound = self._doubt(work.which)
        overlap = -work.gap - apart
        if overlap > 0.0:
            # a later impact is less certain: others and the ego can still react; a shallow one may be a miss
            t_impact = float(TIMES[min(work.when, len(TIMES) - 1)])
            left, stake = (
                math.exp(-t / settings.foresight) for t in (self._time_left(work.which, t_impact), t_impact)
            )
            impact = min(-work.gap / settings.full_overlap, 1.0) * work.impact**2
            if -work.gap <= bound:  # perhaps the bound alone is touched
                return _IMPACT + left * impact, stake * impact, 1.0
            return _IMPACT + left * (impact + overlap), stake * impact, 1.0 - left
        lack = max(-work.min_margin, 0.01)
        plan.exposure = self._exposure(plan)
        return float(min(lack + self._settings.exposure * plan.exposure, 0.9)), 0.0, 1.0

    def _time_left(self, j: int, t_impact: float) -> float:
        """Return when a vehicle ahead is met at the present speeds [s]: the same for all plans."""
        around, traffic = self._around, self._around.traffic
        closing = around.v - float(traffic.v[j, 0])
        gap = float(traffic.s[j, 0] - traffic.half_l[j]) - around.s - around.vehicle.front
        if traffic.crosses[j] or gap <= 0.0 or closing <= STANDSTILL_SPEED:
            return t_impact
        return gap / closing

    def _doubt(self, j: int) -> tuple[float, float]:
        """Overlaps with a vehicle's uncertainty bound up to which the bodies are, and may be, apart [m]."""
        vehicles = self._around.traffic.vehicles
        if not 0 <= j < len(vehicles):
            return 0.0, 0.0
        bounds = 2.0 * vehicles[j].remote.sigma_along, 2.0 * vehicles[j].remote.sigma_across
        return min(bounds), max(bounds)

    def _grade_by_braking(self, plan: Plan, *, out_now: bool) -> None:
        limits, response = self._around.limits, self._response
        plan.silence = response.silence(plan.decides)
        if plan.braking <= self._settings.comfortable_braking:
            plan.grade = Grade.COMFORTABLE
        elif plan.braking <= limits.b_max:
            plan.grade = Grade.FULL
        elif response.is_possible(plan, out_now=out_now) and response.is_given(plan):
            plan.grade, plan.braking = Grade.RESPONSE, limits.b_max
        else:
            plan.grade = Grade.NOMINAL

    def _certify_maneuver(self, plan: Plan, out: Mask, touch: float, clearance: float) -> None:
        """Certify a plan that leaves its lane: gap acceptance, and one safe end for all vehicles."""
        around, settings = self._around, self._settings
        steps = np.flatnonzero(out)
        back = float(TIMES[min(int(steps[-1]) + 1, len(TIMES) - 1)])
        x_safety = around.settings.x_safety * (0.5 if plan.path.is_last else 1.0) if self._inside else 0.0
        here = Branch(plan.path, plan.path_row, settings.reaction_time, around.limits.b_max)
        ends = here._replace(react=max(back, settings.reaction_time))
        side: Side = "left" if plan.path.kind is PathKind.LEFT else "right"
        begins_later = self._inside and not (plan.path.is_last and plan.path.begin <= around.s)
        lanes = adjacent_lanes(around.road, side, around.s) if begins_later else ()
        refusal = next(filter(None, (lane_refusal(around, lane, side) for lane in lanes)), None)
        if refusal is not None:
            plan.grade, plan.rejection = Grade.REFUSED, refusal
            return
        # drivers behind in the lane that it stays in react to its plan; a safe end is their duty then
        entry = ends if plan.path.to_lane is None else ends._replace(braking=0.0)
        if self._inside and not self._is_safe(plan, entry, touch, clearance, x_safety, _ADJACENT):
            plan.grade = Grade.REFUSED
            plan.rejection = lane_rejection(self._around, plan.path.kind, self._scene.workspace.which)
            return
        if plan.path.to_lane is not None:
            plan.rejection = entry_rejection(around, plan, back, self.home_acceleration)
            if plan.rejection is not None:
                plan.grade = Grade.REFUSED
                return
        homes = (Branch(path, row, *here[2:4], is_other=True) for path, row in self._homes)
        # it brakes at once, here or on its way back, or after the pass; for drivers behind less hard
        hard = [*((b, 0.0) for b in (here, *homes)), (ends, x_safety)]
        checks = hard + [(b._replace(braking=self._firm), x) for b, x in hard]
        safe = self._safe_branch(plan, checks, touch, clearance)
        if safe is not None:
            plan.grade = Grade.COMFORTABLE if plan.path.level is Level.COMFORT else Grade.FULL
            plan.branch, plan.braking = safe, settings.comfortable_braking
            return
        plan.grade = Grade.NOMINAL

    def _safe_branch(
        self, plan: Plan, checks: Sequence[tuple[Branch, float]], touch: float, clearance: float
    ) -> Branch | None:
        """Return the first safe branch that keeps gaps to drivers behind, else the first safe one."""
        found, decides = None, ""
        for branch, x in checks:
            if not self._is_safe(plan, branch, touch, 0.0 if branch.is_other else clearance, x):
                continue
            keeps_gaps = keeps_rear_gaps(self._around, self._scene.arrays, _TAIL, branch.path_row)
            if keeps_gaps or found is None:
                found, decides = branch, plan.decides
            if keeps_gaps:
                break
        plan.decides = plan.decides if found is None else decides
        return found

    def _needed_braking(self, plan: Plan, touch: float, clearance: float) -> float:
        """Return the least deceleration of a tail that is safe in the worst case; infinite if none is."""
        here, limits = plan.branch, self._around.limits
        goes_on = here._replace(braking=0.0)
        if self._is_safe(plan, goes_on, touch, clearance):
            firm, comfortable, gentle = (
                (here._replace(braking=b), 0.0)
                for b in (self._firm, self._settings.comfortable_braking, limits.b_comfort)
            )
            safe = self._safe_branch(plan, (firm, comfortable), touch, clearance)
            plan.branch = safe or self._safe_branch(plan, (gentle,), touch, clearance) or goes_on
            return 0.0
        low, high = min(self._settings.comfortable_braking, 0.5 * limits.b_max), limits.b_max
        if not self._is_safe(plan, here, touch, clearance):
            decides = plan.decides
            # where full braking ends in the way of a crossing vehicle, less of it may end behind that
            softer = np.linspace(low, high, _SOFTER + 1)[:-1].tolist() if self._stops else []
            ends = [(here._replace(braking=b), 0.0) for b in softer]
            past = self._safe_branch(plan, ends, touch, clearance)
            if past is not None:
                plan.branch = past
                return past.braking
            plan.decides = plan.impact_id = decides
            return math.inf
        if self._is_safe(plan, here._replace(braking=low), touch, clearance):
            plan.branch = here._replace(braking=low)
            return low
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            if self._is_safe(plan, here._replace(braking=middle), touch, clearance):
                high = middle
            else:
                low = middle
        plan.branch = here._replace(braking=high)
        return high

    def _is_safe(
        self, plan: Plan, branch: Branch, touch: float, clearance: float, x_safety: float = 0.0,
        which: int = _ALL,
    ) -> bool:  # fmt: skip
        """Return whether a branch of a plan is safe in the worst case."""
        work = self._scene.workspace
        self._roll(plan, branch)
        safe = check_worst(
            work, _TAIL, branch.path_row, touch, clearance, self._settings.duty_delay, x_safety, which
        )
        plan.decides = self._name(work.which)
        return bool(safe)

    def _roll(self, plan: Plan, branch: Branch) -> None:
        """Roll out a branch of a plan."""
        work, profile = self._scene.workspace, plan.profile
        work.react = branch.react
        kept = profile.kept or branch.is_other
        if kept:
            self._scene.arrays["a"][_TAIL] = plan.a if branch.is_other else self._kept
        roll(
            work, _TAIL, branch.path_row, profile.follows, profile.passes, profile.yields, profile.braking,
            branch.braking, kept,
        )  # fmt: skip

    def safe_end(self, plan: Plan) -> tuple[Array, Array, Array, Array]:
        """Return the lateral offsets of a plan's branch, and its stations, speeds and accelerations."""
        branch, rows = plan.branch, self._scene.arrays
        self._roll(plan, branch)
        return rows["d"][branch.path_row], rows["s"][_TAIL], rows["v"][_TAIL], rows["a"][_TAIL]

    def certificate(self, plan: Plan) -> Certificate:
        """Return what is certified of a plan."""
        holds = plan.grade <= Grade.RESPONSE
        return Certificate(
            grade=plan.grade, braking=plan.braking if holds else math.inf, gap=plan.gap,
            vehicle_id=plan.decides, passed=plan.branch.path.overtaken,
        )  # fmt: skip

    def _name(self, j: int) -> str:
        ids = self._around.traffic.ids
        return ids[j] if 0 <= j < len(ids) else ""

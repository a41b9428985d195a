"""Deliberation: one decision, from what is seen to the plan that is driven."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.decide import Rejection, RejectionKind
from cca_core.kernel.scene import TOLERANCE
from cca_core.planner.actuate import safe_stop, since
from cca_core.planner.assumptions import Assumptions
from cca_core.planner.candidates import (
    Rollout,
    Stop,
    find_stops,
    home_paths,
    maneuver_paths,
    profiles,
    shifted,
)
from cca_core.planner.certificate import Grade
from cca_core.planner.certify import Certifier
from cca_core.planner.choose import assess, choose
from cca_core.planner.lane_entry import waiting_for, waiting_speed
from cca_core.planner.occupancy import predict_vehicles
from cca_core.planner.paths import Surroundings, change_paths, lateral_state, reference_of
from cca_core.planner.records import (
    DrivenPlan,
    LaneWish,
    LateralPath,
    Level,
    Observation,
    PathKind,
    Plan,
    PlannerState,
    Profile,
)
from cca_core.planner.scene import TIMES, set_numbers
from cca_core.planner.setup import Setup
from cca_core.planner.stretch import BEHIND, ego_lane_near

_ON_PATH = 0.4  # lateral error up to which the ego is on its path [m]
_OFF_PLAN = 0.2  # deviation up to which the ego is where its plan was to bring it [m], [m/s]
_STAGES = ((Level.COMFORT,), (Level.HARD, Level.NARROW))  # levels that are enumerated at once


class Deliberation:
    """Candidates of one decision: enumerated by levels, certified, and one of them chosen."""

    def __init__(
        self,
        setup: Setup,
        state: PlannerState,
        observation: Observation,
        profile: tuple[Array, Array],
        cruise: float,
        wish: LaneWish | None = None,
    ) -> None:
        self._setup, self._state, self._observation, self._profile = setup, state, observation, profile
        self._wish = wish
        self._cruise, self._base = cruise, math.floor(observation.s) - BEHIND
        self._last = state.plan
        driven = None if state.plan is None else state.plan.path
        self._last_path = None if driven is None or observation.s >= driven.end else driven
        self._plans: list[Plan] = []
        self._rejections: list[Rejection] = []
        self._prepare(driven)

    def decide(self) -> DrivenPlan:
        """Return the plan to drive: comfortable paths first, others only if none of them is certified."""
        best = self._choose()
        for levels in _STAGES:
            if best.grade <= Grade.RESPONSE and (levels[0] is not Level.COMFORT or self._goes_on(best)):
                break
            self._add_maneuvers(levels)
            best = self._choose()
        return self._commit(best)

    def _prepare(self, driven: LateralPath | None) -> None:
        """Place the vehicles, and roll out the paths home and the last plan."""
        setup, observation, state = self._setup, self._observation, self._state
        vehicle, lane = setup.vehicle, ego_lane_near(setup.road, observation.s)
        setup.fill_route(self._base, self._profile)
        if self._wish is not None and self._last is not None:
            v_free = math.sqrt(max(float(np.interp(observation.s, *self._profile)), 0.0))
            slow = waiting_speed(
                self._last.waiting, observation.vehicles, observation.v, v_free, setup.settings.change
            )
            cap = setup.scenes.route["cap"]
            np.minimum(cap, slow * slow, out=cap)
        traffic = predict_vehicles(setup.scenes, observation, setup.road, setup.settings, self._base)
        scene, half = traffic.scene, 0.5 * vehicle.width
        left, right = observation.d + half - TOLERANCE, observation.d - half + TOLERANCE
        inside = lane.right < right and left < lane.left
        set_numbers(
            scene, s_0=observation.s - self._base, v_0=observation.v, a_0=state.a_x, a_true=state.a_true,
            react=setup.settings.certificate.reaction_time,
            established=0 if inside or setup.settings.keeps_motion or not setup.settings.rear_reaction_time
            else 1 if observation.d > lane.d else 2,
            leaves=lane.right < left and right < lane.left,
        )  # fmt: skip
        lateral = lateral_state(
            self._base, observation.s, observation.d, observation.angle, observation.bend, driven, _ON_PATH
        )
        around = Surroundings(
            vehicle=vehicle, road=setup.road, lane=lane, settings=setup.settings, limits=setup.limits,
            traffic=traffic, lateral=lateral, s=observation.s, v=observation.v,
            awareness_range=observation.awareness_range, jerk=setup.speed.jerk,
            jerk_emergency=setup.speed.jerk_emergency,
            free_s=TIMES, free_v=TIMES, wish=self._wish,
        )  # fmt: skip
        self._scene, self._rollout = scene, Rollout(scene, around)
        homes = home_paths(around)
        rows = [self._rollout.add_path(path, setup.limits.a_y_max) for path in homes]
        free = self._rollout.drive(homes[0], rows[0], Profile("free", follows=False))
        self._free, self._free_terms = free, scene.arrays["terms"][free.row].copy()
        self._around = around = replace(around, free_s=free.s + self._base, free_v=free.v)
        self._rollout.around = around
        self._stops = find_stops(scene, around, rows[0])
        self._assumptions = Assumptions.of(scene, traffic.vehicles, observation.t, self._base)
        self._kept = None if self._last is None else shifted(self._last.a, observation.t - self._last.t)
        self._certifier = Certifier(
            scene, around, inside=inside, kept=self._kept, stops=self._stops,
            homes=tuple(zip(homes, rows, strict=True)), valid=self._valid_time(),
        )  # fmt: skip
        for path, row in zip(homes, rows, strict=True):
            self._add(path, row)
        self._certifier.home_acceleration = float(self._plans[0].a.min())
        last = self._last_path
        if last is not None and not lateral.is_lost and last.kind is not PathKind.ROUTE:
            self._add(replace(last, is_last=True), None)
        wish = self._wish
        to, begun = 0.0 if wish is None else wish.d, 0.0 if last is None else last.rest
        if to != (0.0 if lateral.is_lost else begun):  # a change goes on from where the ego is
            for path in change_paths(around, wish):
                self._add(path, None)

    def _add(self, path: LateralPath, row: int | None) -> None:
        """Roll out a path with all of its profiles."""
        limits = self._setup.limits
        is_comfortable = path.kind.is_evasive and path.level is Level.COMFORT
        if row is None:
            if self._rollout.is_full:
                return
            comfort = limits.a_y if self._around.creeps else limits.a_y_limit
            row = self._rollout.add_path(path, min(path.a_y, comfort if is_comfortable else limits.a_y_max))
        keeps = path.is_last or (self._last_path is None and not path.kind.is_evasive)
        found = profiles(
            path, len(self._stops), limits.b_comfort, limits.b_max,
            eases=bool(self._around.traffic.ids), kept=keeps and self._kept is not None,
            desperate=path.kind.is_evasive and not is_comfortable,
        )  # fmt: skip
        for profile in found:
            plan = self._rollout.add(path, row, profile, self._kept)
            if plan is not None:
                assess(
                    plan, self._scene.arrays["terms"], self._free_terms, self._around, self._last_path,
                    self._state.a_x, self._cruise,
                )  # fmt: skip
                self._plans.append(plan)

    def _add_maneuvers(self, levels: Sequence[Level]) -> None:
        """Enumerate the maneuvers of some levels."""
        observation, last = self._observation, self._last_path
        ongoing = None
        if last is not None and last.kind.is_evasive and observation.s >= last.begin:
            ongoing = None if self._around.lateral.is_lost or last.to_lane is not None else last
        v_target = math.sqrt(max(float(np.interp(observation.s, *self._profile)), 0.0))
        max_speed = v_target - self._setup.settings.min_speed_advantage
        found, why = maneuver_paths(self._around, self._rollout, levels, ongoing, max_speed)
        self._rejections += why
        for path in found:
            self._add(path, None)

    def _choose(self) -> Plan:
        return choose(self._plans, self._certifier, self._around)

    def _goes_on(self, best: Plan) -> bool:
        """Whether the best plan is the maneuver that is being driven."""
        return best.path.is_last and best.path.kind.is_evasive

    def _commit(self, best: Plan) -> DrivenPlan:
        """Return the best plan as the one that is driven, with its reference and its safe stop."""
        setup, observation, last = self._setup, self._observation, self._last
        path = best.path
        if path.is_last and last is not None:
            path, reference = replace(last.path, is_last=False), last.reference
        elif path.kind is PathKind.ROUTE:
            reference = setup.road.path
        else:
            reference = reference_of(path, setup.road, observation.s)
            path = replace(path, reference=reference, gap=best.gap)
        if best.is_prolonged and last is not None:
            stop = since(last.safe_stop, observation.t - last.t)
            certificate, assumptions = last.certificate, last.assumptions
        else:
            stop = safe_stop(setup.scenes.route, *self._certifier.safe_end(best), setup.vehicle)
            certificate = self._certifier.certificate(best)
            assumptions = self._assumptions if best.grade <= Grade.FULL else None
        limited_by, yields_to = self._limit_of(best)
        rejected = [p.rejection for p in self._plans if p.rejection is not None and p.cost < best.cost]
        return DrivenPlan(
            t=observation.t, path=path, reference=reference, profile=best.profile, s=best.s + self._base,
            v=best.v.copy(), a=best.a.copy(), a_0=self._state.a_x, limited_by=limited_by,
            certificate=certificate, yields_to=yields_to,
            free_a=float(self._free.a[3]), rejections=(*self._rejections, *rejected, *self._dear(best)),
            safe_stop=stop, costs=best.costs, impact_id=best.impact_id or self._cause_of(best),
            assumptions=assumptions, waiting=waiting_for(self._wish, self._plans, best),
        )  # fmt: skip

    def _dear(self, best: Plan) -> list[Rejection]:
        """Return that the cheapest pass costs more than it saves, if the ego stays behind for that."""
        passes = [p for p in self._plans if p.path.kind.is_evasive and p.path.to_lane is None]
        cheapest = min(passes, key=lambda p: p.cost, default=best)
        if best.path.kind is not PathKind.ROUTE or cheapest.cost <= best.cost:
            return []
        lost, still = (p.costs.progress + p.costs.speed + p.costs.safe_end for p in (best, cheapest))
        spent = cheapest.cost - still - (best.cost - lost)
        return [Rejection(kind=RejectionKind.COST, side=cheapest.path.side, value=spent, limit=lost - still)]

    def _valid_time(self) -> float:
        """Return the time until the last certified plan must brake, if another decision precedes that [s].

        It is 0 if a vehicle is not within the bounds of its certificate, or the ego not where it was to be.
        """
        last, observation, settings = self._last, self._observation, self._setup.settings
        if last is None or last.assumptions is None or self._state.has_news:
            return 0.0
        left = settings.certificate.reaction_time - (observation.t - last.assumptions.t)
        if left <= settings.decision.period + 1e-6:
            return 0.0
        s, v = (float(np.interp(observation.t - last.t, TIMES, row)) for row in (last.s, last.v))
        is_there = abs(s - observation.s) < _OFF_PLAN and abs(v - observation.v) < _OFF_PLAN
        return left if is_there and last.assumptions.hold(self._assumptions) else 0.0

    def _limit_of(self, plan: Plan) -> tuple[str, str]:
        """Return what limits the speed of a plan now, and the vehicle that it yields to."""
        row = plan.limited_by
        if row >= 0:
            return self._certifier.names[row], ""
        if row <= -10:
            stop: Stop = self._stops[-10 - row]
            return f"yield {stop.vehicle_id}", stop.vehicle_id
        return ("" if row == -1 else "curve"), ""

    def _cause_of(self, best: Plan) -> str:
        """Return the vehicle because of which the cheapest plan along the same way is not driven."""
        passes = best.path.kind.is_evasive
        refused = [
            p for p in self._plans
            if p.is_certified and p.impact_id and p.cost < best.cost and p.path.kind.is_evasive is passes
        ]  # fmt: skip
        return min(refused, key=lambda p: p.cost).impact_id if refused else ""

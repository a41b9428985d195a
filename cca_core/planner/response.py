"""Proper response of RSS: how hard the ego must brake until the worst case of a lead is excluded again."""

from collections.abc import Callable

import numpy as np

from cca_core.frenet import FrenetVehicle
from cca_core.planner.occupancy import reported_rate
from cca_core.planner.paths import Surroundings
from cca_core.planner.records import Plan
from cca_core.planner.scene import TIMES
from cca_core.vehicle import STALE_AGE, STANDSTILL_SPEED


class ProperResponse:
    """What the vehicles ahead ask of a plan that is not safe in the worst case."""

    def __init__(self, around: Surroundings, exposure: Callable[[Plan], float]) -> None:
        self._around, self._settings = around, around.settings.certificate
        self._exposure = exposure  # impact speed of a plan in the worst case

    def is_possible(self, plan: Plan, *, out_now: bool) -> bool:
        """Return whether braking is a response to the vehicle that decides about a plan.

        It is none to what comes from behind or the side, and outside the lane only if the gap opens.
        """
        around, traffic = self._around, self._around.traffic
        j = traffic.index(plan.decides)
        is_ahead = j < 0 or bool(traffic.s[j, 0] > around.s and not traffic.crosses[j])
        opens = j >= 0 and plan.gap >= around.settings.clearance and bool(traffic.v[j, 0] >= around.v)
        return is_ahead and (opens or not out_now) and not plan.path.kind.is_evasive

    def is_given(self, plan: Plan) -> bool:
        """Return whether a plan brakes soon and stays at it: in comfort, or up to fully if urgent."""
        around, limits, reaction = self._around, self._around.limits, self._settings.reaction_time
        urgency = max(plan.silence, self._braking_ahead(), self._danger(plan))
        response = limits.b_comfort + (limits.b_max - limits.b_comfort) * urgency
        jerk = around.jerk + (around.jerk_emergency - around.jerk) * urgency
        begun = max(-response, float(plan.a[0]) - 0.5 * jerk * reaction)
        soon, k = np.searchsorted(TIMES, (reaction, reaction + limits.b_comfort / jerk)).tolist()
        return all(
            plan.v[i] < STANDSTILL_SPEED or plan.a[i] <= a + 0.05
            for i, a in ((soon, begun), (k - 1, -response))
        )

    def silence(self, name: str) -> float:
        """Part of the time of silence that asks for full braking [-]; 0 for what is not a stale lead."""
        late = max((n.remote.age - STALE_AGE for n in self._leads() if n.id == name), default=0.0)
        return min(max(late, 0.0) / self._settings.silence_time, 1.0)

    def _braking_ahead(self) -> float:
        """Part of the braking beyond comfort that is seen ahead, as far as the ego needs to stop [-].

        Half of it counts as all: reports tell of braking that still builds up.
        """
        around, limits = self._around, self._around.limits
        until = around.s + around.v**2 / (2.0 * limits.b_comfort)
        braking = max((-reported_rate(n) for n in self._leads() if n.rear < until), default=0.0)
        return min(
            max(braking - limits.b_comfort, 0.0) / max(0.5 * (limits.b_max - limits.b_comfort), 0.1), 1.0
        )

    def _danger(self, plan: Plan) -> float:
        """Part of it that a lead asks for: by its present speed, and by the impact if it brakes now [-]."""
        around, limits, settings = self._around, self._around.limits, self._settings
        lead = next((n for n in self._leads() if n.id == plan.decides and n.v_s >= 0.0), None)
        if lead is None:
            return 0.0
        gap, closing = lead.rear - around.s - around.vehicle.front, max(around.v - lead.v_s, 0.0)
        need = settings.response * closing * closing / (2.0 * max(gap - settings.touch, 0.1))
        now = max(need - limits.b_comfort, 0.0) / max(limits.b_max - limits.b_comfort, 0.1)
        above = max(self._exposure(plan) - settings.mild_impact, 0.0)
        return min(max(now, above / max(settings.severe_impact - settings.mild_impact, 0.1)), 1.0)

    def _leads(self) -> list[FrenetVehicle]:
        """Return the vehicles ahead of the ego that are in its way across the road."""
        around, traffic = self._around, self._around.traffic
        gap = max(around.settings.lead.blocking_gap, self._settings.touch)
        reach = traffic.half_w + 0.5 * around.vehicle.width + gap
        blocks = (traffic.s[:, 0] >= around.s) & (np.abs(traffic.d[:, 0] - around.lateral.offset) <= reach)
        return [traffic.vehicles[j] for j in np.flatnonzero(blocks).tolist()]

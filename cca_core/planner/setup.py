"""Setup of a planner for a route: what does not change from decision to decision."""

from dataclasses import dataclass, replace
from importlib import import_module
from typing import Self

import numpy as np

from cca_core._checks import Array
from cca_core.band import relax_band
from cca_core.follow import SpeedSettings, squared_speed_limit
from cca_core.frenet.branches import Branches
from cca_core.geometry import boxes
from cca_core.path import Road, interpolate_path
from cca_core.planner.limits import Limits, limits_of
from cca_core.planner.scene import Scenes
from cca_core.planner.settings import EvasionSettings
from cca_core.planner.stretch import AHEAD, BEHIND
from cca_core.vehicle import VehicleParams

__all__ = ["Setup"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Setup:
    """What does not change from decision to decision, as long as the route is the same."""

    vehicle: VehicleParams
    road: Road
    settings: EvasionSettings
    speed: SpeedSettings
    limits: Limits
    scenes: Scenes
    lateral_range: tuple[float, float]  # of bodies that matter [m]
    branches: Branches | None  # of a route that passes itself

    @classmethod
    def make(
        cls, vehicle: VehicleParams, road: Road, settings: EvasionSettings, speed: SpeedSettings,
    ) -> Self:  # fmt: skip
        """Return the setup of a planner for a route."""
        limits = limits_of(vehicle, speed, settings)
        lanes = [(lane.right, lane.left) for lane in road.lanes if lane is not road.ego_lane]
        scenes = Scenes(BEHIND + AHEAD, numbers_of(vehicle, settings, speed, limits), lanes)
        # what is slow to build exists before the first cycle
        scenes.for_vehicles(0)
        road.path.project(road.path.position(road.path.start))
        margin, branches = settings.clearance + settings.decision.relevance_margin, Branches(road.path)
        return cls(
            vehicle=vehicle, road=road, settings=settings, speed=speed, limits=limits, scenes=scenes,
            lateral_range=(road.right_edge - margin, road.left_edge + margin),
            branches=branches if branches.passes_itself else None,
        )  # fmt: skip

    def warm_up(self) -> None:
        """Import and build once what is slow, so that the first cycle is not."""
        route = [(float(x), 0.0) for x in range(8)]
        relax_band(route, [boxes(4.0, 9.0, 0.0, 1.0, 1.0)], vehicle=self.vehicle)
        interpolate_path(route)
        import_module("scipy.interpolate")

    def speed_profile(self, cruise: float, start: tuple[float, float] | None) -> tuple[Array, Array]:
        """Return the squared speed along the route; a faster ego slows in comfort from the start."""
        road, speed = self.road, replace(self.speed, b_comfort=self.limits.b_comfort)
        highest = min(cruise, road.speed_limit)
        return squared_speed_limit(
            road.path, highest, self.limits.curve, speed, road.speed_limits, start=start
        )

    def fill_route(self, base: int, profile: tuple[Array, Array]) -> None:
        """Put the stretch of the route around the ego into the scenes."""
        grid = base + np.arange(float(BEHIND + AHEAD))
        xy, first, second = self.road.path.derivatives(grid)
        route = self.scenes.route
        route["x"][:], route["y"][:] = xy[:, 0], xy[:, 1]
        route["psi"][:] = np.unwrap(np.arctan2(first[:, 1], first[:, 0]))
        cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        route["kappa"][:] = cross / np.hypot(first[:, 0], first[:, 1]) ** 3
        route["cap"][:] = np.interp(grid, *profile)


def numbers_of(
    vehicle: VehicleParams, settings: EvasionSettings, speed: SpeedSettings, limits: Limits
) -> dict[str, float]:
    """Return the ego, its limits and the assumptions of the settings as numbers of a scene."""
    certificate, crossing = settings.certificate, settings.crossing
    return {
        "crossing_time": crossing.acceleration_time, "yield_time": crossing.braking_time,
        "half_length": 0.5 * vehicle.length,
        "half_width": 0.5 * vehicle.width, "offset": vehicle.box_offset, "a_max": limits.a_max,
        "b_comfort": limits.b_comfort, "b_max": limits.b_max,
        "b_soft": settings.cost.risk_braking / speed.b_max * limits.b_max,
        "risk_until": settings.cost.horizon, "grip": limits.grip, "standstill_gap": speed.standstill_gap,
        "time_gap": speed.time_gap, "approach_rate": speed.approach_rate, "jerk": speed.jerk,
        "jerk_emergency": speed.jerk_emergency, "lag": certificate.lag, "look": certificate.look_time,
        # what a plan may not come close to is in its way, at equal limits too
        "blocking_gap": max(settings.lead.blocking_gap, certificate.touch) + 1e-6,
        "opening_speed": settings.lead.opening_speed, "creep_time": settings.lead.creep_time,
        "b_firm": settings.lead.firm_braking / speed.b_comfort * limits.b_comfort,
        "rear_braking": settings.rear_braking,
        "rear_reaction": 0.0 if settings.keeps_motion else settings.rear_reaction_time,
        "keeps": settings.keeps_motion, "b_other": settings.assumed_braking,
        "a_other": settings.assumed_acceleration, "a_passed": settings.assumed_acceleration_passed,
        "b_crossing": crossing.assumed_braking, "a_crossing": crossing.assumed_acceleration,
        "min_pet": crossing.min_pet, "braking_time": certificate.braking_time,
        "acceleration_time": certificate.acceleration_time, "entry_tolerance": settings.lane_entry_tolerance,
        "queue_gap": settings.lead.queue_gap,
        "passing_gap": settings.lead.passing_distance,
    }  # fmt: skip

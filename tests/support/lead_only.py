"""Ego controller that hides every vehicle outside the ego lane from its planner."""

from collections.abc import Iterable

from cca_core import Command, Planner, RemoteVehicle, VehicleState


class LeadOnly:
    """A planner that receives only the vehicles in the ego lane, as if eq 11 were not there."""

    def __init__(self, planner: Planner) -> None:
        self.planner = planner

    def step(
        self, t: float, state: VehicleState, remotes: Iterable[RemoteVehicle], *, awareness_range: float
    ) -> Command:
        lane, path = self.planner.road.ego_lane, self.planner.road.path
        in_lane = [r for r in remotes if lane.right < float(path.project((r.x, r.y))[1]) < lane.left]
        return self.planner.step(t, state, in_lane, awareness_range=awareness_range)

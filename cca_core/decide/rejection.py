"""Rejection: why a candidate is not feasible, as data; its text is made here only."""

import math
from dataclasses import dataclass
from enum import Enum

from cca_core._repr import short_repr


class RejectionKind(Enum):
    """Cause of a rejection, with the template of its text."""

    NO_LANE = "no {side} lane"
    INNER_SIDE = "passing on the {side} is not allowed"
    LANE_BLOCKED = "{side} lane blocked by {vehicle_id} ({where}, {value:.1f} m/s)"
    BEYOND_AWARENESS = (
        "{side} lane not confirmed clear beyond {limit:.0f} m (assumed vehicle at {value:.1f} m/s)"
    )
    UNAWARE = "{side} lane not confirmed clear (awareness range is {value:.0f} m)"
    STALE = "{vehicle_id} is stale ({value:.1f} s, limit {limit:.1f} s)"
    TOO_FAST = "{vehicle_id} too fast to pass ({value:.1f} m/s, limit {limit:.1f} m/s)"
    TOO_LONG = "passing {vehicle_id} on the {side} takes more than {limit:.0f} m"
    ROUTE_ENDS = "route ends before the maneuver to the {side} ({limit:.0f} m, required {value:.0f} m)"
    LANE_ENDS = "{side} lane ends before the maneuver ({limit:.0f} m, required {value:.0f} m)"
    NO_SPACE = "no space to pass {vehicle_id} on the {side}, {where}"
    CLEARANCE = "clearance to {vehicle_id} {value:.2f} m on the {side} (limit {limit:.2f} m)"
    ROAD_EDGE = "maneuver to the {side} exceeds a road edge by {value:.2f} m"
    CURVATURE = "maneuver to the {side} has curvature {value:.4f} 1/m (limit {limit:.4f} 1/m)"
    LATERAL_OFFSET = "maneuver to the {side} has lateral offset {value:.0f} m (limit {limit:.0f} m)"
    NOT_CONVERGED = "maneuver to the {side} did not converge"


@dataclass(frozen=True, kw_only=True)  # without slots, as its text is kept
class Rejection:
    """Why a candidate is not feasible.

    Parameters
    ----------
    kind : RejectionKind
        The cause.
    side : str
        Side of the maneuver, "left" or "right".
    vehicle_id : str
        Id of the vehicle that causes it; empty if there is none.
    distance : float
        Gap to it along the route [m], negative if it is behind, 0 alongside; NaN if unknown.
    value, limit : float
        The quantity that decides and its limit [-], in the unit of the kind's text; NaN if there is none.
    """

    kind: RejectionKind
    side: str = ""
    vehicle_id: str = ""
    distance: float = math.nan
    value: float = math.nan
    limit: float = math.nan

    __repr__ = short_repr
    _text = ""  # made once, as reasons repeat it in every cycle

    @property
    def where(self) -> str:
        """Distance in words."""
        if self.distance == 0.0:
            return "alongside"
        return f"{abs(self.distance):.0f} m {'behind' if self.distance < 0.0 else 'ahead'}"

    def __str__(self) -> str:
        if not self._text:
            text = self.kind.value.format(
                side=self.side, vehicle_id=self.vehicle_id, where=self.where, value=self.value,
                limit=self.limit,
            )  # fmt: skip
            object.__setattr__(self, "_text", text)
        return self._text

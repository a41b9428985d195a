"""Rejection: why a candidate is not feasible, as data; its text is made here only."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from cca_core._repr import short_repr


class RejectionKind(Enum):
    """Cause of a rejection, with the template of its text."""

    NO_LANE = "no lane"
    INNER_SIDE = "not allowed"
    LANE_BLOCKED = "{vehicle_id} {where} at {value:.1f} m/s"
    BEYOND_AWARENESS = "lane not confirmed clear beyond {limit:.0f} m"
    UNAWARE = "lane not confirmed clear (awareness range {value:.0f} m)"
    STALE = "{vehicle_id} is stale"
    TOO_FAST = "{vehicle_id} is too fast"
    TOO_LONG = "takes more than {limit:.0f} m"
    ROUTE_ENDS = "route ends too early"
    LANE_ENDS = "lane ends too early"
    NO_SPACE = "no space next to {vehicle_id}"
    CLEARANCE = "too close to {vehicle_id}"
    ROAD_EDGE = "no space within the road"
    CURVATURE = "path too sharp"
    COST = "not worth it"
    LATERAL_OFFSET = "path too far from the route"
    NOT_CONVERGED = "no path found"


class _Figures(NamedTuple):
    """Value and limit that a text adds if they show the shortage as rounded; none is zero or less."""

    text: str
    digits: int
    sign: int = 1  # of the value minus the limit

    def of(self, value: float, limit: float) -> str:
        """Return the template in parentheses; empty if the rounded figures show no shortage."""
        value, limit = round(value, self.digits), round(limit, self.digits)
        is_short = value > 0.0 and math.isfinite(limit) and self.sign * (value - limit) > 0.0
        return f" ({self.text})" if is_short else ""


_FIGURES = {
    RejectionKind.STALE: _Figures("{value:.1f} s, limit {limit:.1f} s", 1),
    RejectionKind.TOO_FAST: _Figures("{value:.1f} m/s, limit {limit:.1f} m/s", 1),
    RejectionKind.ROUTE_ENDS: _Figures("in {limit:.0f} m, needs {value:.0f} m", 0),
    RejectionKind.LANE_ENDS: _Figures("in {limit:.0f} m, needs {value:.0f} m", 0),
    RejectionKind.COST: _Figures("costs {value:.1f} s, saves {limit:.1f} s", 1),
    RejectionKind.CLEARANCE: _Figures("{value:.2f} m, needs {limit:.2f} m", 2, -1),
    RejectionKind.LATERAL_OFFSET: _Figures("{value:.0f} m, limit {limit:.0f} m", 0),
}


@dataclass(frozen=True, kw_only=True)  # without slots, as its text is kept
class Rejection:
    """Why a candidate is not feasible.

    Parameters
    ----------
    kind : RejectionKind
        The cause.
    side : str
        Side of the maneuver, "left" or "right"; empty if it holds for both.
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
        return located(self.distance)

    @property
    def cause(self) -> str:
        """The cause without side and figures."""
        return self._filled(self.kind.value)

    @property
    def why(self) -> str:
        """The cause without the side; figures only if they show what is missing."""
        if not self._text:
            figures = _FIGURES.get(self.kind)
            shown = "" if figures is None else figures.of(self.value, self.limit)
            object.__setattr__(self, "_text", self._filled(self.kind.value + shown))
        return self._text

    def _filled(self, template: str) -> str:
        return template.format(
            vehicle_id=self.vehicle_id or "a vehicle", where=self.where, value=self.value, limit=self.limit
        )

    def __str__(self) -> str:
        return f"on the {self.side}: {self.why}" if self.side else self.why


def located(distance: float) -> str:
    """Return a distance along the route in words."""
    if abs(distance) < 0.5:
        return "alongside"
    return f"{abs(distance):.0f} m {'behind' if distance < 0.0 else 'ahead'}"


def not_passing(rejections: Iterable[Rejection]) -> str:
    """Return why vehicles are not passed: the first cause of each side that has a lane; empty without any."""
    first = {r.side: r for r in reversed(tuple(rejections))}
    if "" in first:  # it holds for both sides
        return f"not passing: {first[''].why}"
    found = [first[side] for side in ("left", "right") if side in first]
    shown = [r for r in found if r.kind is not RejectionKind.NO_LANE] or found
    if len(shown) < 2:
        return f"not passing {shown[0]}" if shown else ""
    left, right = (r.cause for r in shown)  # figures of both make a long text
    both = f"on the left: {left}; on the right: {right}"
    return f"not passing {f'on the left or right: {left}' if left == right else both}"

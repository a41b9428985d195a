"""Status, message and active constraint of a band, from the codes of the kernel."""

from typing import NamedTuple

from cca_core.band.problem import MAX_DISPLACEMENT
from cca_core.errors import Status
from cca_core.kernel import band_workspace as codes

_STATUS = {
    codes.OK: Status.OK,
    codes.INFEASIBLE: Status.INFEASIBLE,
    codes.NOT_CONVERGED: Status.NOT_CONVERGED,
}
_CONSTRAINTS = {
    codes.NO_CONSTRAINT: "",
    codes.LEFT_EDGE: "left edge",
    codes.RIGHT_EDGE: "right edge",
    codes.CURVATURE_LIMIT: "curvature",
}


class Outcome(NamedTuple):
    """Fields of a band that say what it is worth."""

    status: Status
    message: str
    active_constraint: str
    active_obstacle: int | None


def outcome_of(reals: list[float], ints: list[int], clearance: float) -> Outcome:
    """Return the outcome of a band, from its rows of `BandBatch`."""
    status, reason, active, other, node, solves = ints
    gap, edge, _, _, value, limit = reals
    name = _name(active)
    if reason == codes.SATISFIED:
        message = "clearance and limits satisfied"
    elif reason == codes.CLEARANCE:
        message = f"clearance to {name} is {gap:.3f} m (limit {clearance:.3f} m)"
    elif reason == codes.EDGE:
        message = f"the body crosses the {name} by {-edge:.3f} m"
    elif reason == codes.DISPLACEMENT:
        message = f"displacement is {value:.0f} m (limit {MAX_DISPLACEMENT:.0f} m)"
    elif reason == codes.CURVATURE:
        message = f"curvature is {value:.4f} 1/m (limit {limit:.4f} 1/m)"
    elif reason == codes.EMPTY_INTERVAL:
        right, left = (_name(one) if one >= 0 else f"the {_name(one)}" for one in (active, other))
        message = f"no space between {right} and {left} at node {node}"
        active = active if active >= 0 else other
    elif reason == codes.BLOCKED_END:
        message = f"clearance to {name}, at a pinned end, {value:.3f} m (limit {clearance:.3f} m)"
    else:
        message = f"active set did not converge in {solves} solves"
    return Outcome(_STATUS[status], message, _name(active), active if active >= 0 else None)


def _name(constraint: int) -> str:
    """Return the name of a constraint."""
    return f"obstacle {constraint}" if constraint >= 0 else _CONSTRAINTS[constraint]

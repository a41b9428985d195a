"""What one cycle of the planner asks of the car."""

from dataclasses import dataclass

from cca_core.band import Band
from cca_core.decide import Decision
from cca_core.errors import Status
from cca_core.path import Path

__all__ = ["Command"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Command:
    """What the car is to do now, and why.

    Parameters
    ----------
    delta : float
        Road-wheel angle [rad], left positive.
    a_x : float
        Acceleration [m/s^2], forward positive.
    decision : Decision
        The action with its reason.
    band : Band or None
        The bent route while evading, from the ego on.
    reference : Path
        The path that is steered along.
    status : Status
        `Status.OK`; `FALLBACK` for a swerve that is driven otherwise than in comfort, or given up; or
        `INVALID_INPUT`. To follow and to brake, however hard, is `OK`: `decision` says what is done.
    dropped : tuple of (str, str)
        Remote vehicles that could not be used, each with the reason.
    """

    delta: float
    a_x: float
    decision: Decision
    band: Band | None
    reference: Path
    status: Status
    dropped: tuple[tuple[str, str], ...] = ()

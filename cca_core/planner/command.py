"""Command of one cycle."""

from dataclasses import dataclass

from cca_core.band import Band
from cca_core.decide import Decision
from cca_core.errors import Status
from cca_core.path import Path
from cca_core.planner.certificate import Certificate, SafeStop
from cca_core.planner.records import Mode

__all__ = ["Command"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Command:
    """Steering and acceleration of a cycle, with their reason.

    Parameters
    ----------
    delta : float
        Road-wheel angle [rad], left positive.
    a_x : float
        Acceleration [m/s^2], forward positive.
    decision : Decision
        The action with its reason.
    band : Band or None
        The band of an ongoing maneuver, from the ego on.
    reference : Path
        The path that is steered along.
    status : Status
        `Status.OK`; `DEGRADED` if a maneuver is sharper or narrower than a comfortable one, or safe only
        nominally; `INVALID_INPUT` if the state cannot be used. Following and braking are `OK`, even at full
        deceleration.
    dropped : tuple of (str, str)
        Id and reason of remote vehicles that are not used.
    input_faults : tuple of str
        Other inputs of this cycle that are wrong, and what the planner assumes instead: time stamps that
        repeat or step back, awareness ranges that are none, a radio that is not to be trusted.
    mode : Mode, optional
        What the ego does; a label of the plan that it drives.
    safe_stop : SafeStop, optional
        Steering and braking that stop the ego if no further command comes.
    certificate : Certificate, optional
        What is certified of the plan that is driven, and of its safe stop; None if
        the state is lost.
    """

    delta: float
    a_x: float
    decision: Decision
    band: Band | None
    reference: Path
    status: Status
    dropped: tuple[tuple[str, str], ...] = ()
    input_faults: tuple[str, ...] = ()
    mode: Mode | None = None
    safe_stop: SafeStop | None = None
    certificate: Certificate | None = None

    def __repr__(self) -> str:
        return (
            f"Command({self.decision.action.name}, delta={self.delta:.4f} rad, a_x={self.a_x:.2f} m/s^2, "
            f"{self.status.name}, {self.decision.reason!r})"
        )

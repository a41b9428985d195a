"""CAN frames, and what the kit reports in them."""

from dataclasses import dataclass
from typing import NamedTuple

from cca_core.rig.kit import KitState


class Frame(NamedTuple):
    """A CAN frame.

    Parameters
    ----------
    id : int
        Identifier, 11 bits [-].
    data : bytes
        Up to 8 bytes.
    t : float
        Time of reception by the interface [s]; 0 for a frame to be sent.
    """

    id: int
    data: bytes
    t: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class KitStatus:
    """What the kit reports.

    Parameters
    ----------
    state : KitState
        State of the kit.
    has_timed_out : bool
        Whether the safe stop began for want of a command.
    has_safe_stop : bool
        Whether the kit holds a plan of a safe stop.
    cycle : int
        Number of the state [-]; it stays while the vehicle has not started.
    wrong_crc, wrong_counter : int
        Commands that the kit refused [-].
    """

    state: KitState
    has_timed_out: bool = False
    has_safe_stop: bool = False
    cycle: int = 0
    wrong_crc: int = 0
    wrong_counter: int = 0

"""Records of plant and vehicle: a row for each cycle, and what a process leaves."""

import pickle
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.planner.command import Command
from cca_core.rig.kit import KitState
from cca_core.vehicle import RemoteVehicle, VehicleState


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantRow:
    """One cycle of the plant.

    Parameters
    ----------
    cycle : int
        Number of the state [-], from 1 on.
    state : VehicleState
        Motion of the ego.
    a_y : float
        Its lateral acceleration [m/s^2].
    users : tuple
        x, y [m], psi [rad], speed [m/s], acceleration [m/s^2] and yaw rate [rad/s] of each road user.
    frenet : tuple
        Frenet coordinates s, d of each [m].
    shifting, visible : tuple of bool
        Whether each moves laterally, and whether the ego's sensor sees it.
    actuation : tuple of float
        Road-wheel angle [rad] and acceleration [m/s^2] that the kit applies from here on.
    kit : KitState
        State of the kit.
    sent, sent_radio : float
        UTC at which the state was sent [s], and number of messages to the ego so far [-].
    answered : int
        Number of the state that the last valid command answers [-].
    collided_with : str
        Id of the road user whose box overlaps the ego's; empty if none does.
    """

    cycle: int
    state: VehicleState
    a_y: float
    users: tuple[tuple[float, ...], ...]
    frenet: tuple[tuple[float, float], ...]
    shifting: tuple[bool, ...]
    visible: tuple[bool, ...]
    actuation: tuple[float, float]
    kit: KitState
    sent: float
    sent_radio: int
    answered: int
    collided_with: str

    __repr__ = short_repr


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VehicleRow:
    """One command of the vehicle computer.

    Parameters
    ----------
    cycle : int
        Number of the state that it answers [-].
    command : Command
        The command with its reason.
    remotes : tuple of RemoteVehicle
        Vehicles known in this cycle.
    messages : tuple of bytes
        Messages received since the last cycle.
    a_x : float
        Acceleration that was sent [m/s^2]: the command's, or that of a fixed time gap.
    gap_held : bool
        Whether a fixed time gap was kept instead of the command's acceleration.
    cycle_us : float
        Time of the planner [us].
    received, sent : float
        UTC at which the state was complete, and at which the command was sent [s].
    """

    cycle: int
    command: Command
    remotes: tuple[RemoteVehicle, ...]
    messages: tuple[bytes, ...]
    a_x: float
    gap_held: bool
    cycle_us: float
    received: float
    sent: float

    __repr__ = short_repr


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ProcessRecord:
    """What a process leaves when it ends.

    Parameters
    ----------
    rows : list
        Rows of a `PlantNode` or of a `VehicleNode`.
    loop : dict
        Summary of its `RealTimeLoop`.
    refused : dict
        What the operating system did not grant.
    messages : dict
        Numbers of messages, as in `Log.messages`.
    counts : dict
        Counters by the name of their owner.
    """

    rows: list[PlantRow] | list[VehicleRow]
    loop: dict[str, Any]
    refused: dict[str, str]
    messages: dict[str, int] = field(default_factory=dict)
    counts: dict[str, dict[str, int]] = field(default_factory=dict)

    __repr__ = short_repr


def write_record(record: ProcessRecord, file: str | FilePath) -> None:
    """Write the record of a process.

    Parameters
    ----------
    record : ProcessRecord
        The record.
    file : str or pathlib.Path
        File; it appears when it is complete.
    """
    unfinished = FilePath(file).with_suffix(".part")
    unfinished.write_bytes(pickle.dumps(record))
    unfinished.rename(file)


def read_record(file: str | FilePath) -> ProcessRecord | None:
    """Read the record of a process of this machine.

    Parameters
    ----------
    file : str or pathlib.Path
        File that `write_record` has written; read no file of another origin.

    Returns
    -------
    record : ProcessRecord or None
        None if the process left none.

    Raises
    ------
    InputError
        If the file holds something else.
    """
    if not FilePath(file).exists():
        return None
    record = pickle.loads(FilePath(file).read_bytes())
    if not isinstance(record, ProcessRecord):
        raise InputError(f"file {str(file)!r} must hold a ProcessRecord, had {type(record).__name__}")
    return record

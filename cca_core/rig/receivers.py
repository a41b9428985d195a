"""Receivers of CAN messages: the vehicle's of its state, and the kit's of its commands."""

import math
from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass, replace

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.rig.frames import Frame, KitStatus
from cca_core.rig.kit import DriveByWireKit, KitState, SteeringCommand
from cca_core.rig.messages import COMMAND_MESSAGES, N_CYCLES, N_PLAN_CYCLES, STATE_MESSAGES, Codec
from cca_core.rig.protection import CheckStatus, LinkState, ProtectedReceiver, ProtectionSettings
from cca_core.rig.safe_stop import SAFE_STOP_POINTS
from cca_core.vehicle import VehicleState

_BAD = (CheckStatus.REPEATED, CheckStatus.WRONG_SEQUENCE)


@dataclass(frozen=True, slots=True, kw_only=True)
class StateSettings:
    """When a received state is not to be trusted.

    Parameters
    ----------
    timeout : float
        Age from which on a state counts as lost [s].
    period : float
        Time between two states, as their numbers count it [s].
    frozen_cycles : int
        Number of states over which position and speed are compared [-].
    frozen_fraction : float
        Largest difference between the distance by the positions and that by the speeds, per distance [-].
    frozen_distance : float
        Distance below which they are not compared [m].

    Raises
    ------
    InputError
        If a value is not finite or not positive.
    """

    timeout: float = 0.06
    period: float = 0.02
    frozen_cycles: int = 3
    frozen_fraction: float = 0.3
    frozen_distance: float = 0.3

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in self.__slots__:
            check_real(name, getattr(self, name), gt=0.0)


class StateReceiver:
    """Vehicle's receiver of its own state.

    Parameters
    ----------
    codec : Codec
        Messages.
    settings : StateSettings, optional
        Limits.
    protection : ProtectionSettings, optional
        Limits of the end-to-end check.

    Attributes
    ----------
    state : VehicleState or None
        Last complete state with the time of its reception; None before the first.
    status : KitStatus or None
        Status of the kit in that state.
    counts : Counter
        Number of states (``"complete"``), and of refused frames by kind.
    """

    def __init__(
        self,
        codec: Codec,
        settings: StateSettings | None = None,
        protection: ProtectionSettings | None = None,
    ) -> None:
        self.settings = settings or StateSettings()
        self.state: VehicleState | None = None
        self.status: KitStatus | None = None
        self.counts: Counter[str] = Counter()
        self._codec = codec
        self._names = {codec.ids[name]: name for name in STATE_MESSAGES}
        self._links = {name: ProtectedReceiver(codec.ids[name], protection) for name in STATE_MESSAGES}
        self._parts: dict[str, tuple[float, Frame]] = {}  # with times of reception
        self._history: deque[tuple[int, float, float, float]] = deque(maxlen=self.settings.frozen_cycles + 1)

    def take(self, frame: Frame, t: float) -> bool:
        """Take a frame from the bus.

        Parameters
        ----------
        frame : Frame
            Any frame; other identifiers are ignored.
        t : float
            Now on the vehicle's clock [s].

        Returns
        -------
        is_complete : bool
            Whether a new state is complete and can be trusted.
        """
        name = self._names.get(frame.id)
        if name is None:
            return False
        status = self._links[name].check(self._codec.content(frame))
        if not status.is_usable or self._links[name].state is not LinkState.VALID:
            self.counts[status.name.lower()] += 1
            self._parts.pop(name, None)
            return False
        self._parts[name] = t, frame
        # fifteen cycles later the counters are the same again
        parts = [part for at, part in self._parts.values() if t - at <= self.settings.timeout]
        counters = {part.data[1] & 0x0F for part in parts}
        if name != STATE_MESSAGES[-1] or len(parts) < len(STATE_MESSAGES) or len(counters) > 1:
            return False
        state, kit = self._codec.state(parts)
        self._parts.clear()
        if self._is_frozen(state, kit):
            self.counts["frozen"] += 1
            return False
        self.counts["complete"] += 1
        self.state, self.status = replace(state, t=t), kit
        return True

    def age(self, t: float) -> float:
        """Return the age of the state.

        Parameters
        ----------
        t : float
            Now on the vehicle's clock [s].

        Returns
        -------
        age : float
            Time since its reception [s]; infinite before the first.
        """
        return math.inf if self.state is None or self.state.t is None else t - self.state.t

    def is_lost(self, t: float) -> bool:
        """Return whether the state is too old to act on.

        Parameters
        ----------
        t : float
            Now on the vehicle's clock [s].

        Returns
        -------
        lost : bool
            Whether its age exceeds the timeout.
        """
        return self.age(t) > self.settings.timeout

    def _is_frozen(self, state: VehicleState, kit: KitStatus) -> bool:
        """Return whether the content stays although time or the vehicle moves on."""
        history = self._history
        if history and kit.state is not KitState.DISABLED and kit.cycle == history[-1][0]:
            return True
        if history and history[-1][0] == 0:  # the vehicle starts from this state
            history.clear()
        history.append((kit.cycle, state.x, state.y, state.v_x))
        cycle, x, y, _ = history[0]
        if len(history) <= self.settings.frozen_cycles:
            return False
        elapsed = (kit.cycle - cycle) % N_CYCLES * self.settings.period
        speeds = [each[3] for each in history]
        expected = elapsed * sum(speeds) / len(speeds)
        moved = math.hypot(state.x - x, state.y - y)
        limit = self.settings.frozen_fraction * max(expected, moved)
        return max(expected, moved) > self.settings.frozen_distance and abs(moved - expected) > limit


class CommandReceiver:
    """Kit's receiver of commands: only what passes the end-to-end check reaches the kit.

    Parameters
    ----------
    kit : DriveByWireKit
        The kit.
    codec : Codec
        Messages.
    protection : ProtectionSettings, optional
        Limits of the end-to-end check.
    max_cycle_age : int
        Number of cycles [-] beyond which the state that a command answers is too old, or has not been sent.

    Attributes
    ----------
    cycle : int
        Number of the state that the last valid steering command answers [-].
    counts : Counter
        Number of valid commands by message, and of refused frames by kind; ``"late"`` are those that answer a
        state that is too old.

    Raises
    ------
    InputError
        If `max_cycle_age` is negative.
    """

    def __init__(
        self,
        kit: DriveByWireKit,
        codec: Codec,
        protection: ProtectionSettings | None = None,
        *,
        max_cycle_age: int = 5,
    ) -> None:
        self.cycle = 0
        self.counts: Counter[str] = Counter()
        self._max_cycle_age = check_real("max_cycle_age", max_cycle_age, ge=0)
        self._kit, self._codec = kit, codec
        self._names = {codec.ids[name]: name for name in COMMAND_MESSAGES}
        self._links = {name: ProtectedReceiver(codec.ids[name], protection) for name in COMMAND_MESSAGES}
        self._plan: list[Frame] = []
        self._plan_number = 0

    @property
    def wrong_crc(self) -> int:
        """Number of frames with a wrong CRC."""
        return sum(link.counts[CheckStatus.WRONG_CRC] for link in self._links.values())

    @property
    def wrong_counter(self) -> int:
        """Number of frames with a repeated or jumped counter."""
        return sum(link.counts[status] for link in self._links.values() for status in _BAD)

    def take(self, frames: Iterable[Frame], t: float, cycle: int = 0) -> None:
        """Take the frames of one cycle.

        Parameters
        ----------
        frames : iterable of Frame
            All frames that have arrived; other identifiers are ignored.
        t : float
            Now on the kit's clock [s].
        cycle : int
            Number of the last state that was sent [-].
        """
        arrived: set[str] = set()
        for frame in frames:
            name = self._names.get(frame.id)
            if name is None:
                continue
            arrived.add(name)
            status = self._links[name].check(self._codec.content(frame))
            if not status.is_usable or self._links[name].state is not LinkState.VALID:
                self.counts[status.name.lower()] += 1
                continue
            is_plan = name == "SAFE_STOP"
            if self._is_late(frame, cycle, N_PLAN_CYCLES if is_plan else N_CYCLES):
                self.counts["late"] += 1
                continue
            if is_plan:
                self._collect(frame, t)
            else:
                self._act(frame, t)
            self.counts[name] += 1
        for name in COMMAND_MESSAGES[:2]:  # a safe stop does not come in every cycle
            if name not in arrived:
                self._links[name].check(None)

    def _is_late(self, frame: Frame, cycle: int, modulus: int) -> bool:
        """Return whether a command answers a state of another time; a vehicle without states counts on."""
        behind = (cycle - int(self._codec.decode(frame)["Cycle"])) % modulus
        return min(behind, modulus - behind) > self._max_cycle_age

    def _act(self, frame: Frame, t: float) -> None:
        command = self._codec.command(frame)
        if isinstance(command, SteeringCommand):
            self.cycle = int(self._codec.decode(frame)["Cycle"])
            self._kit.steer(t, command)
        else:
            self._kit.accelerate(t, command)

    def _collect(self, frame: Frame, t: float) -> None:
        """Collect the frames of a plan; load it when it is complete."""
        signals = self._codec.decode(frame)
        number, index = int(signals["Cycle"]), int(signals["Index"])
        if index == 0:
            self._plan_number, self._plan = number, []
        if index != len(self._plan) or number != self._plan_number:
            self._plan = []
            return
        self._plan.append(frame)
        if len(self._plan) == SAFE_STOP_POINTS:
            try:
                self._kit.load(t, self._codec.safe_stop(self._plan))
            except InputError:  # a sender that follows another rule
                self.counts["invalid"] += 1
            self._plan = []

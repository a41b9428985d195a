"""What is worth telling of a run: changes of action, and events with their times."""

from collections.abc import Iterable, Sequence

from cca_core.decide import Action
from cca_core.planner.command import Command
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.traffic import Traffic
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["EventRecorder"]

_BRAKES = -1.0  # acceleration that counts as braking [m/s^2]
_STANDS = 0.05  # [m/s]


class EventRecorder:
    """Collects decisions and the first time of each event.

    Parameters
    ----------
    scenario : Scenario
        What is run.

    Attributes
    ----------
    decisions : list of (float, str, str)
        Time [s], action and reason at each change of action.
    events : list of (float, str, str)
        Time [s], what, and the vehicle concerned, each once: ``"seen"``, ``"heard"``, ``"hazard_heard"`` (its
        first message of hard braking), ``"brakes"``, ``"stands"``, ``"swerves"``, ``"released"`` (the ego's
        gap), ``"contact"``.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._names = [user.id for user in scenario.road_users]
        self._pinned = scenario.fixed_gap is not None
        self.decisions: list[tuple[float, str, str]] = []
        self.events: list[tuple[float, str, str]] = []
        self._told: set[tuple[str, str]] = set()
        self._moved = {user.id for user in scenario.road_users if user.v_x > _STANDS}

    def record(
        self,
        t: float,
        state: VehicleState,
        command: Command,
        remotes: Iterable[RemoteVehicle],
        seen: Sequence[bool],
        traffic: Traffic,
        touched: str,
        *,
        held: bool,
    ) -> None:
        """Look at one cycle.

        Parameters
        ----------
        t : float
            Now [s].
        state : VehicleState
            The ego.
        command : Command
            What it does.
        remotes : iterable of RemoteVehicle
            What it knows.
        seen : sequence of bool
            Who is in sight.
        traffic : Traffic
            The road users.
        touched : str
            Id of who touches the ego, empty if nobody does.
        held : bool
            Whether a pinned gap is held.
        """
        action = command.decision.action.value
        if not self.decisions or self.decisions[-1][1] != action:
            self.decisions.append((t, action, command.decision.reason))
        for name, is_seen in zip(self._names, seen, strict=True):
            if is_seen:
                self._tell(t, "seen", name)
        for remote in remotes:
            if remote.source == "v2v":
                self._tell(t, "heard", remote.id)
                if "hard_braking" in remote.events:
                    self._tell(t, "hazard_heard", remote.id)
        for mover in traffic.movers:
            name = mover.user.id
            if mover.a <= _BRAKES:
                self._tell(t, "brakes", name)
            if mover.v <= _STANDS and name in self._moved:
                self._tell(t, "stands", name)
            if mover.is_shifting:
                self._tell(t, "swerves", name)
        if self._pinned and not held:
            self._tell(t, "released", "ego")
        if not held and command.a_x <= _BRAKES:
            self._tell(t, "brakes", "ego")
        if state.v_x <= _STANDS:
            self._tell(t, "stands", "ego")
        if command.decision.action in (Action.EVADE_LEFT, Action.EVADE_RIGHT):
            self._tell(t, "swerves", "ego")
        if touched:
            self._tell(t, "contact", touched)

    def _tell(self, t: float, what: str, who: str) -> None:
        if (what, who) not in self._told:
            self._told.add((what, who))
            self.events.append((t, what, who))

"""A planner whose reasons are compared with its commands in every cycle."""

import re
from typing import Any

from cca_core import Command, Planner
from cca_core.planner.records import Mode

MAX_LENGTH = 150
VERBS = {
    "approaching", "braking", "changing", "following", "holding", "keeping", "passing", "releasing",
    "returning", "slowing", "speeding", "standing", "stopped", "stopping", "waiting", "yielding",
}  # fmt: skip
SLOWS = {"braking", "slowing", "stopping"}
BRAKES_FIRMLY = SLOWS | {"following", "releasing", "stopped", "yielding"}
FORCE = re.compile(r"braking [\d.]+ m/s²|releasing the brakes|: stopped")
SHORTAGES = (
    re.compile(r"(?P<has>[\d.]+) m, needs (?P<needs>[\d.]+) m"),
    re.compile(r"needs (?P<needs>[\d.]+) m, (?P<has>[\d.]+) m left"),
    re.compile(r"\((?P<needs>[\d.]+) \S+, limit (?P<has>[\d.]+) "),
)


def contradictions(command: Command, v: float, last_a_x: float) -> list[str]:
    """What a reason says that its command does not do."""
    reason, a_x, found = command.decision.reason, command.a_x, []
    verb = re.split("[ :]", reason)[0]
    checks = {
        "unknown activity": verb in VERBS,
        "accelerates": verb not in SLOWS or a_x <= 0.05,
        "the brakes are not released": verb != "releasing" or last_a_x - 1e-3 <= a_x < 0.0,
        "does not speed up": verb != "speeding" or a_x > 0.0,
        "moves": verb not in ("stopped", "standing") or v < 0.15,
        "brakes without a cause": a_x > -1.0 or verb in BRAKES_FIRMLY or bool(FORCE.search(reason)),
        "no shortage": all(
            float(m["needs"]) >= float(m["has"]) for form in SHORTAGES for m in form.finditer(reason)
        ),
        "too long": len(reason) <= MAX_LENGTH,
        "not a number": "nan" not in reason and "inf" not in reason.split(),
        "activity and cause": reason.startswith(command.decision.activity)
        and reason.endswith(command.decision.cause),
    }
    found = [name for name, holds in checks.items() if not holds]
    return found


class CheckedPlanner:
    """Planner that keeps what its reasons say wrong."""

    def __init__(self, planner: Planner) -> None:
        self.planner, self.wrong, self.reasons = planner, [], []
        self._last_a_x, self._ids = 0.0, set[str]()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.planner, name)

    def step(self, t: float, state: Any, remotes: Any, **known: Any) -> Command:
        remotes = list(remotes)
        command = self.planner.step(t, state, remotes, **known)
        self.check(command, t, state.v_x, {r.id for r in remotes})
        return command

    def check(self, command: Command, t: float, v: float, ids: set[str]) -> None:
        """Compare a command with its reason."""
        reason = command.decision.reason
        self.reasons.append(reason)
        if command.mode is not Mode.SAFE_STOP:
            found = contradictions(command, v, self._last_a_x)
            gone = (self._ids - ids) & set(re.split(r"[ ,:;()]+", reason))
            found += [f"{name} is not there" for name in gone]
            if command.decision.lead_id not in {None, *ids}:
                found.append("the lead vehicle is not there")
            self.wrong += [f"{t:.2f} s, {command.a_x:.2f} m/s²: {each}: {reason}" for each in found]
        self._ids |= ids
        self._last_a_x = command.a_x

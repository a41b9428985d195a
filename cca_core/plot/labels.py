"""Texts of figures: names of scenarios, cases, ego types and runs."""

import re
from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

from cca_core._optional import require_extra
from cca_core.sim import Log, RoadUser, Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAMES = {
    "eebl": "Emergency braking ahead",
    "ima": "Occluded traffic at an intersection",
    "curbside": "Stopped vehicle at the roadside",
    "maneuver": "Maneuvering in traffic",
    ("eebl", "A"): "no vehicle connected",
    ("eebl", "B"): "only the ego connected",
    ("eebl", "B-hard"): "only the ego connected",
    ("eebl", "C"): "ego and yellow connected",
    ("eebl", "C-gentle"): "both connected, braking gently",
    ("eebl", "D"): "only yellow connected",
    ("eebl", "sensor"): "no vehicle connected",
    ("ima", "left-turn"): "left turn",
    ("ima", "crossing"): "straight on",
    ("curbside", "fast"): "fast",
    ("curbside", "slow"): "slow",
    "v2v": "with V2V",
    "driver": "driver without V2V",
    "sensor": "sensor without V2V",
}
"""Names of scenarios, of their cases and of ego types."""


_ACTIONS = {
    "KEEP": "keeps its lane",
    "FOLLOW": "follows",
    "EVADE_LEFT": "passes on the left",
    "EVADE_RIGHT": "passes on the right",
    "BRAKE": "brakes",
}


def action_words(name: str) -> str:
    """Name of an action in words, such as ``"keeps its lane"``."""
    return _ACTIONS.get(name, name)


def title(log: Log) -> str:
    """Name of a run in words.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    title : str
        Such as ``"Maneuvering in traffic, case 2: with V2V"``.
    """
    return f"{scenario_name(log.scenario)}: {ego_label(log)}"


def title_lines(log: Log) -> str:
    """Name of a run on lines that fit a figure as wide as a column."""
    return break_title(title(log))


def break_title(name: str) -> str:
    """Long title on lines of which the first ends at a comma or a colon."""
    if len(name) < 44:
        return name
    sign = "," if ", " in name else ":"
    return fill_text(name.replace(f"{sign} ", f"{sign}\n", 1), 46)


def scenario_name(scenario: Scenario, *, cased: bool = True) -> str:
    """Name of a scenario in words, such as ``"Maneuvering in traffic, case 2"``."""
    name = NAMES.get(scenario.name, scenario.name)
    return f"{name}, {case_name(scenario)}" if cased and scenario.case is not None else name


def case_name(scenario: Scenario) -> str:
    """Name of a scenario's case in words, such as ``"case 2"``; empty if it has none."""
    if scenario.case is None:
        return ""
    return NAMES.get((scenario.name, scenario.case), f"case {scenario.case}")


def ego_label(log: Log) -> str:
    """Ego type of a run in words, such as ``"driver without V2V"``, and the vehicles without a radio."""
    silent = [user.id for user in log.scenario.road_users if not user.connected]
    if not log.scenario.v2v or not silent:
        return NAMES[log.scenario.ego_type]
    names = join_names(silent) if len(silent) < 3 else "some vehicles"
    return f"with V2V; {names} {'has' if len(silent) == 1 else 'have'} no radio"


def gap_words(gap: float) -> str:
    """Gap between bodies with its unit, in centimeters below 1 m: there they count."""
    return f"{max(gap, 0.0):.{2 if gap < 0.995 else 1}f} m"


def is_called_oncoming(user: RoadUser) -> bool:
    """Return whether a text says that a road user is oncoming: not if its id does."""
    return user.direction < 0 and user.route is None and "oncoming" not in user.id.lower()


def run_heading(label: str, outcomes: Sequence[str], i: int) -> str:
    """Name of the i-th of some runs, and its outcome if it is given."""
    return fill_text(": ".join([begin_sentence(label), *outcomes[i : i + 1]]), 54)


def fill_text(text: str, width: int) -> str:
    """Text on lines of at most some characters, in which numbers and their units stay together."""
    whole = re.sub(r"(\d) (m/s²|m/s|m|s)\b", "\\1\N{NO-BREAK SPACE}\\2", text)
    whole = re.sub(r"\bmin gap (?:to (?:it|them) )?(?=\d)", _unbroken, whole)
    return "\n".join(fill(line, width) for line in whole.split("\n"))


def _unbroken(found: re.Match[str]) -> str:
    return found[0].replace(" ", "\N{NO-BREAK SPACE}")


def begin_sentence(text: str) -> str:
    """Text with a capital first letter."""
    return text[0].upper() + text[1:]


def join_names(ids: Sequence[str]) -> str:
    """Ids with commas and "and"."""
    return " and ".join(filter(None, (", ".join(ids[:-1]), ids[-1])))


def sanitize_text(text: str) -> str:
    """Text with a replacement character for each one that cannot be printed: an id may come as bytes."""
    return "".join(each if each.isprintable() or each == "\N{NO-BREAK SPACE}" else "\ufffd" for each in text)


def escape_figure_text(figure: "Figure") -> "Figure":
    """Make every text of a finished figure printable, and none of it a formula."""
    for text in figure.findobj(require_extra("matplotlib.text", "plot").Text):
        text.set_text("\n".join(map(sanitize_text, text.get_text().split("\n"))))
        text.set_parse_math(False)
    return figure

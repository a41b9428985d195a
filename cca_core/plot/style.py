"""Colors and words that all pictures share."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._optional import require_extra
from cca_core.path import Road
from cca_core.sim import Log, Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EGO = "#0072B2"
"""Color of the ego (blue of the Okabe-Ito set, which color-blind readers can tell apart)."""

ACTIONS = {
    "KEEP": "#EEEEEE",
    "FOLLOW": "#F5E97A",
    "EVADE_LEFT": "#A9D8F5",
    "EVADE_RIGHT": "#C3B8EE",
    "BRAKE": "#F3A683",
}
"""Background color of each action."""

ASPHALT = "#F2F2F2"
"""Color of the road."""

PARKED = "#777777"
"""Color of a parked car."""

HIT = "#A33000"
"""Color of a contact."""

LEAST_A_Y = 1.0
"""Height of a view of lateral acceleration, at least [m/s²]."""

_OTHERS = ("#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56606B")
_NAMED = {"red": "#D62F27", "yellow": "#E0A800"}
_SCENARIOS = {
    "eebl": "Emergency braking ahead",
    "ima": "Hidden traffic at an intersection",
    "curbside": "Stopped vehicle at the roadside",
    "maneuver": "Maneuvering in traffic",
}
_CASES = {
    ("eebl", "A"): "nobody connected",
    ("eebl", "B"): "only the ego connected",
    ("eebl", "C"): "ego and yellow connected",
    ("eebl", "C-gentle"): "both connected, braking gently",
    ("eebl", "D"): "only yellow connected",
    ("eebl", "sensor"): "nobody connected",
    ("ima", "left-turn"): "left turn",
    ("ima", "crossing"): "straight on",
    ("curbside", "fast"): "fast",
    ("curbside", "slow"): "slow",
}
_EGOS = {"v2v": "with V2V", "driver": "driver without V2V", "sensor": "sensor without V2V"}


def assign_colors(ids: Sequence[str]) -> dict[str, str]:
    """Color of each road user; the same ids get the same colors.

    Parameters
    ----------
    ids : sequence of str
        Who is drawn.

    Returns
    -------
    colors : dict
        Color of each id; ``"red"`` and ``"yellow"`` have their own, the others' repeat after five.
    """
    others = sorted(set(ids) - _NAMED.keys())
    palette = {id_: _OTHERS[i % len(_OTHERS)] for i, id_ in enumerate(others)}
    return {id_: _NAMED.get(id_) or palette[id_] for id_ in ids}


def sanitize_text(text: str) -> str:
    """Make text of any origin fit for a page.

    Parameters
    ----------
    text : str
        Such as an id that came as bytes.

    Returns
    -------
    plain : str
        The same with a replacement character for each one that cannot be printed.
    """
    return "".join(each if each.isprintable() or each == "\N{NO-BREAK SPACE}" else "\ufffd" for each in text)


def case_name(scenario: Scenario) -> str:
    """Name of a scenario's case in words.

    Parameters
    ----------
    scenario : Scenario
        The scenario.

    Returns
    -------
    name : str
        Such as ``"case 2"``; empty if it has none.
    """
    if scenario.case is None:
        return ""
    return _CASES.get((scenario.name, scenario.case), f"case {scenario.case}")


def scenario_name(scenario: Scenario, *, cased: bool = True) -> str:
    """Name of a scenario in words.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    cased : bool
        Whether its case is named too.

    Returns
    -------
    name : str
        Such as ``"Maneuvering in traffic, case 2"``.
    """
    name = _SCENARIOS.get(scenario.name, scenario.name)
    return f"{name}, {case_name(scenario)}" if cased and scenario.case is not None else name


def ego_label(log: Log) -> str:
    """Who drives the ego of a run, in words.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    who : str
        Such as ``"driver without V2V"``.
    """
    return _EGOS[log.scenario.ego_type]


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


def row_at(log: Log, t: float) -> int:
    """Cycle of a log that is nearest to a time.

    Parameters
    ----------
    log : Log
        The run.
    t : float
        Time [s].

    Returns
    -------
    row : int
        Index into the arrays of the log [-].
    """
    return int(np.argmin(np.abs(log.t - t)))


def draw_lanes(axis: Any, road: Road) -> None:
    """Draw lanes and edges of a road in path coordinates.

    Parameters
    ----------
    axis : matplotlib.axes.Axes
        Where to draw; its view is left alone along the road.
    road : Road
        Lanes and edges.
    """
    axis.axhspan(road.right_edge, road.left_edge, color=ASPHALT, zorder=0)
    for border in {lane.right for lane in road.lanes} | {lane.left for lane in road.lanes}:
        if border in (road.right_edge, road.left_edge):
            axis.axhline(border, color="#555555", linewidth=1.2)
        else:
            axis.axhline(border, color="#555555", linewidth=0.8, linestyle=(0, (8, 6)))
    axis.set_yticks([lane.d for lane in road.lanes])


def expand_limits(axis: Any, least: float, *, above: float = 0.0) -> None:
    """Widen a view upwards and downwards, so that what is next to nothing looks like it.

    Parameters
    ----------
    axis : matplotlib.axes.Axes
        Where all is drawn; its view is changed.
    least : float
        Least height of the view, in units of the axis.
    above : float
        Room for a legend on top, as a share of the height [-].
    """
    low, high = axis.get_ylim()
    lack = 0.5 * max(least - (high - low), 0.0)
    axis.set_ylim(low - lack, high + lack + above * (high - low + 2.0 * lack))


def escape_figure_text(figure: "Figure") -> "Figure":
    """Make every text of a figure fit to be drawn, whatever ids it holds.

    Parameters
    ----------
    figure : Figure
        The figure, finished; it is changed.

    Returns
    -------
    figure : Figure
        The same one, with no character that cannot be printed and no formula in its texts.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    for text in figure.findobj(require_extra("matplotlib.text", "plot").Text):
        text.set_text("\n".join(map(sanitize_text, text.get_text().split("\n"))))
        text.set_parse_math(False)
    return figure


def new_figure(height: float) -> "Figure":
    """Empty figure of the width of a page.

    Parameters
    ----------
    height : float
        Its height in inches [25.4 mm].

    Returns
    -------
    figure : Figure
        It lays itself out and belongs to no window.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    figure: Figure = require_extra("matplotlib.figure", "plot").Figure(
        figsize=(9.0, height), layout="constrained"
    )
    return figure

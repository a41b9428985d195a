"""Colours and words that all pictures share."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._optional import require_extra
from cca_core.path import Road
from cca_core.sim import Log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EGO = "#0072B2"
"""Colour of the ego (blue of the Okabe-Ito set, which colour-blind readers can tell apart)."""

ACTIONS = {
    "KEEP": "#EEEEEE",
    "FOLLOW": "#F5E97A",
    "EVADE_LEFT": "#A9D8F5",
    "EVADE_RIGHT": "#C3B8EE",
    "BRAKE": "#F3A683",
}
"""Background colour of each action."""

ASPHALT = "#F2F2F2"
"""Colour of the road."""

PARKED = "#777777"
"""Colour of a parked car."""

_OTHERS = ("#D55E00", "#009E73", "#CC79A7", "#E69F00", "#000000")


def colours(ids: Sequence[str]) -> dict[str, str]:
    """Colour of each road user; the same ids get the same colours.

    Parameters
    ----------
    ids : sequence of str
        Who is drawn.

    Returns
    -------
    colours : dict
        Colour of each id; they repeat after five.
    """
    return {id_: _OTHERS[i % len(_OTHERS)] for i, id_ in enumerate(sorted(set(ids)))}


def title(log: Log) -> str:
    """Name of a run in words.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    title : str
        Such as ``"Case 2, without messages"``.
    """
    scenario = log.scenario
    name = scenario.name if scenario.case is None else f"Case {scenario.case}"
    return name if scenario.v2v else f"{name}, without messages"


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

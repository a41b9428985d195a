"""Figure of the rig's computers, their links and the measured latencies: counterpart of the paper's Fig 4."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core.plot.style import COLORS, TEXT, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# corner, width and height of each box, in hundredths of the figure, and its text
_BOXES = {
    "plant": (2, 62, 26, 30, "Plant computer\nplant, traffic, sensor,\ndrive-by-wire kit"),
    "modem": (2, 24, 26, 22, "Modem of all\nother vehicles"),
    "vehicle": (72, 62, 26, 30, "Vehicle computer\ntracker, planner,\nsteering, safe stop"),
    "unit": (72, 24, 26, 22, "On-board unit\nof the ego"),
    "monitor": (36, 2, 28, 13, "Monitor (reads only)"),
}  # fmt: skip


def plot_links(links: Sequence[dict[str, dict[str, Any]]]) -> "Figure":
    """Draw the links between the computers with their latencies.

    Parameters
    ----------
    links : sequence of dict
        Results of `measure_links`; the median of the medians and the largest 99th percentile are shown.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The figure.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    figure = new_figure(4.2)
    axis = figure.add_subplot()
    axis.set(xlim=(0, 100), ylim=(0, 100))
    axis.axis("off")
    for x, y, width, height, text in _BOXES.values():
        axis.add_patch(_box(x, y, width, height))
        axis.text(
            x + 0.5 * width, y + 0.5 * height, text, ha="center", va="center", fontsize=TEXT.note,
            color=COLORS.ink,
        )  # fmt: skip
    _arrow(axis, (28.4, 85), (71.6, 85), f"CAN: state, 50 Hz\n{_latency(links, 'state')}")
    _arrow(axis, (71.6, 66), (28.4, 66), f"CAN: command, 50 Hz; safe stop, 10 Hz\n{_answer(links)}")
    _arrow(axis, (28.4, 38), (71.6, 38), f"UDP: messages of the others, 10 Hz\n{_latency(links, 'radio')}")
    _arrow(axis, (71.6, 28), (28.4, 28), "UDP: messages of the ego, 10 Hz")
    for x in (15, 85):
        _arrow(axis, (x, 61.5), (x, 46.5), "")
        _arrow(axis, (x, 46.5), (x, 61.5), "")
    axis.plot([50, 50], [27, 22], color=COLORS.faint, linewidth=1.0, linestyle=":")
    _arrow(axis, (50, 24), (50, 15.5), "")
    axis.text(
        85, 93.5, f"planner: {_latency(links, 'planner')}", ha="center", va="bottom", fontsize=TEXT.tiny
    )
    return figure


def _box(x: float, y: float, width: float, height: float) -> Any:
    from matplotlib.patches import FancyBboxPatch

    return FancyBboxPatch(
        (x, y), width, height, boxstyle="round,pad=0.4", facecolor=COLORS.road, edgecolor=COLORS.line
    )


def _arrow(axis: Any, tail: tuple[float, float], tip: tuple[float, float], text: str) -> None:
    axis.annotate("", tip, tail, arrowprops={"arrowstyle": "-|>", "color": COLORS.ego, "linewidth": 1.4})
    axis.text(
        0.5 * (tail[0] + tip[0]), 0.5 * (tail[1] + tip[1]) + 1.0, text, ha="center", va="bottom",
        fontsize=TEXT.legend, color=COLORS.ink,
    )  # fmt: skip


def _latency(links: Sequence[dict[str, dict[str, Any]]], name: str) -> str:
    """Return the median and the 99th percentile in words."""
    measured = [each[name] for each in links if each[name]["count"]]
    if not measured:
        return "not measured"
    median = float(np.median([each["median_us"] for each in measured])) / 1000.0
    high = max(each["p99_us"] for each in measured) / 1000.0
    return f"median {median:.2f} ms, 99 % within {high:.1f} ms"


def _answer(links: Sequence[dict[str, dict[str, Any]]]) -> str:
    late = sum(each["commands"]["late"] for each in links)
    total = sum(each["commands"]["cycles"] for each in links)
    return f"{_latency(links, 'command')}\n{late} of {total} commands late"

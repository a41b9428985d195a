"""Studies: how often the ego collides, over latency and loss of the messages."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.plot.style import EGO, new_figure
from cca_core.sim.scenarios.scenario import EGO_TYPES
from cca_core.sim.study.statistics import StudyTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["plot_study"]

_LINES = {
    "v2v": ("with V2V", EGO, "o-"), "driver": ("driver without V2V", "#D55E00", "s--"),
    "sensor": ("sensor without V2V", "#56606B", "^:"),
}  # fmt: skip
_AXES = {"latency": "latency [s]", "loss": "share of messages lost [-]"}
_APART = 0.01  # shift between the lines, as a share of the axis [-]


def plot_study(
    tables: Sequence[StudyTable], *, bins: int = 5, egos: Sequence[str] = EGO_TYPES, log: bool = False
) -> "Figure":
    """Draw the share of runs that end in a contact over the latency and the loss of messages.

    Parameters
    ----------
    tables : sequence of StudyTable
        A row of the figure for each, all their runs: whether or not a contact was avoidable, which the
        messages decide as well.
    bins : int
        Into how many classes of equal width the runs are divided [-].
    egos : sequence of {"v2v", "driver", "sensor"}
        Whose lines are drawn.
    log : bool
        Whether the share is drawn on a scale that shows small ones: linear up to 1 %, then logarithmic.

    Returns
    -------
    figure : Figure
        Shares with their intervals at 95 %; the runs of the three egos are the same.

    Raises
    ------
    InputError
        If there is no table or one is empty, `bins` is below 1, or nobody of that name drove.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not tables or not all(len(table) for table in tables):
        raise InputError("tables must not be empty")
    if bins < 1:
        raise InputError(f"bins must be at least 1, was {bins}")
    if any(ego not in EGO_TYPES for ego in egos):
        raise InputError(f"egos must be of {', '.join(EGO_TYPES)}, were {', '.join(egos)}")
    ticker = require_extra("matplotlib.ticker", "plot")
    figure = new_figure(2.6 * len(tables) + 0.6)
    for table, row in zip(tables, figure.subplots(len(tables), 2, squeeze=False, sharey="row"), strict=True):
        for (name, label), axis in zip(_AXES.items(), row, strict=True):
            _draw(axis, table, table.column(name), bins, egos)
            axis.set_xlabel(label)
            axis.set_yscale(*(("symlog",) if log else ("linear",)), **({"linthresh": 0.01} if log else {}))
            axis.set_ylim(0.0 if log else -0.02, 1.3 if log else 1.02)
            axis.yaxis.set_major_formatter(ticker.PercentFormatter(1.0, decimals=0))
            axis.grid(alpha=0.3)
        row[0].set_ylabel(f"{table.scenario}:\nruns with a contact")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def _draw(axis: Any, table: StudyTable, x: Array, bins: int, egos: Sequence[str]) -> None:
    edges = np.linspace(x.min(), max(x.max(), x.min() + 1e-6), bins + 1)
    middle, span = 0.5 * (edges[1:] + edges[:-1]), edges[-1] - edges[0]
    of = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, bins - 1)
    for i, ego in enumerate(egos):
        rates = [table.rate(ego, of == k) for k in range(bins)]
        value = np.array([rate.value if rate.n else np.nan for rate in rates])
        below = value - np.array([rate.ci_low for rate in rates])
        above = np.array([rate.ci_high for rate in rates]) - value
        label, color, style = _LINES[ego]
        axis.errorbar(
            middle + _APART * (i - 1) * span, value, np.clip((below, above), 0.0, None), fmt=style,
            color=color, label=label, capsize=3, markersize=4, linewidth=1.1,
        )  # fmt: skip

"""Studies: how often the ego collides, over latency and loss of the messages, or over other samples."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array, check_bool
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.plot.labels import NAMES
from cca_core.plot.style import COLUMN_WIDTH, EGO_TYPE_STYLES, TEXT, new_figure, set_text_sizes
from cca_core.sim import EGO_TYPES, StudyTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LABELS = {"latency": "latency [s]", "loss": "messages lost [-]"}
_RESULTS = "t_hazard", "avoiding_action"  # columns behind the samples
_MAX_PANELS = 2  # of a study


def plot_study(
    tables: Sequence[StudyTable], *, bins: int = 5, egos: Sequence[str] = EGO_TYPES, log: bool = False
) -> "Figure":
    """Draw the fraction of runs that end in a collision over the latency and the loss of messages.

    Where one of them is the same in all runs, the next sampled number that varies takes its place.

    Parameters
    ----------
    tables : sequence of StudyTable
        A row of the figure for each. All runs count, whether or not the collision was avoidable: messages
        decide that as well.
    bins : int
        Number of classes of equal width [-].
    egos : sequence of {"v2v", "driver", "sensor"}
        Ego types to draw.
    log : bool
        Whether the scale is linear up to 1 % and logarithmic above.

    Returns
    -------
    figure : Figure
        Rates with their confidence intervals at 95 %; the runs of the ego types are the same.

    Raises
    ------
    InputError
        If there is no table or one is empty, `bins` is below 1, or an ego type is unknown.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not tables or not all(len(table) for table in tables):
        raise InputError("tables must not be empty")
    check_bool("log", log)
    if bins < 1:
        raise InputError(f"bins must be at least 1, was {bins}")
    if any(ego not in EGO_TYPES for ego in egos):
        raise InputError(f"egos must be in {', '.join(EGO_TYPES)}, were {', '.join(egos)}")
    ticker = require_extra("matplotlib.ticker", "plot")
    names = [_varied(table) for table in tables]
    figure = new_figure(2.3 * len(tables) + 0.5, COLUMN_WIDTH)
    axes = figure.subplots(len(tables), max(map(len, names)), squeeze=False, sharey="row")
    for table, shown, row in zip(tables, names, axes, strict=True):
        for axis in row[len(shown) :]:
            axis.set_axis_off()
        for name, axis in zip(shown, row, strict=False):
            _draw(axis, table, table.column(name), bins, egos)
            axis.set_xlabel(_LABELS.get(name, name))
            axis.set_yscale(*(("symlog",) if log else ("linear",)), **({"linthresh": 0.01} if log else {}))
            axis.set_ylim(0.0 if log else -0.02, 1.3 if log else 1.02)
            axis.yaxis.set_major_formatter(ticker.PercentFormatter(1.0, decimals=0))
            axis.grid(alpha=0.3)
        row[0].set_ylabel("runs with a collision")
        row[0].set_title(NAMES.get(table.scenario, table.scenario), loc="left", fontsize=TEXT.heading)
    figure.legend(
        *figure.axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=3, frameon=False,
        fontsize=TEXT.legend, handlelength=1.8, columnspacing=1.0,
    )  # fmt: skip
    set_text_sizes(figure)
    return figure


def _varied(table: StudyTable) -> list[str]:
    """Names of up to two samples that vary; the index of the run if there is none."""
    names = list(table.names)
    last = min((names.index(name) for name in _RESULTS if name in names), default=len(names))
    samples = [name for name in names[:last] if name not in ("index", "seed", *_LABELS)]
    found = [name for name in (*_LABELS, *samples) if name in names and _varies(table.column(name))]
    return found[:_MAX_PANELS] or ["index"]


def _varies(values: Array) -> bool:
    return values.dtype.kind in "fi" and bool(np.isfinite(values).all()) and bool(np.ptp(values) > 0.0)


def _draw(axis: Any, table: StudyTable, x: Array, bins: int, egos: Sequence[str]) -> None:
    edges = np.linspace(x.min(), max(x.max(), x.min() + 1e-6), bins + 1)
    middle, span = 0.5 * (edges[1:] + edges[:-1]), edges[-1] - edges[0]
    of = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, bins - 1)
    for i, ego in enumerate(egos):
        rates = [table.rate(ego, of == k) for k in range(bins)]
        value = np.array([rate.value if rate.n else np.nan for rate in rates])
        below = value - np.array([rate.ci_low for rate in rates])
        above = np.array([rate.ci_high for rate in rates]) - value
        color, line, marker = EGO_TYPE_STYLES[ego]
        axis.errorbar(
            middle + 0.01 * (i - 1) * span, value, np.clip((below, above), 0.0, None), fmt=line + marker,
            color=color, label=NAMES[ego], capsize=3, markersize=4, linewidth=1.1,
        )  # fmt: skip

"""Studies: how often the ego collides, over latency and loss of the messages, or over other samples."""

from collections.abc import Mapping, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array, check_bool, shown, unknown
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.plot.labels import NAMES, escape_figure_text, fill_text, sanitize_text
from cca_core.plot.legends import figure_legend
from cca_core.plot.style import COLUMN_WIDTH, EGO_TYPE_STYLES, TEXT, new_figure, set_text_sizes
from cca_core.sim import EGO_TYPES, StudyTable
from cca_core.sim.study.sampling import STUDY_SCENARIOS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LABELS = {
    "latency": "latency [s]", "loss": "messages lost [-]", "friction": "friction [-]",
    "mass": "mass, of the assumed one [-]", "jitter": "jitter of the latency [s]",
    "mean_burst_length": "mean burst of losses [-]", "radio_range": "radio range [m]",
    "reaction_time": "reaction time of others [s]", "ego_reaction_time": "reaction time of the driver [s]",
    "position_noise": "position noise [m]", "index": "number of the run [-]",
}  # fmt: skip
"""Labels of the samples of all studies."""

_UNITS = {
    "v_x": "m/s", "v_red": "m/s", "gap": "s", "second_gap": "s", "braking": "m/s²", "offset": "s",
    "truck_length": "m", "lane_intrusion": "m", "radius": "m", "curvature": "1/m", "slow_fraction": "-",
}  # fmt: skip
"""Units of further samples of the scenarios of the library."""

_FIRST = "latency", "loss"  # shown of these
_RESULTS = "t_hazard", "avoiding_action"  # columns behind the samples
_MAX_PANELS = 2  # of a study, and in a row


def plot_study(
    tables: Sequence[StudyTable],
    *,
    parameters: Sequence[str] | Mapping[str, str] = (),
    bins: int = 5,
    egos: Sequence[str] = EGO_TYPES,
    log: bool = False,
) -> "Figure":
    """Draw the fraction of runs that end in a collision over two sampled parameters, or over chosen ones.

    In a scenario of the library these are the latency and the loss of messages. In a scenario of one's own
    its own samples come first, in their order. Where one of them is the same in all runs, the next sampled
    number that varies takes its place, but no length of bursts if no message is lost.

    Parameters
    ----------
    tables : sequence of StudyTable
        A row of the figure for each. All runs count, whether or not the collision was avoidable: messages
        decide that as well.
    parameters : sequence of str, or mapping of str to str, optional
        Columns of numbers to draw over, a panel for each; a mapping gives the labels of the axes, such as
        ``{"gap": "time gap [s]"}``. The default is described above.
    bins : int
        Number of classes of equal width [-].
    egos : sequence of {"v2v", "driver", "sensor"}
        Ego types to draw.
    log : bool
        Whether the scale is linear up to 1 % and logarithmic above.

    Returns
    -------
    figure : Figure
        Rates [-] with their confidence intervals at 95 %; the runs of the ego types are the same. Two panels
        are in a row; the unit of one's own sample is only known from `parameters`.

    Raises
    ------
    InputError
        If there is no table or one is empty, `bins` is below 1, an ego type is unknown, or one of
        `parameters` is given twice or is no column of numbers in all runs of each table.
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
    _check_parameters(parameters, tables)
    names = [list(parameters) or _varied(table) for table in tables]
    width = min(_MAX_PANELS, max(map(len, names)))
    heights = [-(-len(each) // width) for each in names]
    figure = new_figure(2.3 * sum(heights) + 0.5, COLUMN_WIDTH)
    axes = iter(figure.subplots(sum(heights), width, squeeze=False, sharey="row"))
    for table, chosen, height in zip(tables, names, heights, strict=True):
        rows = [next(axes) for _ in range(height)]
        for name, axis in zip_longest(chosen, [axis for row in rows for axis in row]):
            if name is None:
                axis.set_axis_off()
                continue
            _draw(axis, table, table.column(name), bins, egos)
            axis.set_xlabel(fill_text(_label(name, table, parameters), 26 if width > 1 else 60))
            axis.set_yscale(*(("symlog",) if log else ("linear",)), **({"linthresh": 0.01} if log else {}))
            axis.set_ylim(0.0 if log else -0.02, 1.3 if log else 1.02)
            axis.yaxis.set_major_formatter(ticker.PercentFormatter(1.0, decimals=0))
            axis.grid(alpha=0.3)
        for row in rows:
            row[0].set_ylabel("runs with a collision")
        rows[0][0].set_title(fill_text(_title(table), 54), loc="left", fontsize=TEXT.heading)
    handles = figure.axes[0].get_legend_handles_labels()[0]
    figure_legend(figure, handles, loc="outside upper left", ncols=3)
    set_text_sizes(figure)
    return escape_figure_text(figure)


def _check_parameters(parameters: object, tables: Sequence[StudyTable]) -> None:
    """Raise unless the parameters are columns of numbers, and their labels texts."""
    if isinstance(parameters, str) or not isinstance(parameters, Sequence | Mapping):
        raise InputError(f"parameters must be a sequence or a mapping, was {shown(parameters)}")
    names: list[object] = list(parameters)
    labels = list(parameters.values()) if isinstance(parameters, Mapping) else []
    if not all(isinstance(each, str) for each in [*names, *labels]) or len(set(names)) < len(names):
        raise InputError(f"parameters must be texts, each given once, were {shown(parameters)}")
    for table in tables:
        for name in map(str, names):
            if name not in table.names:
                raise InputError(
                    f"parameters must be columns of each table, {name!r} is none; "
                    f"{unknown(name, table.names)}"
                )
            if not _is_numeric(table.column(name)):
                raise InputError(f"parameters must be columns of numbers in all runs, {name} has not")


def _label(name: str, table: StudyTable, parameters: Sequence[str] | Mapping[str, str]) -> str:
    """Label of a sample, with its unit if that is known."""
    if isinstance(parameters, Mapping) and name in parameters:
        return parameters[name]
    if name not in _LABELS and table.scenario in STUDY_SCENARIOS:
        unit = "m" if name.startswith("shift_") else _UNITS.get(name, "")
        return f"{name} [{unit}]" if unit else name
    return _LABELS.get(name, name)


def _title(table: StudyTable) -> str:
    """Name of the scenario, and the number of its runs."""
    own = f"Scenario {sanitize_text(table.scenario).replace('_', ' ')}"
    return f"{NAMES.get(table.scenario, own)}, {len(table)} {'run' if len(table) == 1 else 'runs'}"


def _varied(table: StudyTable) -> list[str]:
    """Names of up to two samples that vary; the index of the run if there is none."""
    names = list(table.names)
    last = min((names.index(name) for name in _RESULTS if name in names), default=len(names))
    own = [name for name in names[:last] if name not in ("seed", *_LABELS)]
    usual = [name for name in names[:last] if name in _LABELS and name not in ("index", *_FIRST)]
    if "loss" in names and not table.column("loss").any():
        usual = [name for name in usual if name != "mean_burst_length"]
    first = [name for name in _FIRST if name in names]
    order = first + usual + own if table.scenario in STUDY_SCENARIOS else own + first + usual
    found = [name for name in order if _is_numeric(table.column(name)) and np.ptp(table.column(name)) > 0.0]
    return found[:_MAX_PANELS] or ["index"]


def _is_numeric(values: Array) -> bool:
    return values.dtype.kind in "fi" and bool(np.isfinite(values).all())


def _draw(axis: Any, table: StudyTable, x: Array, bins: int, egos: Sequence[str]) -> None:
    half = 0.05 * max(1.0, float(np.abs(x).max())) if np.ptp(x) == 0.0 else 0.0  # around a fixed value
    edges = np.linspace(x.min() - half, x.max() + half, bins + 1)
    if half > 0.0:
        axis.set_xlim(edges[0], edges[-1])
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

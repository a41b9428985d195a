"""Legends in as many columns as fit; a text that depends on data is broken instead of cut off."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cca_core._optional import require_extra
from cca_core.plot.labels import fill_text, sanitize_text
from cca_core.plot.style import TEXT

_AXIS_LEFT = 60.0  # from the left edge of a figure to its axes [pt]
_EDGE = 8.0  # free at the right edge [pt]
_LINE = 1.45 * TEXT.legend  # height of a line [pt]
_MAX_LINES = 3  # of a text
_HANDLE, _HANDLE_GAP, _COLUMN_GAP = 1.7, 0.5, 1.2  # lengths in sizes of the text [-]


def color_legend(figure: Any, colors: Mapping[str, str], *, loc: str = "outside lower center") -> None:
    """Add a legend of colors outside of the axes."""
    figure_legend(figure, color_patches(colors), loc=loc, ncols=4, handlelength=1.0)


def color_patches(colors: Mapping[str, str]) -> list[Any]:
    """Make the handles of a legend of colors."""
    patch = require_extra("matplotlib.patches", "plot").Patch
    return [patch(facecolor=color, label=name) for name, color in colors.items()]


def figure_legend(figure: Any, handles: Sequence[Any], *, loc: str, ncols: int, **options: Any) -> None:
    """Add a legend in at most some columns outside of the axes; the figure grows with its lines."""
    texts, fitting, lines = fit_texts(handles, 72.0 * figure.get_figwidth() - 2.0 * _EDGE, ncols)
    usual = -(-len(texts) // min(ncols, max(len(texts), 1)))
    figure.set_figheight(figure.get_figheight() + _LINE / 72.0 * max(lines - usual, 0))
    figure.legend(
        handles, texts, loc=loc, ncols=fitting, frameon=False, fontsize=TEXT.legend,
        **{"handlelength": _HANDLE, "handletextpad": _HANDLE_GAP, "columnspacing": _COLUMN_GAP, **options},
    )  # fmt: skip


def legend_above(axis: Any, *, ncols: int = 2, handles: Sequence[Any] | None = None) -> None:
    """Put the legend between the title, which is given before, and the view: it covers no curve."""
    handles = axis.get_legend_handles_labels()[0] if handles is None else handles
    figure = axis.figure
    texts, fitting, lines = fit_texts(handles, 72.0 * figure.get_figwidth() - _AXIS_LEFT - _EDGE, ncols)
    figure.set_figheight(figure.get_figheight() + _LINE / 72.0 * max(lines + len(texts) // -ncols, 0))
    axis.legend(
        handles, texts, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=fitting, frameon=False,
        fontsize=TEXT.legend, handlelength=_HANDLE, handletextpad=_HANDLE_GAP, columnspacing=_COLUMN_GAP,
        labelspacing=0.25, borderaxespad=0.2, borderpad=0.1,
    )  # fmt: skip
    title = axis.get_title(loc="left")
    axis.set_title(title, loc="left", fontsize=TEXT.heading, pad=5.0 + _LINE * lines)


def fit_texts(handles: Sequence[Any], width: float, ncols: int) -> tuple[list[str], int, int]:
    """Return the texts of a legend as wide as `width` [pt], its columns, at most `ncols`, and its lines."""
    handle_width = (_HANDLE + _HANDLE_GAP + _COLUMN_GAP) * TEXT.legend
    texts = [_broken(sanitize_text(handle.get_label()), width - handle_width) for handle in handles]
    widths = [max(map(_text_width, text.split("\n"))) + handle_width for text in texts]
    for n in range(min(ncols, len(texts)), 0, -1):
        columns = np.array_split(np.arange(len(texts)), n)
        if n == 1 or sum(max(widths[i] for i in column) for column in columns) <= width:
            return texts, n, max(sum(texts[i].count("\n") + 1 for i in column) for column in columns)
    return texts, 1, 0


def _broken(text: str, width: float) -> str:
    """Return a text on as many lines as it takes, at most some."""
    needed = _text_width(text)
    if needed <= width:
        return text
    characters = max(int(0.9 * len(text) * width / needed), 8)
    lines = fill_text(text, characters).split("\n")
    if len(lines) <= _MAX_LINES:
        return "\n".join(lines)
    return "\n".join([*lines[: _MAX_LINES - 1], f"{lines[_MAX_LINES - 1][:-1]}\N{HORIZONTAL ELLIPSIS}"])


def _text_width(text: str) -> float:
    """Width of a text on one line [pt]."""
    font = require_extra("matplotlib.font_manager", "plot").FontProperties(size=TEXT.legend)
    to_path = require_extra("matplotlib.textpath", "plot").TextToPath()
    return float(to_path.get_text_width_height_descent(text, font, ismath=False)[0])

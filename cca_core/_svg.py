"""Drawings to scale as SVG text, for notebooks; no plotting package is needed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from cca_core._checks import Array

EGO, OTHER, ROUTE, EDGE, FAILED = "#0072B2", "#D55E00", "#777777", "#333333", "#CC79A7"
SAMPLES = 400
"""Intervals into which a curve is divided to be drawn."""

_WIDTH, _TALLEST, _MARGIN, _FOOT = 640.0, 360.0, 16.0, 40.0  # [px]
_BAR = 120.0  # longest scale bar [px]
_ARROW = np.array([[5.0, 0.0], [-5.0, 4.5], [-5.0, -4.5]])  # [px]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mark:
    """One thing in a drawing.

    Parameters
    ----------
    xy : ndarray, shape (n, 2)
        Its points [m]; without any it is not drawn.
    color : str
        As in CSS.
    kind : {"line", "dashes", "swath", "area", "dots", "arrow"}
        A swath is a translucent line as wide as `width`, an area is closed and filled, an arrow is a head at
        the last point.
    width : float
        Of a line [px]; of a swath [m].
    """

    xy: Array
    color: str
    kind: str = "line"
    width: float = 1.5


def drawing(marks: Sequence[Mark], caption: str) -> str:
    """Draw marks from above, x to the right and y up, with a scale bar.

    Parameters
    ----------
    marks : sequence of Mark
        What to draw, the hindmost first.
    caption : str
        Line of text below.

    Returns
    -------
    svg : str
        One ``svg`` element that needs nothing else.
    """
    marks = [mark for mark in marks if len(mark.xy)]
    points = np.concatenate([mark.xy for mark in marks])
    wide = max((mark.width for mark in marks if mark.kind == "swath"), default=0.0)
    low, high = points.min(axis=0) - 0.5 * wide, points.max(axis=0) + 0.5 * wide
    extent = np.maximum(high - low, 1.0)
    inner = _WIDTH - 2.0 * _MARGIN
    scale = float(min(inner / extent[0], _TALLEST / extent[1]))
    height = max(float(extent[1]) * scale, 24.0) + 2.0 * _MARGIN + _FOOT
    center, middle = 0.5 * (low + high), np.array((0.5 * _WIDTH, 0.5 * (height - _FOOT)))
    shapes = [_shape(mark, (mark.xy - center) * (scale, -scale) + middle, scale) for mark in marks]
    text = escape(caption)
    return "\n".join(
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH:g}" height="{height:.0f}" '
            f'viewBox="0 0 {_WIDTH:g} {height:.0f}" role="img" font-family="sans-serif" font-size="11">',
            f"<title>{text}</title>",
            '<rect width="100%" height="100%" fill="#FFFFFF"/>',
            *shapes,
            _scale_bar(scale, height - _FOOT + 8.0),
            f'<text x="{_MARGIN:g}" y="{height - 8.0:.0f}" fill="#333333">{text}</text>',
            "</svg>",
        )
    )


def _shape(mark: Mark, at: Array, scale: float) -> str:
    """Element for a mark whose points lie `at` pixels."""
    if mark.kind == "dots":
        dots = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in at.tolist())
        return f'<path d="{dots}" stroke="{mark.color}" stroke-width="4" stroke-linecap="round"/>'
    if mark.kind == "arrow":
        along = at[-1] - at[-2]
        cos, sin = along / max(float(np.hypot(*along)), 1e-9)
        at = at[-1] + _ARROW @ np.array([[cos, sin], [-sin, cos]])
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in at.tolist())
    if mark.kind in ("area", "arrow"):
        return f'<path d="{path}Z" fill="{mark.color}"/>'
    look = ""
    width = mark.width
    if mark.kind == "dashes":
        look = ' stroke-dasharray="6 4"'
    elif mark.kind == "swath":
        look, width = ' stroke-opacity="0.25"', mark.width * scale
    return (
        f'<path d="{path}" fill="none" stroke="{mark.color}" stroke-width="{width:.2f}" '
        f'stroke-linejoin="round"{look}/>'
    )


def _scale_bar(scale: float, y: float) -> str:
    """Bar of 1, 2 or 5 times a power of ten meters, with its length."""
    power = 10.0 ** math.floor(math.log10(_BAR / scale))
    length = next(step * power for step in (5.0, 2.0, 1.0) if step * power * scale <= _BAR)
    name = f"{length / 1e3:g} km" if length >= 1e3 else f"{length:g} m"
    end = _MARGIN + length * scale
    return (
        f'<path d="M{_MARGIN:g} {y - 4:.0f}v4H{end:.1f}v-4" fill="none" stroke="#333333"/>'
        f'<text x="{end + 6:.1f}" y="{y:.0f}" fill="#333333">{name}</text>'
    )

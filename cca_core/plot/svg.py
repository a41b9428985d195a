"""Bands, paths and roads as SVG text, to scale, for notebooks; matplotlib is not needed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import singledispatch
from html import escape
from textwrap import wrap

import numpy as np

from cca_core._checks import Array, Complex
from cca_core.band import Band
from cca_core.band.solver import measure
from cca_core.errors import InputError
from cca_core.geometry import boxes
from cca_core.path import Path, Road
from cca_core.plot.lane_lines import lane_line, road_lines
from cca_core.plot.style import COLORS


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """Lengths of a drawing [px]."""

    width: float = 520.0  # on a phone it is scaled to 370 px, where a text of 12 is legible
    max_height: float = 320.0
    margin: float = 16.0
    footer: float = 25.0  # without its lines of text
    line: float = 15.0
    characters: int = 76  # of a line of text [-]
    max_scale_bar: float = 120.0
    n_samples: int = 400
    """Intervals into which a curve is divided [-]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mark:
    """One thing in a drawing: points [m], color, and kind."""

    # a swath is a translucent line `width` meters wide, an area is closed and filled, an arrow is a head at
    # the last point; other widths are in pixels
    xy: Array
    color: str
    kind: str = "line"
    width: float = 1.5


_SHEET = Sheet()


@singledispatch
def to_svg(item: Band | Path | Road) -> str:
    """Draw a band, a path or a road to scale, as Jupyter shows it.

    Parameters
    ----------
    item : Band, Path or Road
        A single band is drawn with its route, its edges and its obstacles, each at the time at which the
        ego is closest to it. An infeasible band has another color.

    Returns
    -------
    svg : str
        One ``svg`` element, x to the right and y up, with a scale bar; it needs no other file.

    Raises
    ------
    InputError
        If `item` is something else or a batch of bands.
    """
    raise InputError(f"item must be a Band, Path or Road, was {type(item).__name__}")


@to_svg.register
def _(item: Path) -> str:
    xy = item.position(np.linspace(item.start, item.end, _SHEET.n_samples + 1))
    return _drawing([Mark(xy=xy, color=COLORS.ego, kind=kind) for kind in ("line", "arrow")], repr(item))


def draw_fit(path: Path, xy: Array) -> str:
    """Draw a path over the waypoints that it was fitted to, shape (n, 2), and mark the largest error."""
    marks = [Mark(xy=xy, color=COLORS.ink, kind="dots")]
    curve = path.position(np.linspace(path.start, path.end, _SHEET.n_samples + 1))
    marks += [Mark(xy=curve, color=COLORS.ego, kind=kind) for kind in ("line", "arrow")]
    caption, report = f"{path!r}; {len(xy)} waypoints", path.fit_report
    if report is not None:
        worst = path.position(np.array([report.s_max_deviation]))
        marks.append(Mark(xy=worst, color=COLORS.second, kind="dots"))
        caption += ", the largest error in orange"
    return _drawing(marks, caption)


@to_svg.register
def _(item: Road) -> str:
    path = item.path
    s = np.linspace(path.start, path.end, _SHEET.n_samples + 1)
    marks, edges, between = [], *road_lines(item, s)
    for lane in item.lanes:
        right, left = (lane_line(lane, s, side) for side in (0, 1))
        if len(right.s) > 1:
            center = path.to_cartesian(right.s, 0.5 * (right.d + left.d))
            narrowest = float((left.d - right.d).min()) if lane.boundaries else lane.width
            marks.append(Mark(xy=center, color=COLORS.route, kind="swath", width=narrowest))
            marks.append(Mark(xy=center[:: lane.direction], color=COLORS.route, kind="arrow"))
    lines = sorted((*edges, *between), key=lambda line: float(line.d[0]))
    marks += [Mark(xy=path.to_cartesian(*line), color=COLORS.ink, width=0.8) for line in lines]
    route = path.position(s)
    marks += [Mark(xy=route, color=COLORS.ego, kind=kind) for kind in ("dashes", "arrow")]
    return _drawing(marks, repr(item))


@to_svg.register
def _(item: Band) -> str:
    if item.nodes.ndim != 2:
        raise InputError("item must be a single band; index the batch first")
    return _drawing(_band_marks(item), repr(item) if item.ok else f"{item.status.name}: {item.message}")


def _band_marks(band: Band) -> list[Mark]:
    """Route, edges, obstacles, and the band as wide as the ego."""
    problem, route = band.problem, band.problem.nodes[0]
    width = problem.vehicle.width
    marks = [Mark(xy=route, color=COLORS.route, kind="dashes", width=1.0)]
    if problem.edges is not None:
        tangents = measure(problem).tangents
        left = np.stack((-tangents[:, 1], tangents[:, 0]), axis=-1)
        for edge in problem.edges[:, 0]:
            marks.append(Mark(xy=route + edge[:, None] * left, color=COLORS.ink))
    for x, y, psi, length, wide in problem.boxes[:, :, 0].swapaxes(0, 1):
        k = int(np.hypot(x - band.nodes[:, 0], y - band.nodes[:, 1]).argmin())
        box = boxes(x[k], y[k], psi[k], length[k], wide[k])
        marks.append(Mark(xy=box.corners(), color=COLORS.second, kind="area"))
    color = COLORS.ego if band.ok else COLORS.failed
    marks.append(Mark(xy=band.nodes, color=color, kind="swath", width=width))
    return [*marks, *(Mark(xy=band.nodes, color=color, kind=kind) for kind in ("dots", "arrow"))]


def _rows(z: Complex) -> Array:
    """Points x + iy as rows, shape (n, 2)."""
    return np.stack((z.real, z.imag), axis=-1)


def _drawing(marks: Sequence[Mark], caption: str) -> str:
    """SVG of marks, the hindmost first, with a scale bar and a line of text."""
    marks = [mark for mark in marks if len(mark.xy)]
    points = np.concatenate([mark.xy for mark in marks])
    wide = max((mark.width for mark in marks if mark.kind == "swath"), default=0.0)
    low, high = points.min(axis=0) - 0.5 * wide, points.max(axis=0) + 0.5 * wide
    extent = np.maximum(high - low, 1.0)
    lines = wrap(caption, _SHEET.characters) or [""]
    width, margin, footer = _SHEET.width, _SHEET.margin, _SHEET.footer + _SHEET.line * len(lines)
    scale = float(min((width - 2.0 * margin) / extent[0], _SHEET.max_height / extent[1]))
    height = max(float(extent[1]) * scale, 24.0) + 2.0 * margin + footer
    center, middle = 0.5 * (low + high), np.array((0.5 * width, 0.5 * (height - footer)))
    shapes = [_shape(mark, (mark.xy - center) * (scale, -scale) + middle, scale) for mark in marks]
    first = height - 8.0 - _SHEET.line * (len(lines) - 1)
    texts = [
        f'<text x="{margin:g}" y="{first + _SHEET.line * i:.0f}" fill="{COLORS.ink}">{escape(line)}</text>'
        for i, line in enumerate(lines)
    ]
    return "\n".join(
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{height:.0f}" '
            f'viewBox="0 0 {width:g} {height:.0f}" role="img" font-family="sans-serif" font-size="12">',
            f"<title>{escape(caption)}</title>",
            '<rect width="100%" height="100%" fill="#FFFFFF"/>',
            *shapes,
            _scale_bar(scale, height - footer + 8.0),
            *texts,
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
        head = np.array([[5.0, 0.0], [-5.0, 4.5], [-5.0, -4.5]])  # [px]
        at = at[-1] + head @ np.array([[cos, sin], [-sin, cos]])
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in at.tolist())
    if mark.kind in ("area", "arrow"):
        return f'<path d="{path}Z" fill="{mark.color}"/>'
    extra, width = "", mark.width
    if mark.kind == "dashes":
        extra = ' stroke-dasharray="6 4"'
    elif mark.kind == "swath":
        extra, width = ' stroke-opacity="0.25"', mark.width * scale
    return (
        f'<path d="{path}" fill="none" stroke="{mark.color}" stroke-width="{width:.2f}" '
        f'stroke-linejoin="round"{extra}/>'
    )


def _scale_bar(scale: float, y: float) -> str:
    """Bar of 1, 2 or 5 times a power of ten meters, with its length."""
    longest = _SHEET.max_scale_bar / scale
    power = 10.0 ** math.floor(math.log10(longest))
    length = next(step * power for step in (5.0, 2.0, 1.0) if step * power <= longest)
    name = f"{length / 1e3:g} km" if length >= 1e3 else f"{length:g} m"
    end = _SHEET.margin + length * scale
    return (
        f'<path d="M{_SHEET.margin:g} {y - 4:.0f}v4H{end:.1f}v-4" fill="none" stroke="{COLORS.ink}"/>'
        f'<text x="{end + 6:.1f}" y="{y:.0f}" fill="{COLORS.ink}">{name}</text>'
    )

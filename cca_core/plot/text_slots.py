"""Texts in an axis that overlap neither bodies nor each other nor its border."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core._optional import require_extra
from cca_core.plot.labels import escape_figure_text, sanitize_text
from cca_core.plot.style import TEXT, darken

Offset = tuple[float, float, str, str]
"""Offset of a text from its point [pt], and its horizontal and vertical alignment."""


def offsets_around(distance: float = 5.0, *, rows: int = 4, step: float = 11.0) -> list[Offset]:
    """Offsets above and below, then to the right and to the left, then farther above and below."""
    found: list[Offset] = []
    for row in range(rows):
        up = distance + step * row
        for dx, side in ((0.0, "center"), (-6.0, "left"), (6.0, "right")):
            found += [(dx, up, side, "bottom"), (dx, -up, side, "top")]
        if row == 0:
            found += [(distance, 0.0, "left", "center"), (-distance, 0.0, "right", "center")]
    return found


class TextSlots:
    """Occupied parts of an axis, from which each text takes another; the layout of the figure is final."""

    def __init__(self, axis: Any, *, padding: float = 1.0, ground: str = "white") -> None:
        self._axis, self._padding, self._ground = axis, padding, ground  # padding around texts [px]
        self._occupied: list[Array] = []  # left, bottom, right, top [px]

    def occupy(self, points: Array) -> None:
        """Keep texts off the box around points of the axis."""
        pixels = self._axis.transData.transform(points)
        # a point or a line takes space, too
        self._occupied.append(np.concatenate((pixels.min(axis=0) - 1.0, pixels.max(axis=0) + 1.0)))

    def write(
        self, text: str, xy: Sequence[float], color: str, offsets: Iterable[Offset], *, must: bool = True,
        **options: Any,
    ) -> Offset | None:  # fmt: skip
        """Write a text at the first offset that is free; without one at the least occupied one if it must be.

        Returns its offset, or None if it was not written.
        """
        ground = {"facecolor": self._ground, "alpha": 0.9, "edgecolor": "none", "pad": 0.3}
        options = {"fontsize": TEXT.legend, "zorder": 6, "bbox": ground} | options
        note = self._axis.annotate(
            "\n".join(map(sanitize_text, text.split("\n"))), xy, (0.0, 0.0), textcoords="offset points",
            color=darken(color), annotation_clip=False, parse_math=False, **options,
        )  # fmt: skip
        found: list[tuple[float, Offset, Array]] = []
        extent = require_extra("matplotlib.text", "plot").Text.get_window_extent
        for dx, dy, ha, va in offsets:
            note.set(position=(dx, dy), ha=ha, va=va)
            note.get_window_extent()  # updates the position; its result has the line in it, too
            box = extent(note)
            extents = np.array([box.x0, box.y0, box.x1, box.y1]) + self._padding * np.array([-1, -1, 1, 1])
            overlap = self._overlap(extents)
            found.append((overlap, (dx, dy, ha, va), extents))
            if overlap <= 0.0:
                break
        overlap, (dx, dy, ha, va), extents = min(found, key=lambda each: each[0])
        if overlap > 0.0 and not must:
            note.remove()
            return None
        note.set(position=(dx, dy), ha=ha, va=va)
        self._occupied.append(extents)
        return dx, dy, ha, va

    def free(
        self, xy: Sequence[float] | Array, offsets: Sequence[tuple[float, float]], radius: float
    ) -> tuple[float, float]:
        """Take the first offset [pt] at which a disk of a radius [pt] is free, or else the least occupied."""
        scale = self._axis.figure.dpi / 72.0
        point = self._axis.transData.transform(xy)
        squares = [
            np.concatenate((middle - radius * scale, middle + radius * scale))
            for middle in (point + scale * np.array(offset) for offset in offsets)
        ]
        overlaps = [self._overlap(square) for square in squares]
        best = overlaps.index(0.0) if 0.0 in overlaps else int(np.argmin(overlaps))
        self._occupied.append(squares[best])
        return offsets[best]

    def _overlap(self, box: Array) -> float:
        """Area of a text that is occupied or outside of the axis [px^2]."""
        frame = self._axis.bbox
        inside = np.minimum(box[2:], (frame.x1, frame.y1)) - np.maximum(box[:2], (frame.x0, frame.y0))
        area = float(np.prod(box[2:] - box[:2]) - np.prod(np.maximum(inside, 0.0)))
        for other in self._occupied:
            both = np.minimum(box[2:], other[2:]) - np.maximum(box[:2], other[:2])
            area += float(np.prod(np.maximum(both, 0.0)))
        return 0.0 if area < 1e-6 else area


def freeze_layout(figure: Any) -> None:
    """Lay a figure out once, so that texts can be measured."""
    escape_figure_text(figure).draw_without_rendering()
    figure.set_layout_engine("none")

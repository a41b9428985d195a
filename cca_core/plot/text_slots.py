"""Texts in a strip of road that overlap neither vehicles nor each other."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.plot.style import COLORS, TEXT


class TextSlots:
    """Occupied parts of a strip, from which each text takes another."""

    def __init__(
        self,
        axis: Any,
        view: tuple[float, float],
        *,
        short: float = 15.0,  # length of an id and a speed [m]
        long: float = 36.0,  # with a distance [m]
        step: float = 2.0,  # between the stations that are tried [m]
    ) -> None:
        self._axis, self._view, self._short, self._long, self._step = axis, view, short, long, step
        self._occupied: list[tuple[float, float, float]] = []  # from, to, lateral [m]

    def occupy(self, box: Array) -> None:
        """Keep texts off a body."""
        self._occupied.append((box[:, 0].min(), box[:, 0].max(), box[:, 1].mean()))

    def write_at_border(self, box: Array, text: str, color: str) -> None:
        """Write the text of a body outside of the view, with its distance."""
        ahead, d = box.mean(axis=0).tolist()
        first, last = self._view
        text += f", {abs(ahead):.0f} m"
        if ahead > 0.0:
            slots = [(x, "right") for x in np.arange(last - 1.0, first + self._long, -self._step).tolist()]
            self._write(slots, d, f"{text} ahead \u25b8", color, self._long)
        else:
            slots = [(x, "left") for x in np.arange(first + 4.0, last - self._long, self._step).tolist()]
            self._write(slots, d, f"\u25c2 {text} behind", color, self._long)

    def write_next_to(self, box: Array, text: str, color: str, *, behind_first: bool) -> None:
        """Write the text of a body ahead of it or behind it."""
        slots = [(box[:, 0].max() + 1.0, "left"), (box[:, 0].min() - 1.0, "right")]
        self._write(slots[::-1] if behind_first else slots, box[:, 1].mean(), text, color, self._short)

    def _write(
        self, slots: Iterable[tuple[float, str]], d: float, text: str, color: str, width: float
    ) -> None:
        for x, align in slots:
            left = x if align == "left" else x - width
            if self._is_free(left, left + width, d):
                break
        self._occupied.append((left, left + width, d))
        self._axis.text(
            x, d, text, color=color, fontsize=TEXT.legend, ha=align, va="center_baseline",
            bbox={"facecolor": COLORS.road, "edgecolor": "none", "pad": 0.5},
        )  # fmt: skip

    def _is_free(self, left: float, right: float, d: float) -> bool:
        inside = self._view[0] <= left and right <= self._view[1]
        return inside and all(right < a or left > b or abs(d - other) > 2.0 for a, b, other in self._occupied)

"""A progress bar that needs no package and appears on a terminal alone."""

import sys
import time
from types import TracebackType
from typing import Self

__all__ = ["ProgressBar"]

_WIDTH = 30  # [characters]
_INTERVAL = 0.1  # between two drawings [s]


class ProgressBar:
    """Share of a long computation that is done, on the standard error, in a ``with`` statement."""

    def __init__(self, label: str, total: float, unit: str) -> None:
        self.done = 0.0
        self._label, self._total, self._unit = label, total, unit
        self._is_shown = sys.stderr.isatty()
        self._t_shown = -_INTERVAL

    def advance(self, done: float) -> None:
        """Show how much is done."""
        self.done = min(done, self._total)
        if not self._is_shown or not self._total:
            return
        now = time.monotonic()
        if now - self._t_shown >= _INTERVAL or done >= self._total:
            self._t_shown = now
            share = self.done / self._total
            bar = ("#" * round(share * _WIDTH)).ljust(_WIDTH)
            sys.stderr.write(f"\r{self._label} {share:4.0%} [{bar}] of {self._total:.0f} {self._unit}")
            sys.stderr.flush()

    def __enter__(self) -> Self:
        self.advance(0.0)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._is_shown:
            sys.stderr.write("\n")

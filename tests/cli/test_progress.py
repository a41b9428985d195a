"""The progress bar."""

import io
import sys

import pytest

from cca_core.cli.progress import ProgressBar


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_bar_on_terminal_ends_full(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with ProgressBar("driving", 20.0, "s") as bar:
        for t in range(21):
            bar.advance(float(t))
    text = terminal.getvalue()
    assert text.endswith("\rdriving 100% [" + "#" * 30 + "] of 20 s\n")
    assert text.startswith("\rdriving   0% [" + " " * 30 + "]")


def test_bar_elsewhere_is_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(sys, "stderr", stream)
    with ProgressBar("driving", 20.0, "s") as bar:
        bar.advance(20.0)
    assert stream.getvalue() == ""


def test_bar_without_total_is_harmless(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    with ProgressBar("driving", 0.0, "s") as bar:
        bar.advance(0.0)

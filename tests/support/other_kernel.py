"""Plugin of pytest: run tests with the compiled kernel in the file that CCA_KERNEL_FILE names."""

import os
import sys
from pathlib import Path

import pytest

from tests.support.load_module import load

if FILE := os.environ.get("CCA_KERNEL_FILE"):  # without it this is no plugin, only a file with doctests
    sys.modules["cca_core.kernel._compiled"] = load(Path(FILE))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print a line that proves which kernel was tested."""
    from cca_core import kernel

    terminalreporter.write_line(f"compiled kernel: {getattr(kernel.COMPILED, '__file__', None)}")

"""Plugin of pytest: run tests with the compiled kernel in the file that CCA_KERNEL_FILE names."""

import os
import sys
from pathlib import Path

import pytest

from tests.support.load_module import load

FILE = Path(os.environ["CCA_KERNEL_FILE"])
sys.modules["cca_core.kernel._compiled"] = load(FILE)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print a line that proves which kernel was tested."""
    from cca_core import kernel

    terminalreporter.write_line(f"compiled kernel: {getattr(kernel.COMPILED, '__file__', None)}")

"""Load a module of Python from its file, without the library."""

import importlib.machinery
import importlib.util
from pathlib import Path
from types import ModuleType


def load(file: Path) -> ModuleType:
    """Load the compiled kernels in a file."""
    loader = importlib.machinery.ExtensionFileLoader("_compiled", str(file))
    spec = importlib.util.spec_from_file_location("_compiled", file, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module

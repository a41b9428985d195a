"""Import of optional packages; their absence becomes a `MissingExtraError`."""

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from cca_core.errors import MissingExtraError


def require_extra(module: str, extra: str) -> ModuleType:
    """Import `module`, or say how to install the extra that brings it.

    Only absence is translated: an error inside the package itself passes through unchanged.
    """
    if find_spec(module.partition(".")[0]) is None:
        raise MissingExtraError(f"{module} is not installed; run: pip install 'cca-planner[{extra}]'")
    return import_module(module)

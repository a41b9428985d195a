"""Import of optional packages; a missing package raises `MissingExtraError`."""

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from cca_core.errors import MissingExtraError


def require_extra(module: str, extra: str | None) -> ModuleType:
    """Import `module`, or raise an error with the pip command of its extra; of itself if that is None."""
    # only absence is translated: an error inside the package passes unchanged
    if find_spec(module.partition(".")[0]) is None:
        wanted = module if extra is None else f"'cca-planner[{extra}]'"
        raise MissingExtraError(f"{module} is not installed; run: pip install {wanted}")
    return import_module(module)

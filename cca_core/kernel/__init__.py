"""What must be fast or must run in the car: restricted Python, and the C made from it.

A *kernel* is a function that the ``__all__`` of a module in this folder lists. `make kernel` translates all
modules here to C (`c/kernel.c`, `c/kernel.h`), writes the module that exports them to Python, and compiles it
in place (`make kernel PY=python`: with the Python on the path). A new file needs no entry anywhere. After a
merge conflict in `c/`, run it again. `tests/support/kernel_forms.py` compares the forms of a kernel.

**The language** is described on the page about the kernel, `docs/kernel.md`; the translator refuses the rest.

**Calls.** A module of the library binds a kernel once and calls it like the function that it is::

    from cca_core.kernel import bind
    from cca_core.kernel.speed import arrival_times

    _arrival_times = bind(arrival_times)
    _arrival_times(len(distance), v_x, v_target, distance, a_max, b_comfort, t)

- Numbers are given by position. Whole numbers are given as int, not as float.
- Arrays are C-contiguous float64 (int32 for `Ints`). Those that are only read may be read-only.
  Their sizes are checked in every call, so a wrong one raises and nothing is written past an end.
- A class of fields is a workspace: ``lent = cca_core.kernel.memory.lend(Curve, segments=12)``. The kernel
  takes ``lent.workspace``, whose numbers are attributes. Its arrays are ``lent.arrays["breaks"]``, written
  and read. One caller has one workspace: a second thread that uses it meanwhile gets an error, except if both
  calls only read it. ``reuse(Curve, segments=12)`` returns the one that the
  thread has given back with ``give_back``.
- Nothing is allocated in a call. Calls that fill arrays or workspaces release the GIL.

**Batches** are kernels that loop from a first to a last index over rows of arrays; `batches.in_chunks` calls
them in threads, each with a workspace of its own.

**Backends.** `CCA_KERNEL=python` or `c` chooses. By default it is C, if it has been compiled from the Python
and the C that are here; `backend()` returns the choice and `backend_reason()` its reason. Both give the same
bits.
"""

import importlib
import math
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from cca_core.kernel.digests import c_digest, digest

__all__ = ["backend", "backend_reason"]

F = TypeVar("F", bound=Callable[..., Any])


def _choose() -> tuple[ModuleType | None, str]:
    """Return the compiled module or None, and the reason of this choice."""
    wish = os.environ.get("CCA_KERNEL", "")
    if wish not in ("", "c", "python"):
        raise ValueError(f"CCA_KERNEL must be c or python, was {wish!r}")
    if wish == "python":
        return None, "CCA_KERNEL is python"
    reason = ""
    try:
        module: ModuleType = importlib.import_module("cca_core.kernel._compiled")
    except ImportError as error:
        reason = f"the kernel is not compiled ({error})"
    else:
        folder = Path(__file__).parent
        if module.digest == digest(folder) and module.c_digest == c_digest(folder / "c"):
            return module, "the kernel is compiled"
        reason = "the kernel has been changed since it was compiled: run `make kernel`"
    if wish == "c":
        raise ImportError(f"CCA_KERNEL is c, but {reason}")
    return None, reason


COMPILED, _REASON = _choose()


def backend() -> str:
    """Return which form of the kernel is in use.

    Returns
    -------
    name : str
        ``"c"`` or ``"python"``.
    """
    return "c" if COMPILED is not None else "python"


def backend_reason() -> str:
    """Return why this form of the kernel is in use.

    Returns
    -------
    reason : str
        One sentence without a period.
    """
    return _REASON


def bind(kernel: F, form: str | None = None) -> F:
    """Return the form of a kernel that is in use, or the given one: "c" or "python"."""
    if (form or backend()) == "c":
        if COMPILED is None:
            raise ValueError(f"form must be python, was c: {_REASON}")
        compiled: F = getattr(COMPILED, kernel.__name__)
        return compiled
    hints = get_type_hints(kernel, include_extras=True)
    hints.pop("return", None)
    python: Any = partial(_call, kernel, tuple(_convert(hint) for hint in hints.values()))
    return python  # type: ignore[no-any-return]


def _call(kernel: Callable[..., Any], converters: tuple[Callable[[Any], Any], ...], *given: Any) -> Any:
    """Call a kernel with plain numbers, and with arrays as memoryviews, which Python reads fastest."""
    return kernel(*[convert(value) for convert, value in zip(converters, given, strict=True)])


def _convert(hint: Any) -> Callable[[Any], Any]:
    """Return what makes an argument one of the kernel's Python."""
    if hint is float:
        return _real
    if hint is bool:
        return bool
    if hint is int:
        return int.__index__
    return memoryview if get_args(hint) and get_origin(hint) is not tuple else lambda given: given


def _real(given: Any) -> float:
    """Return a number as float, as C takes it: unlike `float`, without text."""
    return given if type(given) is float else math.copysign(given, given)

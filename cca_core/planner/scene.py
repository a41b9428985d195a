"""Scene: the memory that the compiled loops of `motion` work on."""

import ctypes
import os
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.planner import motion
from cca_core.planner._kinds import Grid, Ints, Reals

N_ROWS = 72
"""Motions of the ego that a scene holds; the last one is for the braking tail of a check."""

_NUMBERS = {float: ctypes.c_double, int: ctypes.c_int, bool: ctypes.c_int}
_FIELDS = [
    (name, _NUMBERS.get(getattr(kind, "__origin__", kind), ctypes.c_void_p))
    for name, kind in motion.Scene.__annotations__.items()
]
_BASES = {name: getattr(kind, "__origin__", kind) for name, kind in motion.Scene.__annotations__.items()}
_SIZES = {name: getattr(kind, "__metadata__", ()) for name, kind in motion.Scene.__annotations__.items()}


class _Structure(ctypes.Structure):
    _fields_ = _FIELDS


def _library() -> Any:
    """Return the compiled loops, None if there are none."""
    file = os.environ.get("CCA_PLANNER_LIB")
    return ctypes.CDLL(file) if file and os.path.exists(file) else None


_LIBRARY = _library()
_ARGUMENTS = {float: ctypes.c_double, int: ctypes.c_int, bool: ctypes.c_int}


class Scene:
    """Fields of `motion.Scene` as arrays and numbers, and its functions, compiled or not."""

    def __init__(self, **sizes: int) -> None:
        self._lent: Any = motion.Scene()
        self._structure = _Structure()
        self.arrays: dict[str, Array] = {}
        self._sizes = sizes
        self._address = ctypes.c_void_p(ctypes.addressof(self._structure))
        self.set(**sizes)
        for name, base in _BASES.items():
            if base in (Reals, Ints, Grid):
                shape = tuple(sizes[s] if isinstance(s, str) else s for s in _SIZES[name])
                dtype = np.int32 if base is Ints else np.float64
                self.lend(name, np.zeros([max(s, 1) for s in shape], dtype=dtype))
            elif name not in sizes:
                self.set(**{name: base(0)})

    def lend(self, name: str, array: Array) -> None:
        """Let the loops use an array."""
        self.arrays[name] = array
        if _LIBRARY is None:
            setattr(self._lent, name, memoryview(array))
        else:
            setattr(self._structure, name, array.ctypes.data)

    def set(self, **values: float) -> None:
        """Set numbers."""
        target = self._lent if _LIBRARY is None else self._structure
        for name, value in values.items():
            setattr(target, name, value)

    def get(self, name: str) -> Any:
        """Return a number."""
        return getattr(self._lent if _LIBRARY is None else self._structure, name)

    def call(self, name: str, *arguments: float) -> Any:
        """Call a function of `motion`."""
        if _LIBRARY is None:
            return getattr(motion, name)(self._lent, *arguments)
        function = getattr(_LIBRARY, f"cca_{name}")
        return function(self._address, *(_ARGUMENTS[type(a)](a) for a in arguments))

    def __getitem__(self, name: str) -> Array:
        return self.arrays[name]

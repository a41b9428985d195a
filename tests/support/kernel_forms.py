"""A kernel in Python, in C and on strict memory: the same inputs, the same bits.

A test makes a sampler that returns the arguments of one call, random ones from a generator. Arrays are
NumPy's, a workspace is a `Filled`. What is not filled holds other garbage in each case, the same in both
forms, and no kernel may read it: strict memory notices.
"""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Annotated, Any, cast, get_args, get_origin, get_type_hints

import numpy as np
import pytest

from cca_core import kernel
from cca_core.kernel import bind
from cca_core.kernel.memory import Lent, lend, shape_of
from cca_core.kernel.types import Ints

needs_c = pytest.mark.skipif(
    kernel.COMPILED is None, reason=f"no C to compare with: {kernel.backend_reason()}"
)
QUICK, FULL = 200, 100_000
STRICT = 20  # draws that also run on strict memory, which is slow

Sampler = Callable[[np.random.Generator], tuple[Any, ...]]


@dataclass(frozen=True)
class Filled:
    """A workspace before the call: its class, its sizes, its numbers and arrays that are given."""

    owner: type
    sizes: Mapping[str, int]
    values: Mapping[str, Any] = field(default_factory=dict)


def check_forms(function: Callable[..., Any], sampler: Sampler, count: int = QUICK, seed: int = 0) -> None:
    """Compare both forms of a kernel on random inputs: results, arrays and workspaces, bit for bit."""
    forms = {form: bind(function, form) for form in ("python", "c")}
    for k in range(count):
        calls = []
        arguments = sampler(np.random.default_rng((seed, k)))
        for form, call in forms.items():
            given = [prepare(each, form, seed + k) for each in arguments]
            calls.append((call(*(what for what, _ in given)), [state(w, a) for w, a in given]))
        python, compiled = calls
        assert same(python, compiled), f"draw {k} of seed {seed}: {python} in Python, {compiled} in C"
        if k < STRICT:
            result = function(*(strict(each) for each in arguments))
            assert same(result, python[0]), f"draw {k} of seed {seed}: {result} on strict memory"


def prepare(given: Any, form: str, seed: int) -> tuple[Any, dict[str, Any]]:
    """Return an argument for a form, and its arrays."""
    if isinstance(given, np.ndarray):
        copy = given.copy()
        return copy, {"": copy}
    if not isinstance(given, Filled):
        return given, {}
    lent: Lent[Any] = lend(given.owner, form, **given.sizes)
    size = sum(array.size for array in lent.arrays.values())
    garbage = np.random.default_rng(seed).integers(-9, 9, size, dtype=np.int8)  # at once: that is much faster
    end = 0
    for array in lent.arrays.values():
        end += array.size
        array[...] = garbage[end - array.size : end].reshape(array.shape)
    for name, value in given.values.items():
        if name in lent.arrays:
            lent.arrays[name][...] = value
        else:
            setattr(lent.workspace, name, value)
    return lent.workspace, dict(lent.arrays)


def state(argument: Any, arrays: dict[str, Any]) -> dict[str, Any]:
    """Return all that a call may have changed."""
    if not arrays or "" in arrays:
        return arrays
    names = names_of(argument.__class__)
    return {name: arrays[name] if name in arrays else getattr(argument, name) for name in names}


@cache
def names_of(owner: Hashable) -> tuple[str, ...]:
    """Return the fields of a workspace, of its class in Python or of its structure in C."""
    hints = get_type_hints(owner)
    return tuple(hints or (each[0] for each in cast(Any, owner)._fields_[0][1]._fields_))


def same(a: Any, b: Any) -> bool:
    """Return whether two results have the same bits; one NaN is like another."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[name], b[name]) for name in a)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(same, a, b))
    if type(a) is int:
        return bool(a == b)
    a, b = np.atleast_1d(a), np.atleast_1d(b)
    if a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes():
        return True
    if a.dtype == np.float64:
        rest = ~np.isnan(a)
        return np.array_equal(rest, ~np.isnan(b)) and np.array_equal(
            a[rest].view(np.int64), b[rest].view(np.int64)
        )
    return bool(np.array_equal(a, b))


class Strict:
    """Row or grid that refuses indices from the end and elements that nobody has written."""

    def __init__(self, shape: tuple[int, ...], values: Any = None) -> None:
        self.shape, self.memory = shape, {}
        if values is not None:
            self.memory = {at: value.item() for at, value in np.ndenumerate(np.broadcast_to(values, shape))}

    def position(self, at: Any) -> tuple[int, ...]:
        """Return a checked index."""
        position = at if isinstance(at, tuple) else (at,)
        if not all(type(i) is int and 0 <= i < n for i, n in zip(position, self.shape, strict=True)):
            raise IndexError(f"index must be within {self.shape}, was {at}")
        return position

    def __getitem__(self, at: Any) -> Any:
        return self.memory[self.position(at)]

    def __setitem__(self, at: Any, value: Any) -> None:
        self.memory[self.position(at)] = value


def strict(given: Any) -> Any:
    """Return an argument on strict memory."""
    if isinstance(given, np.ndarray):
        return Strict(given.shape, given)
    if not isinstance(given, Filled):
        return given
    workspace = given.owner()
    for name, hint in get_type_hints(given.owner, include_extras=True).items():
        if get_origin(hint) is Annotated:
            base, *shape = get_args(hint)
            sizes = shape_of(tuple(shape), given.sizes)
            values = given.values.get(name)
            dtype = np.int32 if base is Ints else np.float64
            setattr(
                workspace, name, Strict(sizes, None if values is None else np.asarray(values, dtype=dtype))
            )
        elif name in given.sizes or name in given.values:
            setattr(workspace, name, given.sizes.get(name, given.values.get(name)))
    return workspace

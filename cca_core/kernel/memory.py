"""Workspaces that are lent to the kernel: numbers and NumPy arrays that its Python and its C both work on."""

import ast
import ctypes
from dataclasses import dataclass
from typing import Annotated, Any, Generic, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from cca_core import kernel
from cca_core.kernel.types import Ints

T = TypeVar("T")
NUMBERS: dict[Any, Any] = {float: ctypes.c_double, int: ctypes.c_int, bool: ctypes.c_bool}


@dataclass(frozen=True, slots=True)
class Lent(Generic[T]):
    """A workspace and its arrays by the names of their fields."""

    workspace: T
    arrays: dict[str, NDArray[Any]]
    memory: NDArray[np.float64]
    starts: dict[str, int]

    def rows(self, first: str, last: str) -> NDArray[np.float64]:
        """Return the arrays of several fields of one shape, declared one after another, as one array."""
        shape = self.arrays[first].shape
        count, rest = divmod(self.starts[last] - self.starts[first], self.arrays[first].size)
        if rest or count < 0 or self.arrays[last].shape != shape:
            raise ValueError(f"fields from {first} to {last} must have the same shape")
        begin, size = self.starts[first], (count + 1) * self.arrays[first].size
        return self.memory[begin : begin + size].reshape(count + 1, *shape)


def lend(owner: type[T], form: str | None = None, **sizes: int) -> Lent[T]:
    """Make a workspace of a class of fields: zeros, arrays of the sizes in its annotations."""
    numbers, shapes, elements = {}, {}, {}
    for name, hint in get_type_hints(owner, include_extras=True).items():
        if get_origin(hint) is Annotated:
            base, *shape = get_args(hint)
            shapes[name] = tuple(evaluate(size, sizes) for size in shape)
            elements[name] = np.int32 if base is Ints else np.float64
        else:
            numbers[name] = hint
    arrays, memory, starts = allocate(shapes, elements)
    given = {name: sizes.pop(name, kind()) for name, kind in numbers.items()}
    if sizes:
        raise ValueError(f"sizes must be fields of {owner.__name__}, were {', '.join(sizes)}")
    if (form or kernel.backend()) == "c":
        workspace = structure(owner, given, arrays)
    else:
        workspace = owner()
        for name, value in given.items():
            setattr(workspace, name, value)
        for name, array in arrays.items():
            setattr(workspace, name, memoryview(array))  # type: ignore[arg-type]
    return Lent(workspace, arrays, memory, starts)


def allocate(
    shapes: dict[str, tuple[int, ...]], elements: dict[str, Any]
) -> tuple[dict[str, NDArray[Any]], NDArray[np.float64], dict[str, int]]:
    """Allocate arrays: those of reals in one piece, in their order."""
    reals = {name: shape for name, shape in shapes.items() if elements[name] is np.float64}
    memory = np.zeros(sum(int(np.prod(shape)) for shape in reals.values()))
    arrays, starts, end = {}, {}, 0
    for name, shape in shapes.items():
        if name in reals:
            starts[name], begin = end, end
            end += int(np.prod(shape))
            arrays[name] = memory[begin:end].reshape(shape)
        else:
            arrays[name] = np.zeros(shape, dtype=elements[name])
    return arrays, memory, starts


def structure(owner: type[T], numbers: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> T:
    """Make the workspace of a class in C."""
    if kernel.COMPILED is None:
        raise ValueError(f"form must be python, was c: {kernel.backend_reason()}")
    kind, size = kernel.COMPILED.structures[owner.__name__]
    hints = get_type_hints(owner, include_extras=True)
    fields = [(name, NUMBERS.get(hint, ctypes.c_void_p)) for name, hint in hints.items()]
    plain = type("Fields", (ctypes.Structure,), {"_fields_": fields})
    if ctypes.sizeof(plain) != size:
        raise ValueError(f"{owner.__name__} must have {size} bytes, had {ctypes.sizeof(plain)}")
    behind = [("fields", plain), ("kind", ctypes.c_int), ("users", ctypes.c_int)]
    made: Any = type(owner.__name__, (ctypes.Structure,), {"_anonymous_": ("fields",), "_fields_": behind})()
    made.kind = kind
    for name, value in numbers.items():
        setattr(made, name, value)
    for name, array in arrays.items():
        setattr(made, name, array.ctypes.data)
    made.arrays = arrays  # live as long as the structure that points to them
    return made  # type: ignore[no-any-return]


def evaluate(size: int | str, sizes: dict[str, int]) -> int:
    """Return the number of elements that the size in an annotation stands for."""
    return _value(ast.parse(str(size), mode="eval").body, sizes)


def _value(node: ast.expr, sizes: dict[str, int]) -> int:
    match node:
        case ast.Constant(value=int() as value):
            return value
        case ast.Name(id=name):
            if name not in sizes:
                raise ValueError(f"size {name} must be given")
            return sizes[name]
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _value(left, sizes) + _value(right, sizes)
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return _value(left, sizes) * _value(right, sizes)
    raise ValueError(f"a size must be a sum or a product, was {ast.unparse(node)}")

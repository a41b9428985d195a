"""Workspaces that are lent to the kernel: numbers and NumPy arrays that its Python and its C both work on."""

import ast
import ctypes
import threading
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Annotated, Any, Generic, TypeVar, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from cca_core import kernel
from cca_core.kernel.types import Ints

T = TypeVar("T")
C_TYPES: dict[Any, Any] = {float: ctypes.c_double, int: ctypes.c_int, bool: ctypes.c_bool}
MAX_REUSED = 16  # workspaces that a thread keeps
_thread = threading.local()


@dataclass(frozen=True, slots=True)
class Lent(Generic[T]):
    """A workspace, and its arrays by the names of their fields."""

    workspace: T
    arrays: dict[str, NDArray[Any]]
    owner: type[T]
    sizes: Mapping[str, int]

    def __reduce__(self) -> tuple[Any, ...]:
        numbers = {name: getattr(self.workspace, name) for name in fields(cast(Any, self.owner))[0]}
        return _lend_again, (self.owner, self.sizes, numbers, self.arrays)


def lend(owner: type[T], form: str | None = None, **sizes: int) -> Lent[T]:
    """Make a workspace of a class of fields: zeros, arrays of the sizes in its annotations."""
    numbers, shapes = fields(cast(Any, owner))
    arrays = {name: np.zeros(shape_of(shape, sizes), element) for name, (element, shape) in shapes.items()}
    given = {name: sizes.get(name, kind()) for name, kind in numbers.items()}
    unknown = [name for name in sizes if name not in given]
    if unknown:
        raise ValueError(f"sizes must be fields of {owner.__name__}, were {', '.join(unknown)}")
    if (form or kernel.backend()) == "c":
        workspace = cast(Any, structure_type)(owner)(given, arrays)
    else:
        workspace = owner()
        for name, value in given.items():
            setattr(workspace, name, value)
        for name, array in arrays.items():
            setattr(workspace, name, memoryview(cast(Any, array)))
    return Lent(workspace, arrays, owner, sizes)


def put(workspace: object, **numbers: float) -> None:
    """Set reals of a workspace; as float, as C keeps them, although a caller may have given others."""
    for name, value in numbers.items():
        setattr(workspace, name, float(value))


def _lend_again(
    owner: type[T], sizes: Mapping[str, int], numbers: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
) -> Lent[T]:
    """Make a workspace from the contents of another one, perhaps of another process."""
    lent = lend(owner, None, **sizes)
    for name in numbers.keys() - sizes.keys():
        setattr(lent.workspace, name, numbers[name])
    for name, array in arrays.items():
        lent.arrays[name][...] = array
    return lent


def reuse(owner: type[T], **sizes: int) -> Lent[T]:
    """Return a workspace that this thread has given back, with what is in it, or a new one.

    No other call gets it until `give_back`: a signal handler may run within a call and make the same call.
    """
    lent: Lent[T] | None = pick((owner, *sizes.items()))
    return lend(owner, None, **sizes) if lent is None else lent


def give_back(lent: Lent[Any]) -> None:
    """Keep a workspace for the next calls of this thread."""
    keep((lent.owner, *lent.sizes.items()), lent)


def pick(key: object) -> Any:
    """Return what this thread has kept with a key, or None; no other call gets it until it is kept again."""
    return _kept().pop(key, None)


def keep(key: object, memory: Any) -> None:
    """Keep workspaces, or an object that holds some, for the next calls of this thread."""
    kept = _kept()
    kept[key] = memory
    if len(kept) > MAX_REUSED:
        kept.popitem(last=False)


def _kept() -> OrderedDict[Any, Any]:
    """Workspaces that this thread keeps; that of the latest call is the last."""
    kept: OrderedDict[Any, Any] | None = getattr(_thread, "kept", None)
    if kept is None:
        kept = _thread.kept = OrderedDict()
    return kept


@cache
def fields(owner: type) -> tuple[dict[str, Any], dict[str, tuple[Any, tuple[int | str, ...]]]]:
    """Return the types of the numbers of a class, and element types and shapes of its arrays."""
    numbers, shapes = {}, {}
    for name, hint in get_type_hints(owner, include_extras=True).items():
        if get_origin(hint) is Annotated:
            base, *shape = get_args(hint)
            shapes[name] = (np.int32 if base is Ints else np.float64, tuple(shape))
        else:
            numbers[name] = hint
    return numbers, shapes


@cache
def structure_type(owner: type) -> type[ctypes.Structure]:
    """Make the type of the workspaces of a class in C; arrays and their sizes cannot be replaced."""
    if kernel.COMPILED is None:
        raise ValueError(f"form must be python, was c: {kernel.backend_reason()}")
    kind, size = kernel.COMPILED.structures[owner.__name__]
    _, shapes = fields(owner)
    hints = get_type_hints(owner, include_extras=True)
    c_fields = [(name, C_TYPES.get(hint, ctypes.c_void_p)) for name, hint in hints.items()]
    plain = type("Fields", (ctypes.Structure,), {"_fields_": c_fields})
    if ctypes.sizeof(plain) != size:
        raise ValueError(f"{owner.__name__} must have {size} bytes, had {ctypes.sizeof(plain)}")
    behind = [("kind", ctypes.c_int), ("users", ctypes.c_int)]
    whole = type(
        "Whole", (ctypes.Structure,), {"_anonymous_": ("fields",), "_fields_": [("fields", plain), *behind]}
    )

    def begin(self: Any, numbers: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> None:
        self.kind = kind
        for name, value in numbers.items():
            setattr(self.fields, name, value)
        for name, array in arrays.items():
            setattr(self.fields, name, array.ctypes.data)
        self.fixed = {name: numbers[name] for name in sizes} | arrays  # arrays must live as long as this

    sizes = {name for _, shape in shapes.values() for size in shape for name in names_in(size)}
    members: dict[str, Any] = {"__init__": begin}
    members |= {name: property(partial(fixed, name=name)) for name in sizes | shapes.keys()}
    return type(owner.__name__, (whole,), members)


def fixed(workspace: Any, name: str) -> Any:
    """Return a size or an array of a workspace in C."""
    return workspace.fixed[name]


def names_in(size: int | str) -> set[str]:
    """Return the names in the size of an array."""
    return {node.id for node in ast.walk(parsed(str(size))) if isinstance(node, ast.Name)}


def shape_of(sizes: tuple[int | str, ...], values: Mapping[str, int]) -> tuple[int, ...]:
    """Return the shape that the sizes in an annotation stand for."""
    return tuple(_value(parsed(str(size)), values) for size in sizes)


@cache
def parsed(size: str) -> ast.expr:
    """Return the tree of the size of an array."""
    return ast.parse(size, mode="eval").body


def _value(node: ast.expr, values: Mapping[str, int]) -> int:
    """Evaluate a number, a name, a sum or a product."""
    match node:
        case ast.Constant(value=int() as value):
            return value
        case ast.Name(id=name) if name in values:
            return values[name]
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _value(left, values) + _value(right, values)
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return _value(left, values) * _value(right, values)
    raise ValueError(f"sizes must be given, and be sums or products, was {ast.unparse(node)}")

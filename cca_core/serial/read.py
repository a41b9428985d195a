"""Settings and results from their descriptions."""

import math
from collections.abc import Callable, Mapping
from enum import Enum
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import numpy as np

from cca_core._checks import unknown
from cca_core.errors import InputError
from cca_core.serial.band_problem import stated_problem
from cca_core.serial.fields import VERSION, field_types, required_fields
from cca_core.serial.version_1 import CLASSES, updated_fields, updated_value

__all__ = ["from_dict"]

T = TypeVar("T")

_NOT_FINITE = {"Infinity": math.inf, "-Infinity": -math.inf, "NaN": math.nan}


def from_dict(kind: type[T], data: Mapping[str, Any]) -> T:
    """Make settings or a result from a description.

    Parameters
    ----------
    kind : type
        Class of the value, such as `EvasionSettings`.
    data : mapping
        Result of `to_dict` of this version or version 1, or written by hand. ``"type"``, ``"version"`` and
        fields with a default may be omitted.

    Returns
    -------
    value : object
        A `kind` equal to the described value.

    Raises
    ------
    InputError
        If a field is unknown, missing, of the wrong type or out of range; the message names its position,
        such as ``lanes[1].width``. If type or version do not fit.

    Examples
    --------
    >>> from cca_core import Lane
    >>> from_dict(Lane, {"d": 3.5, "direction": -1})
    Lane(d=3.5, width=3.5, direction=-1, boundaries=())
    """
    if field_types(kind) is None:
        raise InputError(f"kind must be a class of settings or results, was {kind!r}")
    given: object = data  # a file may hold anything
    version = given.get("version", VERSION) if isinstance(given, Mapping) else VERSION
    if version not in (1, VERSION):
        raise InputError(f"version must be 1 or {VERSION}, was {version!r}")
    made: T = _object(kind, data, "", version == 1)
    return made


def _name(kind: type, old: bool) -> str:
    """Name of a class, today or in version 1."""
    return CLASSES.get(kind.__name__, kind.__name__) if old else kind.__name__


def _object(kind: type, data: Any, where: str, old: bool) -> Any:
    """Make a record; `where` is empty for the outermost one, `old` is set for version 1."""
    if not isinstance(data, Mapping):
        raise InputError(f"{where or 'data'} must have the fields of {kind.__name__}, was {str(data)[:60]!r}")
    prefix = f"{where}." if where else ""
    if data.get("type", _name(kind, old)) != _name(kind, old):
        raise InputError(f"{prefix}type must be {_name(kind, old)}, was {data['type']!r}")
    if old:
        data = updated_fields(kind.__name__, data)
    if kind.__name__ == "BandProblem":
        data = stated_problem(data)
    hints = field_types(kind) or {}
    for name in data:
        if name not in hints and name != "type" and (name != "version" or where):
            raise InputError(f"{prefix}{name} is not a field of {kind.__name__}; {unknown(str(name), hints)}")
    for name in hints:
        if name not in data and name in required_fields(kind):
            raise InputError(f"{prefix}{name} is missing, a field of {kind.__name__}")
    values = {name: _made(hints[name], data[name], prefix + name, old) for name in hints if name in data}
    try:
        return kind(**values)
    except InputError as error:
        raise InputError(f"{prefix}{error}") from None


def _made(hint: Any, data: Any, where: str, old: bool = False) -> Any:
    """Make a value of type `hint`."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Annotated:  # Annotated[Any, kind]: anything to a type checker, here a kind
        return _made(inner[1], data, where, old)
    if origin in (Union, UnionType):
        return _one_of(inner, data, where, old)
    if origin is Literal:
        return _checked(data in inner, data, where, f"one of {', '.join(map(repr, inner))}")
    if origin is np.ndarray:
        return _array(np.dtype(get_args(inner[1])[0]), data, where)
    if origin in (tuple, frozenset):
        return _sequence(origin, inner, data, where, old)
    if origin in (dict, Mapping):
        _checked(isinstance(data, Mapping), data, where, "an object")
        return {inner[0](key): _made(inner[1], item, f"{where}.{key}", old) for key, item in data.items()}
    if field_types(hint) is not None:
        return _object(hint, data, where, old)
    if isinstance(hint, type) and issubclass(hint, Enum):
        names = list(hint.__members__)
        data = updated_value(hint.__name__, data) if old else data
        _checked(isinstance(data, str) and data in names, data, where, f"one of {', '.join(names)}")
        return hint[data]
    if hint not in _SIMPLE:
        raise InputError(f"{where} cannot be read, its type is {hint}")
    fits, words, convert = _SIMPLE[hint]
    return convert(_checked(fits(data), data, where, words))


def _one_of(kinds: tuple[Any, ...], data: Any, where: str, old: bool) -> Any:
    """Make a value of a union: None, the record of the given type, or the only other type."""
    if data is None and NoneType in kinds:
        return None
    rest = [kind for kind in kinds if kind is not NoneType]
    if len(rest) > 1:
        named = data.get("type") if isinstance(data, Mapping) else None
        words = f"an object whose type is one of {', '.join(_name(kind, old) for kind in rest)}"
        rest = [kind for kind in rest if _name(kind, old) == named]
        _checked(bool(rest), data, where, words)
    return _made(rest[0], data, where, old)


def _array(dtype: np.dtype[Any], data: Any, where: str) -> Any:
    """Make an array of nested lists."""
    words = f"nested lists of {'true and false' if dtype.kind == 'b' else 'numbers'}, all of one shape"
    if isinstance(data, Mapping) and isinstance(data.get("shape"), list):
        shape = [_made(int, n, f"{where}.shape") for n in data["shape"]]
        _checked(0 in shape and min(shape) == 0 and max(shape) < 1_000_000_000, data, where, words)
        return np.empty(shape[:-1] if dtype.kind == "c" else shape, dtype)
    leaves = _leaves({"f": float, "c": float, "b": bool}.get(dtype.kind, int), data, where)
    try:
        array = np.array(leaves, dtype=float if dtype.kind == "c" else dtype)
    except (ValueError, OverflowError):
        raise InputError(f"{where} must be {words}") from None
    if dtype.kind == "c":
        _checked(array.shape[-1:] == (2,), data, where, "nested lists of pairs of numbers")
        array = array.view(dtype)[..., 0]
    array.setflags(write=False)
    return array


def _leaves(leaf: type, data: Any, where: str) -> Any:
    """Check the numbers in nested lists."""
    if isinstance(data, list):
        return [_leaves(leaf, item, where) for item in data]
    return _made(leaf, data, where)


def _sequence(origin: type, inner: tuple[Any, ...], data: Any, where: str, old: bool) -> Any:
    """Make a tuple or frozenset."""
    _checked(isinstance(data, (list, tuple)), data, where, "a list")
    if origin is frozenset or inner[1:] == (Ellipsis,):
        kinds = inner[:1] * len(data)
    else:
        kinds = inner
        _checked(len(data) == len(kinds), data, where, f"a list of {len(kinds)}")
    pairs = enumerate(zip(kinds, data, strict=True))
    return origin(_made(kind, item, f"{where}[{i}]", old) for i, (kind, item) in pairs)


def _checked(fits: bool, data: Any, where: str, words: str) -> Any:
    if not fits:
        raise InputError(f"{where} must be {words}, was {str(data)[:60]!r}")
    return data


def _is_number(data: Any) -> bool:
    if isinstance(data, str):
        return data in _NOT_FINITE
    return isinstance(data, float) or (_is_whole(data) and abs(data) < 2**1023)


def _is_whole(data: Any) -> bool:
    return isinstance(data, int) and not isinstance(data, bool)


def _is_hexadecimal(data: Any) -> bool:
    return isinstance(data, str) and len(data) % 2 == 0 and set(data) <= set("0123456789abcdef")


_SIMPLE: dict[Any, tuple[Callable[[Any], bool], str, Callable[[Any], Any]]] = {
    float: (_is_number, "a number", lambda data: float(_NOT_FINITE.get(data, data))),
    int: (_is_whole, "a whole number", int),
    bool: (lambda data: isinstance(data, bool), "true or false", bool),
    str: (lambda data: isinstance(data, str), "a string", str),
    bytes: (_is_hexadecimal, "hexadecimal digits", bytes.fromhex),
}

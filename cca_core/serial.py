"""Conversion of settings and results to plain dictionaries for JSON, and back."""

import dataclasses
import inspect
import math
from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from cca_core._checks import Array
from cca_core._version_1 import CLASSES, updated_fields, updated_value
from cca_core.errors import InputError
from cca_core.path import Lane, LocalFrame, Path, Road

__all__ = ["VERSION", "from_dict", "to_dict"]

VERSION = 2
"""Version of the dictionaries that are written; version 1 is read as well."""

T = TypeVar("T")

_MADE_OF: dict[type, dict[str, Any]] = {
    Path: {"breaks": Array, "coefficients": Array},
    Road: {
        "path": Path,
        "lanes": tuple[Lane, ...],
        "speed_limit": float,
        "stop_lines": tuple[float, ...],
        "elevation": Array | None,
        "sigma_elevation": float,
    },
    LocalFrame: {"lat0": float, "lon0": float},
}
_NOT_FINITE = {"Infinity": math.inf, "-Infinity": -math.inf, "NaN": math.nan}


def to_dict(value: object) -> dict[str, Any]:
    """Describe settings or a result by JSON types.

    Parameters
    ----------
    value : object
        A dataclass of this library, such as `VehicleParams` or one `Band`; or a `Path`, `Road`, `LocalFrame`.

    Returns
    -------
    data : dict
        Fields by name, with ``"type"`` and ``"version"``. Numbers are exact, also after `json.dumps`.

    Raises
    ------
    InputError
        If the value or a part of it cannot be described.

    Notes
    -----
    Tuples, sets and arrays become lists, a complex number the pair of its parts, an array without elements
    ``{"shape": [...]}``, an enum its name, bytes hexadecimal digits. Floats that are not finite become
    ``"Infinity"``, ``"-Infinity"`` and ``"NaN"``, as in the JSON of protocol buffers.

    Examples
    --------
    >>> to_dict(Lane(d=3.5, direction=-1))
    {'type': 'Lane', 'version': 2, 'd': 3.5, 'width': 3.5, 'direction': -1}
    """
    if _fields(type(value)) is None:
        raise InputError(f"value must be settings or a result, was {type(value).__name__}")
    described = _described(value, type(value).__name__)
    return {"type": described.pop("type"), "version": VERSION, **described}


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
    >>> from_dict(Lane, {"d": 3.5, "direction": -1})
    Lane(d=3.5, width=3.5, direction=-1)
    """
    if _fields(kind) is None:
        raise InputError(f"kind must be a class of settings or results, was {kind!r}")
    given: object = data  # a file may hold anything
    version = given.get("version", VERSION) if isinstance(given, Mapping) else VERSION
    if version not in (1, VERSION):
        raise InputError(f"version must be 1 or {VERSION}, was {version!r}")
    made: T = _object(kind, data, "", version == 1)
    return made


def _fields(kind: Any) -> dict[str, Any] | None:
    """Type of each field; None if the class cannot be described."""
    return _fields_of(kind) if isinstance(kind, type) else None


@cache
def _fields_of(kind: Any) -> dict[str, Any] | None:
    if not dataclasses.is_dataclass(kind):
        return _MADE_OF.get(kind)
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in dataclasses.fields(kind)}


def _described(value: Any, where: str) -> Any:
    """Describe a value; `where` is its position in messages."""
    names = _fields(type(value))
    if names is not None:
        kept = {name: _described(getattr(value, name), f"{where}.{name}") for name in names}
        return {"type": type(value).__name__, **kept}
    if isinstance(value, Enum):
        return value.name
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufc":
        if np.iscomplexobj(value):
            value = np.stack((value.real, value.imag), axis=-1)
        if not value.size:
            return {"shape": list(value.shape)}
        values = value.tolist()
        return values if np.isfinite(value).all() else _described(values, where)
    if isinstance(value, np.generic):
        return _described(value.item(), where)
    if isinstance(value, int):
        return int(value)
    if isinstance(value, float):
        if math.isfinite(value):
            return float(value)
        return "NaN" if math.isnan(value) else "Infinity" if value > 0.0 else "-Infinity"
    if isinstance(value, (tuple, list)):
        return [_described(item, f"{where}[{i}]") for i, item in enumerate(value)]
    if isinstance(value, frozenset):
        return [_described(item, where) for item in sorted(value, key=str)]
    if isinstance(value, dict):
        return {str(key): _described(item, f"{where}.{key}") for key, item in value.items()}
    raise InputError(f"{where} must be made of numbers, strings and records, was {type(value).__name__}")


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
    hints = _fields(kind) or {}
    for name in data:
        if name not in hints and name != "type" and (name != "version" or where):
            raise InputError(f"{prefix}{name} is not a field of {kind.__name__}; it has {', '.join(hints)}")
    for name in hints:
        if name not in data and name in _required(kind):
            raise InputError(f"{prefix}{name} is missing, a field of {kind.__name__}")
    values = {name: _made(hints[name], data[name], prefix + name, old) for name in hints if name in data}
    try:
        return kind(**values)
    except InputError as error:
        raise InputError(f"{prefix}{error}") from None


def _required(kind: type) -> frozenset[str]:
    """Names of the fields without a default."""
    if not dataclasses.is_dataclass(kind):
        empty, arguments = inspect.Parameter.empty, inspect.signature(kind).parameters
        return frozenset(name for name in _MADE_OF[kind] if arguments[name].default is empty)
    missing = dataclasses.MISSING
    fields = dataclasses.fields(kind)
    return frozenset(f.name for f in fields if f.default is missing and f.default_factory is missing)


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
    if _fields(hint) is not None:
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

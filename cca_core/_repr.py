"""Short texts of records: what differs from its default, arrays by their size."""

from dataclasses import MISSING, Field, fields
from enum import Enum
from types import FunctionType
from typing import Any

import numpy as np

_MAX_ITEMS = 6  # of an array or a collection that is written out
_MAX_TEXT = 80  # characters of one value: most of a line


def short_repr(record: Any) -> str:
    """Text of a dataclass in a few lines at most, without the fields that have their default value."""
    changed = [(f, getattr(record, f.name)) for f in fields(record) if f.repr]
    texts = [f"{f.name}={_short(value)}" for f, value in changed if not _is_same(value, _default(f))]
    return f"{type(record).__qualname__}({', '.join(texts)})"


def _default(field: Field[Any]) -> Any:
    return field.default if field.default_factory is MISSING else field.default_factory()


def _is_same(value: Any, default: Any) -> bool:
    if value is default or isinstance(value, np.ndarray):
        return value is default
    both_nan = value != value and default != default
    return type(value) is type(default) and (both_nan or bool(value == default))


def _short(value: Any) -> str:
    if isinstance(value, Enum):
        return f"{type(value).__name__}.{value.name}"
    if isinstance(value, FunctionType):
        return value.__qualname__
    if isinstance(value, float):
        return f"{value:.6g}" if abs(value) < 1e6 else f"{value:.12g}"  # a time since 1970 has a fraction
    if isinstance(value, np.ndarray) and value.ndim != 1:
        size = " x ".join(str(n) for n in value.shape)
        return f"array of {size}" if size else _short(value.item())
    if isinstance(value, (tuple, list, set, frozenset, dict, np.ndarray)):
        return _short_collection(value)
    text = repr(value)
    if len(text) <= _MAX_TEXT and "\n" not in text:
        return text
    if isinstance(value, (str, bytes)):
        return f"{text[: _MAX_TEXT - 4]}...{text[-1]}"
    return f"{type(value).__name__}(...)"


def _short_collection(value: Any) -> str:
    if len(value) <= _MAX_ITEMS and not isinstance(value, dict):
        items = ", ".join(_short(item) for item in value)
        if len(items) <= _MAX_TEXT:
            left, right = ("(", ")") if isinstance(value, tuple) else ("[", "]")
            left, right = ("{", "}") if isinstance(value, (set, frozenset)) else (left, right)
            return f"{left}{items}{',' if left == '(' and len(value) == 1 else ''}{right}"
    numbers = len(value) > 0 and all(isinstance(item, (int, float)) for item in value)
    extent = f" from {min(value):.6g} to {max(value):.6g}" if numbers else ""
    return f"{type(value).__name__} of {len(value)}{extent}"

"""Records that are written and read, with their fields."""

import dataclasses
import inspect
from functools import cache
from typing import Any, get_type_hints

from cca_core._checks import Array
from cca_core.path import Lane, LocalFrame, Path, Road

__all__ = ["VERSION", "field_types", "required_fields"]

VERSION = 2
"""Version of the dictionaries that are written; version 1 is read as well."""

_MADE_OF: dict[type, dict[str, Any]] = {
    Path: {"breaks": Array, "coefficients": Array},
    Road: {
        "path": Path,
        "lanes": tuple[Lane, ...],
        "speed_limit": float,
        "stop_lines": tuple[float, ...],
        "elevation": Array | None,
        "sigma_elevation": float,
        "speed_limits": Array | None,
    },
    LocalFrame: {"lat0": float, "lon0": float},
}


def field_types(kind: Any) -> dict[str, Any] | None:
    """Type of each field; None if the class cannot be described."""
    return _types_of(kind) if isinstance(kind, type) else None


@cache
def _types_of(kind: Any) -> dict[str, Any] | None:
    if not dataclasses.is_dataclass(kind):
        return _MADE_OF.get(kind)
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in dataclasses.fields(kind)}


def required_fields(kind: type) -> frozenset[str]:
    """Names of the fields without a default."""
    if not dataclasses.is_dataclass(kind):
        empty, arguments = inspect.Parameter.empty, inspect.signature(kind).parameters
        return frozenset(name for name in _MADE_OF[kind] if arguments[name].default is empty)
    missing = dataclasses.MISSING
    fields = dataclasses.fields(kind)
    return frozenset(f.name for f in fields if f.default is missing and f.default_factory is missing)

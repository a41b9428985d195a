"""Description of settings and results by JSON types."""

import math
from enum import Enum
from typing import Any

import numpy as np

from cca_core.errors import InputError
from cca_core.serial.fields import VERSION, field_types

__all__ = ["to_dict"]


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
    >>> from cca_core import Lane
    >>> to_dict(Lane(d=3.5, direction=-1))
    {'type': 'Lane', 'version': 2, 'd': 3.5, 'width': 3.5, 'direction': -1, 'boundaries': []}
    """
    if field_types(type(value)) is None:
        raise InputError(f"value must be settings or a result, was {type(value).__name__}")
    described = _described(value, type(value).__name__)
    return {"type": described.pop("type"), "version": VERSION, **described}


def _described(value: Any, where: str) -> Any:
    """Describe a value; `where` is its position in messages."""
    names = field_types(type(value))
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

"""Checks of arguments; each raises `InputError` that names the argument."""

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cca_core.errors import CcaError, InputError

P = ParamSpec("P")
R = TypeVar("R")
Array = np.ndarray[Any, np.dtype[np.float64]]
Complex = np.ndarray[Any, np.dtype[np.complex128]]
Mask = np.ndarray[Any, np.dtype[np.bool_]]
Index = np.ndarray[Any, np.dtype[np.intp]]


def check_real(
    name: str,
    value: object,
    *,
    gt: float = -math.inf,
    ge: float = -math.inf,
    le: float = math.inf,
    allow_inf: bool = False,
) -> float:
    """Return `value` as float if it is a real number, greater than `gt` and from `ge` to `le`."""
    try:
        if isinstance(value, (str, bytes)):  # float() accepts text, but the caller would keep the text
            raise TypeError
        number = float(value)  # type: ignore[arg-type]  # the value may be anything
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} must be a real number, was {shown(value)}") from None
    if not (math.isfinite(number) or (allow_inf and not math.isnan(number))):
        raise InputError(f"{name} must be finite, was {number}")
    if number <= gt:
        raise InputError(f"{name} must be greater than {gt:g}, was {number:g}")
    if not ge <= number <= le:
        bounds = f"at least {ge:g}" if number < ge else f"at most {le:g}"
        raise InputError(f"{name} must be {bounds}, was {number:g}")
    return number


def check_reals(name: str, values: object, *, ge: float = -math.inf) -> tuple[float, ...]:
    """Return `values` as floats if they are a sequence of real numbers from `ge` up."""
    if not isinstance(values, Iterable) or isinstance(values, (str, bytes)):
        raise InputError(f"{name} must be a sequence of real numbers, was {shown(values)}")
    return tuple(check_real(name, value, ge=ge) for value in values)


def check_bool(name: str, value: object) -> bool:
    """Return `value` if it is True or False; any other value, such as a text, is truthy by accident."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} must be True or False, was {shown(value)}")
    return bool(value)


def read_real(name: str, value: object, *, ge: float = -math.inf, le: float = math.inf) -> float:
    """Return `value` as `check_real` does; it may be written as text, as in a file."""
    if isinstance(value, str):
        number = parse_real(value)
        if number is None:
            raise InputError(f"{name} must be a real number, was {shown(value)}")
        value = number
    return check_real(name, value, ge=ge, le=le)


def parse_real(text: str) -> float | None:
    """Return the number that a text in a file stands for; None if it is none."""
    # float() also takes 1_0, digits of other scripts and texts of any length
    if len(text) > 80 or not text.isascii() or "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


def shown(value: object) -> str:
    """Return a short text of any value for a message."""
    try:
        text = repr(value)
    except Exception:  # such as ten thousand digits, lists in lists without end, foreign code
        return f"a {type(value).__name__}"
    return text if len(text) <= 80 else f"{text[:80]}..."


def unknown(name: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown name: the nearest known one, then all."""
    names = list(known)
    longer = [each for each in names if name and each.startswith(name)]
    nearest = longer[:1] or get_close_matches(name, names, n=1, cutoff=0.5)
    return "".join(f"did you mean {each}? " for each in nearest) + f"it has {', '.join(names)}"


def explained(error: Exception, values: Mapping[str, object]) -> Exception:
    """Return the error of a formula as `InputError` that names the value to blame, or as it is."""
    reals: dict[str, float] = {}
    for name, value in values.items():
        try:
            reals[name] = check_real(name, value, allow_inf=True)
        except InputError as refusal:
            return refusal
    if isinstance(error, TypeError) or not reals:
        return error
    name, value = max(reals.items(), key=lambda item: abs(item[1]))
    condition = "finite" if math.isinf(value) else "less in magnitude"
    return InputError(f"{name} must be {condition}, was {value:g}: {error}")


def formula(function: Callable[P, R]) -> Callable[P, R]:
    """Let a formula of plain numbers raise `InputError` where it fails; a result costs no checks."""

    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return function(*args, **kwargs)
        except CcaError:
            raise
        except (TypeError, ValueError, ArithmeticError) as error:
            signature = inspect.signature(function)
            try:
                given = signature.bind(*args, **kwargs).arguments
            except TypeError:
                raise error from None
            reals = {k: v for k, v in given.items() if signature.parameters[k].annotation in (float, int)}
            raise explained(error, reals) from None

    return checked


def check_array(name: str, value: ArrayLike, shape: tuple[int | None, ...]) -> Array:
    """Return a float64 copy of `value` if it is finite and has `shape` (None: any length)."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise InputError(f"{name} must be an array of real numbers, was {type(value).__name__}") from None
    fits = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join("n" if want is None else str(want) for want in shape) + ")"
        raise InputError(f"{name} must have shape {wanted}, had {array.shape}")
    if not np.isfinite(array).all():
        where = np.argwhere(~np.isfinite(array))[0]
        raise InputError(f"{name} must be finite, was {array[tuple(where)]} at {where.tolist()}")
    return array


def is_finite(array: Array) -> bool:
    """Whether all numbers of an array are finite; three times as fast as `all` for a hundred."""
    return int(np.count_nonzero(np.isfinite(array))) == array.size


def check_any(name: str, value: ArrayLike, ends_with: tuple[int, ...] = ()) -> Array:
    """Return `value` as finite float64 array of any shape that ends with the given lengths."""
    given: object = value  # may be anything
    if type(given) is float and math.isfinite(given) and not ends_with:
        return np.array(given)
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise InputError(f"{name} must be an array of real numbers, was {shown(value)}") from None
    if array.shape[array.ndim - len(ends_with) :] != ends_with or array.ndim < len(ends_with):
        wanted = ", ".join(["...", *map(str, ends_with)])
        raise InputError(f"{name} must have shape ({wanted}), had {array.shape}")
    if not is_finite(array):
        raise InputError(f"{name} must be finite, was {array[~np.isfinite(array)][0]}")
    return array


def as_array(name: str, value: ArrayLike) -> Array:
    """Return `value` as float64 array of any shape and any numbers."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError, RecursionError):
        raise InputError(f"{name} must be an array of real numbers, was {shown(value)}") from None


def check_points(name: str, value: ArrayLike, min_points: int) -> Array:
    """Return a float64 copy of `value` if it is a finite (n, 2) array with n >= `min_points`."""
    points = check_array(name, value, (None, 2))
    if len(points) < min_points:
        raise InputError(f"{name} must have at least {min_points} points, had {len(points)}")
    return points

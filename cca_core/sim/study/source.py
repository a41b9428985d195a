"""Source text that a result depends on: the library's, and that of a user's function or class."""

import ast
import hashlib
import inspect
from collections.abc import Callable, Collection, Iterator
from dataclasses import is_dataclass
from functools import cache
from pathlib import Path as FilePath
from types import CodeType, FunctionType
from typing import Any

from cca_core._checks import shown
from cca_core.errors import InputError

_DATA = (bool, int, float, str, bytes, tuple, frozenset, type(None))


def source_digest(without: Collection[str] = ()) -> str:
    """Digest of the library's source files, without those of the packages that no run depends on."""
    package = FilePath(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        name = file.relative_to(package)
        if name.parts[0] not in without:
            digest.update(name.as_posix().encode() + b"\0" + code_of(file) + b"\0")
    return digest.hexdigest()


@cache
def code_of(file: FilePath) -> bytes:
    """Content of a file; of Python the code alone, because comments and docstrings change no result."""
    if file.suffix != ".py":
        return file.read_bytes()
    tree = ast.parse(file.read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [part for part in node.body if not _is_text(part)]
    return ast.dump(tree).encode()


def _is_text(part: ast.stmt) -> bool:
    """Return whether a statement is a text alone."""
    if not isinstance(part, ast.Expr) or not isinstance(part.value, ast.Constant):
        return False
    return isinstance(part.value.value, str)


def check_definition(name: str, value: object) -> None:
    """Raise unless a value is a function or class that other processes find by its module and name."""
    found: Any = value
    if callable(value) and is_dataclass(type(value)):
        found = type(value)
    if not isinstance(found, FunctionType | type) or "." in found.__qualname__ or "<" in found.__qualname__:
        raise InputError(
            f"{name} must be a name of the library, or a function or class at the top level of a module, "
            f"was {shown(value)}"
        )


def definition(value: Callable[..., Any]) -> str:
    """Return the source of a function or class, and of what it uses of its module."""
    found: dict[str, str] = {}
    _collect(value.__name__, value, found)
    return "\n".join(found[name] for name in sorted(found))


def _collect(name: str, value: Any, found: dict[str, str]) -> None:
    try:
        found[name] = inspect.getsource(value)
    except (OSError, TypeError):
        raise InputError(f"the source of {value.__qualname__} must be in a file, was not found") from None
    for function in _functions(value):
        for used in _names(function.__code__):
            other = function.__globals__.get(used, ...)
            if used in found:
                continue
            if isinstance(other, FunctionType | type) and other.__module__ == value.__module__:
                _collect(used, other, found)
            elif isinstance(other, _DATA):
                found[used] = f"{used} = {other!r}"


def _functions(value: Any) -> Iterator[FunctionType]:
    """Yield a function itself, or the methods of a class."""
    if isinstance(value, FunctionType):
        yield value
    else:
        yield from (each for each in vars(value).values() if isinstance(each, FunctionType))


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)

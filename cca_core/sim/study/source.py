"""Source text that a result depends on: the library's, and that of a user's function or class."""

import ast
import hashlib
import inspect
import io
import tokenize
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import is_dataclass
from functools import cache
from pathlib import Path as FilePath
from types import CodeType, FunctionType
from typing import Any

from cca_core._checks import shown
from cca_core.errors import InputError

_DATA = (bool, int, float, str, bytes, tuple, frozenset, type(None))
_Span = tuple[int, int, int, int]  # first line and column, last line and end


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
    """Content of a file; of Python the code alone, because comments and docstrings change no result.

    It is text, as a syntax tree is another one in each version of Python.
    """
    source = file.read_bytes()
    if file.suffix != ".py":
        return source
    source = source.replace(b"\r\n", b"\n")
    lines = source.splitlines(keepends=True)
    tokens = list(tokenize.tokenize(io.BytesIO(source).readline))
    spans = [*_texts(ast.parse(source)), *_comments(tokens, lines)]
    for first, begin, last, end in sorted(spans, reverse=True):
        before, behind = lines[first - 1][:begin], lines[last - 1][end:]
        before = before if behind.strip() else before.rstrip()
        lines[first - 1 : last] = [before + behind, *[b""] * (last - first)]
    blank = {token.start[0] for token in tokens if token.type == tokenize.NL} | {span[0] for span in spans}
    return b"".join(line for i, line in enumerate(lines, start=1) if i not in blank or line.strip())


def _texts(tree: ast.Module) -> Iterator[_Span]:
    """Yield where docstrings are."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            for part in filter(_is_text, node.body):
                yield part.lineno, part.col_offset, part.end_lineno or part.lineno, part.end_col_offset or 0


def _comments(tokens: Iterable[tokenize.TokenInfo], lines: Sequence[bytes]) -> Iterator[_Span]:
    """Yield where comments are, in bytes as the syntax tree counts."""
    for token in tokens:
        if token.type == tokenize.COMMENT:
            row, end = token.start[0], len(lines[token.start[0] - 1].rstrip(b"\r\n"))
            yield row, end - len(token.string.encode()), row, end


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

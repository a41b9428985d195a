"""Kinds of values in the kernel's Python, and how C declares them."""

import ast
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import NoReturn


class TranslationError(SyntaxError):
    """A source holds something outside of the kernel's Python; the message begins with file and line."""


@dataclass(frozen=True)
class Source:
    """A module's file, for the messages about it."""

    path: Path

    def fail(self, node: ast.AST | None, why: str) -> NoReturn:
        """Refuse a node."""
        raise TranslationError(f"{self.path.name}:{getattr(node, 'lineno', 0)}: {why}")

    def comment(self, node: ast.AST, text: str | None) -> list[str]:
        """Return the lines of a docstring as a comment of C."""
        if text is None:
            return []
        if "*/" in text or "/*" in text:
            self.fail(node, "a docstring must not hold the marks of a comment of C")
        return f"/* {text.strip()} */".split("\n")


class Scalar(Enum):
    """Number or flag; the value is the type in C."""

    REAL = "double"
    INT = "int"
    FLAG = "bool"

    def __str__(self) -> str:
        return {"double": "Real", "int": "Int", "bool": "Flag"}[self.value]


@dataclass(frozen=True)
class Array:
    """Lent memory: a row with one size, or a grid with the numbers of its rows and columns."""

    element: Scalar
    shape: tuple[str, ...]

    @property
    def sizes(self) -> str:
        """Sizes as in a declaration of C."""
        return "".join(f"[{size}]" for size in self.shape)

    def __str__(self) -> str:
        return f"{'Grid' if len(self.shape) == 2 else 'row'} of {self.element}"


@dataclass(frozen=True)
class Structure:
    """Class of fields."""

    name: str
    fields: dict[str, "Scalar | Array"]

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Group:
    """Several numbers that a function returns."""

    items: tuple[Scalar, ...]

    @property
    def name(self) -> str:
        """Type in C."""
        return "cca_" + "".join(item.value[0] for item in self.items)

    def __str__(self) -> str:
        return f"tuple[{', '.join(map(str, self.items))}]"


Kind = Scalar | Array | Structure | Group | None


@dataclass(frozen=True)
class Constant:
    """Number of a module."""

    c_name: str
    kind: Scalar


@dataclass(frozen=True)
class Signature:
    """Function: its arguments, which of them it changes, and what it returns."""

    name: str
    c_name: str
    arguments: dict[str, Kind]
    changed: frozenset[str]
    returns: Kind


def c_type(kind: Kind) -> str:
    """Type of what a function returns."""
    if isinstance(kind, Scalar):
        return kind.value
    return kind.name if isinstance(kind, Group) else "void"


def declare(kind: Kind, name: str, is_const: bool = False) -> str:
    """Declare a variable, a field or an argument."""
    const = "const " if is_const else ""
    if isinstance(kind, Array):
        return f"{const}{kind.element.value} *{name}"
    if isinstance(kind, Structure):
        return f"{const}{kind.name} *{name}"
    return f"{c_type(kind)} {name}"

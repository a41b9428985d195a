"""Every public name is documented, and every number in it has a unit.

The rules, for each name in the ``__all__`` of `cca_core` and of its packages, and for the public
methods and properties of the classes among them:

- A docstring in numpydoc form exists.
- Parameters (of a dataclass: its fields, under Parameters or Attributes) are those of the
  signature, none missing, none stale, each with a type and a description.
- A type that begins with ``array_like`` or ``ndarray`` states its ``shape``.
- A type that begins with ``float``, or is an array of anything but bool, int or str, has its unit
  in square brackets in the type or the description: ``[m]``, ``[rad/s]``, ``[kg m^2]``, ``[-]``.
  The same holds for what is returned, and for a property annotated as float.
- What returns a value has Returns (or Yields); what raises, itself or through an argument check,
  has Raises.
"""

import ast
import dataclasses
import enum
import importlib
import inspect
import pkgutil
import re
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from numpydoc.docscrape import NumpyDocString

import cca_core

ROOT = Path(__file__).resolve().parents[1]
UNITS = frozenset("% B Hz J N W bit deg g h kg km m ms rad s us".split())
RAISING_MODULES = frozenset({"cca_core._checks", "cca_core._optional"})


def has_unit(text: str) -> bool:
    for bracket in re.findall(r"\[([^\[\]]+)\]", text):
        words = [word for word in re.split(r"[\s\d/*^().,·⋅⁻¹²³-]+", bracket) if word]
        if bracket == "-" or (words and UNITS.issuperset(words)):
            return True
    return False


def entry_complaints(name: str, kind: str, description: str) -> Iterator[str]:
    if not kind:
        yield f"{name}: no type"
    if not description.strip():
        yield f"{name}: no description"
    is_array = kind.startswith(("array_like", "ndarray"))
    if is_array and "shape" not in kind:
        yield f"{name}: array without shape"
    counts = is_array and re.search(r"\b(bool|int|str)\b", kind)
    if (is_array or kind.startswith("float")) and not counts and not has_unit(kind + description):
        yield f"{name}: no unit in square brackets"


def section_complaints(doc: NumpyDocString, section: str) -> Iterator[str]:
    for entry in doc[section]:
        name = entry.name or section
        yield from entry_complaints(name, entry.type, " ".join(entry.desc))


def names(doc: NumpyDocString, section: str) -> list[str]:
    return [name.strip().lstrip("*") for entry in doc[section] for name in entry.name.split(",")]


def parameter_complaints(doc: NumpyDocString, expected: list[str], *more: str) -> Iterator[str]:
    """Compare with the signature; parameters may also be found in the sections `more`."""
    sections = ("Parameters", *more)
    documented = [name for section in sections for name in names(doc, section)]
    for name in expected:
        if name not in documented:
            yield f"{name}: not documented"
    for name in names(doc, "Parameters"):
        if name not in expected:
            yield f"{name}: documented, but not in the signature"
    for section in sections:
        yield from section_complaints(doc, section)


def raises(function: Callable[..., Any]) -> bool:
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) and node.exc is not None:
            return True
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            called = function.__globals__.get(node.func.id)
            if getattr(called, "__module__", None) in RAISING_MODULES:
                return True
    return False


def raises_complaints(doc: NumpyDocString, function: Callable[..., Any]) -> Iterator[str]:
    if raises(function) and not doc["Raises"]:
        yield "no Raises section"


def function_complaints(function: Callable[..., Any]) -> Iterator[str]:
    text = inspect.getdoc(function)
    if not text:
        yield "no docstring"
        return
    doc = NumpyDocString(text)
    signature = inspect.signature(function)
    expected = [
        name for name in signature.parameters if name not in ("self", "cls") and not name.startswith("_")
    ]  # an underscore marks arguments for tests only
    yield from parameter_complaints(doc, expected)
    if signature.return_annotation not in (None, "None") and not (doc["Returns"] or doc["Yields"]):
        yield "no Returns section"
    yield from section_complaints(doc, "Returns")
    yield from raises_complaints(doc, function)


def property_complaints(getter: Callable[..., Any]) -> Iterator[str]:
    text = inspect.getdoc(getter)
    if not text:
        yield "no docstring"
    elif inspect.signature(getter).return_annotation in (float, "float") and not has_unit(text):
        yield "no unit in square brackets"


def class_complaints(cls: type) -> Iterator[str]:
    text = cls.__doc__
    if not text or text.startswith(f"{cls.__name__}("):  # the latter is made by dataclass
        yield "no docstring"
        return
    doc = NumpyDocString(inspect.cleandoc(text))
    if dataclasses.is_dataclass(cls):
        fields = [field.name for field in dataclasses.fields(cls) if field.name[0] != "_"]
        yield from parameter_complaints(doc, fields, "Attributes")
        initializer = vars(cls).get("__post_init__")
    else:
        initializer = None if issubclass(cls, enum.Enum) else vars(cls).get("__init__")
        if initializer is not None:
            expected = [p for p in list(inspect.signature(initializer).parameters)[1:] if p[0] != "_"]
            yield from parameter_complaints(doc, expected)
    if initializer is not None:
        yield from raises_complaints(doc, initializer)


def public_modules() -> Iterator[Any]:
    """Modules that users import: `cca_core`, its packages and its single modules."""
    yield cca_core
    for module in pkgutil.iter_modules(cca_core.__path__, "cca_core."):
        if not module.name.split(".")[-1].startswith("_"):
            yield importlib.import_module(module.name)


def members(cls: type) -> Iterator[tuple[str, Iterator[str]]]:
    for name, member in vars(cls).items():
        if name.startswith("_"):
            continue
        if isinstance(member, property) and member.fget is not None:
            yield f"{cls.__qualname__}.{name}", property_complaints(member.fget)
        elif isinstance(member, (classmethod, staticmethod)):
            yield f"{cls.__qualname__}.{name}", function_complaints(member.__func__)
        elif inspect.isfunction(member):
            yield f"{cls.__qualname__}.{name}", function_complaints(inspect.unwrap(member))


def cases() -> dict[str, Iterator[str]]:
    """Complaints (not yet computed) for each public class, function, method and property."""
    found: dict[str, Iterator[str]] = {}
    for module in public_modules():
        for name in getattr(module, "__all__", []):
            value = getattr(module, name)
            home = getattr(value, "__module__", module.__name__)
            if inspect.isclass(value):
                found[f"{home}.{value.__qualname__}"] = class_complaints(value)
                found.update((f"{home}.{path}", complaints) for path, complaints in members(value))
            elif inspect.isroutine(value):
                value = inspect.unwrap(value)
                found[f"{home}.{value.__qualname__}"] = function_complaints(value)
    return found


CASES = cases()


@pytest.mark.parametrize("name", sorted(CASES))
def test_docstring(name: str) -> None:
    complaints = list(CASES[name])
    assert not complaints, f"{name}\n  " + "\n  ".join(complaints)


def internal_functions() -> dict[str, ast.FunctionDef | ast.ClassDef]:
    """Functions and classes that no package lists, by module and name."""
    listed = {name.rpartition(".")[2] for name in CASES}
    found: dict[str, ast.FunctionDef | ast.ClassDef] = {}
    for path in sorted((ROOT / "cca_core").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name not in listed:
                found[f"{path.relative_to(ROOT).as_posix()}:{node.name}"] = node
    return found


def test_internal_docstrings_are_short() -> None:
    """Inside a package a docstring has no sections; comments say why."""
    long = [
        name
        for name, node in internal_functions().items()
        if re.search(r"^\s*-{4,}$", ast.get_docstring(node) or "", re.MULTILINE)
    ]
    assert long == []


def good(speed: float, points: object) -> float:
    """Do something.

    Parameters
    ----------
    speed : float
        Forward speed [m/s].
    points : array_like, shape (n, 2)
        Positions [m].

    Returns
    -------
    kappa : float
        Curvature [1/m].
    """
    return speed


def bad(speed: float, points: object, forgotten: int) -> float:
    """Do something [1]_.

    Parameters
    ----------
    speed : float
        Forward speed, see [1]_.
    points : array_like
        Positions [m].
    stale : int
        Not there any more.
    """
    raise ValueError(speed)


def test_rules_find_defects() -> None:
    assert list(function_complaints(good)) == []
    assert list(function_complaints(bad)) == [
        "forgotten: not documented",
        "stale: documented, but not in the signature",
        "speed: no unit in square brackets",
        "points: array without shape",
        "no Returns section",
        "no Raises section",
    ]


@pytest.mark.parametrize("unit", ["[m]", "[-]", "[1/m]", "[kg m^2]", "[kg·m²]", "[rad s/m]"])
def test_unit_is_recognized(unit: str) -> None:
    assert has_unit(f"Something {unit}, positive.")


@pytest.mark.parametrize("text", ["none", "see [1]_", "[rear, front]", "[]"])
def test_text_without_unit_is_rejected(text: str) -> None:
    assert not has_unit(text)

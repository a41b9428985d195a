"""The words of docs/notation.md in identifiers and pages; names and imports of tests."""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.prose import prose

ROOT = Path(__file__).resolve().parents[1]
SOURCES = sorted(p for d in ("cca_core", "tests", "examples", "docs") for p in (ROOT / d).rglob("*.py"))
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
TESTS = [path for path in SOURCES if path.name.startswith("test_")]
GENERATED = {"docs/changelog.md", "docs/performance.md", "docs/table1.md", "docs/validation.md"}

REFUSED = frozenset(
    """who whom told tells says said beside likely unheard forgiven settled helpless pinned witness judge
    verdict ours draws drawn rerun swerve swerves detour retreat shortcut renew place places way ways
    neighbour neighbours leader leaders least most colour colours centre centres room rooms nobody somebody
    sight heard abeam""".split()
)
FOREIGN = {"least_squares", "most_common", "hasMost", "getLeader"}  # names of other libraries
PROSE = re.compile(
    r"\b(he|him|his|nobody|somebody|everybody|reckon\w*|held capable|bent anew|lane beside|rungs?)\b",
    re.IGNORECASE,
)
LONGEST_NAME = 60  # characters of a test's name


def identifiers(path: Path) -> Iterator[tuple[int, str]]:
    """Names in a Python file with their lines."""
    text = path.read_text(encoding="utf-8")
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.NAME and token.string not in FOREIGN:
            yield token.start[0], token.string


def words(name: str) -> set[str]:
    """Words of an identifier: split at underscores and capitals."""
    return {part.lower() for part in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)}


def refused_identifiers(path: Path) -> list[str]:
    """Identifiers of a file that hold a refused word."""
    found = {name: line for line, name in identifiers(path) if words(name) & REFUSED}
    return [f"{line}: {name}" for name, line in found.items()]


def refused_prose(path: Path) -> list[str]:
    """Words of a page that are refused."""
    return [match.group(0) for match in PROSE.finditer(prose(path.read_text(encoding="utf-8")))]


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_identifiers_use_glossary_terms(path: Path) -> None:
    assert refused_identifiers(path) == []


@pytest.mark.parametrize("path", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_page_uses_glossary_terms(path: Path) -> None:
    if path.relative_to(ROOT).as_posix() in GENERATED:
        assert path.exists()
        return
    assert refused_prose(path) == []


@pytest.mark.parametrize("path", TESTS, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_tests_have_short_names_and_no_imports_of_tests(path: Path) -> None:
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    names = [node.name for node in nodes if isinstance(node, ast.FunctionDef)]
    assert [name for name in names if name.startswith("test_") and len(name) > LONGEST_NAME] == []
    modules = [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    assert [name for name in modules if name.rpartition(".")[2].startswith("test_")] == []


def test_words_split_at_underscores_and_capitals() -> None:
    assert words("lane_besideSwerve2") == {"lane", "beside", "swerve"}

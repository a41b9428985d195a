"""Sentences of the pages, the notebooks and the public docstrings are short.

The style guide of CONTRIBUTING.md: short, active sentences. On each page half of the sentences have at
most 18 words, and none has more than 40. Tables, code, formulas, headings and references do not count.
"""

import importlib
import inspect
import json
import pkgutil
import statistics
from collections.abc import Iterator
from pathlib import Path

import pytest

import cca_core
from tests.support.prose import count_words, prose, sentences

ROOT = Path(__file__).resolve().parents[1]
BUILT = {"generated", "_build"}
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *(ROOT / name for name in ("ros2/README.md", "tests/trials/README.md")),
    *sorted(page for page in (ROOT / "docs").rglob("*.md") if not BUILT & set(page.parts)),
    *sorted((ROOT / "examples" / "notebooks").glob("*.ipynb")),
]
MAX_MEDIAN = 18  # words, of the sentences of a page
MAX_WORDS = 40  # in any sentence
MIN_WORDS = 3  # fewer are no sentence


def lengths(text: str) -> dict[str, int]:
    """Words of each sentence."""
    counted = {sentence: count_words(sentence) for sentence in sentences(text)}
    return {sentence: n for sentence, n in counted.items() if n >= MIN_WORDS}


def read_page(page: Path) -> str:
    """Text of a page; of a notebook, that of its markdown cells."""
    text = page.read_text(encoding="utf-8")
    if page.suffix != ".ipynb":
        return text
    cells = json.loads(text)["cells"]
    return "\n\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")


def first_paragraphs() -> Iterator[tuple[str, str]]:
    """Name and first paragraph of each public class, function, method and property."""
    packages = pkgutil.iter_modules(cca_core.__path__, "cca_core.")
    modules = [importlib.import_module(m.name) for m in packages if not m.name.split(".")[-1].startswith("_")]
    for module in modules:
        for name in getattr(module, "__all__", []):
            value = getattr(module, name)
            members = vars(value).items() if inspect.isclass(value) else ()
            public = [(f"{name}.{member}", part) for member, part in members if not member.startswith("_")]
            for path, part in [(name, value), *public]:
                if inspect.isclass(part) or inspect.isroutine(part) or isinstance(part, property):
                    yield f"{module.__name__}.{path}", (inspect.getdoc(part) or "").split("\n\n")[0]


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_page_has_short_sentences(page: Path) -> None:
    found = lengths(prose(read_page(page)))
    assert {sentence: n for sentence, n in found.items() if n > MAX_WORDS} == {}
    assert not found or statistics.median(found.values()) <= MAX_MEDIAN


def test_public_docstrings_begin_with_short_sentences() -> None:
    found = [
        (n, name, sentence)
        for name, text in first_paragraphs()
        for sentence, n in lengths(prose(text)).items()
    ]
    assert [entry for entry in found if entry[0] > MAX_WORDS] == []
    assert statistics.median(n for n, _, _ in found) <= MAX_MEDIAN


def test_long_sentences_are_found() -> None:
    assert list(lengths(f"{'word ' * MAX_WORDS}end. Two words.").values()) == [MAX_WORDS + 1]


def test_prose_leaves_out_code_tables_and_formulas() -> None:
    page = "# A heading\n\nOne `a b c` and [two words](x.md). Next.\n\n```\ncode here\n```\n| a | table |\n"
    assert [s for s in sentences(prose(page)) if s] == ["One x and two words.", "Next."]


def test_sentences_of_list_items_are_separate() -> None:
    assert list(sentences("Do:\n- this one\n- that one.")) == ["Do:", "this one", "that one."]


def test_signs_are_no_words() -> None:
    assert count_words("v = 3 m/s — or less") == 5

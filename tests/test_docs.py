"""The documentation: complete, linked, runnable, and without anything from the network."""

import ast
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import cca_core
from tests.bench import speed_page

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if not {"generated", "_build"} & set(page.parts))
LINKED = [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
FENCE = re.compile(r"^(`{3,}|~{3,})[^\n]*\n.*?^\1\s*$", re.MULTILINE | re.DOTALL)
SINGLE = re.compile(r"^\.\. auto(?:class|data|function):: (\S+)\.(\w+)$", re.MULTILINE)
DIRECTIVE = re.compile(r"^\.\. automodule:: (\S+)\n   :members:(.*)$", re.MULTILINE)
ROLE = re.compile(r"\{py:(\w+)\}`~?([\w.]+)`")


def named(pages: list[Path]) -> list[Any]:
    return [pytest.param(page, id=page.relative_to(ROOT).as_posix()) for page in pages]


# --- the API reference --------------------------------------------------------------------------------


def public_modules() -> Iterator[ModuleType]:
    """Modules that users import: `cca_core`, its packages and its single modules."""
    yield cca_core
    for module in pkgutil.iter_modules(cca_core.__path__, "cca_core."):
        if not module.name.split(".")[-1].startswith("_"):
            yield importlib.import_module(module.name)


def documented() -> set[tuple[str, str]]:
    """Module and name of everything in the API reference."""
    found = set()
    for page in PAGES:
        found |= set(SINGLE.findall(page.read_text(encoding="utf-8")))
        for module, members in DIRECTIVE.findall(page.read_text(encoding="utf-8")):
            chosen = [name.strip() for name in members.split(",") if name.strip()]
            for name in chosen or importlib.import_module(module).__all__:
                found.add((module, name))
    return found


def documented_value(module: str, name: str) -> object:
    """The documented object; its name if it does not exist."""
    return getattr(importlib.import_module(module), name, f"{module}.{name}")


DOCUMENTED = documented()


def test_api_reference_names_exist() -> None:
    missing = [pair for pair in DOCUMENTED if not hasattr(importlib.import_module(pair[0]), pair[1])]
    assert missing == []


def test_api_reference_documents_public_modules_only() -> None:
    public = {module.__name__ for module in public_modules()}
    assert {module for module, _ in DOCUMENTED} - public == set()


def test_public_name_is_documented_once() -> None:
    seen: dict[tuple[str, int], str] = {}
    for module, name in sorted(DOCUMENTED):
        value = documented_value(module, name)
        other = seen.setdefault((name, id(value)), module)
        assert other == module, f"{name} is documented under {other} and {module}"


@pytest.mark.parametrize(
    "module", sorted(public_modules(), key=lambda m: m.__name__), ids=lambda m: m.__name__
)
def test_public_names_are_in_api_reference(module: ModuleType) -> None:
    there = {(name, id(documented_value(home, name))) for home, name in DOCUMENTED}
    names = getattr(module, "__all__", [])
    assert [name for name in names if (name, id(getattr(module, name))) not in there] == []


@pytest.mark.parametrize("page", named(PAGES))
def test_python_references_are_in_api_reference(page: Path) -> None:
    wrong = []
    for _, target in ROLE.findall(page.read_text(encoding="utf-8")):
        parts = target.split(".")
        homes = [(".".join(parts[:i]), parts[i]) for i in range(1, len(parts))]
        if not any(home in DOCUMENTED for home in homes):
            wrong.append(target)
    assert wrong == []


# --- links --------------------------------------------------------------------------------------------


def slug(heading: str) -> str:
    """Anchor of a heading, as MyST and GitHub make it."""
    text = re.sub(r"`|\*|\$|\[([^\]]*)\]\([^)]*\)", r"\1", heading.strip().lower())
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def anchors(page: Path) -> set[str]:
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    labels = re.findall(r"^\(([\w-]+)\)=$", text, re.MULTILINE)
    return {slug(h) for h in re.findall(r"^#{1,3} +(.+)$", text, re.MULTILINE)} | set(labels)


def links(text: str) -> list[str]:
    return re.findall(r"\]\(<?([^)\s>]+)>?\)", re.sub(r"`[^`\n]*`", "", FENCE.sub("", text)))


@pytest.mark.parametrize("page", named(LINKED))
def test_internal_links_resolve(page: Path) -> None:
    broken = []
    for link in links(page.read_text(encoding="utf-8")):
        if re.match(r"[a-z]+:", link):
            continue
        file, _, anchor = link.partition("#")
        target = (page.parent / file).resolve() if file else page
        if not target.exists() or (anchor and target.suffix == ".md" and anchor not in anchors(target)):
            broken.append(link)
    assert broken == []


def test_link_check_finds_links_and_anchors(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# One thing\n[a](page.md#one-thing) [b](gone.md) [c](#two)\n", encoding="utf-8")
    assert links(page.read_text(encoding="utf-8")) == ["page.md#one-thing", "gone.md", "#two"]
    assert anchors(page) == {"one-thing"}


def test_pages_are_in_table_of_contents() -> None:
    listed = {DOCS / "index.md"}
    for page in PAGES:
        for body in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            entries = [line for line in body.split("\n") if line and not line.startswith(":")]
            listed |= {page.parent / f"{entry}.md" for entry in entries}
    assert set(PAGES) - listed == set()


ASKED = {
    "end of the route": "questions", "not overtake": "questions", "clock": "questions", "GPX": "questions",
    "SUMO": "adapters", "CARLA": "adapters", "CAN": "rig", "ROS 2": "rig", "installation": "quickstart",
    "own vehicle": "quickstart", "OpenDRIVE": "maps", "left-hand traffic": "questions",
}  # fmt: skip


@pytest.mark.parametrize(("words", "page"), ASKED.items())
def test_headings_hold_what_users_search(words: str, page: str) -> None:
    """The search of the site ranks headings first."""
    headings = re.findall(r"^#{1,3} +(.+)$", FENCE.sub("", (DOCS / f"{page}.md").read_text("utf-8")), re.M)
    assert [heading for heading in headings if words.lower() in heading.lower()]


# --- offline ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", named([*PAGES, *NOTEBOOKS]))
def test_page_loads_nothing_from_network(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert not re.search(r"<(script|link|img|iframe)[^>]+https?:", text, re.IGNORECASE)
    assert not re.search(r"!\[[^\]]*\]\(https?:|```\{(image|figure)\} https?:|@import", text)


def test_site_loads_nothing_from_network() -> None:
    """Sphinx would load MathJax and widgets, unless its options name local files."""
    tree = ast.parse((DOCS / "conf.py").read_text(encoding="utf-8"))
    texts = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    assert not [
        text for text in texts if isinstance(text, str) and text.startswith(("http:", "https:", "//"))
    ]
    given = {
        target.id: value
        for node in tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign)
        for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
        if isinstance(target, ast.Name) and (value := node.value) is not None
    }
    assert ast.literal_eval(given["mathjax_path"]) == "tex-svg.js"
    assert ast.literal_eval(given["nb_ipywidgets_js"]) == {}


def test_site_links_types_of_arguments() -> None:
    assert "numpydoc_xref_param_type = True" in (DOCS / "conf.py").read_text("utf-8")


# --- commands and code of the pages -------------------------------------------------------------------


def blocks(page: Path) -> str:
    return "\n".join(re.findall(r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S))


@pytest.mark.requires("matplotlib")
def test_quickstart_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = DOCS / "quickstart.md"
    (table,) = re.findall(r":caption: route\.csv\n\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "route.csv").write_text(table, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    done: dict[str, Any] = {}
    exec(compile(blocks(page), "quickstart.md", "exec"), done)
    assert done["band"].status.name == "OK"
    assert (tmp_path / "band.svg").read_text(encoding="utf-8").startswith("<svg")
    assert (tmp_path / "driven.png").stat().st_size > 1000
    assert done["d"].max() > 1.5  # the ego passed the van, and returned
    assert abs(done["d"][-1]) < 0.2
    assert done["command"].decision.action.name == "KEEP"
    assert "EVADE_LEFT" in capsys.readouterr().out
    gains = done["gains"]
    assert len(gains.speeds) == 3
    assert min(gains.k_p) > 0.0


@pytest.mark.requires("matplotlib", "mcap")
@pytest.mark.parametrize("name", ["own_scenario", "own_plant", "maps", "adapters"])
def test_page_is_a_program(name: str, tmp_path: Path) -> None:
    script = tmp_path / f"{name}.py"  # studies need the source in a file
    script.write_text(blocks(DOCS / f"{name}.md"), encoding="utf-8")
    result = subprocess.run(
        [sys.executable, script.name], cwd=tmp_path, capture_output=True, text=True, timeout=900
    )
    assert result.returncode == 0, result.stderr[-4000:]
    assert result.stdout


def test_code_of_steering_page_works_and_keeps_its_reasons(
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("matplotlib")
    done: dict[str, Any] = {}
    exec(compile(blocks(DOCS / "steering.md"), "steering.md", "exec"), done)
    assert done["figure"].axes[0].get_title(loc="left").startswith("20 m/s, ")
    region = "region=StabilityRegion(decay=0.47, damping=0.24) works at all speeds"
    assert capsys.readouterr().out.strip().endswith(region)
    slow = done["StabilityRegion"](delay=1.0)
    with pytest.raises(done["NoGainsError"], match=r"works up to 3 m/s"):
        done["gains_for"](done["van"], [10.0, 20.0], slow)
    assert done["gains_for"](done["van"], [2.0, 10.0], slow).speeds == (2.0,)


def test_readme_picture_matches_its_code(tmp_path: Path) -> None:
    """The first code block has five lines at most, and makes the picture that the page shows."""
    (first, *_) = re.findall(r"^```python\n(.*?)^```$", (ROOT / "README.md").read_text("utf-8"), re.M | re.S)
    lines = [line for line in first.splitlines() if line and not line.startswith("#")]
    done: dict[str, Any] = {}
    exec(compile(first, "README.md", "exec"), done)
    assert len(lines) <= 5
    assert done["band"].status.name == "OK"
    shown = (DOCS / "pictures" / "band.svg").read_text(encoding="utf-8")
    assert f"<title>{done['band']}</title>" in shown


def test_make_targets_on_pages_exist() -> None:
    targets = set(re.findall(r"^([a-z0-9]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    named_targets = set()
    for page in LINKED:
        named_targets |= set(
            re.findall(r"`make ([a-z0-9]+)`|^\$ make ([a-z0-9]+)", page.read_text("utf-8"), re.MULTILINE)
        )
    assert {name for pair in named_targets for name in pair if name} <= targets


def test_files_on_pages_exist() -> None:
    named = re.compile(r"\b((?:tests|examples|cca_core)/[\w/]+\.(?:py|ipynb))")
    pages = [page for page in PAGES if page.name != "validation.md"]  # it lists the files of its own commit
    found = {f"{page.name}: {f}" for page in pages for f in named.findall(page.read_text("utf-8"))}
    assert {entry for entry in found if not (ROOT / entry.partition(": ")[2]).exists()} == set()


def test_paper_map_is_complete() -> None:
    page = (DOCS / "paper.md").read_text(encoding="utf-8")
    equations, _, figures = page.partition("## Text")
    numbers = re.findall(r"^\| ([\d, -]+) \|", equations, re.MULTILINE)
    assert spread(numbers) == set(range(1, 12))
    assert spread(re.findall(r"^\| ([\d, -]+) \|", figures.partition("## Figures")[2], re.MULTILINE)) == set(
        range(1, 20)
    )
    assert "not yet" not in page.lower()


def spread(entries: list[str]) -> set[int]:
    found: set[int] = set()
    for part in ",".join(entries).split(","):
        first, _, last = part.strip().partition("-")
        found |= set(range(int(first), int(last or first) + 1))
    return found


def test_properties_page_lists_all_test_files() -> None:
    page = (DOCS / "properties.md").read_text(encoding="utf-8")
    files = [f for f in (ROOT / "tests").rglob("test_*.py") if "bench" not in f.parts]
    assert [f.relative_to(ROOT).as_posix() for f in files if f.relative_to(ROOT).as_posix() not in page] == []


def test_documented_names_have_docstrings() -> None:
    for module, name in DOCUMENTED:
        value = documented_value(module, name)
        if inspect.isfunction(value) or inspect.isclass(value):
            assert inspect.getdoc(value), f"{module}.{name}"


def test_performance_page_marks_missed_budgets(tmp_path: Path) -> None:
    report = tmp_path / "bench.xml"
    report.write_text(
        '<testsuites><testsuite><testcase classname="tests.bench.test_cycle_speed" name="test_steer"/>'
        '<testcase classname="tests.bench.test_cycle_speed" name="test_kernel">'
        '<properties><property name="budget" value="17 of 5 us"/></properties>'
        '<failure message="assert 6.123456 &lt;= 5.0"/></testcase>'
        '<testcase classname="tests.bench.test_decide_speed" name="test_choose_action[True]"><properties>'
        '<property name="us" value="4.7"/><property name="budget" value="4.7 of 20 us"/>'
        "</properties></testcase></testsuite></testsuites>",
        encoding="utf-8",
    )
    stats = {"median": 17.04e-6, "min": 0.00163}
    bench = {
        "machine_info": {"cpu": {"brand_raw": "A machine", "count": 2}, "python_version": "3.11"},
        "commit_info": {"id": "0123456789", "dirty": False},
        "datetime": "2026-01-02T03:04:05+00:00",
        "benchmarks": [
            {"fullname": f"tests/bench/test_cycle_speed.py::{name}", "stats": stats, "extra_info": {"gap": 3}}
            for name in ("test_steer", "test_kernel")
        ],
    }
    text = speed_page.page(bench, speed_page.read_outcomes(report))
    assert (
        "Measured on 2026-01-02: A machine, 2 cores, Python 3.11, commit 0123456. 1 of 2 budgets missed."
        in text
    )
    assert "| steer | 17 µs | 1.63 ms | gap 3 | - |" in text
    assert "| kernel | 17 µs | 1.63 ms | gap 3 | **missed**: 17 of 5 us |" in text
    assert "| choose action (True) | 4.7 µs |  |  | kept: 4.7 of 20 us |" in text

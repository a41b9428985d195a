"""Notebooks hold no output and valid links; `make docs` runs them."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def notebook(request: pytest.FixtureRequest) -> Path:
    return request.param


def cells(notebook: Path) -> list[dict[str, Any]]:
    return json.loads(notebook.read_text(encoding="utf-8"))["cells"]


def text(notebook: Path) -> str:
    return "\n".join("".join(cell["source"]) for cell in cells(notebook))


def test_notebooks_exist() -> None:
    assert NOTEBOOKS


def test_notebook_format_and_kernel(notebook: Path) -> None:
    content = json.loads(notebook.read_text(encoding="utf-8"))
    assert (content["nbformat"], content["nbformat_minor"]) == (4, 5)
    assert content["metadata"]["kernelspec"]["name"] == "python3"
    ids = [cell["id"] for cell in content["cells"]]
    assert len(set(ids)) == len(ids)


def test_notebook_stores_no_output(notebook: Path) -> None:
    code = [cell for cell in cells(notebook) if cell["cell_type"] == "code"]
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)


def test_notebook_has_one_parameter_cell(notebook: Path) -> None:
    everything = cells(notebook)
    starts = ["".join(cell["source"])[:20] for cell in everything]
    heads = [i for i, start in enumerate(starts) if start.startswith("## Values to change")]
    assert len(heads) == 1
    assert everything[heads[0] + 1]["cell_type"] == "code"


def test_notebook_begins_with_picture(notebook: Path) -> None:
    assert re.search(r"^# .+\n\n!\[.{20,}\]\(.+\.svg\)", "".join(cells(notebook)[0]["source"]))


def test_notebooks_begin_with_the_reader() -> None:
    assert [path.stem for path in NOTEBOOKS][:2] == ["1_your_own_road", "2_your_own_simulator"]


def test_notebook_figures_are_svg(notebook: Path) -> None:
    assert '%config InlineBackend.figure_formats = ["svg"]' in text(notebook)


def test_notebook_links_exist(notebook: Path) -> None:
    links = re.findall(r"\]\(([^)#\s]+)", text(notebook))
    missing = [link for link in links if "://" not in link and not (notebook.parent / link).exists()]
    assert not missing


def test_examples_page_lists_all_scripts() -> None:
    page = (ROOT / "docs" / "notebooks.md").read_text(encoding="utf-8")
    scripts = {path.name for path in (ROOT / "examples").glob("*.py")}
    assert set(re.findall(r"^\| `(\w+\.py)`", page, flags=re.M)) == scripts

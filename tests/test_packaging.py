"""Metadata of the package; `tests/build_packages.py` builds and installs it."""

import re
import tomllib
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

import pytest

import cca_core

ROOT = Path(__file__).resolve().parents[1]
WHOLE = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = WHOLE["project"]
EXTRAS = PROJECT["optional-dependencies"]


def test_version_is_the_same_everywhere() -> None:
    cited = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert cited is not None
    assert {version("cca-planner"), cited[1]} == {cca_core.__version__}


def test_version_is_in_changelog() -> None:
    assert f"## [{cca_core.__version__}]" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_conda_recipe_agrees_with_project() -> None:
    recipe = (ROOT / "conda" / "meta.yaml").read_text(encoding="utf-8")
    listed = set(re.findall(r"^    - (\w+ ?>=.+)$", recipe, re.MULTILINE))
    wanted = [
        f"python{PROJECT['requires-python']}",
        *PROJECT["dependencies"],
        *WHOLE["build-system"]["requires"],
    ]
    assert {name.replace(" ", "") for name in listed} == set(wanted)
    assert f'set version = "{cca_core.__version__}"' in recipe
    (command,) = PROJECT["scripts"].items()
    assert f"    - {' = '.join(command)}\n" in recipe


def test_package_is_marked_as_typed() -> None:
    assert files(cca_core).joinpath("py.typed").is_file()
    assert "Typing :: Typed" in PROJECT["classifiers"]


def test_core_requires_numpy_and_scipy() -> None:
    assert [re.sub(r">=\d+(\.\d+)+$", "", requirement) for requirement in PROJECT["dependencies"]] == [
        "numpy",
        "scipy",
    ]


def test_extra_all_has_every_extra() -> None:
    (everything,) = EXTRAS["all"]
    named = re.fullmatch(r"cca-planner\[(.+)\]", everything)
    assert named is not None
    assert set(named[1].split(",")) == EXTRAS.keys() - {"all"}


@pytest.mark.parametrize("extra", sorted(EXTRAS))
def test_extra_is_on_quickstart_page(extra: str) -> None:
    assert f"| `{extra}` |" in (ROOT / "docs" / "quickstart.md").read_text(encoding="utf-8")


def test_required_extras_exist() -> None:
    named = set()
    for file in (ROOT / "cca_core").rglob("*.py"):
        named |= set(re.findall(r'require_extra\([^()]+, "(\w+)"\)', file.read_text(encoding="utf-8")))
    assert named
    assert named <= EXTRAS.keys()


def test_oldest_python_is_first_classifier() -> None:
    listed = [re.search(r":: (3\.\d+)$", each) for each in PROJECT["classifiers"]]
    assert PROJECT["requires-python"] == f">={next(found[1] for found in listed if found)}"


def test_sdist_files_exist() -> None:
    for name in WHOLE["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]:
        assert (ROOT / name.removeprefix("/")).exists(), name
    assert [(ROOT / name).is_file() for name in (*PROJECT["license-files"], PROJECT["readme"])] == [
        True,
        True,
    ]

"""The core needs only NumPy and SciPy, and imports few modules."""

import subprocess
import sys

import pytest

CORE = [
    "geometry",
    "vehicle",
    "serial",
    "predict",
    "path",
    "band",
    "follow",
    "decide",
    "warnings",
    "planner",
    "v2x",
    "sim",
]

BLOCK_THIRD_PARTIES = """
import sys

allowed = sys.stdlib_module_names | {"cca_core", "numpy", "scipy"}


class Blocker:
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top not in allowed and not top.startswith("_sysconfigdata"):
            raise ModuleNotFoundError(f"{name} is not a core dependency", name=name)


sys.meta_path.insert(0, Blocker())
"""

NEW_MODULES = """
import sys

import numpy

before = set(sys.modules)
import {module}

print(*sorted(name for name in set(sys.modules) - before if sys.modules[name].__spec__ is not None))
"""


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)


def test_core_imports_with_numpy_and_scipy_alone() -> None:
    imports = "\n".join(f"import cca_core.{package}" for package in CORE)
    result = run(f"{BLOCK_THIRD_PARTIES}\nimport cca_core\n{imports}")
    assert result.returncode == 0, result.stderr


def test_blocker_refuses_third_parties() -> None:
    result = run(f"{BLOCK_THIRD_PARTIES}\nimport pytest")
    assert "pytest is not a core dependency" in result.stderr


@pytest.mark.parametrize(("module", "limit"), [("cca_core", 50), ("cca_core.sim", 120)])
def test_import_loads_no_scipy_and_few_modules(module: str, limit: int) -> None:
    """Functions import SciPy, which takes a second, when they need it; `make bench` times the import."""
    result = run(NEW_MODULES.format(module=module))
    assert result.returncode == 0, result.stderr
    loaded = result.stdout.split()
    assert [
        name for name in loaded if name.split(".")[0] not in {*sys.stdlib_module_names, "cca_core", "numpy"}
    ] == []
    assert len([name for name in loaded if name.split(".")[0] != "cca_core"]) < limit


@pytest.mark.parametrize("package", ["plot", "report", "baselines"])
def test_upper_packages_are_not_loaded_with_the_core(package: str) -> None:
    assert f"cca_core.{package}" not in run(NEW_MODULES.format(module="cca_core")).stdout.split()

"""The core needs NumPy and SciPy alone, and imports fast."""

import subprocess
import sys

import pytest

CORE = ["path", "band", "follow", "decide", "planner", "sim"]

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

TIME_THE_IMPORT = """
from time import perf_counter

start = perf_counter()
import cca_core

print(perf_counter() - start)
"""


def run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("module", ["cca_core", *(f"cca_core.{room}" for room in CORE)])
def test_core_imports_with_numpy_and_scipy_alone(module: str) -> None:
    result = run(f"{BLOCK_THIRD_PARTIES}\nimport {module}")
    assert result.returncode == 0, result.stderr


def test_the_blocker_blocks() -> None:
    result = run(f"{BLOCK_THIRD_PARTIES}\nimport pytest")
    assert "pytest is not a core dependency" in result.stderr


def test_import_takes_less_than_400_ms() -> None:
    results = [run(TIME_THE_IMPORT) for _ in range(5)]
    assert all(result.returncode == 0 for result in results), results[0].stderr
    assert min(float(result.stdout) for result in results) < 0.4

"""Every example runs as a script, in an empty folder."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

NEEDED = {"drive_in_sumo": "libsumo", "drive_in_highway_env": "highway_env"}
LESS = {"paper_scenarios": ["--only", "eebl"], "run_a_study": ["--runs", "2"]}  # of a minute and more
EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.stem)
def test_example_runs(script: Path, tmp_path: Path) -> None:
    check_example(script, LESS.get(script.stem, []), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", LESS)
def test_long_example_runs_in_full(name: str, tmp_path: Path) -> None:
    check_example(next(script for script in EXAMPLES if script.stem == name), [], tmp_path)


def check_example(script: Path, arguments: list[str], tmp_path: Path) -> None:
    """Run an example as a program; it must end well and write what it says."""
    needed = NEEDED.get(script.stem, "numpy")
    if find_spec(needed) is None:
        pytest.skip(f"needs {needed}")
    out = tmp_path / "out"
    writes = "--out" in script.read_text(encoding="utf-8")
    command = [sys.executable, str(script), *arguments, *(["--out", str(out)] if writes else [])]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=900)
    assert result.returncode == 0, result.stdout[-2000:] + result.stderr[-4000:]
    assert not writes or any(out.iterdir())

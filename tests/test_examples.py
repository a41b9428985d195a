"""Every example runs as a script, in an empty folder."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

NEEDED = {"drive_in_sumo": "libsumo", "drive_in_highway_env": "highway_env"}
EXAMPLES = sorted((Path(__file__).resolve().parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.stem)
def test_example_runs(script: Path, tmp_path: Path) -> None:
    needed = NEEDED.get(script.stem, "numpy")
    if find_spec(needed) is None:
        pytest.skip(f"needs {needed}")
    out = tmp_path / "out"
    writes = "--out" in script.read_text(encoding="utf-8")
    command = [sys.executable, str(script), *(["--out", str(out)] if writes else [])]
    result = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=900)
    assert result.returncode == 0, result.stdout[-2000:] + result.stderr[-4000:]
    assert not writes or any(out.iterdir())

"""The page about the kernel: its program in C runs."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.trial_compiler import COMPILER, KERNEL, NO_COMPILER

PAGE = Path(__file__).resolve().parents[2] / "docs" / "kernel.md"


@pytest.mark.skipif(bool(NO_COMPILER) or not PAGE.exists(), reason=NO_COMPILER or "there is no page")
def test_program_in_c_prints_what_the_page_shows(tmp_path: Path) -> None:
    text = PAGE.read_text(encoding="utf-8")
    (program,) = re.findall(r"```c\n(.*?)```", text, re.DOTALL)
    ((command, output),) = re.findall(r"\$ (cc .*?) && \./drive\n(.*?)```", text, re.DOTALL)
    (tmp_path / "drive.c").write_text(program, encoding="utf-8")
    shutil.copytree(KERNEL / "c", tmp_path / "cca_core" / "kernel" / "c")
    subprocess.run([str(COMPILER), *command.split()[1:], "-O0"], cwd=tmp_path, check=True)
    done = subprocess.run([str(tmp_path / "drive")], capture_output=True, text=True, check=True)
    assert done.stdout == output

"""Which form of the kernel is in use: the choice is never silent."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import cca_core
from cca_core import kernel
from cca_core.kernel import backend, backend_reason, bind
from cca_core.kernel.box_gaps import oriented_box_gap
from cca_core.kernel.digests import digest
from tests.support.trial_compiler import NO_COMPILER

ASK = "from cca_core import kernel; print(kernel.backend(), kernel.backend_reason(), sep=': ')"


def ask(wish: str, before: str = "", at: Path | None = None) -> str:
    """Return what a new process answers, or its error, with the library that is at a path."""
    command = [sys.executable, "-c", before + ASK]
    env = os.environ | {"CCA_KERNEL": wish} | ({} if at is None else {"PYTHONPATH": str(at)})
    done = subprocess.run(command, env=env, cwd=at, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


def test_c_is_in_use_where_there_is_a_compiler() -> None:
    if os.environ.get("CCA_KERNEL") == "python":
        pytest.skip("CCA_KERNEL is python")
    if NO_COMPILER:
        pytest.skip(NO_COMPILER)
    assert backend() == "c", f"{backend_reason()}; run `make kernel`"


def test_environment_chooses_python() -> None:
    assert ask("python") == "python: CCA_KERNEL is python\n"


def test_environment_of_another_value_raises() -> None:
    assert "ValueError: CCA_KERNEL must be c or python, was 'fortran'" in ask("fortran")


def test_missing_module_has_a_reason() -> None:
    hide = "import sys; sys.modules['cca_core.kernel._compiled'] = None; "
    assert ask("", hide).startswith("python: the kernel is not compiled")
    assert "ImportError: CCA_KERNEL is c, but the kernel is not compiled" in ask("c", hide)


def test_module_of_other_sources_is_not_used() -> None:
    old = "import sys, types; old = types.ModuleType('_compiled'); old.digest = ''; "
    old += "sys.modules['cca_core.kernel._compiled'] = old; "
    assert ask("", old).startswith("python: the kernel has been changed since it was compiled")
    assert "run `make kernel`" in ask("c", old)


@pytest.mark.parametrize(
    "edited",
    [
        "kernel/speed.py", "kernel/types.py", "kernel/c/kernel.c", "kernel/c/kernel.h", "kernel/c/python.c",
        "kernel/c/lend.h", "codegen/expressions.py", "codegen/build.py",
    ],
)  # fmt: skip
def test_module_is_not_used_after_edit(edited: str, tmp_path: Path) -> None:
    """An edit by hand, of any file that the compiled module has been made from."""
    if kernel.COMPILED is None:
        pytest.skip("there is no compiled module")
    copy = tmp_path / "cca_core"
    shutil.copytree(Path(cca_core.__file__).parent, copy, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(str(kernel.COMPILED.__file__), copy / "kernel")
    assert ask("", at=tmp_path) == "c: the kernel is compiled\n"
    with (copy / edited).open("a", encoding="utf-8") as file:
        file.write("\n")
    assert ask("", at=tmp_path).startswith("python: the kernel has been changed since it was compiled")


def test_digest_ignores_line_ends(tmp_path: Path) -> None:
    for ends in (b"\n", b"\r\n"):
        (tmp_path / ends.hex()).mkdir()
        (tmp_path / ends.hex() / "case.py").write_bytes(b"A = 1" + ends)
    assert digest(tmp_path / "0a") == digest(tmp_path / "0d0a")


def test_c_without_a_module_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel, "COMPILED", None)
    with pytest.raises(ValueError, match="form must be python, was c"):
        bind(oriented_box_gap, "c")


def test_kernel_that_is_not_compiled_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel, "COMPILED", ModuleType("empty"))
    with pytest.raises(AttributeError, match="oriented_box_gap"):
        bind(oriented_box_gap)

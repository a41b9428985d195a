"""Kernels that are compiled for a test, by any compiler with any flags."""

import os
import shutil
import subprocess
import sysconfig
from pathlib import Path
from types import ModuleType

from cca_core.codegen import translate
from cca_core.codegen.build import KERNEL, UNIX
from cca_core.kernel.digests import c_digest
from tests.support.load_module import load

TRIAL = Path(__file__).parent / "trial_kernel"
COMPILER = shutil.which((sysconfig.get_config_var("CC") or "cc").split()[0]) if os.name == "posix" else None
HEADERS = Path(sysconfig.get_path("include")) / "Python.h"
NO_COMPILER = "" if COMPILER and HEADERS.exists() else "there is no C compiler, or no Python.h"


def compile_to(folder: Path, sources: Path, *flags: str, compiler: str = "") -> Path:
    """Compile the C in a folder to a module of Python in another; the last flags win."""
    target = folder / f"_compiled{sysconfig.get_config_var('SHLIB_SUFFIX')}"
    command = [compiler or str(COMPILER), "-shared", "-fPIC", f"-I{HEADERS.parent}", *UNIX, *flags]
    command.append(f"-DCCA_C_DIGEST={c_digest(sources)}")
    command += [str(sources / "python.c"), str(sources / "kernel.c"), "-lm", "-o", str(target)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    return target


def compile_trial(folder: Path) -> ModuleType:
    """Translate, compile and load the trial kernels."""
    for name, text in translate(TRIAL).items():
        (folder / name).write_text(text, encoding="utf-8")
    shutil.copy(KERNEL / "c" / "lend.h", folder)
    return load(compile_to(folder, folder, "-Wall", "-Wextra", "-Werror", "-Wconversion"))

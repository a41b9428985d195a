"""Compile the kernel's C to a module in the folder of its Python. Needs setuptools and a compiler."""

import os
import runpy
import sys
import tempfile
from pathlib import Path

KERNEL = Path(__file__).resolve().parents[1] / "kernel"
# no contraction of products and sums: the same bits as in Python; errno is not read
UNIX = ["-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-g0"]
WINDOWS = ["/O2", "/fp:precise"]


def compile_kernel(folder: Path = KERNEL, target: Path = KERNEL) -> Path:
    """Compile the C in a folder to a module of Python in another; return its file."""
    from setuptools import Distribution, Extension
    from setuptools.command.build_ext import build_ext

    c_digest = runpy.run_path(str(KERNEL / "digests.py"))["c_digest"]
    flags = WINDOWS if os.name == "nt" else UNIX
    extension = Extension(
        "_compiled",
        [str(folder / "c" / name) for name in ("python.c", "kernel.c")],
        extra_compile_args=flags + os.environ.get("CFLAGS", "").split(),  # the last one wins
        define_macros=[("CCA_C_DIGEST", c_digest(folder / "c"))],
        py_limited_api=True,
    )
    command = build_ext(Distribution({"ext_modules": [extension]}))
    with tempfile.TemporaryDirectory(dir=target) as scratch:
        command.build_lib = command.build_temp = scratch
        command.ensure_finalized()
        command.run()
        (made,) = (Path(scratch) / name for name in os.listdir(scratch) if name.startswith("_compiled"))
        # a process that has the old one loaded keeps it
        return made.replace(target / made.name)


if __name__ == "__main__":
    try:
        sys.stdout.write(f"compiled {compile_kernel()}\n")
    except Exception as error:  # setuptools has no common class of what compilers do wrong
        sys.exit(f"the kernel is not compiled: {error}")

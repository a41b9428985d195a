"""The C of the kernel by other compilers: no warnings, the same bits, defined behavior, a small stack."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.trial_compiler import KERNEL, NO_COMPILER, UNIX, compile_to

ROOT = Path(__file__).resolve().parents[2]
SOURCES = KERNEL / "c"
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wdouble-promotion", "-Werror"]
# all of libm that the kernel may call; sin and cos of one angle may become one call, a loop that clears a row
# that of memset
SYMBOLS = set(
    "sqrt sin cos sincos tan asin acos atan atan2 exp log pow fmod remainder floor copysign memset".split()
)
MAX_STACK = 4096  # [B]
SANITIZERS = "-fsanitize=address,undefined,float-divide-by-zero"

pytestmark = pytest.mark.skipif(bool(NO_COMPILER), reason=NO_COMPILER or "-")


def tool(name: str) -> str:
    """Return a program, or skip the test."""
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"there is no {name}")
    return found


def run(*command: str | Path, **variables: str) -> str:
    """Return the output of a command that must succeed."""
    env = os.environ | variables
    done = subprocess.run(
        command, env=env, cwd=ROOT, capture_output=True, text=True, check=False, timeout=10800
    )
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]
    return done.stdout


def run_tests(file: Path, *selected: str, **variables: str) -> None:
    """Run tests with another compiled kernel."""
    command = [sys.executable, "-m", "pytest", "-q", "-s", "-n0", "-p", "no:cacheprovider"]
    command += ["-p", "tests.support.other_kernel", f"--ignore={__file__}", *selected]
    env = {"CCA_KERNEL_FILE": str(file), "CCA_KERNEL": "c", "PYTHONPATH": str(ROOT)}
    output = run(*command, **env, **variables)
    assert f"compiled kernel: {file}" in output
    assert re.search(r"\d+ passed", output)


@pytest.fixture(scope="module")
def gcc_object(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Compile the C by gcc, with its warnings as errors; the stack of each function is in a file beside."""
    file = tmp_path_factory.mktemp("gcc") / "kernel.o"
    run(tool("gcc"), *UNIX, *WARNINGS, "-fstack-usage", "-c", SOURCES / "kernel.c", "-o", file)
    return file


def test_gcc_has_no_warnings(gcc_object: Path) -> None:
    assert gcc_object.exists()


def test_clang_has_no_warnings() -> None:
    run(tool("clang"), *UNIX, *WARNINGS, "-fsyntax-only", SOURCES / "kernel.c")


def test_stack_is_small(gcc_object: Path) -> None:
    assert 0 < deepest_stack(gcc_object.with_suffix(".su")) < MAX_STACK


@pytest.mark.slow
def test_stack_is_small_with_inlining(tmp_path: Path) -> None:
    file = tmp_path / "kernel.o"
    run(tool("gcc"), *UNIX, "-O3", "-fstack-usage", "-c", SOURCES / "kernel.c", "-o", file)
    assert 0 < deepest_stack(file.with_suffix(".su")) < MAX_STACK


def test_kernel_calls_libm_alone(gcc_object: Path) -> None:
    symbols = set(run(tool("nm"), "-u", "--format=posix", gcc_object).split()) - {"U"}
    assert symbols - {"_GLOBAL_OFFSET_TABLE_"} <= SYMBOLS


def deepest_stack(usage: Path) -> int:
    """Return the stack of the deepest chain of calls [B]."""
    rows = [line.split("\t") for line in usage.read_text(encoding="utf-8").splitlines()]
    assert {kind for _, _, kind in rows} <= {"static", "dynamic,bounded"}
    frames = {spot.rpartition(":")[2].partition(".")[0]: int(size) for spot, size, _ in rows}
    return max(stack_of(name, frames, calls()) for name in frames)


def calls() -> dict[str, set[str]]:
    """Return which functions each function of the kernel names."""
    text = (SOURCES / "kernel.c").read_text(encoding="utf-8")
    functions = re.findall(
        r"^[a-z]\w+(?: \w+)* \*?(\w+)\([^{;]*\)\n\{\n(.*?)^\}", text, re.MULTILINE | re.DOTALL
    )
    names = {name for name, _ in functions}
    return {name: names & set(re.findall(r"\w+", body)) for name, body in functions}


def stack_of(name: str, frames: dict[str, int], called: dict[str, set[str]]) -> int:
    """Return the stack of a function and of the deepest that it calls [B]."""
    return frames.get(name, 0) + max((stack_of(each, frames, called) for each in called[name]), default=0)


def test_cppcheck_finds_nothing() -> None:
    checks = "--enable=warning,performance,portability"
    run(tool("cppcheck"), "--std=c99", checks, "--error-exitcode=1", "--quiet", SOURCES / "kernel.c")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("compiler", "flags"),
    [
        ("gcc", ["-O3"]),
        ("gcc", ["-O3", "-march=native"]),
        ("gcc", ["-O0"]),
        ("clang", ["-O2"]),
        ("clang", ["-O3", "-march=native"]),
    ],
)
def test_other_compilers_give_the_same_bits(compiler: str, flags: list[str], tmp_path: Path) -> None:
    file = compile_to(tmp_path, SOURCES, *flags, compiler=tool(compiler))
    run_tests(file, "-m", "skipif and not slow", "tests/kernel")  # those that compare with Python


@pytest.mark.slow
def test_sanitizers_find_nothing(tmp_path: Path) -> None:
    gcc = tool("gcc")
    runtime = run(gcc, "-print-file-name=libasan.so").strip()
    if not Path(runtime).is_absolute():
        pytest.skip("there is no libasan")
    flags = [SANITIZERS, "-fno-sanitize-recover=all", "-O1", "-g"]
    file = compile_to(tmp_path, SOURCES, *flags, compiler=gcc)
    # Python itself keeps memory until its end
    variables = {"LD_PRELOAD": runtime, "ASAN_OPTIONS": "detect_leaks=0"}
    run_tests(file, "tests/kernel", "tests/band", **variables)

"""The C project of the steering law: warnings, sanitizers, and every recorded step bit for bit."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from cca_core import InputError, VehicleParams, fit_path
from cca_core.fmi import export_c

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
X = np.linspace(0.0, 800.0, 161)
PATH = fit_path(np.column_stack((X, 10.0 * np.sin(X / 60.0))))
SOURCES = ["kernel.c", "model.c", "harness.c"]
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]


def build(folder: Path, *flags: str, compiler: str = "cc") -> Path:
    command = [compiler, "-std=c99", "-ffp-contract=off", *flags, *SOURCES, "-o", "harness", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder / "harness"


def run(folder: Path, *prefix: str) -> str:
    done = subprocess.run(
        [*prefix, str(folder / "harness"), "cases.txt"], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("vehicle", ["bmw_320i", "ford_escort"])
def test_recorded_steps_are_bitwise_identical(tmp_path: Path, vehicle: str) -> None:
    export_c(tmp_path, getattr(VehicleParams, vehicle)(), PATH, delay=0.05)
    build(tmp_path, "-O2", *WARNINGS)
    assert run(tmp_path).startswith("2000 of 2000 equal")


@pytest.mark.slow
def test_100_000_steps_are_bitwise_identical(tmp_path: Path) -> None:
    export_c(tmp_path, VehicleParams.vw_vanagon(), PATH, cases=100_000, seed=2)
    build(tmp_path, "-O2")
    assert run(tmp_path).startswith("100000 of 100000 equal")


def test_sanitizers_find_nothing(tmp_path: Path) -> None:
    export_c(tmp_path, VehicleParams.bmw_320i(), PATH, cases=500)
    build(tmp_path, "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    assert "500 of 500 equal" in run(tmp_path)


def test_wrong_output_is_found(tmp_path: Path) -> None:
    export_c(tmp_path, VehicleParams.bmw_320i(), PATH, cases=50)
    build(tmp_path, "-O2")
    cases = (tmp_path / "cases.txt").read_text(encoding="utf-8").splitlines()
    cases[20] = cases[20].rsplit(" ", 1)[0] + " 0x1.0p-3"
    (tmp_path / "cases.txt").write_text("\n".join(cases), encoding="utf-8")
    done = subprocess.run(
        [str(tmp_path / "harness"), "cases.txt"], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 1
    assert done.stdout.startswith("49 of 50 equal")


def test_code_allocates_nothing(tmp_path: Path) -> None:
    export_c(tmp_path, VehicleParams.bmw_320i(), PATH, cases=1)
    for name in ("kernel.c", "model.c"):
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert not re.search(r"\b(malloc|calloc|realloc|free)\s*\(", text)


def test_cross_build_for_arm_is_bitwise_identical(tmp_path: Path) -> None:
    compiler, emulator = (
        "aarch64-linux-gnu-gcc",
        shutil.which("qemu-aarch64") or shutil.which("qemu-aarch64-static"),
    )
    if shutil.which(compiler) is None or emulator is None:
        pytest.skip("needs aarch64-linux-gnu-gcc and qemu-user")
    export_c(tmp_path, VehicleParams.bmw_320i(), PATH, cases=500)
    build(tmp_path, "-O2", "-static", compiler=compiler)
    assert "500 of 500 equal" in run(tmp_path, emulator)


@pytest.mark.skipif(shutil.which("cmake") is None, reason="needs cmake")
def test_cmake_builds_and_tests(tmp_path: Path) -> None:
    export_c(tmp_path, VehicleParams.bmw_320i(), PATH, cases=50)
    for command in (["cmake", "-S", ".", "-B", "build"], ["cmake", "--build", "build"]):
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    subprocess.run(["ctest", "--test-dir", "build"], cwd=tmp_path, check=True, capture_output=True)


@pytest.mark.parametrize(("name", "value"), [("cases", 0), ("delay", -1.0), ("a_y_max", 0.0)])
def test_wrong_arguments_raise(tmp_path: Path, name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        export_c(tmp_path, VehicleParams.bmw_320i(), PATH, **{name: value})

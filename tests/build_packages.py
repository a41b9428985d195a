"""Build the distributions, check their contents and use them in clean environments. Called by `make package`.

`python tests/build_packages.py all` also installs every extra (1.5 GB) and runs an example of them.
"""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import tomllib
import venv
import zipfile
from email.parser import Parser
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
SOURCE = (ROOT / "cca_core" / "__init__.py").read_text(encoding="utf-8")
(VERSION,) = re.findall(r'^__version__ = "(.+)"$', SOURCE, re.MULTILINE)
NAME = f"cca_planner-{VERSION}"
TOOLS = ("pytest", "hypothesis", "shapely", "pymap3d", "asn1tools")
# these read the sources or need every extra; all other tests run with the wheel and TOOLS, or are skipped
EXCLUDED = [f"tests/test_{name}.py" for name in ("docs", "docstrings", "examples", "packaging", "vocabulary")]
EXCLUDED += ["tests/test_repr.py", "tests/plot/test_legibility.py"]  # these import what extras install
# a batch of bands equals single bands bitwise only with the BLAS of SciPy 1.13 and newer, before to 1e-12 m
NOT_OLDEST = "tests/band/test_batch.py::test_obstacles_and_edges_broadcast"
IMPORT = "from time import perf_counter as now; t = now(); import cca_core; print(now() - t)"
BACKEND = "from cca_core import kernel; print(kernel.backend(), kernel.backend_reason(), sep=': ')"
NO_COMPILER = "there-is-no-compiler"
EXTRA = """
from cca_core import VehicleParams, relax_band, smooth_band

smooth_band(relax_band([(x, 0.0) for x in range(50)], vehicle=VehicleParams.bmw_320i()))
"""
CONSUMER = """
from collections.abc import Sequence

import numpy as np

from cca_core import Band, Command, Lane, LocalFrame, Path, Planner, RemoteVehicle, Road, Status
from cca_core import VehicleParams, VehicleState, fit_path, relax_band
from cca_core.serial import from_dict, to_dict


def drive(lat: Sequence[float], lon: Sequence[float], others: Sequence[RemoteVehicle]) -> Command:
    path: Path = fit_path(LocalFrame(lat[0], lon[0]).to_local(lat, lon), tolerance=0.3)
    road = Road(path, lanes=[Lane(d=0.0), from_dict(Lane, {"d": 3.5})], speed_limit=25.0)
    planner = Planner(VehicleParams.bmw_320i(), road, cruise_speed=20.0)
    command = planner.step(0.0, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0), others)
    band: Band = relax_band(path.sample(2.0), vehicle=planner.vehicle)
    total: float = command.delta + command.a_x + float(np.sum(band.nodes))
    data: dict[str, object] = to_dict(command.decision)
    assert command.status is Status.OK and data and total
    return command
"""
MISUSE = """
from cca_core import Lane, Planner

Lane(d="left")
Planner().step(0.0)
"""


def main() -> None:
    """Check everything; the first failure ends it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        builder = environment(folder / "builder", "build")
        run(builder, "-m", "build", "--outdir", folder, ROOT)
        (wheel,), sdist = folder.glob(f"{NAME}-*.whl"), folder / f"{NAME}.tar.gz"
        run(builder, "-m", "build", "--wheel", "--outdir", folder, sdist, CC=NO_COMPILER)
        pure = folder / f"{NAME}-py3-none-any.whl"
        has_compiler = wheel != pure
        expect(
            has_compiler == (shutil.which("cc") is not None),
            f"{wheel.name} in spite of the compiler, or none",
        )
        expect(not has_compiler or wheel.name.startswith(f"{NAME}-cp311-abi3-"), f"the wheel is {wheel.name}")
        for each in {wheel, pure}:
            check_wheel(each, is_pure=each == pure)
        source = check_sdist(sdist, folder)
        use_core(wheel, folder, source, "c" if has_compiler else "python")
        check_types(wheel, folder)
        check_editable(sdist, folder, has_compiler)
        if sys.version_info[:2] == (3, 11):  # newer ones need newer versions of the dependencies
            floor = (requirement.replace(">=", "==") for requirement in PROJECT["dependencies"])
            run_tests("oldest", pure, folder, source, *floor, backend="python")
        run_tests("newest", wheel, folder, source, backend="c" if has_compiler else "python")
        if "all" in sys.argv[1:]:
            use_all(wheel, folder, source)


def check_wheel(wheel: Path, is_pure: bool) -> None:
    """Check that the wheel holds the package with its data files, its license and nothing else."""
    with zipfile.ZipFile(wheel) as file:
        names = set(file.namelist())
        metadata = Parser().parsestr(file.read(f"{NAME}.dist-info/METADATA").decode())
    own = {name for name in names if not name.startswith(f"{NAME}.dist-info/")}
    compiled = {name for name in own if name.startswith("cca_core/kernel/_compiled")}
    expect(len(compiled) == (0 if is_pure else 1), f"compiled kernel in {wheel.name}: {compiled}")
    files = {path.relative_to(ROOT).as_posix() for path in (ROOT / "cca_core").rglob("*") if path.is_file()}
    files = {name for name in files if "__pycache__" not in name and "/_compiled" not in name}
    expect(own - compiled == files, f"wheel differs: {own ^ files}")
    kinds = {Path(name).suffix for name in own}
    expect({".html", ".css", ".js"} <= kinds, f"pages of the report are missing, there are {kinds}")
    expect("cca_core/py.typed" in own, "py.typed is missing")
    expect(f"{NAME}.dist-info/licenses/LICENSE" in names, "the license is missing")
    expect(metadata["License-Expression"] == "Apache-2.0", "no license expression")
    expect(metadata["Requires-Python"] == PROJECT["requires-python"], "another Python")
    expect(len(metadata.get_payload()) > 1000, "no readme")
    print(f"{wheel.name}: {wheel.stat().st_size / 1e3:.0f} kB, {len(own)} files")


def check_sdist(sdist: Path, folder: Path) -> Path:
    """Check that the sdist holds a packager's needs; return it unpacked, without the package itself."""
    with tarfile.open(sdist) as file:
        names = {name.removeprefix(f"{NAME}/") for name in file.getnames()}
        file.extractall(folder, filter="data")
    for name in (
        "pyproject.toml",
        "README.md",
        "LICENSE",
        "CITATION.cff",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "Makefile",
        "build_kernel.py",
        "cca_core/py.typed",
        "tests/conftest.py",
        "docs/conf.py",
        "examples/deform_a_band.py",
    ):
        expect(name in names, f"{name} is not in the sdist")
    unwanted = {
        name for name in names if re.search(r"__pycache__|_compiled|\.pyc$|_build/|^out/|\.hypothesis", name)
    }
    expect(not unwanted, f"the sdist holds {unwanted}")
    print(f"sdist: {sdist.stat().st_size / 1e3:.0f} kB, {len(names)} files")
    source = folder / NAME
    (source / "cca_core").rename(folder / "not_to_be_imported")
    return source


def use_core(wheel: Path, folder: Path, source: Path, backend: str) -> None:
    """Install without extras, run an example, measure time and size."""
    python = environment(folder / "core", wheel)
    found = run(python, "-c", BACKEND).strip()
    expect(found.partition(":")[0] == backend, f"the kernel runs in {found}")
    expect(run(python, "-c", BACKEND, CCA_KERNEL="python").startswith("python:"), "CCA_KERNEL has no effect")
    listed = run(python, "-m", "pip", "list", "--format=freeze").split()
    names = {line.partition("==")[0].replace("_", "-") for line in listed} - {"pip", "setuptools"}
    expect(names == {"cca-planner", "numpy", "scipy"}, f"the core installs {names}")
    print(run(python, source / "examples" / "deform_a_band.py", cwd=folder).splitlines()[-1])
    output = run(python, "-c", EXTRA, fails=True)
    expect("pip install 'cca-planner[qp]'" in output, f"the extra is not named: {output}")
    times = [float(run(python, "-c", IMPORT)) for _ in range(7)]
    numpy_times = [float(run(python, "-c", IMPORT.replace("cca_core", "numpy"))) for _ in range(7)]
    print(f"import: {min(times):.3f} s, of which NumPy {min(numpy_times):.3f} s")
    expect(min(times) < 0.4, "the import is slow")
    print(f"installed: {size(python, 'cca_core'):.1f} MB, with NumPy and SciPy {size(python):.0f} MB")


def use_all(wheel: Path, folder: Path, source: Path) -> None:
    """Install every extra and run an example of them."""
    python = environment(folder / "all", f"{wheel}[all]")
    run(python, source / "examples" / "design_gains.py", cwd=folder)
    run(python, "-c", "import casadi, control, matplotlib, ompl, osqp, piqp, qpsolvers, tqdm, vehiclemodels")
    print(f"installed with all extras: {size(python):.0f} MB")


def check_editable(sdist: Path, folder: Path, has_compiler: bool) -> None:
    """Check that an editable install compiles in place, and works without a compiler."""
    for name, compiler, backend in (("here", "cc", "c"), ("none", NO_COMPILER, "python")):
        if name == "here" and not has_compiler:
            continue
        with tarfile.open(sdist) as file:
            file.extractall(folder / f"editable_{name}", filter="data")
        checkout = folder / f"editable_{name}" / NAME
        python = environment(folder / f"environment_{name}")
        run(python, "-m", "pip", "install", "--quiet", "--editable", checkout, CC=compiler)
        found = run(python, "-c", BACKEND).strip()
        expect(found.partition(":")[0] == backend, f"the kernel of an editable install runs in {found}")
    print("editable: compiles in place, works without a compiler")


def check_types(wheel: Path, folder: Path) -> None:
    """Run a type checker on a program that uses the library, and on one that misuses it."""
    python = environment(folder / "types", wheel, "mypy")
    for name, text in (("consumer", CONSUMER), ("misuse", MISUSE)):
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    run(python, "-m", "mypy", "--strict", "consumer.py", cwd=folder)
    found = run(python, "-m", "mypy", "--strict", "misuse.py", cwd=folder, fails=True)
    expect(found.count("error:") >= 3, f"misuse is not found: {found}")
    print("types: a strict consumer passes, misuse is found")


def run_tests(name: str, wheel: Path, folder: Path, source: Path, *requirements: str, backend: str) -> None:
    """Run the tests that need no extra against some versions of the dependencies."""
    python = environment(folder / name, wheel, *requirements, *TOOLS)
    listed = run(python, "-m", "pip", "list", "--format=freeze").split()
    versions = ", ".join(line for line in listed if line.startswith(("numpy=", "scipy=")))
    begun = time.perf_counter()
    skipped = [f"--ignore={file}" for file in EXCLUDED] + [f"--deselect={NOT_OLDEST}"] * bool(requirements)
    out = run(
        python,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        *skipped,
        "tests",
        cwd=source,
        CCA_KERNEL=backend,
    )
    print(f"{name} ({versions}): {out.splitlines()[-1]}, {time.perf_counter() - begun:.0f} s with collection")


def environment(folder: Path, *packages: str | Path) -> Path:
    """Make a virtual environment with packages; return its Python."""
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    if packages:
        run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *packages)
    return python


def size(python: Path, package: str = "") -> float:
    """Size on disk of a package, or of everything installed except pip [MB]."""
    site = run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    files = (path for path in Path(site, package).rglob("*") if path.is_file())
    tools = {"pip", "setuptools", "pkg_resources", "_distutils_hack", "__pycache__"}
    return sum(path.stat().st_size for path in files if not tools & set(path.parts)) / 1e6


def run(
    python: Path, *arguments: str | Path, cwd: Path | None = None, fails: bool = False, **variables: str
) -> str:
    """Output of Python with arguments and environment variables; it must succeed, or fail if `fails`."""
    command = [str(python), *map(str, arguments)]
    cwd = cwd or python.parent  # in the checkout, Python would import that instead of what is installed
    env = os.environ | variables
    done = subprocess.run(
        command, cwd=cwd, env=env, capture_output=True, text=True, timeout=7200, check=False
    )
    report = f"{' '.join(command)}\n{done.stdout[-6000:]}\n{done.stderr[-4000:]}"
    expect(bool(done.returncode) == fails, report)
    return report if fails else done.stdout


def expect(condition: bool, message: str) -> None:
    """Stop with a message unless a condition holds."""
    if not condition:
        sys.exit(f"packaging: {message}")


if __name__ == "__main__":
    main()

"""Export of the steering law and of the single-track plant as FMUs, from the C of the kernel."""

import hashlib
import platform
import shutil
import subprocess
import tempfile
import zipfile
from importlib.resources import files
from pathlib import Path as FilePath

from cca_core._checks import check_real
from cca_core.codegen.export.model import Model
from cca_core.codegen.export.steering import steering_model
from cca_core.errors import InputError
from cca_core.fmi.description import SOURCES, build_description, model_description
from cca_core.fmi.plant import plant_model
from cca_core.follow import PreviewGains
from cca_core.path import Path
from cca_core.vehicle import VehicleParams, VehicleState

VERSIONS = ("2.0", "3.0")
_PLATFORMS = {"2.0": {"x86_64": "linux64"}, "3.0": {"x86_64": "x86_64-linux", "aarch64": "aarch64-linux"}}


def export_steering(
    file: str | FilePath,
    vehicle: VehicleParams,
    path: Path,
    gains: PreviewGains | None = None,
    *,
    delay: float = 0.0,
    a_y_max: float = 8.0,
    version: str = "3.0",
    step: float = 0.02,
) -> None:
    """Write the steering law along a path as FMU for co-simulation.

    Parameters
    ----------
    file : str or pathlib.Path
        File to write, with the ending ``.fmu``.
    vehicle : VehicleParams
        The controlled vehicle.
    path : Path
        Path to follow.
    gains : PreviewGains, optional
        Schedule over speed; the default is the shipped one.
    delay : float
        Known dead time between command and road wheel [s].
    a_y_max : float
        Limit of the commanded lateral acceleration [m/s^2].
    version : {"2.0", "3.0"}
        Version of FMI.
    step : float
        Cycle time [s].

    Raises
    ------
    InputError
        If the version is unknown or a number is out of range.

    Notes
    -----
    Inputs are the motion of the center of gravity, and the distance on the path at the start: by default it
    is searched. The output is the road-wheel angle. The results equal those of `PreviewController` with the
    same inputs. The FMU holds its sources, and a library for this machine if a C compiler is found.
    """
    check_real("a_y_max", a_y_max, gt=0.0)
    model = steering_model(vehicle, path, gains, delay=check_real("delay", delay, ge=0.0), a_y_max=a_y_max)
    _write(FilePath(file), model, version, step)


def export_plant(
    file: str | FilePath,
    vehicle: VehicleParams,
    state: VehicleState,
    *,
    drive_lag: float = 0.1,
    version: str = "3.0",
    step: float = 0.02,
) -> None:
    """Write the single-track plant as FMU for co-simulation.

    Parameters
    ----------
    file : str or pathlib.Path
        File to write, with the ending ``.fmu``.
    vehicle : VehicleParams
        Geometry, inertia, tires, friction and steering actuator.
    state : VehicleState
        Motion at the start.
    drive_lag : float
        Time constant of drive and brakes [s].
    version : {"2.0", "3.0"}
        Version of FMI.
    step : float
        Cycle time [s].

    Raises
    ------
    InputError
        If the version is unknown or a number is out of range.

    Notes
    -----
    Inputs are the commanded road-wheel angle and acceleration; outputs are the motion. The results equal
    those of `cca_core.sim.SingleTrackPlant`.
    """
    model = plant_model(vehicle, state, drive_lag=check_real("drive_lag", drive_lag, ge=0.0))
    _write(FilePath(file), model, version, step)


def _write(file: FilePath, model: Model, version: str, step: float) -> None:
    if version not in VERSIONS:
        raise InputError(f"version must be one of {', '.join(VERSIONS)}, was {version!r}")
    check_real("step", step, gt=0.0)
    adapter = f"fmi{version[0]}.c"
    token = "{" + hashlib.sha256(model.c_sources()["model.c"].encode()).hexdigest()[:32] + "}"
    sources = model.c_sources(token) | {
        name: files("cca_core.fmi").joinpath(name).read_text(encoding="utf-8") for name in (adapter, "fmi.h")
    }
    if version == "3.0":
        sources["buildDescription.xml"] = build_description(model)
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", model_description(model, token, version, step))
        for name, text in sources.items():
            archive.writestr(f"sources/{name}", text)
        library, folder = _compiled(sources, adapter), _PLATFORMS[version].get(platform.machine())
        if library is not None and folder is not None and platform.system() == "Linux":
            archive.writestr(f"binaries/{folder}/{model.name}.so", library)


def _compiled(sources: dict[str, str], adapter: str) -> bytes | None:
    """Return the library for this machine; None without a C compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as name:
        folder = FilePath(name)
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        # without contraction of products and sums the results are those of Python
        command = [
            compiler, "-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden",
            adapter, *SOURCES, "-o", "model.so", "-lm",
        ]  # fmt: skip
        done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
        return (folder / "model.so").read_bytes() if done.returncode == 0 else None

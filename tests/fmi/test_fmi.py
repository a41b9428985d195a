"""FMUs of steering law and plant: valid, built without warnings, equal to Python in closed loop."""

import math
import shutil
import subprocess
import zipfile
from importlib import import_module
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, PreviewController, VehicleParams, VehicleState, fit_path
from cca_core.fmi import FmuPlant, export_plant, export_steering
from cca_core.sim import SingleTrackPlant

CAR = VehicleParams.bmw_320i()
X = np.linspace(0.0, 800.0, 161)
PATH = fit_path(np.column_stack((X, 10.0 * np.sin(X / 60.0))))
START = VehicleState(x=0.0, y=0.4, psi=0.1, v_x=15.0)
VERSIONS = ("2.0", "3.0")
needs_fmpy = pytest.mark.requires("fmpy")
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")


def export(kind: str, file: FilePath, version: str) -> None:
    if kind == "steering":
        export_steering(file, CAR, PATH, version=version)
    else:
        export_plant(file, CAR, START, version=version)


@needs_fmpy
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", ["steering", "plant"])
def test_fmu_has_no_problems(tmp_path: FilePath, kind: str, version: str) -> None:
    file = tmp_path / "model.fmu"
    export(kind, file, version)
    assert import_module("fmpy.validation").validate_fmu(str(file)) == []


@needs_compiler
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", ["steering", "plant"])
def test_sources_compile_without_warnings(tmp_path: FilePath, kind: str, version: str) -> None:
    """The FMU holds all that another machine needs to build it."""
    export(kind, tmp_path / "model.fmu", version)
    with zipfile.ZipFile(tmp_path / "model.fmu") as archive:
        archive.extractall(tmp_path)
    sources = sorted(path.name for path in (tmp_path / "sources").glob("*.c"))
    assert sources == [f"fmi{version[0]}.c", "kernel.c", "model.c"]
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wno-cast-qual", "-Werror"]
    for source in (f"fmi{version[0]}.c", "model.c"):
        done = subprocess.run(
            ["cc", *flags, "-c", source, "-o", "out.o"],
            cwd=tmp_path / "sources",
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr


def steering_fmu(file: FilePath, version: str) -> tuple[Any, Any]:
    """An initialized FMU of the steering law, and its variables."""
    fmpy, module = import_module("fmpy"), import_module(f"fmpy.fmi{version[0]}")
    description = fmpy.read_model_description(str(file))
    slave = module.FMU3Slave if version == "3.0" else module.FMU2Slave
    fmu = slave(
        guid=description.guid, unzipDirectory=fmpy.extract(str(file)), instanceName="steering",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )  # fmt: skip
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, {v.name: v.valueReference for v in description.modelVariables}


@needs_fmpy
@needs_compiler
@pytest.mark.parametrize("version", VERSIONS)
def test_closed_loop_of_both_fmus_equals_python(tmp_path: FilePath, version: str) -> None:
    """1 500 steps; the arithmetic is the same, so the results are."""
    export("steering", tmp_path / "steering.fmu", version)
    export("plant", tmp_path / "plant.fmu", version)
    fmu, at = steering_fmu(tmp_path / "steering.fmu", version)
    there, here, controller = (
        FmuPlant(tmp_path / "plant.fmu"),
        SingleTrackPlant(CAR, START),
        PreviewController(CAR),
    )
    set_values = fmu.setFloat64 if version == "3.0" else fmu.setReal
    get_values = fmu.getFloat64 if version == "3.0" else fmu.getReal
    names = ("x", "y", "psi", "v_x", "v_y", "r")
    worst = 0.0
    for k in range(1500):
        a_x = 0.3 * math.sin(k / 100.0) - (1.3 if k > 700 else 0.0)
        set_values([at[name] for name in names], [getattr(there.state, name) for name in names])
        fmu.doStep(currentCommunicationPoint=0.02 * k, communicationStepSize=0.02)
        there.step(get_values([at["delta"]])[0], a_x, 0.02)
        here.step(controller.steer(here.state, PATH, 0.02), a_x, 0.02)
        worst = max(worst, *(abs(getattr(there.state, n) - getattr(here.state, n)) for n in names))
        worst = max(worst, abs(there.a_y - here.a_y))
    assert worst <= 1e-12
    assert here.state.v_x == 0.0  # the drive ends at rest
    fmu.terminate()
    fmu.freeInstance()
    there.close()


@needs_fmpy
@needs_compiler
def test_variables_of_other_names_are_mapped(tmp_path: FilePath) -> None:
    export("plant", tmp_path / "plant.fmu", "3.0")
    plant = FmuPlant(tmp_path / "plant.fmu", outputs={"v_y": "r", "r": "v_y"})
    plant.step(0.05, 0.0, 0.02)
    plain = FmuPlant(tmp_path / "plant.fmu")
    plain.step(0.05, 0.0, 0.02)
    assert (plant.state.v_y, plant.state.r) == (plain.state.r, plain.state.v_y)
    plant.close()
    plain.close()
    with pytest.raises(InputError, match="no_such"):
        FmuPlant(tmp_path / "plant.fmu", inputs={"a_x_command": "no_such"})


@needs_fmpy
def test_file_that_is_no_fmu_raises(tmp_path: FilePath) -> None:
    (tmp_path / "plant.fmu").write_bytes(b"no archive")
    with pytest.raises(InputError, match="must be an FMU"):
        FmuPlant(tmp_path / "plant.fmu")


@pytest.mark.parametrize(
    ("change", "named"),
    [({"version": "1.0"}, "version"), ({"step": 0.0}, "step"), ({"delay": -1.0}, "delay")],
)
def test_wrong_arguments_raise(tmp_path: FilePath, change: dict[str, Any], named: str) -> None:
    with pytest.raises(InputError, match=named):
        export_steering(tmp_path / "a.fmu", CAR, PATH, **change)


def test_without_compiler_sources_alone_are_written(
    tmp_path: FilePath, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)
    export("plant", tmp_path / "plant.fmu", "3.0")
    with zipfile.ZipFile(tmp_path / "plant.fmu") as archive:
        assert not [name for name in archive.namelist() if name.startswith("binaries")]

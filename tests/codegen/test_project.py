"""The C project of the steering law: warnings, sanitizers, and every recorded step bit for bit."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, PreviewController, VehicleParams, fit_path
from cca_core.codegen.__main__ import main
from cca_core.codegen.export.measure import deepest_stack
from cca_core.codegen.export.project import SteerCall, write_cases
from cca_core.fmi import export_c
from cca_core.rig import scenario_id
from cca_core.serial import to_dict
from cca_core.sim import Scenario, paper_scenarios, simulate

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


def write_road(file: Path) -> Path:
    np.savetxt(file, np.column_stack((X, 20.0 * np.sin(X / 80.0))), delimiter=",", header="x,y", comments="")
    return file


@pytest.mark.parametrize("cases", [500, pytest.param(100_000, marks=pytest.mark.slow)])
def test_command_records_python_without_its_c(tmp_path: Path, cases: int) -> None:
    """The outputs are those of the kernel in Python, so nothing is compared with itself."""
    road = write_road(tmp_path / "road.csv")
    command = [
        sys.executable, "-m", "cca_core.codegen", "--vehicle", "vw_vanagon", "--road", str(road),
        "--out", str(tmp_path), "--cases", str(cases), "--seed", "2", "--delay", "0.03",
    ]  # fmt: skip
    done = subprocess.run(
        command, env=os.environ | {"CCA_KERNEL": "python"}, capture_output=True, text=True, check=True
    )
    build(tmp_path, "-O2", *WARNINGS)
    assert run(tmp_path).startswith(f"{cases} of {cases} equal")
    if shutil.which("gcc"):
        assert re.search(rf"{cases} of {cases} equal.*\n\d+ bytes of stack", done.stdout)


def test_command_takes_vehicle_from_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    road, vehicle = write_road(tmp_path / "road.csv"), tmp_path / "car.json"
    vehicle.write_text(json.dumps(to_dict(VehicleParams.ford_escort())), encoding="utf-8")
    models = []
    for given in (str(vehicle), "ford_escort"):
        out = tmp_path / "out"
        assert main(["--vehicle", given, "--road", str(road), "--out", str(out), "--cases", "9"]) == 0
        models.append((out / "model.c").read_text(encoding="utf-8"))
    assert models[0] == models[1]
    assert "Path(" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("vehicle", "road", "named"),
    [
        ("lada", "road.csv", "vehicle must be bmw_320i"),
        ("bmw_320i", "no.csv", "no.csv"),
        ("no.json", "road.csv", "no.json"),
    ],
)
def test_command_names_wrong_argument(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], vehicle: str, road: str, named: str
) -> None:
    write_road(tmp_path / "road.csv")
    assert main(["--vehicle", vehicle, "--road", str(tmp_path / road), "--out", str(tmp_path / "out")]) == 2
    assert named in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def recorded_runs(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> list[list[SteerCall]]:
    """All calls of the steering law in a run, by controller."""
    runs: dict[int, tuple[object, list[SteerCall]]] = {}
    steer = PreviewController.steer

    def record(
        self: PreviewController, state: Any, path: Any, dt: float = 0.02, *, s_guess: float | None = None
    ) -> float:
        delta = steer(self, state, path, dt, s_guess=s_guess)
        _, calls = runs.setdefault(id(self), (self, []))
        calls.append(SteerCall(state, path, dt, s_guess, delta))
        return delta

    with monkeypatch.context() as patch:
        patch.setattr(PreviewController, "steer", record)
        simulate(scenario)
    return [calls for _, calls in runs.values()]


@pytest.mark.parametrize(
    "scenario",
    [
        pytest.param(
            each, id=scenario_id(each),
            marks=() if scenario_id(each) == "maneuver/2/v2v" else pytest.mark.slow,
        )
        for each in paper_scenarios()
    ],
)  # fmt: skip
def test_inputs_of_scenario_give_same_outputs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scenario: Scenario
) -> None:
    """With every reference that the planner made."""
    runs = recorded_runs(scenario, monkeypatch)
    count = sum(map(len, runs))
    assert count > 250
    if scenario.name == "maneuver" and scenario.ego_type == "v2v":
        assert len({id(call.path) for run in runs for call in run}) >= 3  # route and two maneuvers
    export_c(tmp_path, scenario.vehicle, scenario.road.path, cases=1)
    write_cases(tmp_path / "cases.txt", scenario.road.path, runs)
    build(tmp_path, "-O2")
    assert run(tmp_path).startswith(f"{count} of {count} equal")


NOT_FINITE = r"""#include <math.h>
#include <stdio.h>

#include "model.h"

static Model model;

int main(void)
{
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e300, -1e300};
    int wrong = 0, n = 0;
    model_start(&model);
    for (int field = MODEL_X; field <= MODEL_R + 1; field++) {
        for (int k = 0; k < 5; k++) {
            for (int i = 0; i < 20; i++) {
                double step = 0.02;
                model.values[MODEL_X] = 0.3 * i;
                model.values[MODEL_Y] = model.values[MODEL_PSI] = 0.1;
                model.values[MODEL_V_X] = 15.0;
                model.values[MODEL_V_Y] = model.values[MODEL_R] = 0.0;
                *(i != 10 ? &step : field > MODEL_R ? &step : &model.values[field]) = i == 10 ? bad[k] : 0.02;
                model_step(&model, step);
                wrong += !(fabs(model.values[MODEL_DELTA]) < 1.1);
                n++;
            }
            wrong += !(fabs(model.values[MODEL_DELTA]) < 0.3); /* and the vehicle steers again */
        }
    }
    printf("%d steps, %d wrong\n", n, wrong);
    return wrong != 0;
}
"""


def test_inputs_that_are_not_finite_leave_no_trace(tmp_path: Path) -> None:
    """NaN, infinite and huge motions and times: the angle stays in its limits, and later steps are sound."""
    export_c(tmp_path, VehicleParams.bmw_320i(), PATH, cases=1)
    (tmp_path / "harness.c").write_text(NOT_FINITE, encoding="utf-8")
    build(tmp_path, "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    assert run(tmp_path) == "700 steps, 0 wrong\n"


def test_deepest_stack_of_call_graph() -> None:
    graph = [
        'node: { title: "model_step" label: "model_step\\nmodel.c:1:1\\n100 bytes (static)" }',
        'edge: { sourcename: "model_step" targetname: "kernel.c:a" label: "model.c:2:3" }',
        'edge: { sourcename: "model_step" targetname: "sin" }',
        'node: { title: "kernel.c:a" label: "a\\nkernel.c:4:1\\n40 bytes (static)" }',
        'node: { title: "kernel.c:b" label: "b\\nkernel.c:9:1\\n500 bytes (static)" }',
    ]
    assert deepest_stack(["\n".join(graph[:3]), "\n".join(graph[3:])], "model_step") == 140


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

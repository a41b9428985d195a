"""The steering law as a C99 project for a vehicle computer, with recorded inputs and outputs."""

import math
from importlib.resources import files
from pathlib import Path as FilePath

import numpy as np

from cca_core._checks import check_real
from cca_core.fmi.model import steering_model
from cca_core.follow import PreviewController, PreviewGains
from cca_core.path import Path
from cca_core.vehicle import VehicleParams, VehicleState

_CMAKE = """cmake_minimum_required(VERSION 3.10)
project(cca_steering C)
set(CMAKE_C_STANDARD 99)
set(CMAKE_C_EXTENSIONS OFF)
if(NOT MSVC)
  # without contraction of products and sums the results are those of Python
  add_compile_options(-O2 -ffp-contract=off)
endif()
add_library(cca_steering STATIC kernel.c model.c)
add_executable(harness harness.c)
target_link_libraries(harness cca_steering $<$<NOT:$<C_COMPILER_ID:MSVC>>:m>)
enable_testing()
add_test(NAME recorded COMMAND harness ${CMAKE_SOURCE_DIR}/cases.txt)
"""


def export_c(
    folder: str | FilePath,
    vehicle: VehicleParams,
    path: Path,
    gains: PreviewGains | None = None,
    *,
    delay: float = 0.0,
    a_y_max: float = 8.0,
    cases: int = 2000,
    seed: int = 1,
) -> None:
    """Write the steering law along a path as C99 that needs nothing but the standard library.

    Parameters
    ----------
    folder : str or pathlib.Path
        Folder for the sources, CMakeLists.txt, the test harness and its cases; it is made.
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
    cases : int
        Number of recorded steps [-].
    seed : int
        Seed of their random inputs.

    Raises
    ------
    InputError
        If a number is out of range.

    Notes
    -----
    A vehicle computer calls ``model_start`` once. In every cycle it writes x, y, psi, v_x, v_y and r to
    ``values[1]`` to ``values[6]``, calls ``model_step``, and reads the road-wheel angle from the last value.
    Nothing is allocated. Parameters are hexadecimal constants. The harness compares every recorded step bit
    for bit, and prints the size of the state and the longest step.
    """
    check_real("a_y_max", a_y_max, gt=0.0)
    check_real("cases", cases, ge=1)
    model = steering_model(vehicle, path, gains, delay=check_real("delay", delay, ge=0.0), a_y_max=a_y_max)
    controller = PreviewController(vehicle, gains, delay=delay, a_y_max=a_y_max)
    kernel = files("cca_core.kernel").joinpath("c")
    target = FilePath(folder)
    target.mkdir(parents=True, exist_ok=True)
    for name, text in {
        "kernel.c": kernel.joinpath("kernel.c").read_text(encoding="utf-8"),
        "kernel.h": kernel.joinpath("kernel.h").read_text(encoding="utf-8"),
        "model.c": model.c_source(), "model.h": model.c_header(""), "CMakeLists.txt": _CMAKE,
        "harness.c": files("cca_core.fmi").joinpath("harness.c").read_text(encoding="utf-8"),
        "cases.txt": "\n".join(_recorded(controller, path, cases, np.random.default_rng(seed))) + "\n",
    }.items():  # fmt: skip
        (target / name).write_text(text, encoding="utf-8")


def _recorded(controller: PreviewController, path: Path, cases: int, rng: np.random.Generator) -> list[str]:
    """Return inputs and output of each step of a vehicle that moves along the path with random errors."""
    lines, s = [], path.start
    for k in range(cases):
        v = float(rng.uniform(0.0, 40.0)) if rng.random() < 0.9 else 0.0
        dt = float(rng.choice([0.02, 0.02, 0.01, 0.1]))
        s = s + v * dt if s + v * dt < path.end else path.start
        x, y = path.to_cartesian(s, float(rng.normal(0.0, 1.0))).tolist()
        psi = float(path.heading(s)) + float(rng.normal(0.0, 0.2)) + math.tau * int(rng.integers(-1, 2))
        v_y, r = float(rng.normal(0.0, 0.5)), float(rng.normal(0.0, 0.3))
        state = VehicleState(x=x, y=y, psi=psi, v_x=v, v_y=v_y, r=r)
        delta = controller.steer(state, path, dt, s_guess=path.start if k == 0 else None)
        lines.append(" ".join(value.hex() for value in (x, y, psi, v, v_y, r, dt, delta)))
    return lines

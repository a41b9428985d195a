"""The steering law as a C99 project for a vehicle computer, with recorded inputs and outputs."""

import math
from collections.abc import Iterable, Iterator
from importlib.resources import files
from itertools import chain
from pathlib import Path as FilePath
from typing import NamedTuple

import numpy as np

from cca_core._checks import check_real
from cca_core._files import parse_json, read_bytes
from cca_core.codegen.export.model import c_number
from cca_core.codegen.export.steering import steering_model
from cca_core.errors import InputError
from cca_core.follow import PreviewController, PreviewGains
from cca_core.path import Path
from cca_core.serial import from_dict
from cca_core.vehicle import VehicleParams, VehicleState

VEHICLES = ("bmw_320i", "ford_escort", "vw_vanagon")
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


class SteerCall(NamedTuple):
    """A call of `PreviewController.steer` and its result."""

    state: VehicleState
    path: Path
    dt: float
    s_guess: float | None
    delta: float


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
    A vehicle computer calls ``model_start`` once. In every cycle it writes the motion to
    ``values[MODEL_X]`` to ``values[MODEL_R]``, calls ``model_step``, and reads ``values[MODEL_DELTA]``, the
    road-wheel angle. ``model_follow`` gives another reference, such as that of a maneuver. Nothing is
    allocated. Parameters are hexadecimal constants. The harness compares every recorded step bit for bit, and
    prints the size of the state and the time of a step.
    """
    check_real("a_y_max", a_y_max, gt=0.0)
    check_real("cases", cases, ge=1)
    model = steering_model(vehicle, path, gains, delay=check_real("delay", delay, ge=0.0), a_y_max=a_y_max)
    controller = PreviewController(vehicle, gains, delay=delay, a_y_max=a_y_max)
    recorded = random_calls(controller, path, cases, np.random.default_rng(seed))
    target = FilePath(folder)
    target.mkdir(parents=True, exist_ok=True)
    harness = files("cca_core.codegen.export").joinpath("harness.c").read_text(encoding="utf-8")
    texts = model.c_sources() | {"CMakeLists.txt": _CMAKE, "harness.c": harness}
    for name, text in texts.items():
        (target / name).write_text(text, encoding="utf-8")
    write_cases(target / "cases.txt", path, [recorded])


def find_vehicle(name: str) -> VehicleParams:
    """Return a vehicle of the library, or that of a JSON file."""
    if name in VEHICLES:
        vehicle: VehicleParams = getattr(VehicleParams, name)()
        return vehicle
    if not name.endswith(".json"):
        raise InputError(f"vehicle must be {', '.join(VEHICLES)} or a JSON file, was {name!r}")
    data = read_bytes(name, max_bytes=1_000_000, name="vehicle")
    return from_dict(VehicleParams, parse_json(data, f"vehicle {name!r}"))


def random_calls(
    controller: PreviewController, path: Path, count: int, rng: np.random.Generator
) -> Iterator[SteerCall]:
    """Steer a vehicle that moves along a path with random errors; some are large, late or elsewhere."""
    s = path.start
    for _ in range(count):
        kind = rng.random()
        v = float(rng.uniform(0.0, 40.0)) if kind < 0.9 else float(rng.choice([0.0, -0.4, 60.0]))
        dt = float(rng.choice([0.02, 0.02, 0.02, 0.01, 0.1])) if kind > 0.002 else 5.0
        s += max(v, 0.0) * dt
        if s > path.end or rng.random() < 0.002:
            s = float(rng.uniform(path.start, path.end))
        spread = 1.0 if rng.random() < 0.98 else 20.0
        x, y = path.to_cartesian(s, spread * float(rng.normal())).tolist()
        psi = (
            float(path.heading(s)) + 0.2 * spread * float(rng.normal()) + math.tau * int(rng.integers(-1, 2))
        )
        v_y, r = 0.5 * spread * float(rng.normal()), 0.3 * spread * float(rng.normal())
        state = VehicleState(x=x, y=y, psi=psi, v_x=v, v_y=v_y, r=r)
        yield SteerCall(state, path, dt, None, controller.steer(state, path, dt))


def write_cases(file: FilePath, road: Path, runs: Iterable[Iterable[SteerCall]]) -> None:
    """Write what the harness reads; each run begins with a new controller."""
    with file.open("w", encoding="utf-8") as text:
        text.writelines(f"{line}\n" for line in chain.from_iterable(case_lines(road, run) for run in runs))


def case_lines(road: Path, calls: Iterable[SteerCall]) -> Iterator[str]:
    """Return the calls of one controller as lines: changes of the path, inputs and output of each step."""
    yield "start"
    followed: Path | None = None
    for state, path, dt, s_guess, delta in calls:
        if path is not followed:
            station = c_number(math.nan if s_guess is None else s_guess)
            if path is road:
                yield f"road {station}"
            else:
                numbers = [*path.breaks.tolist(), *np.asarray(path.curve.powers).ravel().tolist()]
                yield f"path {path.curve.segments} {station} {' '.join(map(c_number, numbers))}"
            followed = path
        motion = state.x, state.y, state.psi, state.v_x, state.v_y, state.r
        yield f"step {' '.join(map(c_number, (*motion, dt, delta)))}"

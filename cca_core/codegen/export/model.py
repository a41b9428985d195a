"""Models in C around the kernel: a vector of values, a start and a step."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from cca_core.codegen import FOLDER, translate

_HEADER = """#ifndef MODEL_H
#define MODEL_H

#include "kernel.h"

/* values: time, inputs, outputs */
{names}
#define MODEL_VARIABLES {count}
#define MODEL_INPUTS {inputs}
#define MODEL_TOKEN "{token}"

typedef struct Model {{
    double values[MODEL_VARIABLES];
{structure}}} Model;

/* Before the first step. */
void model_start(Model *model);

/* Compute the outputs after a time [s]. */
void model_step(Model *model, double step);
{prototypes}
#endif
"""
_SOURCE = """#include <math.h>
#include <stddef.h>
#include <string.h>

#include "model.h"

{tables}
void model_start(Model *model)
{{
    memset(model, 0, sizeof(Model));
{start}}}
{functions}
void model_step(Model *model, double step)
{{
{step}}}
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A variable of type Float64: an input, or an output."""

    name: str
    unit: str
    description: str
    start: float = 0.0
    is_input: bool = False


MOTION = (
    ("x", "m", "position of the center of gravity, east"),
    ("y", "m", "position of the center of gravity, north"),
    ("psi", "rad", "heading, counter-clockwise from x"),
    ("v_x", "m/s", "forward speed"),
    ("v_y", "m/s", "lateral speed, left positive"),
    ("r", "rad/s", "yaw rate, left positive"),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model: inputs before outputs, fields of its C structure, and the bodies of its functions."""

    name: str
    description: str
    kernel: str  # module of the kernel
    variables: tuple[Variable, ...]
    structure: str  # fields besides `values`
    start: str  # body of model_start, after the values are set
    step: str  # body of model_step
    tables: str = ""  # constants in C
    prototypes: str = ""  # of further functions
    functions: str = ""

    def c_sources(self, token: str = "") -> dict[str, str]:
        """Texts of model.c, model.h, kernel.c and kernel.h, which need nothing else."""
        starts = [0.0, *(v.start for v in self.variables)]
        values = "".join(
            f"    model->values[{i}] = {c_number(value)};\n" for i, value in enumerate(starts) if value
        )
        names = "\n".join(f"#define MODEL_{v.name.upper()} {i}" for i, v in enumerate(self.variables, 1))
        header = _HEADER.format(
            names=names, count=len(starts), inputs=sum(v.is_input for v in self.variables), token=token,
            structure=self.structure, prototypes=self.prototypes,
        )  # fmt: skip
        source = _SOURCE.format(
            tables=self.tables, start=values + self.start, functions=self.functions, step=self.step
        )
        return {"model.c": source, "model.h": header, **_kernel_sources(self.kernel)}


@cache
def _kernel_sources(module: str) -> dict[str, str]:
    texts = translate(FOLDER, module)
    return {name: texts[name] for name in ("kernel.c", "kernel.h")}


def c_number(value: float) -> str:
    """Return a number in C, exactly."""
    return float(value).hex()


def c_table(name: str, values: ArrayLike) -> str:
    """Return an array of constants in C."""
    numbers = [c_number(value) for value in np.asarray(values, dtype=np.float64).ravel().tolist()]
    rows = [", ".join(numbers[i : i + 4]) for i in range(0, len(numbers), 4)]
    return f"static const double {name}[] = {{\n    " + ",\n    ".join(rows) + "\n};\n"


def c_fields(structure: str, values: dict[str, float]) -> str:
    """Return assignments to the fields of a structure of the model."""
    return "".join(f"    model->{structure}.{name} = {c_number(value)};\n" for name, value in values.items())


def c_pointers(structure: str, tables: Iterable[tuple[str, str]]) -> str:
    """Return assignments of tables, which the kernel only reads, to fields."""
    return "".join(f"    model->{structure}.{name} = (double *){table};\n" for name, table in tables)

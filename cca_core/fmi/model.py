"""Models for an FMU: variables, and the C around the kernel that computes a step."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cca_core.follow import PreviewGains, shipped_gains
from cca_core.path import Path
from cca_core.vehicle import VehicleParams, VehicleState


@dataclass(frozen=True, slots=True, kw_only=True)
class Variable:
    """A variable of type Float64: an input, or an output."""

    name: str
    unit: str
    description: str
    start: float = 0.0
    is_input: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model: inputs before outputs, fields of its C structure, and the bodies of its functions."""

    name: str
    description: str
    variables: tuple[Variable, ...]
    tables: str  # constants in C
    structure: str  # fields besides `values`
    start: str  # body of model_start
    step: str  # body of model_step

    def c_source(self) -> str:
        """Return model.c."""
        values = _assignments("model->values", [0.0, *(v.start for v in self.variables)])
        return (
            f'#include <math.h>\n\n#include "model.h"\n\n{self.tables}\n'
            f"void model_start(Model *model)\n{{\n{values}{self.start}}}\n\n"
            f"void model_step(Model *model, double step)\n{{\n{self.step}}}\n"
        )

    def c_header(self, token: str) -> str:
        """Return model.h."""
        n_inputs = sum(v.is_input for v in self.variables)
        return (
            f'#ifndef MODEL_H\n#define MODEL_H\n\n#include "kernel.h"\n\n'
            f"/* values: time, inputs, outputs */\n#define MODEL_VARIABLES {len(self.variables) + 1}\n"
            f'#define MODEL_INPUTS {n_inputs}\n#define MODEL_TOKEN "{token}"\n\n'
            f"typedef struct Model {{\n    double values[MODEL_VARIABLES];\n{self.structure}}} Model;\n\n"
            "void model_start(Model *model);\nvoid model_step(Model *model, double step);\n\n#endif\n"
        )


_MOTION = (
    ("x", "m", "position of the center of gravity, east"),
    ("y", "m", "position of the center of gravity, north"),
    ("psi", "rad", "heading, counter-clockwise from x"),
    ("v_x", "m/s", "forward speed"),
    ("v_y", "m/s", "lateral speed, left positive"),
    ("r", "rad/s", "yaw rate, left positive"),
)  # fmt: skip


def steering_model(
    vehicle: VehicleParams, path: Path, gains: PreviewGains | None, *, delay: float, a_y_max: float
) -> Model:
    """Return the steering law along a path: motion in, road-wheel angle out."""
    gains = gains or shipped_gains(vehicle)
    curve = path.curve
    tables = "".join(
        _table(name, values)
        for name, values in (
            ("breaks", np.asarray(curve.breaks).ravel().tolist()),
            ("powers", np.asarray(curve.powers).ravel().tolist()),
            ("speeds", gains.speeds), ("gains_p", gains.k_p), ("gains_d", gains.k_d), ("previews", gains.l_s),
        )
    )  # fmt: skip
    n = len(gains.speeds)
    law = {
        "delta_max": vehicle.delta_max, "delta_rate_max": vehicle.delta_rate_max,
        "steering_lag": vehicle.steering_lag, "understeer": vehicle.understeer_gradient, "delay": delay,
        "a_y_max": a_y_max,
    }  # fmt: skip
    car = {
        "l_f": vehicle.l_f, "l_r": vehicle.l_r, "m": vehicle.m, "inertia": vehicle.I_z, "c_f": vehicle.C_f,
        "c_r": vehicle.C_r, "mu": vehicle.mu,
    }  # fmt: skip
    pointers = "".join(
        f"    model->law.{name} = (double *){table};\n"
        for name, table in (("speeds", "speeds"), ("k_p", "gains_p"), ("k_d", "gains_d"), ("l_s", "previews"))
    )
    start = (
        f"{_fields('law', law)}{_fields('car', car)}    model->law.count = {n};\n{pointers}"
        "    model->car.trace_s = model->trace_s;\n    model->car.trace_beta = model->trace_beta;\n"
        "    model->car.trace_r = model->trace_r;\n"
    )
    first = path.start
    step = (
        f"    const Curve curve = {{{curve.segments}, (double *)breaks, (double *)powers}};\n"
        "    double *v = model->values, v_x = v[4] > 0.0 ? v[4] : 0.0;\n"
        f"    double guess = model->law.started ? model->law.s + v_x * step : {_hex(first)} + v[7];\n"
        "    v[8] = cca_steer(&model->law, &model->car, &curve, guess, v[1], v[2], v[3], v[4], v[5], v[6], "
        "step);\n"
    )
    inputs = tuple(
        Variable(name=name, unit=unit, description=text, is_input=True) for name, unit, text in _MOTION
    )
    guess = Variable(name="s_start", unit="m", description="distance on the path at the start", is_input=True)
    angle = Variable(name="delta", unit="rad", description="road-wheel angle, left positive")
    return Model(
        name="cca_steering", description="Preview steering along a path", tables=tables,
        variables=(*inputs, guess, angle), start=start, step=step,
        structure="    Steering law;\n    IdealCar car;\n"
        "    double trace_s[1024], trace_beta[1024], trace_r[1024];\n",
    )  # fmt: skip


def plant_model(vehicle: VehicleParams, state: VehicleState, *, drive_lag: float) -> Model:
    """Return the single-track plant: commands in, motion out."""
    constants = {
        "l_f": vehicle.l_f, "l_r": vehicle.l_r, "m": vehicle.m, "inertia": vehicle.I_z, "c_f": vehicle.C_f,
        "c_r": vehicle.C_r, "mu": vehicle.mu, "delta_rate_max": vehicle.delta_rate_max,
        "steering_lag": max(vehicle.steering_lag, 1e-3), "drive_lag": max(drive_lag, 1e-3),
    }  # fmt: skip
    names = ("x", "y", "psi", "v_x", "v_y", "r", "delta", "a_x")
    motion = {name: getattr(state, name) for name in names}
    outputs = (
        *_MOTION, ("delta", "rad", "road-wheel angle, left positive"), ("a_x", "m/s2", "acceleration"),
        ("a_y", "m/s2", "lateral acceleration, left positive"),
    )  # fmt: skip
    limit = _hex(vehicle.delta_max)
    copied = "".join(f"    v[{3 + i}] = car->{name};\n" for i, name in enumerate((*names, "a_y")))
    step = (
        "    SingleTrackCar *car = &model->car;\n    double *v = model->values;\n"
        f"    double delta = v[1] < -{limit} ? -{limit} : v[1] > {limit} ? {limit} : v[1];\n"
        "    if (car->v_x == 0.0 && v[2] <= 0.0 && car->a_x <= 0.0) { /* only the steering moves */\n"
        "        double bound = car->delta_rate_max * step;\n"
        "        double turn = (delta - car->delta) * -expm1(-step / car->steering_lag);\n"
        "        car->delta += turn < -bound ? -bound : turn > bound ? bound : turn;\n"
        "        car->v_y = car->r = car->a_x = car->a_y = 0.0;\n"
        "    } else {\n        cca_drive(car, delta, v[2], step);\n    }\n" + copied
    )
    return Model(
        name="cca_plant", description="Single-track car on tires that can slide", tables="",
        variables=(
            Variable(name="delta_command", unit="rad", description="road-wheel angle", is_input=True),
            Variable(name="a_x_command", unit="m/s2", description="acceleration", is_input=True),
            *(
                Variable(name=name, unit=unit, description=text, start=motion.get(name, 0.0))
                for name, unit, text in outputs
            ),
        ),
        structure="    SingleTrackCar car;\n", start=_fields("car", constants | motion), step=step,
    )  # fmt: skip


def _hex(value: float) -> str:
    """Return a number in C, exactly."""
    return float(value).hex()


def _table(name: str, values: Sequence[float]) -> str:
    numbers = ", ".join(map(_hex, values))
    return f"static const double {name}[] = {{{numbers}}};\n"


def _fields(structure: str, values: dict[str, float]) -> str:
    return "".join(f"    model->{structure}.{name} = {_hex(value)};\n" for name, value in values.items())


def _assignments(target: str, values: Iterable[float]) -> str:
    return "".join(f"    {target}[{i}] = {_hex(value)};\n" for i, value in enumerate(values))

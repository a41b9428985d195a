"""The single-track plant in C: commands in, motion out."""

from cca_core.codegen.export.model import MOTION, Model, Variable, c_fields, c_number
from cca_core.vehicle import VehicleParams, VehicleState


def plant_model(vehicle: VehicleParams, state: VehicleState, *, drive_lag: float) -> Model:
    """Return the single-track plant as a model."""
    constants = {
        "l_f": vehicle.l_f, "l_r": vehicle.l_r, "m": vehicle.m, "inertia": vehicle.I_z, "c_f": vehicle.C_f,
        "c_r": vehicle.C_r, "mu": vehicle.mu, "delta_rate_max": vehicle.delta_rate_max,
        "steering_lag": max(vehicle.steering_lag, 1e-3), "drive_lag": max(drive_lag, 1e-3),
    }  # fmt: skip
    names = ("x", "y", "psi", "v_x", "v_y", "r", "delta", "a_x")
    motion = {name: getattr(state, name) for name in names}
    outputs = (
        *MOTION, ("delta", "rad", "road-wheel angle, left positive"), ("a_x", "m/s2", "acceleration"),
        ("a_y", "m/s2", "lateral acceleration, left positive"),
    )  # fmt: skip
    limit = c_number(vehicle.delta_max)
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
        name="cca_plant", description="Single-track car on tires that can slide", kernel="single_track",
        variables=(
            Variable(name="delta_command", unit="rad", description="road-wheel angle", is_input=True),
            Variable(name="a_x_command", unit="m/s2", description="acceleration", is_input=True),
            *(
                Variable(name=name, unit=unit, description=text, start=motion.get(name, 0.0))
                for name, unit, text in outputs
            ),
        ),
        structure="    SingleTrackCar car;\n", start=c_fields("car", constants | motion), step=step,
    )  # fmt: skip

"""The steering law along a path in C: motion in, road-wheel angle out."""

from typing import Any

from cca_core.codegen.export.model import MOTION, Model, Variable, c_fields, c_number, c_pointers, c_table
from cca_core.follow import PreviewGains, shipped_gains
from cca_core.follow.preview import MAX_JUMP
from cca_core.path import Path
from cca_core.vehicle import VehicleParams

_STRUCTURE = """    Steering law;
    IdealCar car;
    double trace_s[1024], trace_beta[1024], trace_r[1024];
    Curve path;
    CurveSamples samples; /* of the path; none: count is 0 */
    double station, x, y; /* given with the path; last position */
    bool is_new; /* path */
"""
_PROTOTYPES = """
/* Follow a path from the next step on. Its arrays must live as long as it is followed. The station is near
   the vehicle; if it is not a number, the nearest one of the samples is taken. Without samples: NULL. */
void model_follow(Model *model, const Curve *path, const CurveSamples *samples, double station);

/* Follow the road again. */
void model_follow_road(Model *model, double station);
"""
_FUNCTIONS = """
void model_follow(Model *model, const Curve *path, const CurveSamples *samples, double station)
{
    static const CurveSamples none = {0, 0, 0.0, NULL, NULL, NULL};
    model->path = *path;
    model->samples = samples != NULL ? *samples : none;
    model->station = station;
    model->is_new = true;
}

void model_follow_road(Model *model, double station) { model_follow(model, &road, &road_samples, station); }
"""
# as PreviewController.steer does it
_STEP = f"""    double *v = model->values;
    const double travel = (0.0 > v[4] ? 0.0 : v[4]) * step;
    const double moved = hypot(v[1] - model->x, v[2] - model->y);
    double guess = model->law.s + travel;
    if (model->is_new && !model->law.started && v[7] >= 0.0) {{
        model->station = model->path.breaks[0] + v[7];
    }}
    /* another path, or the vehicle is elsewhere */
    if (model->is_new || !(travel >= 0.0 && travel < {MAX_JUMP} && moved < {MAX_JUMP})) {{
        guess = model->is_new ? model->station : (double)NAN;
        if (isnan(guess)) {{
            guess = model->samples.count > 0
                ? cca_nearest_point(&model->path, &model->samples, v[1], v[2]).item0
                : model->path.breaks[0];
        }}
    }}
    model->is_new = false;
    model->x = v[1];
    model->y = v[2];
    v[8] = cca_steer(&model->law, &model->car, &model->path, guess, v[1], v[2], v[3], v[4], v[5], v[6], step);
"""


def steering_model(
    vehicle: VehicleParams, path: Path, gains: PreviewGains | None, *, delay: float, a_y_max: float
) -> Model:
    """Return the steering law along a path as a model."""
    gains = gains or shipped_gains(vehicle)
    curve, samples = path.curve, path.samples
    tables: dict[str, Any] = {
        "breaks": curve.breaks, "powers": curve.powers, "samples_s": samples.s, "samples_x": samples.x,
        "samples_y": samples.y, "speeds": gains.speeds, "gains_p": gains.k_p, "gains_d": gains.k_d,
        "previews": gains.l_s,
    }  # fmt: skip
    road = (
        f"static const Curve road = {{{curve.segments}, (double *)breaks, (double *)powers}};\n"
        f"static const CurveSamples road_samples = {{{samples.count}, {samples.stride}, "
        f"{c_number(samples.max_gap)}, (double *)samples_s, "
        "(double *)samples_x, (double *)samples_y};\n"
    )
    law = {
        "delta_max": vehicle.delta_max, "delta_rate_max": vehicle.delta_rate_max,
        "steering_lag": vehicle.steering_lag, "understeer": vehicle.understeer_gradient, "delay": delay,
        "a_y_max": a_y_max,
    }  # fmt: skip
    car = {
        "l_f": vehicle.l_f, "l_r": vehicle.l_r, "m": vehicle.m, "inertia": vehicle.I_z, "c_f": vehicle.C_f,
        "c_r": vehicle.C_r, "mu": vehicle.mu,
    }  # fmt: skip
    grids = (("speeds", "speeds"), ("k_p", "gains_p"), ("k_d", "gains_d"), ("l_s", "previews"))
    traces = "".join(
        f"    model->car.{name} = model->{name};\n" for name in ("trace_s", "trace_beta", "trace_r")
    )
    start = (
        f"{c_fields('law', law)}{c_fields('car', car)}    model->law.count = {len(gains.speeds)};\n"
        f"{c_pointers('law', grids)}{traces}"
        "    model_follow_road(model, (double)NAN);\n"
    )
    return Model(
        name="cca_steering", description="Preview steering along a path", kernel="steering",
        tables="".join(c_table(name, values) for name, values in tables.items()) + road,
        variables=(
            *(Variable(name=name, unit=unit, description=text, is_input=True) for name, unit, text in MOTION),
            Variable(
                name="s_start", unit="m", is_input=True, start=-1.0,
                description="distance on the path at the start; negative: searched",
            ),
            Variable(name="delta", unit="rad", description="road-wheel angle, left positive"),
        ),
        structure=_STRUCTURE, prototypes=_PROTOTYPES, functions=_FUNCTIONS, start=start, step=_STEP,
    )  # fmt: skip

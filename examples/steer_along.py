"""A closed loop of your own: a car with a tire model, steered along an S-curve."""

import numpy as np

from cca_core import PreviewController, VehicleParams, VehicleState, fit_path
from cca_core.sim import SingleTrackPlant

x = np.arange(0.0, 401.0, 10.0)
path = fit_path(np.column_stack((x, 8.0 * np.sin(x / 50.0))), tolerance=0.05)
vehicle = VehicleParams.bmw_320i()

for speed in (10.0, 20.0, 25.0):
    start = VehicleState(x=0.0, y=0.5, psi=float(path.heading(0.0)), v_x=speed)  # half a meter off
    plant, controller = SingleTrackPlant(vehicle, start), PreviewController(vehicle)
    s, errors, a_y = 0.0, [], []
    while s < path.end - 20.0:
        state = plant.state
        s, d, _, _ = path.foot_point(state.x, state.y, s_guess=s)
        plant.step(controller.steer(state, path), a_x=speed - state.v_x, dt=0.02)
        errors.append(abs(d))
        a_y.append(abs(plant.a_y))
    steady = errors[len(errors) // 4 :]
    print(f"{speed:4.0f} m/s: error {max(steady):.3f} m in steady state, peak a_y {max(a_y):.1f} m/s²")

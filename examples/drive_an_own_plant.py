"""Drive a plant of your own, a car with late brakes, through the paper's emergency braking."""

from math import atan, cos, exp, sin, tan

from cca_core import VehicleParams, VehicleState
from cca_core.sim import eebl, simulate


class LateBrakes:
    """A car that follows its wheels without slip; its brakes lag by 0.3 s."""

    def __init__(self, vehicle: VehicleParams, state: VehicleState) -> None:
        self.vehicle, self.state, self.a_y = vehicle, state, 0.0

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Advance by a time step [s]."""
        car, old = self.vehicle, self.state
        a_x = a_x + (old.a_x - a_x) * exp(-dt / 0.3)
        v = max(old.v_x + a_x * dt, 0.0)
        r = v * tan(delta) / (car.l_f + car.l_r)
        course = old.psi + atan(car.l_r * tan(delta) / (car.l_f + car.l_r))
        x, y = old.x + v * dt * cos(course), old.y + v * dt * sin(course)
        self.a_y = v * r
        self.state = VehicleState(x=x, y=y, psi=old.psi + r * dt, v_x=v, r=r, delta=delta, a_x=a_x)


for plant in ("single_track", LateBrakes):
    log = simulate(eebl("C"), plant=plant)
    key = log.summary()
    print(f"{log.plant}: min gap {key['min_gap_m']:.2f} m, collided: {key['collided']}")

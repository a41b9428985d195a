"""Drive a stub of CARLA's API, not CARLA: an actor that moves in left-handed axes, past a parked car."""

import math
from types import SimpleNamespace as Stub

from cca_core import Lane, Planner, Road, VehicleParams, fit_path
from cca_core.adapters import carla_remote, carla_state, to_carla_control


def make_actor(id: int, x: float, speed: float) -> Stub:
    """Make a stub of `carla.Vehicle`: a kinematic bicycle; y to the right, degrees clockwise."""
    actor = Stub(id=id, x=x, y=1.75, yaw=0.0, speed=speed, a=0.0, turn=0.0)
    actor.bounding_box = Stub(extent=Stub(x=2.25, y=0.8, z=0.7), location=Stub(x=0.0, y=0.0, z=0.0))

    def forward(length: float) -> Stub:
        yaw = math.radians(actor.yaw)
        return Stub(x=length * math.cos(yaw), y=length * math.sin(yaw))

    actor.get_transform = lambda: Stub(location=Stub(x=actor.x, y=actor.y), rotation=Stub(yaw=actor.yaw))
    actor.get_velocity, actor.get_acceleration = lambda: forward(actor.speed), lambda: forward(actor.a)
    actor.get_angular_velocity = lambda: Stub(x=0.0, y=0.0, z=actor.turn)
    return actor


ego, parked = make_actor(1, 0.0, 12.0), make_actor(2, 90.0, 0.0)  # with CARLA: world.get_actors()
car, delta, y = VehicleParams.bmw_320i(), 0.0, -1.75  # to the right is less than zero here
road = Road(fit_path([(x, y) for x in range(-20, 400, 20)], tolerance=0.1), [Lane(d=0.0), Lane(d=3.5)], 14.0)
planner = Planner(car, road, cruise_speed=13.0)
for k in range(700):
    state = carla_state(ego, car, delta=delta)
    command = planner.step(0.02 * k, state, [carla_remote(parked)])
    delta, control = command.delta, to_carla_control(command.delta, command.a_x, state.v_x)
    # with CARLA: ego.apply_control(carla.VehicleControl(*control)), then world.tick() of 0.02 s
    velocity, ego.a = ego.get_velocity(), 4.0 * control.throttle - 8.0 * control.brake - 0.3
    ego.turn = math.degrees(ego.speed * math.tan(math.radians(70.0 * control.steer)) / car.wheelbase)
    ego.x, ego.y, ego.yaw = ego.x + 0.02 * velocity.x, ego.y + 0.02 * velocity.y, ego.yaw + 0.02 * ego.turn
    ego.speed += 0.02 * ego.a
    if k % 70 == 0:
        print(f"x {state.x:5.1f} m, y {state.y:5.2f} m, {state.v_x:4.1f} m/s: {command.decision.reason}")

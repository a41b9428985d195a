"""Twenty vehicles around the ego: situations in which a decision has much to look at."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cca_core import Command, Lane, Path, Planner, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.path import fit_path
from cca_core.planner.actuate import dead_reckon

CAR = VehicleParams.bmw_320i()
DT = 0.02  # of a cycle [s]


@dataclass(frozen=True)
class Crowd:
    """A road, the ego's speeds, and other vehicles: place, heading and speed of each in the route's frame."""

    road: Road
    v_x: float
    cruise: float
    others: tuple[tuple[float, float, float, float], ...]  # s, d, angle, v
    start: float = 100.0


def road_with(*lanes: float, radius: float = math.inf) -> Road:
    """Road of 1.5 km: the ego's lane, and lanes at lateral offsets, negative direction if left of 3 m."""
    s = np.arange(0.0, 1501.0, 10.0)
    turn = s / radius
    xy = np.column_stack((s, 0.0 * s))
    if math.isfinite(radius):
        xy = radius * np.column_stack((np.sin(turn), 1.0 - np.cos(turn)))
    path: Path = fit_path(xy, tolerance=0.05)
    made = [Lane(d=0.0, width=3.5)] + [
        Lane(d=abs(d), width=3.5, direction=1 if d > 0.0 else -1) for d in lanes
    ]
    return Road(path, lanes=tuple(made), speed_limit=30.0)


def queue() -> Crowd:
    """A queue that ends in front of the ego, beside a lane of its direction."""
    return Crowd(
        road_with(3.5), 15.0, 20.0, tuple((190.0 + 9.0 * i, 0.1 * (i % 3), 0.0, 0.0) for i in range(20))
    )


def slow_queue() -> Crowd:
    """Slow vehicles a few meters apart, with an empty lane of the other direction beside."""
    return Crowd(
        road_with(-3.5, radius=600.0), 15.0, 20.0, tuple((160.0 + 14.0 * i, 0.0, 0.0, 5.0) for i in range(20))
    )


def crossing() -> Crowd:
    """Vehicles that cross the route one after another from both sides."""
    return Crowd(road_with(3.5), 14.0, 15.0, tuple(
        (170.0 + 6.0 * (i % 3), side * (8.0 + 9.0 * (i // 2)), -side * 0.5 * math.pi, 9.0)
        for i in range(20) for side in ((1.0, -1.0)[i % 2],)
    ))  # fmt: skip


def oblique() -> Crowd:
    """Vehicles that cross at an angle at which their ways overlap the route for long."""
    return Crowd(road_with(3.5), 14.0, 15.0, tuple(
        (130.0 + 5.0 * i, side * (5.0 + 4.0 * (i // 2)), -side * 0.45, 7.0 + 0.2 * i)
        for i in range(20) for side in ((1.0, -1.0)[i % 2],)
    ))  # fmt: skip


def dense() -> Crowd:
    """Two full lanes of one direction."""
    gone = 4  # where the ego is
    return Crowd(road_with(3.5), 22.0, 28.0, tuple(
        (60.0 + 22.0 * (i // 2) + 8.0 * (i % 2), 3.5 * (i % 2), 0.0, 18.0 + 5.0 * (i % 2)) for i in range(21)
        if i != gone
    ))  # fmt: skip


def oncoming() -> Crowd:
    """A slow vehicle ahead, two behind, and traffic against the ego in the other lane."""
    return Crowd(road_with(-3.5), 18.0, 22.0, (
        (150.0, 0.0, 0.0, 9.0), (60.0, 0.0, 0.0, 17.0), (30.0, 0.0, 0.0, 17.0),
        *((180.0 + 45.0 * i, 3.5, math.pi, 18.0) for i in range(17)),
    ))  # fmt: skip


def weaving() -> Crowd:
    """Parked and slow vehicles partly in the lane, on both sides, between lanes of both directions."""
    return Crowd(road_with(3.5, -7.0), 14.0, 18.0, tuple(
        (150.0 + 13.0 * i, (1.5, -1.6, 0.3, 5.2)[i % 4], 0.0, 0.5 * (i % 4)) for i in range(20)
    ))  # fmt: skip


CROWDS: dict[str, Callable[[], Crowd]] = {
    "queue": queue, "slow queue": slow_queue, "crossing": crossing, "oblique": oblique, "dense": dense,
    "oncoming": oncoming, "weaving": weaving,
}  # fmt: skip


def vehicles_at(crowd: Crowd, t: float) -> list[RemoteVehicle]:
    """Reports of the others after a time; those along the road follow it, others drive straight."""
    path, made = crowd.road.path, []
    for i, (s, d, angle, v) in enumerate(crowd.others):
        crosses = abs(math.sin(angle)) > 0.1
        x, y = path.to_cartesian(
            s if crosses else s + math.copysign(1.0, math.cos(angle)) * v * t, d
        ).tolist()
        psi = float(path.heading(s if crosses else s + math.cos(angle) * v * t)) + angle
        if crosses:
            x, y = x + v * t * math.cos(psi), y + v * t * math.sin(psi)
        made.append(RemoteVehicle(
            id=f"V{i}", x=x, y=y, psi=psi, v_x=v, age=0.05 * (i % 3), sigma_along=0.2, sigma_across=0.1,
        ))  # fmt: skip
    return made


def drive(crowd: Crowd, cycles: int, call: Callable[..., Command]) -> Planner:
    """Drive among a crowd; `call` makes each step."""
    planner = Planner(CAR, crowd.road, cruise_speed=crowd.cruise)
    x, y = crowd.road.path.position(crowd.start).tolist()
    state = VehicleState(x=x, y=y, psi=float(crowd.road.path.heading(crowd.start)), v_x=crowd.v_x)
    for k in range(cycles):
        command = call(planner, k * DT, state, vehicles_at(crowd, k * DT))
        state = dead_reckon(state, command.delta, command.a_x, DT, CAR)
    return planner

"""Long straight bodies in bends: what they cover on the route, and drives past them."""

import functools
import itertools
import math

import numpy as np
import pytest

from cca_core import Path, Planner, RemoteVehicle, Road, VehicleParams, VehicleState, fit_path
from cca_core.frenet import FrenetVehicle, to_frenet
from cca_core.geometry import box_gap, boxes
from cca_core.sim import SingleTrackPlant

CAR = VehicleParams.bmw_320i()
TURN = 0.75 * math.pi
STRAIGHT = 60.0  # before and after the bend [m]
WIDTH = 2.55
BENDS = list(itertools.product((15.0, 20.0, 30.0, 40.0), (20.0, 40.0, 60.0), (2.5, 4.5, 8.0), (1, -1)))


@functools.cache
def bend(radius: float, side: int, turn: float = TURN) -> Path:
    """Two straight lines with an arc between them, to the left for side 1."""
    angle = np.linspace(0.0, turn, max(12, int(0.5 * radius * turn)))
    arc = np.column_stack((STRAIGHT + radius * np.sin(angle), radius * (1.0 - np.cos(angle))))
    ahead = np.arange(2.0, STRAIGHT, 2.0)[:, None] * [math.cos(turn), math.sin(turn)]
    before = np.column_stack((np.arange(0.0, STRAIGHT, 2.0), np.zeros(int(STRAIGHT / 2.0))))
    return fit_path(np.concatenate((before, arc, arc[-1] + ahead)) * [1.0, side], tolerance=0.05)


def vehicle_at(path: Path, s: float, d: float, length: float, turned: float = 0.0) -> RemoteVehicle:
    """A stationary vehicle along the route, or turned from it."""
    x, y = path.to_cartesian(s, d)
    psi = float(path.heading(s)) + turned
    return RemoteVehicle(id="T", x=float(x), y=float(y), psi=psi, v_x=0.0, length=length, width=WIDTH)


def in_frenet(remote: RemoteVehicle, path: Path) -> FrenetVehicle:
    (vehicle,), dropped = to_frenet([remote], path, {}, (-9.0, 9.0))
    assert dropped == ()
    return vehicle


def body_points(remote: RemoteVehicle) -> np.ndarray:
    """Points all over a body."""
    along = (
        np.linspace(-0.5, 0.5, 41)[:, None, None]
        * remote.length
        * [math.cos(remote.psi), math.sin(remote.psi)]
    )
    across = np.linspace(-0.5, 0.5, 3)[:, None] * remote.width * [-math.sin(remote.psi), math.cos(remote.psi)]
    return (along + across + [remote.x, remote.y]).reshape(-1, 2)


@pytest.mark.parametrize("turned", [0.0, math.pi - 0.2], ids=str)
@pytest.mark.parametrize("part", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize("radius", [15.0, 40.0, 90.0])
def test_long_body_in_bend_is_covered(radius: float, part: float, turned: float) -> None:
    for length, d in itertools.product((8.0, 20.0, 60.0), (-4.0, 0.0, 3.5, 8.0)):
        side = 1 if d else -1
        path = bend(radius, side)
        remote = vehicle_at(path, STRAIGHT + part * radius * TURN, d * side, length, turned)
        vehicle, points = in_frenet(remote, path), body_points(remote)
        s, d_points = path.project(points)
        near = np.abs(d_points) < min(8.0, 0.9 * radius)
        assert (np.abs(d_points - vehicle.d)[near] <= vehicle.half_width + 0.11).all(), (length, d)
        assert (np.abs(s - vehicle.s)[near] <= vehicle.half_length + 0.5).all(), (length, d)


def test_straight_body_reaches_outward_only() -> None:
    """A left bend of 40 m, a body of 20 m 4 m left of it: its ends are at 40 - (36^2 + 10^2)^0.5."""
    path = bend(40.0, 1)
    vehicle = in_frenet(vehicle_at(path, STRAIGHT + 20.0 * TURN, 4.0, 20.0), path)
    assert vehicle.d + vehicle.half_width == pytest.approx(4.0 + 0.5 * WIDTH, abs=0.02)
    end = 40.0 - math.hypot(36.0 + 0.5 * WIDTH, 10.0)
    assert vehicle.d - vehicle.half_width == pytest.approx(end, abs=0.2)
    assert vehicle.v_s == 0.0


@pytest.mark.parametrize(("radius", "length"), [(100.0, 4.5), (40.0, 4.5), (400.0, 12.0), (2000.0, 30.0)])
def test_gentle_bend_changes_nothing(radius: float, length: float) -> None:
    path = bend(radius, 1, min(TURN, 200.0 / radius))
    remote = vehicle_at(path, STRAIGHT + 5.0, 2.0, length)
    s, d, heading, kappa = path.foot_point(remote.x, remote.y, STRAIGHT)
    plain = FrenetVehicle.from_remote(remote, s, d, remote.psi - heading, kappa)
    (found,), _ = to_frenet([remote], path, {"T": STRAIGHT}, (-9.0, 9.0))
    assert found == plain


def test_uncertainty_adds_to_the_extent_in_a_bend() -> None:
    path = bend(20.0, 1)
    remote = vehicle_at(path, STRAIGHT + 10.0, 4.0, 30.0)
    vague = RemoteVehicle(
        id="T", x=remote.x, y=remote.y, psi=remote.psi, v_x=0.0, length=30.0, width=WIDTH, sigma_along=2.0,
        sigma_across=0.5, age=3.0,
    )  # fmt: skip
    sure, unsure = in_frenet(remote, path), in_frenet(vague, path)
    assert unsure.half_width == pytest.approx(sure.half_width + 1.0, abs=1e-6)
    assert unsure.half_length == pytest.approx(sure.half_length + 4.0, abs=1e-6)
    assert unsure.nominal().half_width == sure.half_width
    assert unsure.nominal().half_length == sure.half_length


def test_long_body_beyond_the_range_reaches_into_it() -> None:
    """Its center is 12 m beside the route, on the inside of a bend of 40 m."""
    path = bend(40.0, 1)
    remote = vehicle_at(path, STRAIGHT + 40.0, 12.0, 50.0)
    vehicles, _ = to_frenet([remote], path, {}, (-6.0, 6.0))
    assert vehicles[0].d - vehicles[0].half_width < 6.0
    assert to_frenet([vehicle_at(path, STRAIGHT + 40.0, 12.0, 12.0)], path, {}, (-6.0, 6.0)) == ([], ())


def min_gap(radius: float, length: float, d: float, side: int, part: float) -> float:
    """Smallest gap of a drive at 7 m/s past a stationary vehicle on the inside of a bend."""
    path = bend(radius, side)
    remote = vehicle_at(path, STRAIGHT + part * radius * TURN, d * side, length)
    body = boxes(remote.x, remote.y, remote.psi, remote.length, remote.width)
    planner, smallest = Planner(CAR, Road(path), cruise_speed=7.0), math.inf
    plant = SingleTrackPlant(CAR, VehicleState(x=20.0, y=0.0, psi=0.0, v_x=7.0))
    for k in range(900):
        state = plant.state
        command = planner.step(0.02 * k, state, [remote])
        ego = boxes(*CAR.center_at(state.x, state.y, state.psi), state.psi, CAR.length, CAR.width)
        smallest = min(smallest, float(box_gap(ego, body)))
        if smallest <= 0.0 or (k > 100 and state.v_x < 0.01):
            break
        plant.step(command.delta, command.a_x, 0.02)
    return smallest


@pytest.mark.parametrize(
    ("radius", "length", "d", "side"),
    [(15.0, 20.0, 2.5, 1), (20.0, 60.0, 8.0, -1), (40.0, 40.0, 4.5, 1), (30.0, 30.0, 5.0, -1)],
)
def test_ego_keeps_clear_of_long_body_in_bend(radius: float, length: float, d: float, side: int) -> None:
    assert min_gap(radius, length, d, side, 0.4) > 0.2


@pytest.mark.slow
@pytest.mark.parametrize(("radius", "length", "d", "side"), BENDS)
def test_ego_keeps_clear_of_any_long_body(radius: float, length: float, d: float, side: int) -> None:
    for part in (0.0, 0.3, 0.5, 1.0):
        assert min_gap(radius, length, d, side, part) > 0.0, part

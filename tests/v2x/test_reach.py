"""Soundness: what a tracker returns and what prediction assumes cover every motion within the limits."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import LocalFrame, RemoteVehicle, VehicleParams, danger_zone, fit_path
from cca_core.decide import CrossingSettings, find_conflict
from cca_core.frenet import FrenetVehicle
from cca_core.predict import predict_ctra
from cca_core.v2x import Bsm, Tracker, encode_bsm

FRAME = LocalFrame(41.0, -104.0)
T0 = 6000.0
BRAKING, ACCELERATION = 8.0, 3.0
TIMES = np.linspace(0.0, 6.0, 25)
STEP = 0.02
HALF = 2.25  # of the body [m]


def tracked(v: float, a_x: float, age: float, psi: float = 0.0, y: float = 0.0) -> RemoteVehicle:
    """A vehicle that has reported its motion at x = 0 once."""
    tracker = Tracker(FRAME)
    lat, lon = FRAME.to_geodetic((0.0, y))
    message = Bsm(
        msg_count=1, id="00000001", sec_mark=T0 % 60.0, latitude_deg=float(lat), longitude_deg=float(lon),
        speed=v, psi=psi, a_x=a_x, r=0.0, length=2.0 * HALF, width=1.8, transmission="forward",
    )  # fmt: skip
    assert tracker.update(encode_bsm(message), T0).accepted
    (vehicle,) = tracker.vehicles(T0 + age)
    return vehicle


def driven(v: float, rates: np.ndarray) -> np.ndarray:
    """Distances after each step of vehicles with an acceleration in each, that do not reverse."""
    speeds = np.full((len(rates), rates.shape[1] + 1), v)
    for k in range(rates.shape[1]):
        speeds[:, k + 1] = np.maximum(speeds[:, k] + STEP * rates[:, k], 0.0)
    mean = 0.5 * (speeds[:, 1:] + speeds[:, :-1])
    return np.concatenate((np.zeros((len(rates), 1)), np.cumsum(STEP * mean, axis=1)), axis=1)


def adversaries(
    age: float, v: float, seed: int, limits: tuple[float, float] = (BRAKING, ACCELERATION)
) -> np.ndarray:
    """Distances from the measurement on: accelerations that change twice between the limits, or at random."""
    n = math.ceil((age + TIMES[-1]) / STEP) + 1
    t = STEP * np.arange(n)
    moments = sorted({0.0, 0.5 * age, age, age + 0.5, age + 2.0, v / limits[0]})
    rates = [
        np.choose((t >= first).astype(int) + (t >= second), values)
        for first, second in itertools.combinations(moments, 2)
        for values in itertools.product((-limits[0], 0.0, limits[1]), repeat=3)
    ]
    rng = np.random.default_rng(seed)
    rates += [np.repeat(rng.uniform(-limits[0], limits[1], n // 20 + 1), 20)[:n] for _ in range(20)]
    return driven(v, np.array(rates))


def sampled(distances: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Distances at times."""
    t = STEP * np.arange(distances.shape[1])
    return np.array([np.interp(at, t, row) for row in distances])


CASES = [
    (v, a_x, age)
    for v in (0.3, 4.0, 9.0, 25.0)
    for a_x in (-8.0, -4.0, 0.0, 3.0)
    for age in (0.0, 0.1, 0.5, 0.95, 1.0)
]
STALE_CASES = [(v, a_x, age) for v, a_x, _ in CASES[::5] for age in (1.02, 1.5, 3.0, 10.0)]


def assert_covered(v: float, a_x: float, age: float, center: np.ndarray, psi: float) -> None:
    """Assert that bodies at distances are within the occupied interval of the reported vehicle."""
    vehicle = tracked(v, a_x, age, psi)
    reported = FrenetVehicle.from_remote(vehicle, vehicle.x, vehicle.y, vehicle.psi, 0.0)
    rear, front = reported.occupied_interval(TIMES, braking=BRAKING, acceleration=ACCELERATION)
    center = math.cos(psi) * center
    assert (rear - 0.02 <= center - HALF).all(), (v, a_x, age, (center - HALF - rear).min())
    assert (center + HALF <= front + 0.02).all(), (v, a_x, age, (front - center - HALF).min())


@pytest.mark.parametrize("psi", [0.0, math.pi], ids=["along", "oncoming"])
def test_occupied_interval_covers_all_motions(psi: float) -> None:
    for i, (v, a_x, age) in enumerate(CASES):
        assert_covered(v, a_x, age, sampled(adversaries(age, v, i), age + TIMES), psi)


@pytest.mark.parametrize("psi", [0.0, math.pi], ids=["along", "oncoming"])
def test_occupied_interval_covers_motions_of_stale_vehicle(psi: float) -> None:
    """Nothing is lost at an age of 1 s: the reported speed and acceleration are known beyond it."""
    for i, (v, a_x, age) in enumerate(STALE_CASES):
        assert_covered(v, a_x, age, sampled(adversaries(age, v, i), age + TIMES), psi)


RATE = st.floats(-BRAKING, ACCELERATION)


@given(
    st.floats(0.0, 40.0), RATE, st.floats(0.0, 4.0), st.lists(RATE, min_size=1, max_size=8),
    st.sampled_from([0.0, math.pi]),
)  # fmt: skip
def test_occupied_interval_covers_any_motion(
    v: float, a_x: float, age: float, rates: list[float], psi: float
) -> None:
    n = math.ceil((age + TIMES[-1]) / STEP) + 1
    steps = np.array(rates)[np.arange(n) * len(rates) // n]
    distances = driven(round(v / 0.02) * 0.02, steps[None, :])
    assert_covered(v, a_x, age, sampled(distances, age + TIMES), psi)


def test_danger_zone_covers_all_motions() -> None:
    """An ego at 15 m/s and an oncoming vehicle 200 m ahead."""
    travel = 15.0 * TIMES
    for i, (v, a_x, age) in enumerate(CASES):
        vehicle = tracked(v, a_x, age, math.pi)
        reported = FrenetVehicle.from_remote(vehicle, vehicle.x + 200.0, vehicle.y, vehicle.psi, 0.0)
        zone = danger_zone(
            reported.rear, reported.front, reported.v_s, times=TIMES, ego_travel=travel, x_safety=0.0,
            age=vehicle.age, braking=BRAKING, acceleration=ACCELERATION, a_reported=reported.speed_rate,
        )  # fmt: skip
        relative = 200.0 - sampled(adversaries(age, v, i), age + TIMES) - travel
        assert zone[0] <= relative.min() - HALF + 0.02, (v, a_x, age)
        assert relative.max() + HALF <= zone[1] + 0.02, (v, a_x, age)


def test_conflict_covers_all_motions() -> None:
    """A vehicle that crosses the route: its times in the conflict area, whatever it did since the message."""
    settings = CrossingSettings()
    limits = settings.b_max, settings.a_max
    path = fit_path(np.column_stack((np.linspace(-60.0, 140.0, 41), np.zeros(41))))
    stations, times = np.array([20.0, 160.0]), np.array([0.0, 14.0])

    def conflict_of(vehicle: RemoteVehicle):
        car = VehicleParams.bmw_320i()
        return find_conflict(path, 60.0, stations, times, car, vehicle, horizon=20.0, settings=settings)

    for i, (v, a_x, age) in enumerate((v, a, age) for v, a, age in CASES if v > 1.0 and age > 0.0):
        exact = conflict_of(tracked(v, 0.0, 0.0, 0.5 * math.pi, y=-40.0))
        conflict = conflict_of(tracked(v, a_x, age, 0.5 * math.pi, y=-40.0))
        assert exact is not None
        assert conflict is not None, (v, a_x, age)
        enters, leaves = (v * t for t in exact.t_other_nominal)
        for distance in adversaries(age, v, i, limits):
            t = STEP * np.arange(len(distance)) - age
            inside = t[(distance >= enters + 0.5) & (distance <= leaves - 0.5) & (t >= 0.0)]
            if len(inside):
                assert conflict.t_other[0] <= inside[0] + STEP, (v, a_x, age)
                assert inside[-1] <= conflict.t_other[1] + STEP, (v, a_x, age)


def test_truck_that_reported_braking_may_keep_its_speed() -> None:
    """Reported 9 m/s and -8 m/s^2 0.95 s ago: it may have accelerated since."""
    vehicle = tracked(9.0, -8.0, 0.95, math.pi)
    reported = FrenetVehicle.from_remote(vehicle, vehicle.x, vehicle.y, vehicle.psi, 0.0)
    rear, _ = reported.occupied_interval(np.array([4.0]), braking=BRAKING, acceleration=ACCELERATION)
    assert rear[0] <= -(9.0 * 4.95 + 0.5 * ACCELERATION * 4.95**2) - HALF


@pytest.mark.parametrize("a_x", [-8.0, -4.0])
def test_stopped_vehicle_does_not_reverse(a_x: float) -> None:
    """The nominal prediction of a vehicle that braked to standstill, and reported it."""
    vehicle = tracked(4.0, a_x, 1.0)
    assert (vehicle.v_x, vehicle.a_x) == (0.0, a_x)
    x, _, _ = predict_ctra(vehicle, np.array([0.0, 3.0]))
    assert x[1] == x[0]

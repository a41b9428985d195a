"""The ego's own messages, heard back under an unknown id with the noise of a receiver."""

import math
from typing import Any

import numpy as np
import pytest

from cca_core import Planner, Road, VehicleParams, VehicleState, fit_path
from cca_core.sim import SingleTrackPlant
from cca_core.v2x import Tracker
from tests.support.v2x_messages import FRAME, T0, bsm

CAR = VehicleParams.bmw_320i()
CYCLE = 0.02  # [s]
TURN = np.linspace(0.0, 4.0, 200)
CURVE = fit_path(np.column_stack((60.0 * np.sin(TURN), 60.0 - 60.0 * np.cos(TURN))), tolerance=0.05)
STRAIGHT = fit_path([[0.0, 0.0], [400.0, 0.0], [900.0, 0.0]])


class Echo:
    """Errors of the ego's position in its own messages, which last for `correlation` seconds."""

    def __init__(self, noise: float, seed: int, correlation: float = 0.0) -> None:
        self.noise, self.correlation, self.rng = noise, correlation, np.random.default_rng(seed)
        self.error = self.rng.normal(0.0, noise, 2)

    def offset(self) -> np.ndarray:
        kept = math.exp(-0.1 / self.correlation) if self.correlation else 0.0
        fresh = self.rng.normal(0.0, self.noise, 2)
        self.error = kept * self.error + math.sqrt(1.0 - kept * kept) * fresh
        return self.error


def lost_speed(
    noise: float,
    seed: int,
    *,
    v: float = 15.0,
    path: Any = STRAIGHT,
    correlation: float = 0.0,
    new_id_after: float = math.inf,
    latency: float = 0.05,
    speed_noise: float = 0.0,
    loss: float = 0.0,
    seconds: float = 6.0,
) -> float:
    """Largest loss of speed of an ego that hears its own messages [m/s]."""  # fmt: skip
    echo, tracker, planner = (
        Echo(noise, seed, correlation),
        Tracker(FRAME),
        Planner(CAR, Road(path), cruise_speed=v),
    )
    (x, y), psi = path.position(5.0), float(path.heading(5.0))
    plant, slowest = SingleTrackPlant(CAR, VehicleState(x=float(x), y=float(y), psi=psi, v_x=v)), v
    waiting: list[tuple[float, Any]] = []
    for k in range(round(seconds / CYCLE)):
        t, state = T0 + CYCLE * k, plant.state
        if k % 5 == 0 and echo.rng.random() >= loss:
            dx, dy = echo.offset()
            name = "000000ee" if t - T0 < new_id_after else "000000ef"
            message = bsm(
                t, state.x + dx, state.y + dy, v=state.v_x + abs(echo.rng.normal(0.0, speed_noise)),
                r=state.r, psi=state.psi, a_x=state.a_x, id=name, length=CAR.length, width=CAR.width,
            )  # fmt: skip
            waiting.append((t + latency, message))
        while waiting and waiting[0][0] <= t:
            tracker.update(waiting.pop(0)[1], t)
        command = planner.step(t, state, tracker.vehicles(t, state), radio=tracker.health(t))
        plant.step(command.delta, command.a_x, CYCLE)
        slowest = min(slowest, plant.state.v_x)
    return v - slowest


@pytest.mark.parametrize("noise", [0.0, 0.5, 1.0, 1.5])
def test_own_messages_do_not_brake_the_ego(noise: float) -> None:
    for seed in range(3):
        assert lost_speed(noise, seed) < 1.0, seed


@pytest.mark.parametrize(
    "values",
    [
        {"correlation": 5.0}, {"correlation": 30.0}, {"path": CURVE, "v": 12.0}, {"new_id_after": 3.0},
        {"latency": 0.2}, {"loss": 0.3}, {"speed_noise": 0.2},
    ],
    ids=["drift", "slow-drift", "curve", "new-id", "latency", "loss", "speed"],
)  # fmt: skip
def test_own_messages_of_any_kind_do_not_brake(values: dict[str, Any]) -> None:
    for seed in range(3):
        assert lost_speed(1.0, seed, **values) < 1.0, seed


@pytest.mark.slow
@pytest.mark.parametrize("correlation", [0.0, 5.0])
def test_own_messages_with_many_noises_do_not_brake(correlation: float) -> None:
    lost = [lost_speed(1.0, seed, correlation=correlation) for seed in range(60)]
    assert sorted(lost)[-2] < 1.5


@pytest.mark.parametrize("noise", [0.0, 0.5])
@pytest.mark.parametrize(
    ("lag", "part"), [(0.0, 1.0), (0.4, 1.0), (0.0, 0.7), (0.0, 1.4)], ids=["same", "later", "less", "more"]
)
@pytest.mark.parametrize("y", [3.0, -2.0])
def test_vehicle_that_brakes_with_the_ego_is_listed(y: float, lag: float, part: float, noise: float) -> None:
    """Alongside in the next lane; closer too, unless it brakes at the same time by as much."""
    if abs(y) < 3.0 and (lag, part) == (0.0, 1.0):
        y = math.copysign(2.8, y)
    tracker, rng, x, x_ego = Tracker(FRAME), np.random.default_rng(5), 0.5, 0.0
    for k in range(100):
        t = 0.1 * k
        v_ego, v = (
            20.0 - a * min(max(t - begin, 0.0), 3.0) for a, begin in ((3.0, 4.0), (3.0 * part, 4.0 + lag))
        )
        x_ego, x = x_ego + 0.1 * v_ego, x + 0.1 * v
        tracker.update(bsm(T0 + t, *rng.normal((x, y), noise), v=v), T0 + t)
        ego = VehicleState(x=x_ego, y=0.0, psi=0.0, v_x=v_ego)
        assert tracker.vehicles(T0 + t, ego) or abs(x - x_ego) > 9.0, t


@pytest.mark.parametrize("noise", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(
    ("x", "y", "dv"),
    [
        (0.0, 3.5, 0.0),
        (1.0, -3.0, 0.0),
        (-30.0, 3.2, 0.9),
        (6.5, 0.0, 0.0),
        (-6.5, 0.0, 0.0),
        (0.0, 2.8, 0.5),
    ],
    ids=["alongside", "right", "overtaking", "ahead", "behind", "close"],
)
def test_other_vehicle_near_the_ego_is_listed(x: float, y: float, dv: float, noise: float) -> None:
    """Its speed differs by less than that of the ego in its own messages may."""
    for seed in range(5):
        tracker, rng, missing = Tracker(FRAME), np.random.default_rng(seed), 0
        for k in range(300):
            t, ego = T0 + 0.1 * k, VehicleState(x=1.5 * k, y=0.0, psi=0.0, v_x=15.0)
            at = ego.x + x + min(dv * 0.1 * k, 40.0), y
            if abs(at[0] - ego.x) > 20.0 and k > 100:
                break
            tracker.update(bsm(t, *rng.normal(at, noise), v=15.0 + dv), t)
            missing += not tracker.vehicles(t, ego)
        assert missing <= (0 if noise < 0.7 else 3), seed


def test_vehicle_that_leaves_the_ego_is_listed_at_once() -> None:
    """A body that was on the ego's place is a vehicle as soon as its place differs by a lane."""
    tracker = Tracker(FRAME)
    for k in range(40):
        t, ego = T0 + 0.1 * k, VehicleState(x=1.5 * k, y=0.0, psi=0.0, v_x=15.0)
        tracker.update(bsm(t, 1.5 * k, 3.5 if k > 30 else 0.0, v=15.0), t)
        assert bool(tracker.vehicles(t, ego)) == (k > 30 or k < 1)


def test_own_track_that_became_silent_is_deleted() -> None:
    tracker = Tracker(FRAME)
    for k in range(60):
        t, ego = T0 + 0.1 * k, VehicleState(x=1.5 * k, y=0.0, psi=0.0, v_x=15.0)
        if k < 30:
            tracker.update(bsm(t, 1.5 * k, 0.3, v=15.0), t)
        listed = tracker.vehicles(t, ego)
        assert k < 2 or not listed
    assert len(tracker) == 0

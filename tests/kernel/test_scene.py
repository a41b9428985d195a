"""Scenes in the kernel: traffic, conflicts, rollouts and checks have the same bits in both forms."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cca_core.kernel.conflicts import find_conflicts
from cca_core.kernel.gap_checks import check_nominal, check_worst_case
from cca_core.kernel.memory import lend
from cca_core.kernel.obstacles import find_meetings, find_obstacles, find_span
from cca_core.kernel.rollout import limit_path_speed, roll_out, sum_costs
from cca_core.kernel.scene import Scene
from cca_core.kernel.traffic import locate_vehicles
from cca_core.predict import predict_ctra, reachable_interval
from cca_core.vehicle import RemoteVehicle
from tests.support.kernel_curves import random_curve
from tests.support.kernel_forms import QUICK, Filled, check_forms, needs_c

Random = np.random.Generator
N, STEPS, VEHICLES = 90, 12, 4
MANY = 5_000
SIZES = {"n": N, "max_m": VEHICLES, "max_paths": 2, "max_rows": 2, "steps": STEPS, "max_lanes": 1}
SCRATCH = (
    "order leads met turn scale wide bends "
    "x_e y_e c_e s_e x_p y_p c_p s_p x_b y_b r_b s_enter s_exit t_enter t_exit"
).split()  # what each call writes before it reads


def numbers(random: Random) -> dict[str, Any]:
    """The ego, its limits and what is assumed."""
    positive = {
        "half_length": 2.3, "half_width": 0.9, "a_max": 2.0, "b_comfort": 2.0, "b_max": 8.0, "b_soft": 5.0,
        "grip": 9.0, "standstill_gap": 2.0, "time_gap": 1.4, "approach_rate": 0.5, "jerk": 5.0,
        "jerk_emergency": 20.0, "lag": 0.15, "blocking_gap": 0.3, "look": 1.6, "react": 0.4,
        "creep_time": 0.5, "opening_speed": 2.0, "b_firm": 3.5,
        "risk_until": 9.0, "rear_braking": 2.0, "v_limit": 25.0, "braking_time": 4.0,
        "acceleration_time": 1.0, "min_pet": 1.0, "entry_tolerance": 0.2,
        "queue_gap": 15.0, "passing_gap": 7.0,
    }  # fmt: skip
    values = {name: float(value * random.uniform(0.7, 1.3)) for name, value in positive.items()}
    bounds = {
        name: float(random.uniform(0.0, 8.0)) for name in ("b_other", "a_other", "b_crossing", "a_crossing")
    }
    return values | bounds | {
        "lane_right": -1.75, "lane_left": 1.75, "edge_right": -5.25, "edge_left": 5.25,
        "crossing_time": 0.5, "yield_time": 1.0, "offset": float(random.normal(0.0, 1.0)),
        "s_0": float(random.uniform(15.0, 40.0)), "v_0": float(random.uniform(0.0, 25.0)),
        "a_0": float(random.normal(0.0, 2.0)), "a_true": float(random.normal(0.0, 2.0)), "a_passed": 0.0,
        "margin": float(random.uniform(0.0, 1.0)), "rear_reaction": float(random.choice([0.0, 1.5])),
        "keeps": bool(random.integers(0, 2)),
        "established": int(random.integers(0, 3)), "leaves": bool(random.integers(0, 2)),
        "zone_from": 0.5, "begin_from": 0.2, "zone_side": int(random.integers(1, 3)),
    }  # fmt: skip


def seen(random: Random) -> np.ndarray:
    """Columns of vehicles near the ego, some of which cross, stand, come or are wide of the road."""
    rows = np.zeros((VEHICLES, 27))
    crosses = random.integers(0, 3, VEHICLES) == 0
    rows[:, 0] = random.uniform(-10.0, N, VEHICLES)
    rows[:, 1] = random.normal(0.0, 3.0, VEHICLES)
    rows[:, 2] = random.normal(8.0, 10.0, VEHICLES) * random.integers(0, 4, VEHICLES).clip(0, 1)
    rows[:, 3:7] = random.uniform(1.0, 3.0, (VEHICLES, 4))
    rows[:, 7] = random.normal(0.0, 2.0, VEHICLES)
    rows[:, 8] = np.minimum(rows[:, 7], random.normal(0.0, 4.0, VEHICLES))
    rows[:, 9] = random.uniform(0.0, 1.5, VEHICLES)
    rows[:, 10] = np.sign(rows[:, 2])
    rows[:, 11:13] = random.uniform((-1.0, 0.0), (1.0, 3.0), (VEHICLES, 2))
    rows[:, 13] = crosses
    rows[:, 14], rows[:, 15] = rows[:, 0], random.normal(0.0, 20.0, VEHICLES)
    rows[:, 16:20] = random.normal(0.0, 1.0, (VEHICLES, 4)) * (2.0, 10.0, 2.0, 0.3)
    rows[:, 20:22] = random.uniform(1.0, 3.0, (VEHICLES, 2))
    rows[:, 22:25] = random.uniform((0.0, 0.0, -1.0), (30.0, 0.3, 1.5), (VEHICLES, 3))
    rows[:, 25] = rows[:, 1] + random.normal(0.0, 0.5, VEHICLES)
    rows[:, 26] = random.integers(0, 2, VEHICLES)
    return rows


def given(random: Random) -> dict[str, Any]:
    """A scene before anything is computed: route, one path that leaves it, and what is seen."""
    along = np.arange(float(N))
    kappa = random.normal(0.0, 0.01)
    leaves = 3.0 * np.clip((along - 40.0) / 15.0, 0.0, 1.0) * random.normal(0.0, 1.0)
    return numbers(random) | {
        "x": along, "y": 0.5 * kappa * along**2, "psi": kappa * along, "kappa": np.full(N, kappa),
        "cap": random.uniform(0.0, 900.0, N), "d": np.stack((np.zeros(N), leaves)),
        "overtakes": random.integers(0, 2, (2, VEHICLES)).astype(float), "m": VEHICLES,
        "t": np.concatenate((0.1 * np.arange(6), 0.6 + 0.8 * np.arange(STEPS - 6))), "seen": seen(random),
        "stop_s": random.uniform(30.0, 80.0, 8), "stop_until": random.uniform(0.0, 5.0, 8), "stops": 2,
        "other_lanes": (1.75, 5.25),
    }  # fmt: skip


def scene_after(random: Random, *calls: Callable[[Any], object]) -> Filled:
    """A scene after some calls."""
    lent = lend(Scene, "python", **SIZES)
    for name, value in given(random).items():
        if name in lent.arrays:
            lent.arrays[name][...] = value
        else:
            setattr(lent.workspace, name, value)
    for call in calls:
        call(lent.workspace)
    values = {name: array for name, array in lent.arrays.items() if name not in SCRATCH}
    work: Any = lent.workspace
    values |= {name: getattr(work, name) for name in given(random) if name not in lent.arrays}
    return Filled(Scene, SIZES, values | {"crossing": work.crossing})


def located(w: Any) -> None:
    """Place the vehicles."""
    locate_vehicles(w, VEHICLES - 1)


def driven(w: Any) -> None:
    """Place the vehicles and drive the path that leaves the route."""
    located(w)
    for p in range(2):
        limit_path_speed(w, p, 3.0)
    for row in range(2):
        roll_out(w, row, 1, True, False, 2, 0.0, 0.0, False)


def obstacles(random: Random) -> tuple[Any, ...]:
    """Stations of a band, the times at which the ego is there, and a group of one."""
    _, curve = random_curve(random)
    n, group = int(random.integers(1, 9)), int(random.integers(0, 2))
    s, t = np.sort(random.uniform(0.0, N, n)), np.sort(random.uniform(-0.1, 6.0, n))
    rows, boxes = np.zeros(VEHICLES, dtype=np.int32), np.zeros((VEHICLES * n, 5))
    return scene_after(random, driven), curve, 3.0, n, s, t, 10.0, group, VEHICLES, rows, boxes


SAMPLERS: dict[str, tuple[Callable[..., Any], Callable[[Random], tuple[Any, ...]]]] = {
    "place": (locate_vehicles, lambda r: (Filled(Scene, SIZES, given(r)), int(r.integers(0, VEHICLES + 1)))),
    "limit": (limit_path_speed, lambda r: (Filled(Scene, SIZES, given(r)), 1, float(r.uniform(1.0, 4.0)))),
    "conflicts": (find_conflicts, lambda r: (scene_after(r, located), 1, int(r.integers(0, 45)), 0.5)),
    "roll out": (roll_out, lambda r: (
        scene_after(r, driven), 1, int(r.integers(0, 2)), bool(r.integers(0, 2)), bool(r.integers(0, 2)),
        int(r.integers(0, 3)), *r.choice([0.0, 4.0], 2).tolist(), bool(r.integers(0, 2)),
    )),
    "meetings": (find_meetings, lambda r: (scene_after(r, driven), 0, float(r.uniform(0.0, 40.0)))),
    "span": (find_span, lambda r: (
        scene_after(r, driven), 0, int(r.integers(0, VEHICLES)), *r.uniform(0.0, 1.0, 2).tolist(),
    )),
    "obstacles": (find_obstacles, obstacles),
    "costs": (sum_costs, lambda r: (scene_after(r, driven), 0, 1, float(r.uniform(0.0, 9.0)))),
    "nominal": (check_nominal, lambda r: (scene_after(r, driven), 0, 1, *r.uniform(0.0, 1.0, 5).tolist())),
    "worst case": (check_worst_case, lambda r: (
        scene_after(r, driven), 0, 1, *r.uniform(0.0, 1.0, 3).tolist(), float(r.choice([0.0, 5.0])),
        int(r.integers(0, 3)),
    )),
}  # fmt: skip


@needs_c
@pytest.mark.parametrize("name", SAMPLERS)
@pytest.mark.parametrize("count", [QUICK // 4, pytest.param(MANY, marks=pytest.mark.slow)])
def test_scene_in_c_equals_python(name: str, count: int) -> None:
    function, sampler = SAMPLERS[name]
    check_forms(function, sampler, count)


def locate_one(**columns: float) -> dict[str, Any]:
    """Place a vehicle of some columns; return the arrays of the scene."""
    names = "s d v half_l half_w nominal_l nominal_w rate nominal_rate age ahead side range crosses"
    names += " x y psi v_x a_x r body_l body_w bulge bend_w sure_w nominal_d leaves"
    lent = lend(Scene, "python", **SIZES)
    work: Any = lent.workspace
    for name, value in given(np.random.default_rng(0)).items():
        if name in lent.arrays:
            lent.arrays[name][...] = value
        else:
            setattr(work, name, value)
    work.m, work.keeps, work.v_limit, work.b_other, work.a_other = 1, False, 99.0, 6.0, 2.0
    lent.arrays["seen"][0] = [columns.get(name, 0.0) for name in names.split()]
    locate_vehicles(work, 1)
    return lent.arrays


@pytest.mark.parametrize(
    ("v", "rate", "age"), [(12.0, 0.0, 0.0), (-9.0, -1.0, 0.4), (0.2, 0.0, 0.1), (7.0, 3.0, 0.8)]
)
def test_worst_case_along_equals_reachable_interval(v: float, rate: float, age: float) -> None:
    rows = locate_one(s=40.0, v=v, half_l=2.0, rate=rate, nominal_rate=rate, age=age, ahead=v)
    limits = {"braking": max(6.0, -rate), "acceleration": max(2.0, rate)}
    low, high = reachable_interval(v, rows["t"], age=age, a_reported=rate, **limits)
    if abs(v) < 0.5:  # what stands does not reverse, but may have braked since its report
        low = np.maximum(low, 0.5 * v * v / limits["braking"] - v * age)
    np.testing.assert_allclose(rows["low"][0], 38.0 + low, atol=1e-9)
    np.testing.assert_allclose(rows["high"][0], 42.0 + high, atol=1e-9)


@pytest.mark.parametrize(("v", "a", "r"), [(9.0, 0.0, 0.0), (9.0, -3.0, 0.2), (-4.0, 0.0, -0.3)])
def test_crossing_vehicle_moves_as_ctra_predicts(v: float, a: float, r: float) -> None:
    rows = locate_one(crosses=1.0, x=30.0, y=-8.0, psi=1.4, v_x=v, a_x=a, r=r)
    remote = RemoteVehicle(id="A", x=30.0, y=-8.0, psi=1.4, v_x=v, a_x=a, r=r)
    for name, expected in zip(("x_o", "y_o", "psi_o"), predict_ctra(remote, rows["t"]), strict=True):
        np.testing.assert_allclose(rows[name][0], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("v", "a", "age"), [(9.0, -3.0, 0.0), (9.0, -3.0, 0.4), (1.0, -3.0, 0.1), (9.0, -3.0, 1.2)]
)
def test_crossing_vehicle_that_brakes_goes_on_for_a_second(v: float, a: float, age: float) -> None:
    """In the worst case it accelerates after that; a report that is older says nothing about now."""
    rows = locate_one(crosses=1.0, psi=0.0, v_x=v, a_x=a, age=age, body_l=2.0)
    random = given(np.random.default_rng(0))
    t, a_max = rows["t"] + random["min_pet"], random["a_crossing"]
    braking = np.minimum(np.minimum(max(1.0 - age, 0.0), t), v / -a)
    then, speed = t - braking, v + a * braking
    expected = v * braking + 0.5 * a * braking**2 + speed * then + 0.5 * a_max * then**2
    _, bound = reachable_interval(
        v, t, age=age, a_reported=0.0, braking=max(random["b_crossing"], -a), acceleration=a_max
    )
    front = rows["x_w"][0] + rows["half_l_w"][0] - 2.0
    np.testing.assert_allclose(front, bound if age > 1.0 else np.minimum(bound, expected), atol=1e-9)


@pytest.mark.parametrize("kept", [False, True])
def test_motion_before_tail_equals_plan(kept: bool) -> None:
    """What is driven until the tail begins is what its check assumes."""
    differ = 0
    for seed in range(40):
        random = np.random.default_rng((77, seed))
        rows = driven_with_tail(random, kept=kept)
        begin = int(np.argmax(rows["t"] >= rows["react"] - 1e-9))
        for name in ("s", "v"):
            np.testing.assert_array_equal(rows[name][0, : begin + 1], rows[name][1, : begin + 1])
        np.testing.assert_array_equal(rows["a"][0, :begin], rows["a"][1, :begin])
        differ += not np.array_equal(rows["a"][0], rows["a"][1])
    assert differ > 20


def driven_with_tail(random: Random, *, kept: bool) -> dict[str, Any]:
    """Drive a path without and with a braking tail."""
    lent = lend(Scene, "python", **SIZES)
    work: Any = lent.workspace
    for name, value in given(random).items():
        if name in lent.arrays:
            lent.arrays[name][...] = value
        else:
            setattr(work, name, value)
    work.react = 0.4
    located(work)
    limit_path_speed(work, 1, 3.0)
    lent.arrays["a"][:] = random.uniform(-4.0, 1.0, STEPS)
    for row, tail in enumerate((0.0, 7.0)):
        roll_out(work, row, 1, True, False, 2, 0.0, tail, kept)
    return {**lent.arrays, "react": 0.4}

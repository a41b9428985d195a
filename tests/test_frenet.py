"""Frenet coordinates of vehicles, one by one and in a batch."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import RemoteVehicle
from cca_core.frenet import FrenetVehicle, to_frenet
from cca_core.frenet.branches import Branches
from cca_core.path import fit_path

S = np.linspace(0.0, 3.0, 60)
PATH = fit_path(np.column_stack((150.0 * np.sin(S), 150.0 * (1.0 - np.cos(S)))), tolerance=0.05)


def remotes(n: int, d: float = 12.0, seed: int = 1) -> list[RemoteVehicle]:
    """Vehicles with lateral offsets up to `d` and any heading."""
    rng = np.random.default_rng(seed)
    s, d_vehicle = rng.uniform(-20.0, PATH.length + 20.0, n), rng.uniform(-d, d, n)
    xy, psi = PATH.to_cartesian(s, d_vehicle), rng.uniform(-math.pi, math.pi, n)
    return [
        RemoteVehicle(id=str(i), x=float(x), y=float(y), psi=float(p), v_x=10.0, sigma_along=1.0)
        for i, ((x, y), p) in enumerate(zip(xy, psi, strict=True))
    ]


@pytest.mark.parametrize("warm", [False, True])
def test_batch_projection_equals_scalar(warm: bool) -> None:
    many, last_s = remotes(80), {}
    if warm:
        to_frenet(many, PATH, last_s)
        many = [replace(r, x=r.x + 0.3, y=r.y - 0.2) for r in many]
    before = dict(last_s)
    together, _ = to_frenet(many, PATH, last_s)
    assert len(together) == len(last_s) == 80
    for remote, vehicle in zip(many, together, strict=True):
        guess = {remote.id: before[remote.id]} if warm else {}
        (alone,), _ = to_frenet([remote], PATH, guess)
        for name in ("s", "d", "v_s", "half_length", "half_width", "angle"):
            assert getattr(vehicle, name) == pytest.approx(getattr(alone, name), abs=1e-6)
        assert guess[remote.id] == pytest.approx(last_s[remote.id], abs=1e-6)


def test_single_vehicle_is_accepted() -> None:
    (at,) = PATH.to_cartesian([100.0], [0.0])
    van = RemoteVehicle(id="van", x=float(at[0]), y=float(at[1]), psi=float(PATH.heading(100.0)), v_x=10.0)
    (vehicle,), dropped = to_frenet(van, PATH, {})  # type: ignore[arg-type]
    assert (vehicle.remote, dropped) == (van, ())
    assert to_frenet(7, PATH, {}) == ([], (("7", "not a RemoteVehicle"),))  # type: ignore[arg-type]
    assert to_frenet(None, PATH, {}) == ([], (("None", "not a RemoteVehicle"),))  # type: ignore[arg-type]


def test_laterally_distant_vehicles_are_ignored() -> None:
    """Vehicles that cross, or reach near by size, angle or uncertainty bound, are kept."""
    at, psi = PATH.to_cartesian(100.0, 20.0), float(PATH.heading(100.0))
    far = RemoteVehicle(id="far", x=float(at[0]), y=float(at[1]), psi=psi, v_x=10.0)
    for kept, changes in (
        (False, {}), (False, {"psi": psi + math.pi}), (True, {"psi": psi - 0.5}),
        (True, {"sigma_across": 2.2}), (False, {"sigma_along": 5.0}),
        (True, {"sigma_along": 9.0, "psi": psi + 0.3}),
    ):  # fmt: skip
        vehicles, dropped = to_frenet([replace(far, **changes)], PATH, {})
        assert (len(vehicles), dropped) == (int(kept), ())
        reach = 0.0 if not kept else vehicles[0].d - vehicles[0].half_width
        assert reach < 15.0 or abs(math.sin(vehicles[0].angle)) > 0.35
    assert len(to_frenet([far], PATH, {}, lateral_range=(-30.0, 30.0))[0]) == 1


@pytest.mark.parametrize(
    ("v_s", "age", "v_lower"), [(20.0, 0.9, 20.0), (20.0, 2.0, 12.0), (20.0, 9.0, 0.0), (-20.0, 5.0, -20.0)]
)
def test_lower_speed_bound_of_stale_vehicle(v_s: float, age: float, v_lower: float) -> None:
    remote = RemoteVehicle(id="a", x=0.0, y=0.0, psi=0.0, v_x=abs(v_s), age=age)
    vehicle = FrenetVehicle.from_remote(remote, 0.0, 0.0, 0.0 if v_s > 0.0 else math.pi, 0.0)
    assert vehicle.v_lower == pytest.approx(v_lower)


@pytest.mark.parametrize("value", [3, np.float64(3.0), np.float32(3.0), 1e308, -1e308])
def test_numeric_types_are_validated_alike(value: Any) -> None:
    remote = RemoteVehicle(id="a", x=value, y=float(value), psi=0.0, v_x=10.0)
    plain = RemoteVehicle(id="a", x=float(value), y=float(value), psi=0.0, v_x=10.0)
    assert remote.invalid_reason == plain.invalid_reason
    assert (remote.invalid_reason is None) == (abs(value) < 10.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, np.float64("nan"), None, "3", 3j])
def test_non_numeric_field_is_reported(value: Any) -> None:
    reason = RemoteVehicle(id="a", x=0.0, y=0.0, psi=0.0, v_x=10.0, age=value).invalid_reason
    assert reason is not None
    assert "age" in reason


def test_nominal_has_no_uncertainty_and_reported_speed() -> None:
    reported = RemoteVehicle(
        id="A", x=80.0, y=0.0, psi=0.3, v_x=14.0, age=5.0, sigma_along=30.0, sigma_across=5.0
    )
    known = replace(reported, age=0.0, sigma_along=0.0, sigma_across=0.0)
    vague, sure = (FrenetVehicle.from_remote(remote, 80.0, 0.0, 0.3, 0.0) for remote in (reported, known))
    assert vague.nominal() == sure
    assert sure.nominal() == sure
    assert vague.v_lower == 0.0
    assert vague.nominal().v_lower == sure.v_s


TURN = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 40)
OUT = [(x, 0.0) for x in np.arange(0.0, 600.0, 10.0)]
OUT_AND_BACK = fit_path(
    [*OUT, *np.column_stack((600.0 + 20.0 * np.cos(TURN), 20.0 + 20.0 * np.sin(TURN))),
     *[(x, 40.0) for x, _ in OUT[::-1]]],
    tolerance=0.05,
)  # fmt: skip
NARROW = fit_path(
    [*OUT, (620.0, -10.0), (640.0, 0.0), (630.0, 8.0), *[(x, 4.0) for x, _ in OUT[::-1]]], tolerance=0.3
)
LOOP = np.linspace(0.0, 4.0 * math.pi, 400)
TWO_LAPS = fit_path(np.column_stack((80.0 * np.sin(LOOP), 80.0 - 80.0 * np.cos(LOOP))), tolerance=0.05)


def stations_of(path: Any, x: float, y: float, s_ego: float) -> list[float]:
    remote = RemoteVehicle(id="a", x=x, y=y, psi=0.0, v_x=0.0)
    return [n.s for n in to_frenet([remote], path, {}, (-6.0, 6.0), (Branches(path), s_ego))[0]]


@pytest.mark.parametrize(
    ("path", "expected"), [(PATH, False), (OUT_AND_BACK, False), (NARROW, True), (TWO_LAPS, True)]
)
def test_routes_that_pass_themselves_are_found(path: Any, expected: bool) -> None:
    assert Branches(path).passes_itself is expected


def test_vehicle_between_two_branches_is_on_both() -> None:
    near, far = stations_of(NARROW, 550.0, 2.0, 500.0)
    assert near == pytest.approx(550.0, abs=0.5)
    assert NARROW.position(far) == pytest.approx((550.0, 4.0), abs=0.3)
    assert stations_of(NARROW, 300.0, 2.0, 200.0) == pytest.approx([300.0], abs=0.5)


def test_vehicle_on_a_loop_is_on_the_lap_of_the_ego() -> None:
    lap = 2.0 * math.pi * 80.0
    for s_ego, expected in ((10.0, 20.0), (lap + 10.0, lap + 20.0)):
        x, y = TWO_LAPS.position(20.0)
        assert min(abs(s - expected) for s in stations_of(TWO_LAPS, float(x), float(y), s_ego)) < 0.5


def test_branches_of_an_ordinary_route_change_nothing() -> None:
    many = remotes(30)
    plain, _ = to_frenet(many, PATH, {})
    found, _ = to_frenet(many, PATH, {}, branches=(Branches(PATH), 200.0))
    assert [n.id for n in found] == [n.id for n in plain]
    assert [n.s for n in found] == pytest.approx([n.s for n in plain], abs=1e-6)

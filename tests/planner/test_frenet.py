"""The scene: vehicles in path coordinates, one by one and many at once."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cca_core import RemoteVehicle
from cca_core.frenet import FrenetVehicle, to_frenet
from cca_core.path import fit_path

S = np.linspace(0.0, 3.0, 60)
PATH = fit_path(np.column_stack((150.0 * np.sin(S), 150.0 * (1.0 - np.cos(S)))), tolerance=0.05)


def remotes(n: int, d: float = 12.0, seed: int = 1) -> list[RemoteVehicle]:
    """Vehicles beside the route, at most `d` from it, heading anywhere."""
    rng = np.random.default_rng(seed)
    s, beside = rng.uniform(-20.0, PATH.length + 20.0, n), rng.uniform(-d, d, n)
    xy, psi = PATH.to_cartesian(s, beside), rng.uniform(-math.pi, math.pi, n)
    return [
        RemoteVehicle(id=str(i), x=float(x), y=float(y), psi=float(p), v_x=10.0, sigma_along=1.0)
        for i, ((x, y), p) in enumerate(zip(xy, psi, strict=True))
    ]


@pytest.mark.parametrize("warm", [False, True])
def test_batch_projection_equals_scalar(warm: bool) -> None:
    many, places = remotes(80), {}
    if warm:
        to_frenet(many, PATH, places)
        many = [replace(r, x=r.x + 0.3, y=r.y - 0.2) for r in many]
    before = dict(places)
    together, _ = to_frenet(many, PATH, places)
    assert len(together) == len(places) == 80
    for remote, neighbor in zip(many, together, strict=True):
        own = {remote.id: before[remote.id]} if warm else {}
        (alone,), _ = to_frenet([remote], PATH, own)
        for name in ("s", "d", "v_s", "half_length", "half_width", "angle"):
            assert getattr(neighbor, name) == pytest.approx(getattr(alone, name), abs=1e-6)
        assert own[remote.id] == pytest.approx(places[remote.id], abs=1e-6)


def test_single_vehicle_is_accepted() -> None:
    (at,) = PATH.to_cartesian([100.0], [0.0])
    van = RemoteVehicle(id="van", x=float(at[0]), y=float(at[1]), psi=float(PATH.heading(100.0)), v_x=10.0)
    (neighbor,), dropped = to_frenet(van, PATH, {})  # type: ignore[arg-type]
    assert (neighbor.remote, dropped) == (van, ())
    assert to_frenet(7, PATH, {}) == ([], (("7", "not a RemoteVehicle"),))  # type: ignore[arg-type]
    assert to_frenet(None, PATH, {}) == ([], (("None", "not a RemoteVehicle"),))  # type: ignore[arg-type]


def test_laterally_distant_vehicles_are_ignored() -> None:
    """Who crosses, or reaches near by size, angle or bounds, is not."""
    at, psi = PATH.to_cartesian(100.0, 20.0), float(PATH.heading(100.0))
    far = RemoteVehicle(id="far", x=float(at[0]), y=float(at[1]), psi=psi, v_x=10.0)
    for kept, changes in (
        (False, {}), (False, {"psi": psi + math.pi}), (True, {"psi": psi - 0.5}),
        (True, {"sigma_across": 2.2}), (False, {"sigma_along": 5.0}),
        (True, {"sigma_along": 9.0, "psi": psi + 0.3}),
    ):  # fmt: skip
        neighbors, dropped = to_frenet([replace(far, **changes)], PATH, {})
        assert (len(neighbors), dropped) == (int(kept), ())
        reach = 0.0 if not kept else neighbors[0].d - neighbors[0].half_width
        assert reach < 15.0 or abs(math.sin(neighbors[0].angle)) > 0.35
    assert len(to_frenet([far], PATH, {}, lateral_range=(-30.0, 30.0))[0]) == 1


@pytest.mark.parametrize(
    ("v_s", "age", "least"), [(20.0, 0.9, 20.0), (20.0, 2.0, 12.0), (20.0, 9.0, 0.0), (-20.0, 5.0, -20.0)]
)
def test_lower_speed_bound_of_stale_vehicle(v_s: float, age: float, least: float) -> None:
    remote = RemoteVehicle(id="a", x=0.0, y=0.0, psi=0.0, v_x=abs(v_s), age=age)
    neighbor = FrenetVehicle.from_remote(remote, 0.0, 0.0, 0.0 if v_s > 0.0 else math.pi, 0.0)
    assert neighbor.v_lower == pytest.approx(least)


@pytest.mark.parametrize("value", [3, np.float64(3.0), np.float32(3.0), 1e308, -1e308])
def test_numeric_types_are_validated_alike(value: Any) -> None:
    remote = RemoteVehicle(id="a", x=value, y=float(value), psi=0.0, v_x=10.0)
    plain = RemoteVehicle(id="a", x=float(value), y=float(value), psi=0.0, v_x=10.0)
    assert remote.invalid_reason == plain.invalid_reason
    assert (remote.invalid_reason is None) == (abs(value) < 10.0)


@pytest.mark.parametrize("value", [math.nan, math.inf, np.float64("nan"), None, "3", 3j])
def test_non_numeric_field_is_reported(value: Any) -> None:
    defect = RemoteVehicle(id="a", x=0.0, y=0.0, psi=0.0, v_x=10.0, age=value).invalid_reason
    assert defect is not None
    assert defect.startswith("age is not a finite number")


def test_nominal_has_no_uncertainty_and_reported_speed() -> None:
    told = RemoteVehicle(
        id="A", x=80.0, y=0.0, psi=0.3, v_x=14.0, age=5.0, sigma_along=30.0, sigma_across=5.0
    )
    known = replace(told, age=0.0, sigma_along=0.0, sigma_across=0.0)
    vague, sure = (FrenetVehicle.from_remote(remote, 80.0, 0.0, 0.3, 0.0) for remote in (told, known))
    assert vague.nominal() == sure
    assert sure.nominal() == sure
    assert vague.v_lower == 0.0
    assert vague.nominal().v_lower == sure.v_s

"""Road users that drive into each other: they do not collide, and the run states it."""

import math
import warnings
from dataclasses import replace
from itertools import combinations
from pathlib import Path as FilePath

import numpy as np
import pytest

from cca_core import Lane, Road, VehicleParams
from cca_core.path import interpolate_path
from cca_core.sim import Log, RoadUser, Scenario, ima, load_log, save_log, simulate
from cca_core.sim.loop import make_controller
from cca_core.sim.overlaps import find_overlaps
from cca_core.sim.study.parameters import ParameterRanges, sample_scenario, without_v2v
from cca_core.sim.study.sampling import STUDY_SCENARIOS

ROAD = Road(interpolate_path([[0.0, 0.0], [400.0, 0.0]]), [Lane(d=0.0), Lane(d=3.5), Lane(d=7.0)])
PARKED = RoadUser(id="a", s=100.0, d=7.0, v_x=0.0)
CAR = RoadUser(id="b", s=50.0, d=7.0, v_x=20.0)  # reaches the parked one after 45.5 m


def scene(*users: RoadUser) -> Scenario:
    """The ego stands two lanes to the right of what happens."""
    return Scenario(
        name="pile-up", case=None, road=ROAD, vehicle=VehicleParams.bmw_320i(), start=20.0, v_x=0.0,
        cruise_speed=1.0, road_users=users, duration=3.0, ego_type="sensor",
    )  # fmt: skip


def drive(*users: RoadUser) -> Log:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return simulate(scene(*users))


def test_first_overlap_has_both_ids_time_and_speed() -> None:
    for users in ((CAR, PARKED), (PARKED, CAR)):
        log = drive(*users)
        ((t, *ids, speed),) = log.overlaps
        assert (t, ids, speed) == (pytest.approx(2.28), ["b", "a"], pytest.approx(20.0))
        assert {log.time_of("overlap", "a"), log.time_of("overlap", "b")} == {t}
        assert [each[0] for each in log.events] == sorted(each[0] for each in log.events)
        assert log.summary()["overlaps"] == [[2.28, "b", "a", 20.0]]


def test_overlap_is_warned_of_once_in_a_run() -> None:
    third = RoadUser(id="c", s=30.0, d=7.0, v_x=25.0)  # passes through b, then a
    with pytest.warns(UserWarning, match="b drives into a") as noted:
        log = simulate(scene(PARKED, CAR, third))
    (warning,) = noted
    assert str(warning.message) == (
        "b drives into a at 2.3 s: road users do not collide, so what follows means little; 1 more such pair"
    )
    assert warning.filename == __file__
    assert [ids for _, *ids, _ in log.overlaps] == [["b", "a"], ["c", "a"]]
    assert len([kind for _, kind, _ in log.events if kind == "overlap"]) == 3


def test_vehicles_that_begin_inside_each_other_are_named() -> None:
    with pytest.warns(UserWarning, match="a and b are inside each other from the start: road users do not"):
        log = simulate(scene(PARKED, replace(CAR, s=101.0, v_x=0.0)))
    assert log.overlaps == ((0.0, "a", "b", 0.0),)


@pytest.mark.parametrize(
    "car", [replace(CAR, v_x=0.0, s=95.5), replace(CAR, d=5.2), replace(CAR, d=8.8), replace(CAR, v_x=15.0)]
)
def test_vehicles_that_touch_or_pass_have_no_event(car: RoadUser) -> None:
    log = simulate(scene(PARKED, car))
    assert log.overlaps == ()
    assert log.time_of("overlap", "b") == math.inf


def test_overlap_is_kept_in_files(tmp_path: FilePath) -> None:
    log = drive(CAR, PARKED)
    save_log(log, tmp_path / "run.npz")
    assert load_log(tmp_path / "run.npz").overlaps == log.overlaps != ()


def test_the_faster_in_the_direction_of_the_other_drives_into_it() -> None:
    crossing = interpolate_path([[100.0, -100.0], [100.0, 100.0]])
    for v_x, ids in ((20.0, ["b", "c"]), (4.0, ["c", "b"])):
        across = RoadUser(id="c", s=107.0 - 2.4 * 5.0, d=0.0, v_x=5.0, route=crossing)
        log = drive(replace(CAR, v_x=v_x, s=100.0 - 2.4 * v_x), across)
        ((t, *found, speed),) = log.overlaps
        assert found == ids
        assert speed == pytest.approx(math.hypot(v_x, 5.0))
        assert 1.0 < t < 2.4
    oncoming = replace(CAR, id="c", s=120.0, v_x=10.0, direction=-1)
    ((_, *found, speed),) = drive(oncoming, CAR).overlaps
    assert (found, speed) == (["b", "c"], pytest.approx(30.0))


def random_motions(rng: np.random.Generator) -> tuple[tuple[RoadUser, ...], np.ndarray]:
    """Five bodies on straight courses for 60 cycles, the last of which comes late."""
    users = tuple(
        RoadUser(id=f"u{i}", s=0.0, d=0.0, v_x=0.0, length=rng.uniform(1, 12), width=rng.uniform(1, 3))
        for i in range(5)
    )
    v, psi = rng.uniform(0.0, 20.0, 5), rng.uniform(-math.pi, math.pi, 5)
    xy = rng.uniform(-15.0, 15.0, (5, 2))[None] + np.arange(60)[:, None, None] * 0.02 * np.stack(
        (v * np.cos(psi), v * np.sin(psi)), axis=-1
    )
    rows = np.concatenate((xy, np.broadcast_to(np.stack((psi, v), axis=-1), (60, 5, 2))), axis=-1)
    rows[: rng.integers(0, 20), 4] = np.nan
    return users, rows


def test_overlaps_equal_shapely_in_plain_loops() -> None:
    shapely = pytest.importorskip("shapely")
    affinity = pytest.importorskip("shapely.affinity")

    def body(user: RoadUser, row: np.ndarray) -> "shapely.Polygon":
        half, across = 0.5 * user.length, 0.5 * user.width
        box = affinity.rotate(
            shapely.box(-half, -across, half, across), row[2], origin=(0, 0), use_radians=True
        )
        return affinity.translate(box, row[0], row[1])

    rng, n_found = np.random.default_rng(7), 0
    for _ in range(40):
        users, rows = random_motions(rng)
        expected = {}
        for k, row in reversed(list(enumerate(rows))):
            bodies = {
                user.id: body(user, each) for user, each in zip(users, row, strict=True) if each[0] == each[0]
            }
            for one, other in combinations(bodies, 2):
                if bodies[one].intersection(bodies[other]).area > 1e-3:
                    expected[frozenset((one, other))] = 0.02 * k
        overlaps = find_overlaps(0.02 * np.arange(60), users, rows)
        times = {frozenset((one, other)): t for t, one, other, _ in overlaps}
        assert times.keys() == expected.keys()
        # a depth of 1 mm and an area of 10 cm^2 may be a cycle apart
        assert all(abs(t - expected[pair]) < 0.03 for pair, t in times.items())
        assert list(times.values()) == sorted(times.values())
        n_found += len(overlaps)
    assert n_found > 40


def test_runs_without_other_vehicles_have_no_overlap() -> None:
    assert simulate(scene()).overlaps == ()
    assert simulate(replace(scene(PARKED), duration=0.02)).overlaps == ()
    assert simulate(ima()).overlaps == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", STUDY_SCENARIOS)
def test_road_users_of_the_studies_never_overlap(name: str) -> None:
    for index in range(30):
        scenario, nominal, _ = sample_scenario(ParameterRanges(scenario=name), 1, index)
        for ego in (scenario, without_v2v(scenario, "driver"), without_v2v(scenario, "sensor")):
            log = simulate(ego, planner=make_controller(replace(ego, vehicle=nominal)))
            assert log.overlaps == (), (index, ego.ego_type)

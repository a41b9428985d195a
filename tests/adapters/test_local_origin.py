"""Maps in coordinates of UTM: the same roads as near zero, and the origin that was taken."""

import contextlib
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Road, VehicleParams, VehicleState
from cca_core.adapters import (
    SumoWorld,
    join_lanelets,
    read_commonroad_map,
    read_opendrive,
    read_sumo_net,
)
from cca_core.sim import drive_commonroad, read_commonroad
from tests.support.commonroad_files import (
    REGION,
    ROAD,
    document,
    goal,
    lanelet,
    moving,
    problem,
    state,
    written,
)
from tests.support.fake_sumo import FakeLane, FakeSumo, FakeVehicle
from tests.support.moved_maps import FAR, moved_commonroad, moved_file, numbers
from tests.support.opendrive_files import crossing, geometry, road, write_map
from tests.support.sumo_files import write_net

CAR = VehicleParams.bmw_320i()
EXACT = 1e-6  # [m]


def check_same(far: Road, near: Road, shift: Any) -> None:
    """Compare a road with the one near zero, `shift` away."""
    s = np.linspace(near.path.start, near.path.end, 500)
    assert far.path.length == pytest.approx(near.path.length, abs=EXACT)
    assert np.abs(far.path.position(s) - near.path.position(s) - shift).max() < EXACT
    assert np.abs(far.path.curvature(s[1:-1]) - near.path.curvature(s[1:-1])).max() < EXACT
    assert len(far.lanes) == len(near.lanes)
    for lane, like in zip(far.lanes, near.lanes, strict=True):
        assert (lane.direction, lane.d) == (like.direction, pytest.approx(like.d, abs=EXACT))
        assert np.array(lane.boundaries) == pytest.approx(np.array(like.boundaries), abs=EXACT)
    assert far.speed_limit == near.speed_limit


def turn(id_: int, x: float, y: float) -> str:
    """A lanelet that winds, 3.5 m wide, a point every 2 m."""
    along = np.arange(0.0, 121.0, 2.0)
    sides = []
    for tag, d in (("leftBound", 1.75), ("rightBound", -1.75)):
        rows = zip(x + along, y + 8.0 * np.sin(along / 30.0) + d, strict=True)
        points = "".join(f"<point><x>{a:.4f}</x><y>{b:.4f}</y></point>" for a, b in rows)
        sides.append(f"<{tag}>{points}</{tag}>")
    return f'<lanelet id="{id_}">{"".join(sides)}</lanelet>'


BODY = (
    "<shape><rectangle><length>4.5</length><width>1.8</width><center><x>1.25</x><y>0</y></center></rectangle>"
    "</shape>"
)
SCENE = document(
    ROAD,
    turn(8, 0.0, -60.0),
    moving(31, [state("state", k, 40.0 + k, 0.0, 10.0) for k in range(120)]),
    f'<staticObstacle id="32"><type>car</type>{BODY}{state("initialState", 0, 60.0, 3.5, 0.0)}'
    "</staticObstacle>",
    problem(goal((40, 160), REGION.format(y=0))),
)


@pytest.mark.parametrize("by", FAR)
def test_commonroad_far_away_is_that_near_zero(tmp_path: Path, by: tuple[str, str]) -> None:
    near = read_commonroad(written(tmp_path, SCENE))
    far = read_commonroad_map(written(tmp_path, moved_commonroad(SCENE, by)))
    shift = np.subtract(numbers(by), far.origin)
    assert np.abs(shift).max() < 9e5
    assert far.left_out == near.left_out == ()
    for ids in ([1, 2], [8]):
        check_same(join_lanelets(far, ids), join_lanelets(near, ids), shift)
    for other, like in zip(far.obstacles, near.obstacles, strict=True):
        assert np.abs(other.states - like.states - [*shift, 0.0, 0.0]).max() < EXACT
    (task,), (same,) = far.problems, near.problems
    assert (task.state.x, task.state.y) == pytest.approx(
        np.add(shift, (same.state.x, same.state.y)), abs=EXACT
    )
    assert task.goals[0].regions[0] == pytest.approx(same.goals[0].regions[0] + shift, abs=EXACT)


def test_commonroad_far_away_is_driven_like_near_zero(tmp_path: Path) -> None:
    near = drive_commonroad(read_commonroad(written(tmp_path, SCENE)))
    far = drive_commonroad(read_commonroad_map(written(tmp_path, moved_commonroad(SCENE, FAR[0]))))
    assert len(near.decisions) > 1
    assert far.t_goal == near.t_goal
    assert far.ego[:, 3] == pytest.approx(near.ego[:, 3], abs=1e-5)


def test_commonroad_near_zero_keeps_its_coordinates(tmp_path: Path) -> None:
    file = written(tmp_path, SCENE)
    here, like = read_commonroad_map(file), read_commonroad(file)
    assert here.origin == (0.0, 0.0)
    assert (here.lanelets[8].left == like.lanelets[8].left).all()
    assert (here.name, here.dt) == (like.name, like.dt)


def test_commonroad_position_far_off_moves_no_other(tmp_path: Path) -> None:
    wrong = lanelet(70, (9e8, 9e8 + 50.0), 0.0)
    text = moved_commonroad(document(ROAD), FAR[0])
    file = written(tmp_path, text.replace("</commonRoad>", f"{wrong}</commonRoad>"))
    far = read_commonroad_map(file)
    assert (far.origin, sorted(far.lanelets)) == ((691000.0, 5335000.0), [1, 2, 3, 4, 5, 6])
    assert far.left_out[0].startswith("lanelet 70")


def test_commonroad_region_at_zero_stays_far_away(tmp_path: Path) -> None:
    region = "<position><circle><radius>5</radius></circle></position>"
    text = moved_commonroad(document(ROAD, problem(goal((0, 9)))), FAR[0])
    far = read_commonroad_map(written(tmp_path, text.replace("<goalState>", f"<goalState>{region}")))
    assert far.problems == ()
    assert "center" in far.left_out[0]


def curve(tmp_path: Path) -> Path:
    arc = geometry(40.0, 50.0, -5.0, 0.0, 60.0, '<spiral curvStart="0" curvEnd="0.02"/>')
    return write_map(tmp_path, road("7", 100.0, [geometry(0.0, 10.0, -5.0, 0.0, 40.0), arc]))


@pytest.mark.parametrize("by", FAR)
def test_opendrive_far_away_is_that_near_zero(tmp_path: Path, by: tuple[str, str]) -> None:
    for write, along in ((crossing, ["1", "5", "2"]), (curve, ["7"])):
        file = write(tmp_path)
        near, far = read_opendrive(file), read_opendrive(moved_file(file, by))
        assert near.origin == (0.0, 0.0)
        check_same(
            far.road_along(along, -1), near.road_along(along, -1), np.subtract(numbers(by), far.origin)
        )


def test_opendrive_offset_of_header_does_not_move_roads(tmp_path: Path) -> None:
    file = curve(tmp_path)
    near = read_opendrive(file).road_along(["7"], -1)
    header = '<header><geoReference/><offset x="691000" y="5334000" z="0" hdg="0"/></header>'
    file.write_text(file.read_text().replace("<road", f"{header}<road", 1))
    world = read_opendrive(file)
    assert world.origin == (0.0, 0.0)
    check_same(world.road_along(["7"], -1), near, 0.0)


@pytest.mark.parametrize("by", FAR)
def test_sumo_net_far_away_is_that_near_zero(tmp_path: Path, by: tuple[str, str]) -> None:
    file = write_net(tmp_path)
    near, far = read_sumo_net(file), read_sumo_net(moved_file(file, by))
    assert near.origin == (0.0, 0.0)
    for along in (["in", "on", "end"], ["in", "up"]):
        check_same(far.road_along(along), near.road_along(along), np.subtract(numbers(by), far.origin))


READERS = {
    "commonroad": (read_commonroad_map, lambda folder: written(folder, SCENE)),
    "opendrive": (read_opendrive, crossing),
    "sumo": (read_sumo_net, write_net),
}


@pytest.mark.parametrize("name", READERS)
def test_origin_that_is_given_is_taken(tmp_path: Path, name: str) -> None:
    read, write = READERS[name]
    found: Any = read(write(tmp_path), origin=(100.0, -50.0))  # type: ignore[operator]
    assert found.origin == (100.0, -50.0)
    if name == "commonroad":
        assert found.problems[0].state.x == pytest.approx(10.0 - 100.0, abs=EXACT)
    elif name == "opendrive":
        assert found.road_along(["1"], -1).path.position(0.0) == pytest.approx((-100.0, 48.25), abs=EXACT)
    else:
        assert found.road_along(["in"]).path.position(0.0) == pytest.approx((-100.0, 44.75), abs=EXACT)


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("origin", [5.0, (1.0,), "ab", (float("nan"), 0.0)])
def test_origin_that_is_no_position_raises(tmp_path: Path, name: str, origin: Any) -> None:
    read, write = READERS[name]
    with pytest.raises(InputError, match="origin"):
        read(write(tmp_path), origin=origin)  # type: ignore[operator]


@pytest.mark.parametrize("value", ["1.7e308", "1e-9999999999999999999", "nan", "", "1_0", "1e-400"])
@pytest.mark.parametrize("count", [1, -1])
@pytest.mark.parametrize("name", READERS)
def test_odd_positions_are_read_or_refused(tmp_path: Path, name: str, count: int, value: str) -> None:
    read, write = READERS[name]
    file: Path = write(tmp_path)  # type: ignore[operator]
    text = file.read_text(encoding="utf-8")
    pattern = {"commonroad": "(<x>)[^<]*", "opendrive": '( x=")[^"]*', "sumo": '(shape=")[^,]*'}[name]
    file.write_text(re.sub(pattern, rf"\g<1>{value}", text, count=max(count, 0)), encoding="utf-8")
    for origin in (None, (5e5, 5e6)):
        with contextlib.suppress(InputError):
            read(file, origin=origin)  # type: ignore[operator]


def fake(by: tuple[float, float]) -> FakeSumo:
    """Two lanes and a curve to the left of one, with the ego and a car ahead."""
    x, y = by
    bend = [(x + 200.0 + 30.0 * np.sin(a), y + 30.0 * (1.0 - np.cos(a))) for a in np.linspace(0.0, 1.5, 20)]
    lanes = {
        "a_0": FakeLane([(x, y), (x + 200.0, y)], [("b_0", "", "s")]),
        "a_1": FakeLane([(x, y + 3.5), (x + 200.0, y + 3.5)]),
        "b_0": FakeLane(bend),
    }
    cars = {
        "ego": FakeVehicle(x + 52.25, y, 90.0, 10.0),
        "other": FakeVehicle(x + 90.0, y + 3.5, 90.0, 8.0),
    }
    return FakeSumo(lanes, ["a", "b"], cars)


@pytest.mark.parametrize("by", FAR)
def test_sumo_far_away_is_that_near_zero(by: tuple[str, str]) -> None:
    near = SumoWorld("ego", CAR, connection=fake((0.0, 0.0)))
    sumo = fake(numbers(by))
    far = SumoWorld("ego", CAR, connection=sumo)
    shift = np.subtract(numbers(by), far.origin)
    assert near.origin == (0.0, 0.0)
    check_same(far.read_road(), near.read_road(), shift)
    (other,), (like,) = far.remotes(), near.remotes()
    assert (other.x, other.y) == pytest.approx(np.add(shift, (like.x, like.y)), abs=EXACT)
    here, there = far.ego_state(), near.ego_state()
    assert (here.x, here.y) == pytest.approx(np.add(shift, (there.x, there.y)), abs=EXACT)
    far.move_ego(here)
    moves = [call for call in sumo.calls if call[0] == "moveToXY"]
    assert moves[-1][4:6] == pytest.approx(sumo.getPosition("ego"), abs=EXACT)


def test_sumo_shares_the_origin_of_a_file() -> None:
    world = SumoWorld("ego", CAR, connection=fake((0.0, 0.0)), origin=(52.0, 7.0))
    assert world.ego_state().y == pytest.approx(-7.0, abs=EXACT)
    world.move_ego(VehicleState(x=0.0, y=0.0, psi=0.0, v_x=5.0))
    with pytest.raises(InputError, match=r"^origin must be x and y"):
        SumoWorld("ego", CAR, connection=fake((0.0, 0.0)), origin=(1.0,))  # type: ignore[arg-type]

"""CommonRoad files: contents, and errors that name the element."""

import math
import tempfile
from contextlib import suppress
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError, VehicleState
from cca_core.sim.commonroad.drive import drive_commonroad
from cca_core.sim.commonroad.read import CommonRoadScenario, read_commonroad
from tests.support.commonroad_files import BOX, REGION, ROAD, document, goal, moving, problem, state, written

CAR = moving(31, [state("state", k, 40.0 + 1.2 * k, 0.0, 12.0) for k in range(5, 21)])
GOAL = goal((80, 100), REGION.format(y=0.0))
GOOD = document(ROAD, CAR, problem(GOAL))


def test_lanelets(tmp_path: Path) -> None:
    scenario = read_commonroad(written(tmp_path, GOOD))
    assert scenario.name == "ZAM_Test-1"
    assert scenario.dt == 0.1
    assert sorted(scenario.lanelets) == [1, 2, 3, 4, 5, 6]
    one = scenario.lanelets[1]
    np.testing.assert_array_equal(one.center, [[0.0, 0.0], [50.0, 0.0], [100.0, 0.0]])
    assert (one.length, one.width) == (100.0, 3.5)
    assert (one.successors, one.on_left, one.on_right) == ((2,), (3, 1), (5, -1))
    assert scenario.lanelets[2].predecessors == (1,)
    assert scenario.lanelets[5].heading_at(50.0, -3.5) == pytest.approx(math.pi)
    assert not one.left.flags.writeable


def test_both_tags_of_moving_obstacle(tmp_path: Path) -> None:
    states = [state("state", k, 2.0 * k, 0.0, 20.0) for k in range(3)]
    new = read_commonroad(written(tmp_path, document(ROAD, moving(31, states), problem(GOAL))))
    text = document(ROAD, moving(31, states, new=False), problem(GOAL), version="2018b")
    old = read_commonroad(written(tmp_path, text))
    np.testing.assert_array_equal(new.obstacles[0].states, old.obstacles[0].states)


def test_obstacle_is_interpolated_between_states(tmp_path: Path) -> None:
    turning = [state("state", 5, 0.0, 0.0, 10.0, 3.1), state("state", 6, 1.0, 0.5, 11.0, -3.1)]
    text = document(ROAD, moving(31, turning), problem(GOAL))
    (car,) = read_commonroad(written(tmp_path, text)).obstacles
    assert car.at(0.49) is None
    assert car.at(0.61) is None
    now = car.at(0.525)
    assert now is not None
    step = math.tau - 6.2
    found = (now.x, now.y, now.psi, now.v_x, now.a_x, now.r, now.length, now.width)
    assert found == pytest.approx((0.25, 0.125, 3.1 + 0.25 * step, 10.25, 10.0, 10.0 * step, 4.5, 1.8))
    assert now.invalid_reason is None


def test_static_obstacle_is_always_present(tmp_path: Path) -> None:
    shape = (
        "<shape><rectangle><length>2</length><width>1</width><orientation>0.5</orientation>"
        "<center><x>3</x><y>1</y></center></rectangle></shape>"
    )
    still = state("initialState", 0, 60.0, 2.0, 0.0, math.pi / 2.0)
    still = still.replace("<velocity><exact>0.0</exact></velocity>", "")
    text = document(
        ROAD, f'<staticObstacle id="40"><type>x</type>{shape}{still}</staticObstacle>', problem(GOAL)
    )
    (parked,) = read_commonroad(written(tmp_path, text)).obstacles
    now = parked.at(1e4)
    assert now is not None
    # 3 m ahead of (60, 2) facing north and 1 m to its left
    assert (now.x, now.y, now.psi, now.v_x) == pytest.approx((59.0, 5.0, math.pi / 2.0 + 0.5, 0.0))


def test_round_and_polygonal_shapes_become_boxes(tmp_path: Path) -> None:
    corners = ((-1.0, -1.0), (3.0, -1.0), (1.0, 2.0))
    points = "".join(f"<point><x>{x}</x><y>{y}</y></point>" for x, y in corners)
    car = moving(31, [state("state", 0, 10.0, 0.0, 5.0), state("state", 1, 10.5, 0.0, 5.0)])
    expected = {
        "<circle><radius>0.4</radius></circle>": (10.0, 0.0, 0.8, 0.8),
        f"<polygon>{points}</polygon>": (11.0, 0.5, 4.0, 3.0),
    }
    for shape, box in expected.items():
        text = document(ROAD, car.replace(BOX, f"<shape>{shape}</shape>"), problem(GOAL))
        now = read_commonroad(written(tmp_path, text)).obstacles[0].at(0.0)
        assert now is not None
        assert (now.x, now.y, now.length, now.width) == pytest.approx(box)


def test_goal_checks_time_position_speed_and_heading(tmp_path: Path) -> None:
    inner = (
        REGION.format(y=0.0)
        + "<orientation><intervalStart>-0.1</intervalStart><intervalEnd>0.2</intervalEnd></orientation>"
        + "<velocity><intervalStart>10</intervalStart><intervalEnd>12</intervalEnd></velocity>"
    )
    text = document(ROAD, problem(goal((80, 100), inner), step=7))
    (task,) = read_commonroad(written(tmp_path, text)).problems
    (aim,) = task.goals
    assert task.t == pytest.approx(0.7)
    assert aim.t == pytest.approx((8.0, 10.0))

    def reached(
        t: float = 9.0, x: float = 150.0, y: float = 0.0, v_x: float = 11.0, psi: float = 0.0
    ) -> bool:
        return aim.reached(t, VehicleState(x=x, y=y, psi=psi, v_x=v_x))

    assert reached()
    assert reached(t=8.0) and reached(t=10.0) and not reached(t=7.9) and not reached(t=10.1)  # noqa: PT018
    assert reached(x=145.1) and not reached(x=144.9) and not reached(y=1.8)  # noqa: PT018
    assert reached(v_x=10.0) and not reached(v_x=9.9) and not reached(v_x=12.1)  # noqa: PT018
    assert reached(psi=0.2 - math.tau) and not reached(psi=0.21) and not reached(psi=-0.11)  # noqa: PT018


def test_goal_regions_of_other_shapes(tmp_path: Path) -> None:
    circle = "<circle><radius>2</radius><center><x>150</x><y>0</y></center></circle>"
    goals = goal((0, 9), f"<position>{circle}</position>") + goal(
        (0, 9), '<position><lanelet ref="4"/></position>'
    )
    (task,) = read_commonroad(written(tmp_path, document(ROAD, problem(goals)))).problems
    round_, lane = task.goals
    at = {x: VehicleState(x=x, y=0.0, psi=0.0, v_x=1.0) for x in (148.1, 147.9)}
    assert round_.reached(0.5, at[148.1])
    assert not round_.reached(0.5, at[147.9])
    assert lane.lanelets == (4,)
    assert lane.reached(0.5, VehicleState(x=150.0, y=3.5, psi=0.0, v_x=1.0))
    assert not lane.reached(0.5, at[148.1])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("commonRoad ", "openRoad ", "broken XML"),
        ('commonRoadVersion="2020a"', 'commonRoadVersion="2017a"', "commonRoadVersion"),
        ('timeStepSize="0.1"', 'timeStepSize="0"', "timeStepSize"),
        ('timeStepSize="0.1"', 'timeStepSize="-0.1"', "timeStepSize"),
        ('timeStepSize="0.1"', "", "timeStepSize"),
        ('timeStepSize="0.1"', 'timeStepSize="nan"', "timeStepSize"),
        ('timeStepSize="0.1"', f'timeStepSize="{"1" * 400}"', "timeStepSize"),
    ],
)
def test_error_names_attribute(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in GOOD
    with pytest.raises(InputError, match=words):
        read_commonroad(written(tmp_path, GOOD.replace(old, new)))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('<successor ref="2"/>', '<successor ref="77"/>', "lanelet 1: refers to lanelet 77"),
        ('<adjacentLeft ref="3"', '<adjacentLeft ref="33"', "lanelet 1: refers to lanelet 33"),
        ('drivingDir="same"', 'drivingDir="up"', "drivingDir of adjacentLeft of lanelet 1"),
        ('<lanelet id="1">', "<lanelet>", "id of lanelet"),
        ('<lanelet id="2">', '<lanelet id="1">', "id must be unique, 1"),
        ("leftBound>", "upperBound>", "lanelet 1 must hold one leftBound, held 0"),
        ("<point><x>50.0</x><y>1.75</y></point>", "", "lanelet 1: rightBound has 3 points, leftBound 2"),
        ("<x>50.0</x><y>1.75</y>", "<x>nan</x><y>1.75</y>", "x of leftBound of lanelet 1 must be finite"),
        ("<x>50.0</x><y>1.75</y>", "<x>1e9</x><y>1.75</y>", "x of leftBound of lanelet 1 must be at most"),
        ("<x>50.0</x><y>1.75</y>", "<x>50.0</x>", "leftBound of lanelet 1 must hold one y"),
        ("<x>50.0</x><y>1.75</y>", "<x>a</x><y>1.75</y>", "x of leftBound of lanelet 1 must be a real"),
        ("<rectangle><length>4.5", "<rectangle><length>-4.5", "length of rectangle of dynamicObstacle 31"),
        ("<shape>", "<shape><circle/>", "circle of dynamicObstacle 31 must hold one radius"),
        ("trajectory>", "occupancySet>", "dynamicObstacle 31 must hold one trajectory"),
        ("<time><exact>6</exact>", "<time><exact>9</exact>", "31: states in order of time, 1 repeated"),
        ("<time><exact>6</exact>", "<time><exact>6.5</exact>", "time of state of dynamicObstacle 31"),
        ("<time><exact>6</exact></time>", "", "state of dynamicObstacle 31 must hold one time"),
        ("<time><exact>6</exact>", "<time><exact>-6</exact>", "time of state of dynamicObstacle 31"),
        ("goalState", "hope", "planningProblem 900 must hold a goalState"),
        ("<intervalEnd>100<", "<intervalEnd>10<", "intervalEnd of time of goalState"),
        ("<velocity><exact>15.0", "<velocity><exact>-15.0", "velocity of initialState"),
        ("<velocity><exact>15.0</exact></velocity>", "", "velocity, held 0"),
    ],
)  # fmt: skip
def test_odd_element_is_named_and_rest_read(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in GOOD
    everywhere = not old.startswith(("<", "draw", "driv")) or old.endswith("Bound>")
    if old.startswith("<velocity><exact>15.0"):
        text = GOOD[::-1].replace(old[::-1], new[::-1], 1)[::-1]  # that of the ego
    else:
        text = GOOD.replace(old, new, -1 if everywhere else 1)
    scenario = read_commonroad(written(tmp_path, text))
    named = [text for text in (*scenario.left_out, *scenario.changed) if words in text]
    assert named
    assert len(scenario.lanelets) >= (0 if everywhere else 5)
    assert len(scenario.obstacles) + len(scenario.problems) >= 1


def test_single_point_raises(tmp_path: Path) -> None:
    text = document('<lanelet id="1"><leftBound/><rightBound/></lanelet>', problem(GOAL))
    (reason, *_) = read_commonroad(written(tmp_path, text)).left_out
    assert "leftBound of lanelet 1 must have at least 2 points, had 0" in reason


def test_map_without_a_planning_problem_is_read(tmp_path: Path) -> None:
    scenario = read_commonroad(written(tmp_path, document(ROAD)))
    assert (len(scenario.lanelets), scenario.obstacles, scenario.problems) == (6, (), ())
    assert (scenario.left_out, scenario.changed) == ((), ())
    with pytest.raises(InputError, match="must have a planning problem"):
        drive_commonroad(scenario)
    with pytest.raises(InputError, match="must hold lanelets, obstacles or planning problems"):
        read_commonroad(written(tmp_path, document()))


def test_ids_are_unique_in_each_kind_only(tmp_path: Path) -> None:
    states = [state("state", k, 60.0 + k, 0.0, 10.0) for k in range(3)]
    initial = state("initialState", 0, 90.0, 9.0, 0.0)
    still = f'<staticObstacle id="1"><type>x</type>{BOX}{initial}</staticObstacle>'
    text = document(ROAD, moving(1, states), moving(1, states), still, problem(GOAL).replace("900", "1"))
    scenario = read_commonroad(written(tmp_path, text))
    assert [obstacle.id for obstacle in scenario.obstacles] == ["1", "1 (2)", "1 (3)"]
    assert (len(scenario.lanelets), scenario.problems[0].id) == (6, 1)
    assert len(scenario.changed) == 2


def test_obstacle_without_trajectory(tmp_path: Path) -> None:
    """At standstill it stays; where a moving one goes is not known."""
    parked, gone = (moving(i, [state("state", 0, 60.0, 0.0, v)]) for i, v in ((31, 0.0), (32, 9.0)))
    bare = parked.replace("<trajectory></trajectory>", "").replace('"31"', '"33"')
    occupied = parked.replace("trajectory>", "occupancySet>").replace('"31"', '"34"')
    scenario = read_commonroad(written(tmp_path, document(ROAD, parked, gone, bare, occupied, problem(GOAL))))
    assert [obstacle.id for obstacle in scenario.obstacles] == ["31", "33"]
    now = scenario.obstacles[1].at(50.0)
    assert now is not None
    assert (now.x, now.v_x) == (60.0, 0.0)
    assert ["32" in scenario.left_out[0], "34" in scenario.left_out[1]] == [True, True]
    assert "occupancySet" in scenario.left_out[1]


def test_uncertain_states_become_their_middle(tmp_path: Path) -> None:
    def between(low: float, high: float) -> str:
        return f"<intervalStart>{low}</intervalStart><intervalEnd>{high}</intervalEnd>"

    region = (
        "<rectangle><length>2</length><width>1</width><orientation>-1.9</orientation>"
        "<center><x>60</x><y>1</y></center></rectangle>"
    )
    uncertain = (
        f"<initialState><position>{region}</position><orientation>{between(0.1, 0.3)}</orientation>"
        f"<time><exact>0</exact></time><velocity>{between(8.0, 9.0)}</velocity></initialState>"
    )
    first = state("initialState", 0, 60.0, 1.0, 8.5, 0.2)
    sure = moving(31, [state("state", 0, 60.0, 1.0, 8.5, 0.2), state("state", 1, 61.0, 1.0, 8.5)])
    ego = problem(GOAL).replace(state("initialState", 0, 10.0, 0.0, 15.0), uncertain.replace("60", "10"))
    scenario = read_commonroad(written(tmp_path, document(ROAD, sure.replace(first, uncertain), ego)))
    (car,) = scenario.obstacles
    assert car.states[0].tolist() == pytest.approx([60.0, 1.0, 0.2, 8.5])
    start = scenario.problems[0].state
    assert (start.x, start.psi, start.v_x) == pytest.approx((10.0, 0.2, 8.5))
    assert [text.split(":")[0] for text in scenario.changed] == ["dynamicObstacle 31", "planningProblem 900"]


def test_slip_angle_at_standstill_is_left_out(tmp_path: Path) -> None:
    slip = "</velocity><slipAngle><exact>3.0995</exact></slipAngle></initialState>"
    text = document(ROAD, problem(GOAL, v=0.012).replace("</velocity></initialState>", slip))
    scenario = read_commonroad(written(tmp_path, text))
    assert scenario.problems[0].state.v_x == pytest.approx(0.012)
    assert "slip angle" in scenario.changed[0]
    text = document(ROAD, problem(GOAL, v=15.0).replace("</velocity></initialState>", slip))
    assert "slipAngle" in read_commonroad(written(tmp_path, text)).left_out[0]


def test_states_are_ordered_and_repeated_ones_dropped(tmp_path: Path) -> None:
    steps = (0, 0, 2, 1, 1, 3)
    car = moving(31, [state("state", k, 60.0 + 1.2 * k, 0.0, 12.0) for k in steps])
    (obstacle,) = read_commonroad(written(tmp_path, document(ROAD, car, problem(GOAL)))).obstacles
    np.testing.assert_allclose(obstacle.t, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(obstacle.states[:, 0], [60.0, 61.2, 62.4, 63.6])


def test_heading_and_speed_follow_from_the_motion(tmp_path: Path) -> None:
    """Point masses have no heading, some files no speed."""
    states = [state("state", k, 60.0 + k, 2.0 * k, 0.0) for k in range(4)]
    bare = moving(31, states)
    for inner in ("<orientation><exact>0.0</exact></orientation>", "<velocity><exact>0.0</exact></velocity>"):
        bare = bare.replace(inner, "")
    (car,) = read_commonroad(written(tmp_path, document(ROAD, bare, problem(GOAL)))).obstacles
    np.testing.assert_allclose(car.states[:, 2], math.atan2(2.0, 1.0))
    np.testing.assert_allclose(car.states[:, 3], 10.0 * math.hypot(1.0, 2.0))


def test_tapering_lanelet_is_read(tmp_path: Path) -> None:
    points = [[(0.0, 0.0), (50.0, 1.75), (200.0, 1.75)], [(0.0, 0.0), (50.0, -1.75), (200.0, -1.75)]]
    bounds = [
        f"<{tag}>" + "".join(f"<point><x>{x}</x><y>{y}</y></point>" for x, y in line) + f"</{tag}>"
        for tag, line in zip(("leftBound", "rightBound"), points, strict=True)
    ]
    taper = f'<lanelet id="9">{bounds[0]}{bounds[1]}</lanelet>'
    flat = f'<lanelet id="10">{bounds[0]}{bounds[0].replace("left", "right")}</lanelet>'
    scenario = read_commonroad(written(tmp_path, document(taper, flat, problem(GOAL))))
    assert scenario.lanelets[9].width == 0.0
    assert 10 not in scenario.lanelets
    assert drive_commonroad(scenario).summary()["reached"]


def test_several_shapes_become_one_box(tmp_path: Path) -> None:
    trailer = (
        "<rectangle><length>6</length><width>2.5</width><orientation>0</orientation>"
        "<center><x>-5.25</x><y>0</y></center></rectangle></shape>"
    )
    car = moving(31, [state("state", k, 60.0 + k, 0.0, 10.0) for k in range(2)])
    (body,) = read_commonroad(written(tmp_path, document(ROAD, car.replace("</shape>", trailer)))).obstacles
    assert (body.length, body.width) == pytest.approx((10.5, 2.5))
    assert body.states[0, 0] == pytest.approx(60.0 - 3.0)


def test_unknown_kinds_of_obstacles_are_named(tmp_path: Path) -> None:
    scenario = read_commonroad(written(tmp_path, document(ROAD, '<phantomObstacle id="7"/>')))
    assert scenario.left_out == ("phantomObstacle 7: this kind is not read",)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_raise(tmp_path: Path, encoding: str) -> None:
    bomb = '<!DOCTYPE commonRoad [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
    text = GOOD.replace('<?xml version="1.0"?>', f'<?xml version="1.0" encoding="{encoding}"?>{bomb}')
    file = tmp_path / "bomb.xml"
    file.write_bytes(text.replace("ZAM_Test-1", "&b;").encode(encoding))
    with pytest.raises(InputError, match="DOCTYPE"):
        read_commonroad(file)


def test_large_missing_or_other_file_raises(tmp_path: Path) -> None:
    large = tmp_path / "large.xml"
    with large.open("wb") as stream:
        stream.truncate(50_000_001)
    with pytest.raises(InputError, match="at most 50 MB"):
        read_commonroad(large)
    with pytest.raises(InputError, match="cannot be read"):
        read_commonroad(tmp_path / "none.xml")
    with pytest.raises(InputError, match="cannot be read"):
        read_commonroad(tmp_path)
    with pytest.raises(InputError, match="must be a path"):
        read_commonroad(None)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="root element must be commonRoad, was 'gpx'"):
        read_commonroad(written(tmp_path, "<gpx/>"))


def read(data: bytes) -> CommonRoadScenario:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "fuzzed.xml"
        file.write_bytes(data)
        return read_commonroad(file)


def refused_or_read(data: bytes) -> None:
    with suppress(InputError):
        scenario = read(data)
        assert scenario.lanelets or scenario.obstacles or scenario.problems


@given(st.integers(0, len(GOOD) - 1))
def test_truncated_file_raises(length: int) -> None:
    with pytest.raises(InputError):
        read(GOOD[:length].encode())


@given(st.integers(0, len(GOOD) - 1), st.binary(max_size=4))
def test_damaged_bytes_raise_or_are_read(at: int, patch: bytes) -> None:
    data = GOOD.encode()
    refused_or_read(data[:at] + patch + data[at + len(patch) :])


@given(st.data())
def test_damaged_elements_raise_or_are_read(data: st.DataObject) -> None:
    root = ElementTree.fromstring(GOOD)
    for _ in range(data.draw(st.integers(1, 3))):
        elements = [element for element in root.iter() if len(element)]
        parent = elements[data.draw(st.integers(0, len(elements) - 1))]
        child = parent[data.draw(st.integers(0, len(parent) - 1))]
        kind = data.draw(st.sampled_from(("delete", "repeat", "text", "tag", "attribute")))
        if kind == "delete":
            parent.remove(child)
        elif kind == "repeat":
            parent.append(child)
        elif kind == "text":
            child.text = data.draw(st.sampled_from(("", "nan", "-inf", "1e400", "-1", "1_0", "\u0663", "x")))
        elif kind == "tag":
            child.tag = data.draw(st.sampled_from(("point", "lanelet", "x", "exact", "circle")))
        else:
            name = data.draw(st.sampled_from(("id", "ref", "drivingDir")))
            child.set(name, data.draw(st.sampled_from(("", "-1", "1", "900", "1e3", "9" * 50))))
        if not any(len(element) for element in root.iter()):
            break
    refused_or_read(ElementTree.tostring(root))

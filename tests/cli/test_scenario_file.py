"""Scenarios in TOML: what is read, and messages of what is wrong."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cca_core import EvasionSettings, VehicleParams
from cca_core.cli.scenario_file import read_scenario
from cca_core.errors import InputError
from cca_core.sim import BrakeAction, LateralShiftAction, ReactToLeadAction, Scenario, SpeedAction
from cca_core.v2x import ChannelSettings
from tests.support.moved_maps import moved_file
from tests.support.sumo_files import write_net

SMALL = """
[road]
pieces = [{length = 500.0}]
[ego]
cruise_speed = 20.0
"""
FULL = """
name = "merge"
case = "wet"
duration = 12.5
seed = 7
plant = "multi_body"
visibility = 90.0
[road]
pieces = [{length = 200.0}, {length = 157.0796, radius = 100.0}, {length = 300.0, radius = -400.0}]
start = [10.0, -5.0]
heading = 0.5
speed_limit = 25.0
stop_lines = [150.0]
[[road.lanes]]
d = 0.0
[[road.lanes]]
d = 3.4
width = 3.2
direction = -1
[ego]
type = "sensor"
start = 40
v_x = 15
cruise_speed = 22
sensor_range = 60.0
vehicle = {preset = "vw_vanagon", mu = 0.6}
fixed_gap = {lead_id = "B", time_gap = 0.8}
[evasion]
preset = "traffic"
clearance = 0.8
cost = {}
[speed]
b_max = 6.0
[radio]
preset = "wyoming"
loss_probability = 0.1
shared_modem = true
[sender]
position_noise = 0.4
[[road_users]]
id = "A"
s = 150
v_x = 10.0
events = ["hazard_lights"]
actions = [
    {type = "speed", t = 1.0, v_x = 14.0},
    {type = "lateral_shift", s_start = 200.0, offset = 3.4, duration = 4.0},
]
[[road_users]]
id = "B"
s = 90.0
v_x = 15.0
actions = [{type = "react_to_lead", lead_id = "A"}, {type = "brake", t = 5.0, deceleration = 3.0}]
[[road_users]]
id = "C"
s = 0.0
v_x = 8.0
connected = false
route = {pieces = [{length = 300.0}], start = [100.0, -100.0], heading = 1.5708}
"""


def read(text: str, tmp_path: Path) -> Scenario:
    file = tmp_path / "trip.toml"
    file.write_text(text, encoding="utf-8")
    return read_scenario(file)[0]


def test_small_file_takes_defaults(tmp_path: Path) -> None:
    made = read(SMALL, tmp_path)
    assert (made.name, made.case, made.ego_type) == ("trip", None, "v2v")
    assert (made.start, made.v_x, made.duration, made.seed) == (20.0, 20.0, 40.0, 1)
    assert made.vehicle == VehicleParams.bmw_320i()
    assert made.evasion == EvasionSettings()
    assert made.channel == ChannelSettings(latency=0.1)
    assert made.road.path.length == pytest.approx(500.0)
    assert made.road_users == ()


def test_full_file_sets_every_value(tmp_path: Path) -> None:
    made = read(FULL, tmp_path)
    assert (made.name, made.case, made.duration, made.seed) == ("merge", "wet", 12.5, 7)
    assert (made.ego_type, made.start, made.v_x, made.cruise_speed) == ("sensor", 40.0, 15.0, 22.0)
    assert (made.visibility, made.sensor_range, made.shared_modem) == (90.0, 60.0, True)
    assert made.vehicle == replace(VehicleParams.vw_vanagon(), mu=0.6)
    assert made.evasion == replace(EvasionSettings.traffic(), clearance=0.8)
    assert made.speed.b_max == 6.0
    assert made.channel == replace(ChannelSettings.wyoming(), loss_probability=0.1)
    assert made.sender.position_noise == 0.4
    assert made.fixed_gap is not None
    assert [(lane.d, lane.width, lane.direction) for lane in made.road.lanes] == [(0, 3.5, 1), (3.4, 3.2, -1)]
    a, b, c = made.road_users
    assert a.actions == (
        SpeedAction(t=1.0, v_x=14.0), LateralShiftAction(s_start=200.0, offset=3.4, duration=4.0)
    )  # fmt: skip
    assert a.events == {"hazard_lights"}
    assert b.actions == (ReactToLeadAction(lead_id="A"), BrakeAction(t=5.0, deceleration=3.0))
    assert c.route is not None
    assert c.route.position(300.0) == pytest.approx([100.0, 200.0], abs=0.01)
    assert read_scenario(tmp_path / "trip.toml")[1] == "multi_body"


def test_pieces_are_lines_and_arcs(tmp_path: Path) -> None:
    path = read(FULL, tmp_path).road.path
    assert path.position(0.0) == pytest.approx([10.0, -5.0])
    assert path.heading(100.0) == pytest.approx(0.5, abs=1e-6)
    assert path.curvature(280.0) == pytest.approx(0.01, rel=1e-3)
    assert path.curvature(500.0) == pytest.approx(-0.0025, rel=1e-3)
    assert path.heading(path.end) == pytest.approx(0.5 + math.pi / 2.0 - 0.75, abs=1e-4)
    assert path.length == pytest.approx(657.08, abs=0.01)
    at_joint = path.curvature(np.linspace(180.0, 220.0, 200))
    assert at_joint.max() <= 0.0125
    assert at_joint.min() >= -0.0025


def test_road_file_is_relative_to_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "way.csv").write_text("x,y\n" + "".join(f"{x},0\n" for x in range(0, 401, 20)))
    made = read(SMALL.replace("pieces = [{length = 500.0}]", 'file = "sub/way.csv"'), tmp_path)
    assert made.road.path.length == pytest.approx(400.0)


def test_limits_and_lanes_may_vary_along_the_road(tmp_path: Path) -> None:
    varying = """
speed_limits = [[0.0, 20.0], [200.0, 12.0]]
lanes = [{d = 0.0}, {boundaries = [[0.0, 1.75, 5.25], [300.0, 1.75, 5.25], [350.0, 1.75, 1.75]]}]
[ego]"""
    road = read(SMALL.replace("[ego]", varying), tmp_path).road
    assert road.speed_limits is not None
    assert road.speed_limits.tolist() == [[0.0, 20.0], [200.0, 12.0]]
    assert road.lanes[1].end == 350.0


def test_road_of_a_map_has_its_lanes_and_limits(tmp_path: Path) -> None:
    write_net(tmp_path)
    text = SMALL.replace("pieces = [{length = 500.0}]", 'file = "small.net.xml"\nalong = ["in", "on"]')
    road = read(text, tmp_path).road
    assert road.path.length == pytest.approx(400.0, abs=1e-6)
    assert [lane.direction for lane in road.lanes] == [1, 1, -1]
    with pytest.raises(
        InputError, match=r"^road.along must be ids of the map, had 'of'; the map has in, on,"
    ):
        read(text.replace('"on"', '"of"'), tmp_path)
    with pytest.raises(InputError, match=r"^road.file: lane must be at most"):
        read(text.replace("[ego]", "lane = 7\n[ego]"), tmp_path)
    with pytest.raises(InputError, match=r"^road.lane must be a whole number, was 'left'"):
        read(text.replace("[ego]", 'lane = "left"\n[ego]'), tmp_path)
    with pytest.raises(InputError, match=r"^road.lanes is unknown"):
        read(text.replace("[ego]", "lanes = []\n[ego]"), tmp_path)


@pytest.mark.parametrize("route", ["map", "track", "pieces"])
def test_routes_are_in_the_frame_of_a_road_of_utm(tmp_path: Path, route: str) -> None:
    by = "691234.5", "5334567.25"
    x, y = map(float, by)
    found = []
    for near in (True, False):
        file = write_net(tmp_path) if near else moved_file(write_net(tmp_path), by)
        left, low = (0.0, 0.0) if near else (x, y)
        track = tmp_path / f"{near}.csv"
        track.write_text("x,y\n" + "".join(f"{left + 20 * k},{low + k * k}\n" for k in range(20)))
        given = {
            "map": f'file = "{file.name}", along = ["in", "up"]',
            "track": f'file = "{track.name}"',
            "pieces": f"pieces = [{{length = 90.0}}], start = [{left + 5.0}, {low - 40.0}], heading = 1.0",
        }[route]
        pieces = "pieces = [{length = 500.0}]"
        text = SMALL.replace(pieces, f'file = "{file.name}"\nalong = ["in", "on"]')
        scenario = read(f"{text}{USER}route = {{{given}}}\n", tmp_path)
        own = scenario.road_users[0].route
        assert own is not None
        s = np.linspace(0.0, 80.0, 9)
        found.append((scenario.road.path.position(s), own.position(s)))
    shift = (234.5, -432.75)
    for far, like in zip(found[1], found[0], strict=True):
        assert np.abs(far - like - shift).max() < 1e-6


def test_pieces_that_begin_far_away_are_those_near_zero(tmp_path: Path) -> None:
    far = SMALL.replace("[ego]", "start = [691234.5, 5334567.25]\n[ego]")
    route = "route = {pieces = [{length = 90.0}], start = [691300.0, 5334500.0], heading = 1.0}"
    scenario = read(f"{far}{USER}{route}\n", tmp_path)
    assert scenario.road.path.position(100.0) == pytest.approx((334.5, -432.75), abs=1e-6)
    own = scenario.road_users[0].route
    assert own is not None
    assert own.position(0.0) == pytest.approx((300.0, -500.0), abs=1e-6)


def test_routes_are_in_the_frame_of_a_gps_road(tmp_path: Path) -> None:
    for name, lon in (("road", 11.0), ("route", 11.005)):
        rows = "".join(f"48.1,{lon + 0.0005 * k}\n" for k in range(20))
        (tmp_path / f"{name}.csv").write_text(f"lat,lon\n{rows}")
    text = SMALL.replace("pieces = [{length = 500.0}]", 'file = "road.csv"')
    scenario = read(f'{text}{USER}route = {{file = "route.csv"}}\n', tmp_path)
    own = scenario.road_users[0].route
    assert own is not None
    s, d = scenario.road.path.project(own.position(0.0))
    assert (float(s), float(d)) == (pytest.approx(372.4, abs=1.0), pytest.approx(0.0, abs=0.1))


USER = '\n[[road_users]]\nid = "A"\ns = 60.0\nv_x = 9.0\n'
WRONG = [
    (SMALL + "v_x = 200.0\n", "ego.v_x must be at most 160", "200"),
    (SMALL + "vehicle = {length = 50.0}\n", "ego.vehicle.length must be at most 40.95", "50"),
    (SMALL + USER + "length = 1e-3\n", "road_users[0].length must be at least 0.01", "0.001"),
    (
        SMALL + USER + 'actions = [{type = "brake", t = 1.0, deceleration = 90.0}]\n',
        "road_users[0].actions[0].deceleration must be at most 20", "90",
    ),
    ("[[road.lanes]]\nd = 0.0\n[[road.lanes]]\nd = 3.5\nwidth = -3.0\n", "road.lanes[1].width must be", "-3"),
    ("[[road.lanes]]\nd = 0.0\nwidht = 3.0\n", "road.lanes[0].widht is unknown; did you mean width?", ""),
    ("[[road.lanes]]\nd = 9.0\n", "road.lanes must", ""),
    ("durration = 3.0\n" + SMALL, "durration is unknown; did you mean duration?", "road_users"),
    ("duration = -3.0\n" + SMALL, "duration must be greater than 0", "-3"),
    ('duration = "long"\n' + SMALL, "duration must be a real number", "'long'"),
    ("duration = true\n" + SMALL, "duration must be a number", "True"),
    ("seed = -1\n" + SMALL, "seed must be a whole number from 0", "-1"),
    ("seed = 1.5\n" + SMALL, "seed must be a whole number from 0", "1.5"),
    ('plant = "truck"\n' + SMALL, "plant must be one of single_track, multi_body", "'truck'"),
    ("name = 3\n" + SMALL, "name must be a text", "3"),
    ("road = 3\n[ego]\ncruise_speed = 3.0\n", "road must be a table", "3"),
    ("[ego]\ncruise_speed = 3.0\n", "road must be given", ""),
    ("[road]\npieces = [{length = 500.0}]\n", "ego must be given", ""),
    ("[road]\n[ego]\ncruise_speed = 3.0\n", "road must have file or pieces, had neither", ""),
    (
        '[road]\nfile = "a.csv"\npieces = []\n[ego]\n',
        "road must have file or pieces, had file and pieces", "",
    ),
    ('[road]\nfile = "a.csv"\n[ego]\n', "road.file: file", "a.csv' cannot be read"),
    ('[road]\nfile = "a.csv"\nheading = 1.0\n[ego]\n', "road.heading must not be given with file", ""),
    ("[road]\npieces = []\n[ego]\n", "road.pieces must have at least one piece", ""),
    ("[road]\npieces = 3\n[ego]\n", "road.pieces must be a list of tables", "3"),
    ("[road]\npieces = [{length = 9.0, radius = 0.0}]\n[ego]\n", "road.pieces[0].radius must be", "was 0"),
    ("[road]\npieces = [{length = 0.0}]\n[ego]\n", "road.pieces[0].length must be greater than 0", ""),
    ("[road]\npieces = [{length = 1e9}]\n[ego]\n", "road.pieces[0].length must end within 200 km", ""),
    ("[road]\npieces = [{radius = 9.0}]\n[ego]\n", "road.pieces[0].length must be given", ""),
    ("[road]\npieces = [{length = 9.0}]\nstart = [1.0]\n[ego]\n", "road.start must be x and y", "[1.0]"),
    (
        "[road]\npieces = [{length = 9.0}]\nspeed_limits = [3.0]\n[ego]\ncruise_speed = 3.0\n",
        "road.speed_limits", "",
    ),
    (
        "[road]\npieces = [{length = 9.0}]\nstop_lines = 3\n[ego]\ncruise_speed = 3.0\n",
        "road.stop_lines", "3",
    ),
    ("[road]\npieces = [{length = 500.0}]\n[ego]\n", "ego.cruise_speed must be given", ""),
    (SMALL + "start = 900.0\n", "ego.start must be at most 500", "900"),
    (SMALL + "v_x = -1.0\n", "ego.v_x must be at least 0", "-1"),
    (SMALL + 'type = "human"\n', "ego.type must be one of v2v, driver, sensor", "'human'"),
    (SMALL + 'vehicle = {preset = "bmw"}\n', "ego.vehicle.preset must be one of bmw_320i", "'bmw'"),
    (SMALL + "vehicle = {mu = 0.0}\n", "ego.vehicle.mu must be greater than 0", "0"),
    (SMALL + "vehicle = {lenght = 4.0}\n", "ego.vehicle.lenght is unknown; did you mean length?", ""),
    (SMALL + "field_of_view = 9.0\n", "ego.field_of_view must be at most", "9"),
    (SMALL + 'fixed_gap = {lead_id = "A", time_gap = 1.0}\n', "ego.fixed_gap.lead_id must be one of", "'A'"),
    (SMALL + "[evasion]\nclearence = 1.0\n", "evasion.clearence is unknown; did you mean clearance?", ""),
    (SMALL + "[evasion]\nclearance = -1.0\n", "evasion.clearance must be", "-1"),
    (SMALL + "[evasion.lead]\nx = 1.0\n", "evasion.lead.x is not a field of LeadSettings", ""),
    (SMALL + "[speed]\njerk = 0.0\n", "speed.jerk must be greater than 0", "0"),
    (SMALL + "[radio]\nloss_probability = 1.5\n", "radio.loss_probability must be at most 1", "1.5"),
    (SMALL + "[radio]\nloss = 0.5\n", "radio.loss is unknown; did you mean loss_probability?", ""),
    (SMALL + "[radio]\nshared_modem = 1\n", "radio.shared_modem must be true or false", "1"),
    (SMALL + "[sender]\ninterval = 0.0\n", "sender.interval must be greater than 0", "0"),
    (SMALL + "[[road_users]]\ns = 3.0\nv_x = 1.0\n", "road_users[0].id must be given", ""),
    (SMALL + USER + "sped = 3.0\n", "road_users[0].sped is unknown", ""),
    (SMALL + USER.replace("9.0", "-9.0"), "road_users[0].v_x must be at least 0, with direction = -1", "-9"),
    (SMALL + USER + "direction = 2\n", "road_users[0].direction must be 1 or -1", "2"),
    (SMALL + USER + USER, "road_users[1].id must be used once", "'A'"),
    (
        SMALL + USER + 'actions = [{type = "stop"}]\n',
        "road_users[0].actions[0].type must be one of brake", "stop",
    ),
    (SMALL + USER + "actions = [{t = 1.0}]\n", "road_users[0].actions[0].type must be given", ""),
    (SMALL + USER + 'actions = [{type = "brake"}]\n', "road_users[0].actions[0].t is missing", ""),
    (
        SMALL + USER + 'actions = [{type = "brake", t = 1.0}, {type = "speed", t = 1.0, v_x = -2.0}]\n',
        "road_users[0].actions[1].v_x must be at least 0", "-2",
    ),
    (
        SMALL + USER + 'actions = [{type = "react_to_lead", lead_id = "B"}]\n',
        "road_users[0].actions[0].lead_id must be the id of another road user", "'B'",
    ),
    (
        SMALL + USER + "route = {pieces = [{length = -1.0}]}\n",
        "road_users[0].route.pieces[0].length must be", "",
    ),
    (SMALL + USER + "route = {speed_limit = 9.0}\n", "road_users[0].route.speed_limit is unknown", ""),
    ("duration = = 3", "file '", "must be TOML, was not"),
    ("a = " + "[" * 5000, "file '", "must be TOML, was not"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "begin", "part"), WRONG, ids=range(len(WRONG)))
def test_error_names_the_key(text: str, begin: str, part: str, tmp_path: Path) -> None:
    if text.startswith("[[road.lanes]]"):
        text = SMALL.replace("[ego]", text + "[ego]")
    with pytest.raises(InputError) as error:
        read(text, tmp_path)
    assert str(error.value).startswith(begin)
    assert part in str(error.value)


@pytest.mark.parametrize("value", ["[]", "{}", "nan", "inf", "1979-05-27", '"x"', "[[1]]", "true", "-1"])
@pytest.mark.parametrize(
    "key",
    [
        "name", "duration", "seed", "plant", "visibility", "road.pieces", "road.start", "road.heading",
        "road.lanes", "road.speed_limit", "road.speed_limits", "road.stop_lines", "ego.type", "ego.start",
        "ego.v_x", "ego.cruise_speed", "ego.vehicle", "ego.vehicle.m", "ego.sensor_range", "ego.fixed_gap",
        "evasion.preset", "evasion.clearance", "evasion.cost", "speed.jerk", "radio.range", "radio.preset",
        "road_users", "sender.interval",
    ],
)  # fmt: skip
def test_any_value_is_read_or_refused(key: str, value: str, tmp_path: Path) -> None:
    content: dict[str, Any] = {"road.pieces": "[{length = 500.0}]", "ego.cruise_speed": "20.0"}
    try:
        read("".join(f"{name} = {text}\n" for name, text in (content | {key: value}).items()), tmp_path)
    except InputError as error:
        assert key.split(".")[0] in str(error)  # noqa: PT017

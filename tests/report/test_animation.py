import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from cca_core import InputError
from cca_core.report import animate
from cca_core.report.files import read_text
from cca_core.sim import Log
from tests.support.paper_runs import HOSTILE_ID, Run

ELSEWHERE = re.compile(r"\b(?:https?:|ftp:|file:|//\w)|\bsrc=|href=|<link|@import|url\(|<img|<image")


def data_of(fragment: str) -> list[dict[str, object]]:
    """What is embedded, with differences summed up."""
    (text,) = (e.text for e in ElementTree.fromstring(fragment).iter("script") if e.get("type"))
    runs = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is embedded"))
    for data in runs:
        data["t"] = 1e-3 * np.cumsum(data["t"])
        data["bodies"] = np.cumsum(np.array(data["bodies"], dtype=float), axis=-1)
        data["camera"] = np.cumsum(np.array(data["camera"], dtype=float), axis=-1)
    return runs


@pytest.fixture(scope="module")
def pair(run: Run) -> tuple[Log, Log]:
    return run("eebl", "A", "driver"), run("eebl", "C", "v2v")


def test_positions_are_those_of_the_log_within_1_cm(pair: tuple[Log, Log]) -> None:
    for log, data in zip(pair, data_of(animate(pair)), strict=True):
        rows = np.searchsorted(log.t, np.asarray(data["t"]) - 1e-3)
        np.testing.assert_allclose(log.t[rows], data["t"], atol=1e-3)
        assert rows[-1] == len(log.t) - 1
        assert np.diff(data["t"]).max() < 0.101
        ego, _ = log.bodies()
        own = np.column_stack((ego.x[:, 0], ego.y[:, 0]))[rows]
        shown = np.asarray(data["bodies"])
        np.testing.assert_allclose(0.01 * shown[0, :2].T + data["origin"], own, atol=0.01)
        for i in range(len(log.scenario.road_users)):
            np.testing.assert_allclose(
                0.01 * shown[1 + i, :2].T + data["origin"], log.road_users[rows, i, :2], atol=0.01
            )
            np.testing.assert_allclose(0.01 * shown[1 + i, 3], log.road_users[rows, i, 3], atol=0.01)


def test_headings_are_unwrapped(run: Run) -> None:
    log = run("maneuver", "1-smooth", "v2v")
    turned = log.ego.copy()
    turned[:, 2] -= 2.0 * np.pi * (log.t > 5.0)
    (data,) = data_of(animate([replace(log, ego=turned)]))
    assert np.abs(np.diff(np.asarray(data["bodies"])[0, 2])).max() < 2000  # 0.2 rad in 0.1 s


def test_bodies_start_at_their_logged_positions(pair: tuple[Log, Log]) -> None:
    root = ElementTree.fromstring(animate(pair))
    for log, svg in zip(pair, root.iter("svg"), strict=True):
        cars = [group for group in svg.iter("g") if "car" in (group.get("class") or "").split()]
        numbers = [re.findall(r"-?[\d.]+", car.get("transform")) for car in cars]
        xy = np.array([[float(x), float(y)] for x, y, _ in numbers])
        np.testing.assert_allclose(xy[0], (0.0, 0.0), atol=0.01)
        np.testing.assert_allclose(xy[1:], log.road_users[0, :, :2] - log.ego[0, :2], atol=0.02)
        sizes = [(float(car[0].get("width")), float(car[0].get("height"))) for car in cars]
        assert sizes == [(4.5, 1.8)] * len(cars)


def test_roads_are_those_of_the_scenario(run: Run) -> None:
    log = run("curbside", "fast", "driver")
    svg = next(ElementTree.fromstring(animate([log])).iter("svg"))
    ego, _ = log.bodies()
    origin = ego.x[0, 0], ego.y[0, 0]
    lines = {}
    for line in svg.iter("polyline"):
        points = np.array([p.split(",") for p in line.get("points").split()], dtype=float).reshape(-1, 2)
        lines.setdefault(line.get("class"), []).append(points + origin)
    road = log.scenario.road
    for kind, wanted in (
        ("edge", [road.right_edge, road.left_edge]), ("dashes", [1.75]), ("route", [0.0])
    ):  # fmt: skip
        for points, d in zip(lines[kind], wanted, strict=True):
            assert len(points) > 10
            np.testing.assert_allclose(road.path.project(points)[1], d, atol=0.04)


def test_fragment_is_well_formed_small_and_self_contained(pair: tuple[Log, Log]) -> None:
    fragment = animate(pair)
    root = ElementTree.fromstring(fragment)
    assert not ELSEWHERE.search(fragment)
    assert len(fragment.encode()) < 200_000
    assert len(list(root.iter("svg"))) == len(pair)
    assert all(svg.get("aria-label") and svg.find("title").text for svg in root.iter("svg"))
    assert root.find(".//section").get("aria-label")
    assert [root.find(f".//{tag}") is not None for tag in ("button", "input", "select")] == [True] * 3
    assert root.find(".//input").get("aria-label")


def test_script_respects_reduced_motion_and_is_xml_safe() -> None:
    script = read_text("player.js")
    assert "prefers-reduced-motion" in script
    assert not set("<&") & set(script)


def test_style_and_script_are_included_on_request(pair: tuple[Log, Log]) -> None:
    assert len(list(ElementTree.fromstring(animate(pair)).iter("script"))) == 2
    bare = ElementTree.fromstring(animate(pair, standalone=False))
    assert len(list(bare.iter("script"))) == 1
    assert bare.find(".//style") is None


def test_collision_is_marked_and_named(pair: tuple[Log, Log]) -> None:
    fragment = animate(pair)
    text, none = (data["collision"] for data in data_of(fragment))
    log = pair[0]
    assert none is None
    assert text == f"collision with yellow at {log.t[-1]:.1f} s, {log.closing_speed():.1f} m/s"
    crashed, free = ElementTree.fromstring(fragment).iter("svg")
    (mark,) = (group for group in crashed.iter("g") if group.get("class") == "collision")
    x, y = (float(v) for v in re.findall(r"-?[\d.]+", mark.get("transform")))
    bumper = 0.5 * (log.ego[-1, 0] + log.road_users[-1, 0, 0]) - log.ego[0, 0]
    np.testing.assert_allclose((x, y), (bumper, 0.0), atol=1.0)
    assert not [group for group in free.iter("g") if group.get("class") == "collision"]


def test_known_vehicles_follow_sensor_or_messages(pair: tuple[Log, Log]) -> None:
    without, with_v2v = data_of(animate(pair))
    assert set(without["known"][1]) == {"0"}  # yellow hides red
    assert set(without["known"][0]) == {"1"}
    assert with_v2v["known"][1].lstrip("0") == "1" * len(with_v2v["known"][1].lstrip("0")) != ""
    assert without["received"] == [[], []]
    for times in with_v2v["received"]:
        assert len(times) > 5
        assert np.diff(times).min() >= 500
        assert {round(1e-3 * t / 0.02) for t in times} <= {row for row, _ in pair[1].received}


def test_hostile_id_stays_text(hostile: Log) -> None:
    fragment = animate([hostile])
    root = ElementTree.fromstring(fragment)
    assert len(list(root.iter("script"))) == 2
    assert "alert('&" not in fragment
    assert "\x00" not in fragment
    fragment.encode("utf-8")
    (data,) = data_of(fragment)
    assert any(name.startswith(HOSTILE_ID[:30]) for name in data["names"])


def test_run_without_other_vehicles(alone: Log) -> None:
    (data,) = data_of(animate([alone]))
    assert np.asarray(data["bodies"]).shape[0] == 1
    assert data["known"] == data["received"] == []


def test_run_of_one_cycle(pair: tuple[Log, Log]) -> None:
    log = pair[0]
    fields = (
        "t ego a_y command ego_frenet tracking road_users user_motion user_frenet visible tracked gap_held"
        " degraded cycle_us"
    )
    short = replace(log, **{name: getattr(log, name)[:1] for name in fields.split()})
    (data,) = data_of(animate([short]))
    assert np.asarray(data["t"]).tolist() == [0.0]


def test_camera_is_fixed_only_if_roads_cross(run: Run, pair: tuple[Log, Log]) -> None:
    (crossing,) = data_of(animate([run("ima", "left-turn", "v2v")]))
    assert np.ptp(np.asarray(crossing["camera"]), axis=1).max() == 0.0
    for log, data in zip(pair, data_of(animate(pair)), strict=True):
        traveled = np.ptp(np.asarray(data["camera"])[0])
        assert traveled == pytest.approx(100.0 * np.ptp(log.ego_frenet[:, 0]), rel=1e-3)


def test_animation_without_runs_raises() -> None:
    with pytest.raises(InputError, match="at least one run"):
        animate([])

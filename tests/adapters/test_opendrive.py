"""Maps of OpenDRIVE against closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import fresnel

from cca_core import InputError, Road
from cca_core.adapters import read_opendrive
from tests.support.opendrive_files import crossing, geometry, lane, road, section, width, write_map


def one_road(tmp_path: Path, shape: str, length: float, **kwargs: object) -> Road:
    text = road("7", length, [geometry(0.0, 10.0, -5.0, 0.4, length, shape)], **kwargs)  # type: ignore[arg-type]
    return read_opendrive(write_map(tmp_path, text)).road_along(["7"], -1)


ON_LINE = '<laneOffset s="0" a="1.75" b="0" c="0" d="0"/>'


def on_reference(tmp_path: Path, shape: str, length: float) -> Road:
    return one_road(tmp_path, shape, length, sections=[section(0.0, [lane(-1)])], offsets=ON_LINE)


def turned(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    c, s = math.cos(0.4), math.sin(0.4)
    return np.column_stack((10.0 + c * u - s * v, -5.0 + s * u + c * v))


S = np.linspace(0.0, 120.0, 241)


def test_line_is_exact(tmp_path: Path) -> None:
    here = on_reference(tmp_path, "<line/>", 120.0)
    assert here.path.length == pytest.approx(120.0, abs=1e-9)
    assert here.path.position(S) == pytest.approx(turned(S, 0.0 * S), abs=1e-9)


@pytest.mark.parametrize("curvature", [0.01, -0.08, 1e-7])
def test_arc_is_exact_to_a_tenth_of_a_millimeter(tmp_path: Path, curvature: float) -> None:
    here = on_reference(tmp_path, f'<arc curvature="{curvature}"/>', 120.0)
    angle = curvature * S
    want = turned(np.sin(angle) / curvature, (1.0 - np.cos(angle)) / curvature)
    assert here.path.length == pytest.approx(120.0, abs=1e-6)
    assert np.abs(here.path.position(S) - want).max() < 1e-4
    assert here.path.curvature(S[1:-1]) == pytest.approx(curvature, rel=2e-3, abs=1e-9)


@pytest.mark.parametrize(("first", "last"), [(0.0, 0.05), (-0.02, 0.03), (0.04, 0.0), (0.0, 1e-9)])
def test_spiral_is_a_clothoid(tmp_path: Path, first: float, last: float) -> None:
    here = on_reference(tmp_path, f'<spiral curvStart="{first}" curvEnd="{last}"/>', 120.0)
    rate = (last - first) / 120.0
    scale, shift = math.sqrt(math.pi / abs(rate)), first / rate
    sines, cosines = fresnel((S + shift) / scale)
    sines_0, cosines_0 = fresnel(shift / scale)
    turn = np.exp(-0.5j * first * shift)
    z = turn * scale * ((cosines - cosines_0) + 1j * math.copysign(1.0, rate) * (sines - sines_0))
    assert here.path.length == pytest.approx(120.0, abs=1e-6)
    assert np.abs(here.path.position(S) - turned(z.real, z.imag)).max() < 1e-4
    assert here.path.curvature(S[2:-2]) == pytest.approx(first + rate * S[2:-2], abs=2e-4)


def test_poly3_is_over_arc_length(tmp_path: Path) -> None:
    a, b, c, d = 0.0, 0.0, 0.004, -0.00002
    here = on_reference(tmp_path, f'<poly3 a="{a}" b="{b}" c="{c}" d="{d}"/>', 100.0)
    u = np.linspace(0.0, 90.0, 50)
    along = [quad(lambda w: math.hypot(1.0, 2 * c * w + 3 * d * w * w), 0.0, end)[0] for end in u.tolist()]
    want = turned(u, c * u**2 + d * u**3)
    assert np.abs(here.path.position(along) - want).max() < 1e-3
    assert here.path.length == pytest.approx(100.0, abs=1e-3)


@pytest.mark.parametrize(("p_range", "end"), [("normalized", 1.0), ("arcLength", 80.0)])
def test_param_poly3_is_exact(tmp_path: Path, p_range: str, end: float) -> None:
    # a parabola of 80 m along u
    cubic = f'aU="0" bU="{80.0 / end}" cU="0" dU="0" aV="0" bV="0" cV="{20.0 / end**2}" dV="0"'
    here = on_reference(tmp_path, f'<paramPoly3 pRange="{p_range}" {cubic}/>', 80.0)
    u = np.linspace(0.0, 80.0, 60)
    s, d = here.path.project(turned(u, 20.0 * (u / 80.0) ** 2))
    assert np.abs(d).max() < 1e-4
    length = quad(lambda w: math.hypot(1.0, 0.5 * w / 80.0), 0.0, 80.0)[0]
    assert here.path.length == pytest.approx(length, abs=1e-6)
    assert s[-1] == pytest.approx(length, abs=1e-4)


def test_lane_center_on_arc_has_its_own_radius(tmp_path: Path) -> None:
    here = one_road(tmp_path, '<arc curvature="0.02"/>', 100.0)
    assert here.path.length == pytest.approx(100.0 * 51.75 / 50.0, abs=1e-6)
    assert here.path.curvature(50.0) == pytest.approx(1.0 / 51.75, rel=1e-3)
    assert [(lane.direction, round(lane.d, 3), round(lane.width, 3)) for lane in here.lanes] == [
        (1, 0.0, 3.5), (-1, 3.5, 3.5),
    ]  # fmt: skip
    assert not any(lane.boundaries for lane in here.lanes)


def test_lane_against_s_is_driven_backward(tmp_path: Path) -> None:
    text = road("7", 100.0, [geometry(0.0, 10.0, -5.0, 0.4, 100.0, '<arc curvature="0.02"/>')])
    here = read_opendrive(write_map(tmp_path, text)).road_along(["7"], 1)
    assert here.path.length == pytest.approx(100.0 * 48.25 / 50.0, abs=1e-6)
    assert here.path.curvature(50.0) == pytest.approx(-1.0 / 48.25, rel=1e-3)
    assert here.path.heading(here.path.end) == pytest.approx(0.4 - math.pi, abs=1e-6)
    assert [round(lane.d, 3) for lane in here.lanes] == [0.0, 3.5]


def test_left_hand_traffic_drives_on_the_left(tmp_path: Path) -> None:
    text = road("7", 100.0, [geometry(0.0, 0.0, 0.0, 0.0, 100.0)], rule="LHT")
    here = read_opendrive(write_map(tmp_path, text)).road_along(["7"], 1)
    assert here.path.position(100.0) == pytest.approx((100.0, 1.75))
    assert [(lane.direction, round(lane.d, 3)) for lane in here.lanes] == [(-1, -3.5), (1, 0.0)]


def test_lane_that_widens_keeps_its_boundaries(tmp_path: Path) -> None:
    # a lane that begins at 40 m and has its width of 3 m at 80 m: 3 (3 r^2 - 2 r^3)
    begins = width(0.0) + width(0.0, 0.0, 9.0 / 1600, -6.0 / 64000, 40.0) + width(3.0, offset=80.0)
    lanes = [lane(-1), lane(-2, begins)]
    here = one_road(tmp_path, "<line/>", 120.0, sections=[section(0.0, lanes)])
    added = next(lane for lane in here.lanes if lane is not here.ego_lane)
    for s in (50.0, 60.0, 75.0, 100.0):
        r = min((s - 40.0) / 40.0, 1.0)
        wide = 3.0 * (3 * r**2 - 2 * r**3)
        assert added.bounds_at(s) == pytest.approx((-1.75 - wide, -1.75), abs=2e-3)
    assert here.edges_at(20.0) == pytest.approx((-1.75, 1.75), abs=2e-3)


def test_ego_lane_that_widens_is_followed_along_its_center(tmp_path: Path) -> None:
    grows = width(3.0) + width(3.0, 0.0, 3.0 / 1600, -2.0 / 64000, 40.0) + width(4.0, offset=80.0)
    here = one_road(tmp_path, "<line/>", 120.0, sections=[section(0.0, [lane(-1, grows)])])
    start = turned(np.array([0.0]), np.array([-1.5]))
    end = turned(np.array([120.0]), np.array([-2.0]))
    assert here.path.position(here.path.start) == pytest.approx(start[0], abs=1e-6)
    assert here.path.position(here.path.end) == pytest.approx(end[0], abs=1e-6)
    assert here.ego_lane.bounds_at(10.0) == pytest.approx((-1.5, 1.5), abs=2e-3)
    assert here.ego_lane.bounds_at(100.0) == pytest.approx((-2.0, 2.0), abs=2e-3)


def test_lanes_go_on_over_sections_and_end(tmp_path: Path) -> None:
    sections = [
        section(0.0, [lane(1, before=1, after=1), lane(-1, after=-1), lane(-2, after=-2)]),
        section(50.0, [lane(1, before=1), lane(-1, before=-1), lane(-2, width(3.5, -0.07), before=-2)]),
    ]
    here = one_road(tmp_path, "<line/>", 100.0, sections=sections)
    ends = here.lane_at(-3.0, 20.0)
    assert ends is not None
    assert ends.bounds_at(75.0) == pytest.approx((-3.5, -1.75), abs=2e-3)
    assert here.lane_at(-3.0, 95.0) is None
    assert len(here.lanes) == 3


def test_speed_limits_of_road_and_lane(tmp_path: Path) -> None:
    types = '<type s="0" type="town"><speed max="50" unit="km/h"/></type>'
    types += '<type s="60" type="rural"><speed max="30" unit="mph"/></type>'
    types += '<type s="90" type="rural"><speed max="no limit"/></type>'
    slow = lane(-1, speed='<speed sOffset="30" max="8"/>')
    sections = [section(0.0, [lane(-1, after=-1)]), section(10.0, [slow])]
    text = road("7", 120.0, [geometry(0.0, 0.0, 0.0, 0.0, 120.0)], types=types)
    plain = read_opendrive(write_map(tmp_path, text)).road_along(["7"], -1, speed_limit=40.0)
    assert plain.speed_limits is not None
    assert plain.speed_limits == pytest.approx(
        np.array([(0.0, 50 / 3.6), (60.0, 30 * 0.44704), (90.0, 40.0)])
    )
    back = read_opendrive(tmp_path / "map.xodr").road_along(["7"], 1)
    assert [back.highest_limit(s, s) for s in (10.0, 40.0, 100.0)] == pytest.approx([36.0, 13.4112, 50 / 3.6])
    lanes = road("7", 120.0, [geometry(0.0, 0.0, 0.0, 0.0, 120.0)], sections, types=types)
    here = read_opendrive(write_map(tmp_path, lanes)).road_along(["7"], -1)
    assert [here.highest_limit(s, s) for s in (10.0, 39.0, 41.0)] == pytest.approx([50 / 3.6, 50 / 3.6, 8.0])


def test_heights_are_kept(tmp_path: Path) -> None:
    heights = '<elevation s="0" a="2" b="0.01" c="0" d="0"/>'
    here = one_road(tmp_path, "<line/>", 100.0, heights=heights)
    assert here.height_range(0.0, here.path.end) == pytest.approx((2.0, 3.0))


def test_route_turns_within_a_junction(tmp_path: Path) -> None:
    here = read_opendrive(crossing(tmp_path)).find_road(("1", 20.0, -1), ("2", 30.0, 1))
    quarter = 0.5 * math.pi * 21.75
    assert here.path.length == pytest.approx(80.0 + quarter + 50.0, abs=1e-5)
    assert here.path.position(0.0) == pytest.approx((20.0, -1.75))
    assert here.path.position(here.path.end) == pytest.approx((121.75, 70.0), abs=1e-5)
    assert here.path.curvature(80.0 + 0.5 * quarter) == pytest.approx(1.0 / 21.75, rel=1e-3)
    assert here.lane_at(3.5, 40.0) is not None
    assert here.lane_at(3.5, 95.0) is None
    assert here.lane_at(3.5, 140.0) is not None


def test_route_by_roads_is_that_by_positions(tmp_path: Path) -> None:
    world = read_opendrive(crossing(tmp_path))
    assert world.road_ids == ("1", "2", "3", "5", "6")
    by_roads = world.road_along(["1", "6", "3"], -1)
    found = world.find_road(("1", 0.0, -1), ("3", 60.0, -1))
    assert by_roads.path.length == pytest.approx(200.0)
    assert np.array_equal(by_roads.path.breaks, found.path.breaks)


def test_roads_that_point_at_each_other_are_one_route(tmp_path: Path) -> None:
    # the numbers of curve_road_mixed.xodr of esmini: three arcs of 200 m radius, the second one against s
    def arc(
        id: str, x: float, y: float, heading: float, length: float, k: float, link: str, *links: object
    ) -> str:
        before, after = links
        lanes = [
            lane(1, width(3.0), before=before and -1, after=after and -1),  # type: ignore[arg-type]
            lane(-1, width(3.0), before=before and 1, after=after and 1),  # type: ignore[arg-type]
        ]
        shape = [geometry(0.0, x, y, heading, length, f'<arc curvature="{k}"/>')]
        return road(id, length, shape, [section(0.0, lanes)], link=link)

    def to(tag: str, id: str, contact: str) -> str:
        return f'<{tag} elementType="road" elementId="{id}" contactPoint="{contact}"/>'

    x, y = 112.92849467900706, 34.932877018064346
    first = arc("0", 0.0, 0.0, 0.0, 100.0, 0.005, to("successor", "1", "end"), None, True)
    links = to("predecessor", "2", "start") + to("successor", "0", "end")
    second = arc("1", x, y, 3.741592653589793, 20.0, -0.005, links, True, True)
    third = arc("2", x, y, 6.883185307179586, 100.0, 0.005, to("predecessor", "1", "start"), True, None)
    here = read_opendrive(write_map(tmp_path, first, second, third)).road_along(["0", "1", "2"], -1)
    s = np.linspace(0.0, here.path.length, 300)
    angle = s / 201.5
    want = np.column_stack((201.5 * np.sin(angle), 200.0 - 201.5 * np.cos(angle)))
    assert here.path.length == pytest.approx(220.0 * 201.5 / 200.0, abs=1e-5)
    assert np.abs(here.path.position(s) - want).max() < 1e-4
    assert [(lane.direction, round(lane.d, 3), round(lane.width, 3)) for lane in here.lanes] == [
        (1, 0.0, 3.0), (-1, 3.0, 3.0),
    ]  # fmt: skip


def test_lane_without_width_raises(tmp_path: Path) -> None:
    words = r"^lane -1 of road '7' on the route must be at least 0.1 m wide, was 0 m at s = 0.0 m"
    with pytest.raises(InputError, match=words):
        one_road(tmp_path, "<line/>", 50.0, sections=[section(0.0, [lane(-1, width(0.0, 0.07))])])


def test_corners_are_fitted(tmp_path: Path) -> None:
    shapes = [geometry(0.0, 0.0, 0.0, 0.0, 60.0), geometry(60.0, 60.0, 0.0, 0.1, 60.0)]
    here = read_opendrive(write_map(tmp_path, road("7", 120.0, shapes))).road_along(["7"], -1)
    assert here.path.min_radius > 10.0
    points = [
        (30.0, -1.75),
        (60.0 + 30.0 * math.cos(0.1) + 1.75 * math.sin(0.1), 30.0 * math.sin(0.1) - 1.75 * math.cos(0.1)),
    ]
    assert np.abs(here.path.project(points)[1]).max() < 0.11
    assert here.ego_lane.bounds_at(30.0) == pytest.approx((-1.75, 1.75), abs=0.11)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m: m.road_along(["4"], -1), "^road_ids must be a road of the map, was '4'"),
        (lambda m: m.road_along("1", -1), "^road_ids must be a sequence of ids"),
        (lambda m: m.road_along([], -1), "^road_ids must be a sequence of ids"),
        (lambda m: m.road_along(["1"], -4), r"^lane_id must be one of \[-1, 1\] of road '1', was -4"),
        (lambda m: m.road_along(["1", "3"], -1), "^lane -1 of road '1' must lead to road '3', leads to '5'"),
        (lambda m: m.find_road(("1", 0.0, -1), ("2", 10.0, -1)), "^end must be reachable along the lane"),
        (lambda m: m.find_road(("1", 101.0, -1), ("2", 9.0, 1)), "^station of start must be at most 100"),
        (lambda m: m.find_road("1", ("2", 10.0, 1)), "^start must be a road id, a station and a lane id"),
        (lambda m: m.find_road(("1", 50.0, -1), ("1", 20.0, -1)), "^end must be reachable"),
        (lambda m: m.road_along(["1"], -1, speed_limit=0.0), "^speed_limit must be greater than 0"),
    ],
)  # fmt: skip
def test_invalid_route_raises(tmp_path: Path, call, words: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=words):
        call(read_opendrive(crossing(tmp_path)))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<net/>", "^root element must be OpenDRIVE, was 'net'"),
        ("<OpenDRIVE/>", "^OpenDRIVE must hold a road"),
        ('<OpenDRIVE><road id="1" length="x"/></OpenDRIVE>', "^length of road '1' must be a real number"),
        ('<OpenDRIVE><road id="1" length="9"/></OpenDRIVE>', "^road '1' must have a planView"),
        ("<!DOCTYPE a><OpenDRIVE/>", "^DOCTYPE must not occur"),
        ("<OpenDRIVE>", "broken XML"),
    ],
)
def test_broken_map_raises(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "map.xodr"
    file.write_text(text)
    with pytest.raises(InputError, match=words):
        read_opendrive(file)


def test_gap_in_the_map_raises(tmp_path: Path) -> None:
    shapes = [geometry(0.0, 0.0, 0.0, 0.0, 60.0), geometry(60.0, 65.0, 0.0, 0.0, 60.0)]
    world = read_opendrive(write_map(tmp_path, road("7", 120.0, shapes)))
    with pytest.raises(InputError, match=r"^route must have gaps of at most 1 m, had 5 m near"):
        world.road_along(["7"], -1)

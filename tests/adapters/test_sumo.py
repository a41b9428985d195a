"""The ego in SUMO: roads of nets, positions and motion, by a small fake and by libsumo."""

import math
import subprocess
from pathlib import Path

import numpy as np
import pytest

from cca_core import InputError, LocalFrame, MissingExtraError, VehicleParams, VehicleState
from cca_core.adapters import RadioLink, SumoWorld
from cca_core.v2x import Channel, ChannelSettings
from tests.support.fake_sumo import FakeLane, FakeSumo, FakeVehicle

CAR = VehicleParams(
    m=1500.0, I_z=2500.0, l_f=1.2, l_r=1.5, C_f=1e5, C_r=1e5, length=4.5, width=1.8, box_offset=0.2
)


def straight_net() -> dict[str, FakeLane]:
    """Edges a (0 to 200 m) and b (210 to 400 m) to the east, with a junction, and one lane in return."""
    return {
        "a_0": FakeLane([(0.0, 0.0), (200.0, 0.0)], [("b_0", ":n_0", "s")]),
        "a_1": FakeLane([(0.0, 3.5), (200.0, 3.5)], [("b_1", ":n_1", "s")]),
        ":n_0": FakeLane([(200.0, 0.0), (210.0, 0.0)], [("b_0", "", "s")]),
        ":n_1": FakeLane([(200.0, 3.5), (210.0, 3.5)], [("b_1", "", "s")]),
        "b_0": FakeLane([(210.0, 0.0), (400.0, 0.0)], limit=15.0, width=3.2),
        "b_1": FakeLane([(210.0, 3.5), (400.0, 3.5)]),
        "b_2": FakeLane([(210.0, 7.0), (400.0, 7.0)]),
        "a_back_0": FakeLane([(200.0, 10.5), (0.0, 10.5)]),
        "b_back_0": FakeLane([(400.0, 10.5), (210.0, 10.5)]),
    }


def world(lanes: dict[str, FakeLane] | None = None, **cars: FakeVehicle) -> SumoWorld:
    cars.setdefault("ego", FakeVehicle(52.25, 0.0, 90.0, 10.0))
    return SumoWorld("ego", CAR, connection=FakeSumo(lanes or straight_net(), ["a", "b"], cars))


# --- road ---------------------------------------------------------------------------------------------


def test_road_follows_route_through_junction() -> None:
    road = world().read_road()
    assert road.path.length == pytest.approx(400.0, abs=0.01)
    assert np.abs(road.path.project([(100.0, 0.0), (205.0, 0.0), (390.0, 0.0)])[1]).max() < 0.01


def test_road_has_lanes_as_far_as_they_go_along() -> None:
    road = world().read_road()
    assert road.ego_lane.bounds_at(100.0) == pytest.approx((-1.75, 1.75), abs=0.01)
    assert road.ego_lane.bounds_at(300.0) == pytest.approx((-1.6, 1.6), abs=0.01)
    for d, s, direction in (
        (3.5, 100.0, 1),
        (3.5, 205.0, 1),
        (3.5, 300.0, 1),
        (7.0, 300.0, 1),
        (10.5, 100.0, -1),
    ):
        lane = road.lane_at(d, s)
        assert lane is not None
        assert lane.direction == direction
    assert road.lane_at(7.0, 100.0) is None
    assert road.lane_at(10.5, 205.0) is None  # no connection through the junction


def test_road_has_speed_limits_of_its_edges() -> None:
    road = world().read_road()
    assert road.speed_limits is not None
    assert [v for _, v in road.speed_limits.tolist()] == [20.0, 15.0]
    assert road.speed_limits[1, 0] == pytest.approx(210.0, abs=0.01)


def test_road_of_given_length_ends_early() -> None:
    assert world().read_road(length=150.0).path.length == pytest.approx(210.0, abs=0.01)


def test_lane_for_other_vehicles_is_left_out() -> None:
    lanes = straight_net()
    lanes["a_1"].allowed = ("bicycle",)
    road = world(lanes).read_road()
    assert [road.lane_at(3.5, s) is None for s in (100.0, 205.0, 300.0)] == [True, True, False]


def test_lane_that_drifts_is_followed() -> None:
    lanes = straight_net()
    lanes["b_1"].shape = [(210.0, 3.5), (400.0, 8.0)]
    lane = world(lanes).read_road().lane_at(7.0, 390.0)
    assert lane is not None
    assert lane.bounds_at(305.0) == pytest.approx((4.0, 7.5), abs=0.1)


def test_lane_that_turns_off_ends_there() -> None:
    lanes = straight_net()
    lanes["a_1"].links = [("c_0", "", "l")]
    lanes["c_0"] = FakeLane([(200.0, 3.5), (200.0, 90.0)])
    road = world(lanes).read_road()
    assert [road.lane_at(3.5, s) is None for s in (100.0, 205.0, 300.0)] == [False, True, False]


def test_road_ends_with_lane_that_leaves_route() -> None:
    lanes = straight_net()
    lanes["a_0"].links = [("c_0", "", "r")]
    assert world(lanes).read_road().path.length == pytest.approx(200.0 - CAR.front, abs=0.01)


def test_connection_that_follows_route_farther_is_taken() -> None:
    lanes = straight_net()
    lanes["a_0"].links = [("b_0", "", "s"), ("b_1", ":n_1", "l")]
    lanes["b_1"].links = [("c_0", "", "s")]
    lanes[":n_1"] = FakeLane([(200.0, 0.0), (203.0, 0.5), (207.0, 3.0), (210.0, 3.5)], [("b_1", "", "s")])
    lanes["c_0"] = FakeLane([(400.0, 3.5), (500.0, 3.5)])
    cars = {"ego": FakeVehicle(52.25, 0.0, 90.0, 10.0)}
    road = SumoWorld("ego", CAR, connection=FakeSumo(lanes, ["a", "b", "c"], cars)).read_road()
    assert road.path.position(road.path.end) == pytest.approx((500.0, 3.5), abs=0.1)


def test_road_begins_within_junction() -> None:
    road = world(ego=FakeVehicle(205.0, 0.0, 90.0, 10.0, lane=":n_0")).read_road()
    assert road.path.position(road.path.start) == pytest.approx((200.0, 0.0), abs=0.01)
    assert road.path.length == pytest.approx(200.0, abs=0.01)


# --- vehicles -----------------------------------------------------------------------------------------


def test_ego_state_is_at_center_of_gravity() -> None:
    state = world().ego_state()
    assert (state.x, state.y, state.psi, state.v_x) == pytest.approx((49.8, 0.0, 0.0, 10.0))


def test_moved_ego_has_front_bumper_and_compass_angle() -> None:
    here = world()
    here.move_ego(VehicleState(x=10.0, y=20.0, psi=0.5 * math.pi, v_x=-0.2))
    move, speed = here.connection.calls[-2:]
    assert move == ("moveToXY", "ego", "", -1, pytest.approx(10.0), pytest.approx(22.45), 0.0, 2)
    assert speed == ("setSpeed", "ego", 0.0)


def test_move_and_read_are_inverse() -> None:
    here = world()
    state = here.ego_state()
    here.move_ego(state)
    _, _, _, _, x, y, angle, _ = here.connection.calls[-2]
    ego = here.connection.cars["ego"]
    assert (x, y, angle) == pytest.approx((ego.x, ego.y, ego.angle))


def test_ego_gets_size_of_vehicle_and_is_taken_over() -> None:
    here = world(ego=FakeVehicle(0.0, 0.0, 90.0, 0.0, length=5.0))
    assert here.connection.calls == [
        ("setLength", "ego", 4.5),
        ("setSpeedMode", "ego", 0),
        ("setLaneChangeMode", "ego", 0),
    ]


def test_remotes_are_at_box_centers_within_radius() -> None:
    near = FakeVehicle(80.0, 3.5, 270.0, 12.0, length=8.0, acceleration=-99.0)
    (other,) = world(near=near, far=FakeVehicle(900.0, 0.0, 90.0, 10.0)).remotes()
    assert (other.id, other.length, other.v_x, other.a_x, other.r) == ("near", 8.0, 12.0, -20.0, 0.0)
    assert (other.x, other.y, abs(other.psi)) == pytest.approx((84.0, 3.5, math.pi))
    assert other.invalid_reason is None


def test_remotes_are_dead_reckoned_to_standstill() -> None:
    here = world(near=FakeVehicle(80.0, 0.0, 90.0, 0.2, acceleration=-4.0))
    (now,), (later,) = here.remotes(), here.remotes(0.08)
    assert (later.v_x, later.age) == (0.0, 0.08)
    assert later.x - now.x == pytest.approx(0.008)


def test_yaw_rates_are_differences_of_headings() -> None:
    fake = FakeSumo(straight_net(), ["a", "b"], {"ego": FakeVehicle(52.25, 0.0, 90.0, 10.0)})
    fake.cars["other"] = other = FakeVehicle(80.0, 0.0, 90.0, 10.0)
    here = SumoWorld("ego", CAR, connection=fake, turn_distance=0.0)
    other.angle = 89.0
    assert here.step()
    assert here.remotes()[0].r == pytest.approx(math.radians(10.0))


def test_unknown_ego_raises() -> None:
    with pytest.raises(InputError, match="ego_id must be a vehicle that SUMO has inserted, was 'ghost'"):
        SumoWorld("ghost", CAR, connection=FakeSumo(straight_net(), ["a"], {}))


def test_missing_libsumo_names_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cca_core._optional.find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"libsumo .*'cca-planner\[sumo\]'"):
        SumoWorld("ego", CAR)


def test_radio_link_knows_vehicles_by_their_messages() -> None:
    frame = LocalFrame(48.0, 11.0)
    rng = np.random.default_rng(1)
    link = RadioLink(frame, Channel(ChannelSettings(latency=0.05), rng), rng)
    here = world(near=FakeVehicle(80.0, 0.0, 90.0, 12.0, acceleration=-5.0))
    for k in range(20):
        known = link.exchange(0.1 * k, here.remotes(), here.ego_state())
        here.step()
    (other,) = known
    assert (other.id, other.a_x) == ("near", -5.0)
    assert other.x == pytest.approx(80.0 - 2.25 + 1.9 * 12.0, abs=1.0)
    assert "hard_braking" in other.events
    assert other.age > 0.0


# --- libsumo ------------------------------------------------------------------------------------------

POINTS = {"A": (0, 0), "B": (300, 0), "C": (300, 300), "D": (600, 0)}
NODES = "".join(f'<node id="{name}" x="{x}" y="{y}"/>' for name, (x, y) in POINTS.items())
EDGES = """<edges><edge id="in" from="A" to="B" numLanes="2" speed="20" width="3.5"/>
<edge id="up" from="B" to="C" numLanes="1" speed="14" width="3.2"/>
<edge id="on" from="B" to="D" numLanes="2" speed="25" width="3.5"/>
<edge id="back" from="B" to="A" numLanes="1" speed="20" width="3.5"/></edges>"""
ROUTES = """<routes><vType id="car" length="4.5" width="1.8"/><route id="{0}" edges="{1}"/>
<vehicle id="ego" type="car" route="{0}" depart="0" departLane="{2}" departPos="50" departSpeed="10"/>
</routes>"""


@pytest.fixture
def sumo_net(tmp_path: Path):  # type: ignore[no-untyped-def]
    """A function that starts libsumo with the ego on a route and a lane."""
    libsumo, sumo = pytest.importorskip("libsumo"), pytest.importorskip("sumo")
    for name, text in (("nod", f"<nodes>{NODES}</nodes>"), ("edg", EDGES)):
        (tmp_path / f"{name}.xml").write_text(text, encoding="utf-8")
    program = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
    net, files = tmp_path / "net.xml", (tmp_path / "nod.xml", tmp_path / "edg.xml")
    options = [
        "--no-turnarounds",
        "--default.junctions.radius",
        "15",
        "--offset.disable-normalization",
        "true",
    ]
    command = [program, "-n", files[0], "-e", files[1], "-o", net, *options]
    subprocess.run(command, check=True, capture_output=True)

    def start(edges: str, lane: int) -> SumoWorld:
        routes = tmp_path / "routes.xml"
        routes.write_text(ROUTES.format("r", edges, lane), encoding="utf-8")
        libsumo.start(["sumo", "-n", str(net), "-r", str(routes), "--no-step-log", "--no-warnings"])
        libsumo.simulationStep()
        return SumoWorld("ego", VehicleParams.bmw_320i())

    yield start
    libsumo.close()


@pytest.mark.requires("libsumo")
def test_sumo_road_goes_straight_over_junction(sumo_net) -> None:  # type: ignore[no-untyped-def]
    road = sumo_net("in on", 0).read_road()
    assert road.path.length == pytest.approx(600.0, abs=0.5)
    assert road.path.min_radius > 500.0
    lanes = [(round(lane.d, 1), lane.direction) for lane in road.lanes]
    assert lanes == [(0.0, 1), (3.5, 1), (7.0, -1)]
    assert road.lane_at(7.0, 100.0) is not None
    assert road.lane_at(7.0, 400.0) is None
    assert [road.highest_limit(s, s) for s in (10.0, 400.0)] == [20.0, 25.0]


@pytest.mark.requires("libsumo")
def test_sumo_road_turns_within_junction(sumo_net) -> None:  # type: ignore[no-untyped-def]
    road = sumo_net("in up", 1).read_road()
    end = road.path.position(road.path.end)
    assert end == pytest.approx((301.6, 300.0), abs=0.1)
    assert 8.0 < road.path.min_radius < 20.0
    assert road.path.heading(road.path.end) == pytest.approx(0.5 * math.pi, abs=0.01)


@pytest.mark.requires("libsumo")
def test_sumo_ego_is_where_it_was_moved(sumo_net) -> None:  # type: ignore[no-untyped-def]
    here = sumo_net("in on", 0)
    state = VehicleState(x=150.0, y=-4.0, psi=0.05, v_x=12.0)
    here.move_ego(state)
    assert here.step()
    found = here.ego_state()
    assert (found.x, found.y, found.psi) == pytest.approx((150.0, -4.0, 0.05), abs=1e-3)

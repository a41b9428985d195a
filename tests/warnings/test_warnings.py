"""V2V applications: each warns in its situation and is silent in the one next to it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core import InputError, Lane, Path, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.path import interpolate_path
from cca_core.warnings import AlertSettings, Application, Level, warn, warning_view
from tests.support.turns import quarter_turn

CAR = VehicleParams(m=1500.0, I_z=2500.0, l_f=1.2, l_r=1.4, C_f=1e5, C_r=1e5, length=4.5, width=1.8)
LENGTH = 4.5
G = 9.81

EEBL, FCW, IMA, LTA = Application.EEBL, Application.FCW, Application.IMA, Application.LTA
CURB_SIDE, BSW, LCW, DNPW = Application.CURB_SIDE, Application.BSW, Application.LCW, Application.DNPW


def curved(radius: float) -> Path:
    """Constant curvature to the left (negative radius: to the right), s = 0 in its middle."""
    s = np.arange(-200.0, 901.0, 4.0)
    xy = np.column_stack((radius * np.sin(s / radius), radius * (1.0 - np.cos(s / radius))))
    path = interpolate_path(xy)
    start = float(path.project((0.0, 0.0), 200.0)[0])
    return Path(path.breaks - start, path.coefficients)


STRAIGHT = Path([-200.0, 900.0], [[[0, 0, 1100, -200], [0, 0, 0, 0]]])
ROADS = {"straight": STRAIGHT, "left curve": curved(600.0), "right curve": curved(-600.0)}


def turning(sign: float = 1.0) -> Path:
    """Straight along +x, from s = 0 a quarter turn to the left (sign 1), and straight on."""
    path = quarter_turn(sign=sign, before=80.0, after=80.0)
    start = float(path.project((0.0, 0.0))[0])
    return Path(path.breaks - start, path.coefficients)


LEFT_TURN = turning()


def ego(path: Path, s: float, v: float, d: float = 0.0) -> VehicleState:
    x, y = path.to_cartesian(s, d).tolist()
    return VehicleState(x=x, y=y, psi=float(path.heading(s)), v_x=v)


def other(path: Path, s: float, d: float, v: float, angle: float = 0.0, **more: Any) -> RemoteVehicle:
    """Vehicle at a station of the route, at an angle to it; v is the speed along its lane."""
    x, y = path.to_cartesian(s, d).tolist()
    kappa = path.curvature_at(s) / (1.0 - d * path.curvature_at(s))
    r = v * kappa * round(math.cos(angle)) if abs(math.sin(angle)) < 0.1 else 0.0
    psi = float(path.heading(s)) + angle
    return RemoteVehicle(**{"id": "A", "x": x, "y": y, "psi": psi, "v_x": v, "r": r, **more})


def found(
    path: Path, v: float, remotes: list[RemoteVehicle], s: float = 0.0, d: float = 0.0, **more: Any
) -> dict[Application, Level]:
    return {a.application: a.level for a in warn(ego(path, s, v, d), CAR, path, remotes, **more)}


def ahead(gap: float, v: float, d: float = 0.0, **more: Any) -> dict[str, Any]:
    return {"s": gap + LENGTH, "d": d, "v": v, **more}


def alongside(behind: float, lateral_gap: float, v: float = 25.0, **more: Any) -> dict[str, Any]:
    """Its front `behind` the ego's rear, its side `lateral_gap` from the ego's."""
    return {"s": -behind - LENGTH, "d": 1.8 + lateral_gap, "v": v, **more}


HARD = {"events": frozenset({"hard_braking"}), "a_x": -3.0}

# application, speed of the ego, what sets it off, the silent situation, further arguments
ALONG = {
    "FCW stopped": (FCW, 20.0, ahead(41.9, 0.0), ahead(42.1, 0.0), {}),
    "FCW slower": (FCW, 20.0, ahead(19.9, 10.0), ahead(20.1, 10.0), {}),
    "FCW slower, not yet": (FCW, 20.0, ahead(19.9, 10.0), ahead(22.0, 10.0, a_x=-0.9), {}),
    "FCW decelerating": (FCW, 20.0, ahead(8.5, 20.0, a_x=-3.0), ahead(8.8, 20.0, a_x=-3.0), {}),
    "FCW decelerating at constant difference": (
        FCW, 20.0, ahead(26.0 - 0.1, 10.0, a_x=-1.5), ahead(29.0, 10.0, a_x=-1.5), {},
    ),
    "FCW ego lane": (FCW, 20.0, ahead(15.0, 10.0), ahead(15.0, 10.0, d=3.5), {}),
    "FCW half in the lane": (FCW, 20.0, ahead(15.0, 10.0, d=1.7), ahead(15.0, 10.0, d=1.9), {}),
    "FCW behind": (FCW, 20.0, ahead(15.0, 10.0), {"s": -15.0, "d": 0.0, "v": 10.0}, {}),
    "FCW faster lead": (FCW, 20.0, ahead(15.0, 10.0), ahead(15.0, 25.0), {}),
    "EEBL flag": (EEBL, 29.0, ahead(60.0, 29.0, **HARD), ahead(60.0, 29.0, a_x=-0.39 * G), {}),
    "EEBL without a flag": (
        EEBL, 29.0, ahead(60.0, 29.0, a_x=-0.41 * G), ahead(60.0, 29.0, a_x=-0.39 * G), {},
    ),
    "EEBL range": (EEBL, 29.0, ahead(299.0, 29.0, **HARD), ahead(301.0, 29.0, **HARD), {}),
    "EEBL adjacent lane": (
        EEBL, 29.0, ahead(60.0, 29.0, d=3.5, **HARD), ahead(60.0, 29.0, d=7.0, **HARD), {},
    ),
    "EEBL right lane": (EEBL, 29.0, ahead(60.0, 29.0, d=-3.5, **HARD), ahead(60.0, 29.0, d=-7.0, **HARD), {}),
    "EEBL heading": (
        EEBL, 29.0, ahead(60.0, 29.0, angle=0.75, **HARD), ahead(60.0, 29.0, angle=0.82, **HARD), {},
    ),
    "EEBL behind": (EEBL, 29.0, ahead(60.0, 29.0, **HARD), {"s": -60.0, "d": 0.0, "v": 29.0, **HARD}, {}),
    "EEBL oncoming": (
        EEBL, 29.0, ahead(60.0, 29.0, d=3.5, **HARD), ahead(60.0, 29.0, d=3.5, angle=math.pi, **HARD), {},
    ),
    "curb-side time": (CURB_SIDE, 25.0, ahead(124.0, 0.0), ahead(126.0, 0.0), {}),
    "curb-side intrudes": (CURB_SIDE, 25.0, ahead(100.0, 0.0, d=-1.05), ahead(100.0, 0.0, d=-3.0), {}),
    "curb-side stationary": (CURB_SIDE, 25.0, ahead(100.0, 0.0), ahead(100.0, 2.0), {}),
    "curb-side passed": (CURB_SIDE, 25.0, ahead(10.0, 0.0), {"s": -10.0, "d": 0.0, "v": 0.0}, {}),
    "BSW side": (BSW, 25.0, alongside(-2.0, 2.9), alongside(-2.0, 3.1), {}),
    "BSW too near": (BSW, 25.0, alongside(-2.0, 0.6), alongside(-2.0, -1.4), {}),
    "BSW rear": (BSW, 25.0, alongside(2.9, 1.7), alongside(3.1, 1.7), {}),
    "BSW front": (BSW, 25.0, alongside(-6.7, 1.7), alongside(-6.9, 1.7), {}),
    "BSW same direction": (BSW, 25.0, alongside(-2.0, 1.7), alongside(-2.0, 1.7, angle=math.pi), {}),
    "LCW": (LCW, 25.0, alongside(2.0, 1.7), alongside(3.1, 1.7), {"intent": "left"}),
    "DNPW time": (
        DNPW, 20.0, ahead(359.0, 20.0, d=3.5, angle=math.pi), ahead(361.0, 20.0, d=3.5, angle=math.pi),
        {"intent": "left"},
    ),
    "DNPW lane": (
        DNPW, 20.0, ahead(200.0, 20.0, d=3.5, angle=math.pi), ahead(200.0, 20.0, d=7.0, angle=math.pi),
        {"intent": "left"},
    ),
    "DNPW direction": (
        DNPW, 20.0, ahead(50.0, 12.0, d=3.5, angle=math.pi), ahead(50.0, 12.0, d=3.5), {"intent": "left"},
    ),
}  # fmt: skip

SIDES = {"left": "right", "right": "left", None: None}


@pytest.mark.parametrize("name", ALONG)
@pytest.mark.parametrize("road", ROADS)
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_alert_along_road_has_its_trigger(name: str, road: str, mirror: float) -> None:
    """Also in curves; distances within 0.3 % there (the body is straight, the road is not)."""
    application, v, trigger, silent, more = ALONG[name]
    path = ROADS[road]
    if mirror < 0.0:
        path = Path(path.breaks, path.coefficients * np.array((1.0, -1.0))[:, None])
        more = {"intent": SIDES[more["intent"]]} if "intent" in more else {}

    def alerts_of(where: dict[str, Any]) -> dict[Application, Level]:
        turned = {**where, "d": mirror * where["d"]}
        if "angle" in where:
            turned["angle"] = mirror * where["angle"]
        return found(path, v, [other(path, **turned)], **more)

    # in a curve its bound, 360 m away, moves by more than the meter on either side of it
    if road == "straight" or name != "DNPW time":
        assert application in alerts_of(trigger)
        assert application not in alerts_of(silent)


def test_lanes_follow_the_curve() -> None:
    """200 m ahead in the curve the ego lane is 33 m beside the straight line."""
    path = ROADS["left curve"]
    hard = other(path, 200.0, 0.0, 29.0, **HARD)
    assert found(path, 29.0, [hard])[EEBL] is not Level.INFORM
    assert EEBL not in found(STRAIGHT, 29.0, [hard])


# crossing traffic: ego at s = 0 with 10 m/s on a straight road, the other one comes from the right; it needs
# t seconds to the middle of the ego's lane 25 m ahead
def crossing_car(t: float, v: float = 10.0, s: float = 25.0, angle: float = math.pi / 2.0) -> RemoteVehicle:
    x, y = s - t * v * math.cos(angle), -t * v * math.sin(angle)
    return RemoteVehicle(id="A", x=x, y=y, psi=angle, v_x=v)


@pytest.mark.parametrize(
    ("remote", "warned"),
    [
        (crossing_car(2.5), True),
        (crossing_car(3.9), True),  # arrives 1.4 s later than the ego
        (crossing_car(4.2), False),  # 1.7 s later
        (crossing_car(1.3), True),
        (crossing_car(0.4), False),  # has left the ego's path before
        (crossing_car(4.0, s=42.0), True),  # the ego is there in 3.9 s
        (crossing_car(4.4, s=45.0), False),  # in 4.2 s
        (crossing_car(2.5, angle=0.6), True),
        (crossing_car(2.5, angle=0.4), False),  # merges
        (crossing_car(2.5, angle=2.4), True),
        (crossing_car(2.5, v=0.3), False),
        (RemoteVehicle(id="A", x=25.0, y=-12.0, psi=-math.pi / 2.0, v_x=10.0), False),  # drives away
        (RemoteVehicle(id="A", x=60.0, y=3.5, psi=math.pi, v_x=10.0), False),  # oncoming
        (RemoteVehicle(id="A", x=30.0, y=3.5, psi=math.pi, v_x=8.0, r=0.8), True),  # turns left across
    ],
)
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_crossing_car_triggers_intersection_alert(remote: RemoteVehicle, warned: bool, mirror: float) -> None:
    remote = replace(remote, y=mirror * remote.y, psi=mirror * remote.psi, r=mirror * remote.r)
    levels = found(STRAIGHT, 10.0, [remote])
    assert (IMA in levels) == warned
    assert LTA not in levels


@pytest.mark.parametrize(
    ("s", "v", "gap", "intent", "warned"),
    [
        (-12.0, 6.0, 3.9, None, True),
        (-12.0, 6.0, 4.3, None, False),
        (-12.0, 6.0, 0.0, None, True),
        (-12.0, 6.0, -2.2, None, False),  # it has passed when the ego comes
        (-30.0, 6.0, 2.0, None, False),  # the ego is still 6 s away
        (-2.0, 0.0, 3.8, "left", True),  # waits at the line
        (-2.0, 0.0, 4.4, "left", False),
        (-2.0, 0.0, 3.8, None, False),
    ],
)
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_oncoming_car_triggers_left_turn_alert(
    s: float, v: float, gap: float, intent: Any, warned: bool, mirror: float
) -> None:
    """The oncoming lane is 7 m to the left; the ego turns across it."""
    path = turning(mirror)
    width, turn_speed = 0.5 * 1.8, max(v, 3.0 if intent else 0.0)
    # the ego enters the lane of the other vehicle with its front left corner, found by brute force
    phi = np.linspace(0.0, math.pi / 2.0, 2001)
    corner = 10.0 * (1.0 - np.cos(phi)) + 2.25 * np.sin(phi) + width * np.cos(phi)
    arc = 10.0 * float(phi[np.argmax(corner > 7.0 - width)])
    arrival = (arc - s) / turn_speed if turn_speed else 0.0
    # the front of the other vehicle enters the ego's path there
    x = 10.0 * math.sin(arc / 10.0) + 2.5 + 16.0 * (arrival + gap) + 2.25
    remote = RemoteVehicle(id="A", x=x, y=mirror * 7.0, psi=math.pi, v_x=16.0)
    intent = SIDES[intent] if mirror < 0.0 else intent
    levels = found(path, v, [remote], s=s, intent=intent)
    assert (LTA in levels) == warned
    assert IMA not in levels


def test_right_turn_gives_no_alert_for_oncoming_car() -> None:
    remote = RemoteVehicle(id="A", x=40.0, y=3.5, psi=math.pi, v_x=14.0)
    assert found(turning(-1.0), 6.0, [remote], s=-10.0) == {}


def test_intent_turns_blind_spot_into_lane_change_alert() -> None:
    remote = other(STRAIGHT, -4.0, 3.5, 25.0)
    assert found(STRAIGHT, 25.0, [remote]) == {BSW: Level.INFORM}
    assert found(STRAIGHT, 25.0, [remote], intent="left") == {LCW: Level.WARN}
    assert found(STRAIGHT, 25.0, [remote], intent="right") == {BSW: Level.INFORM}


def test_do_not_pass_needs_intent_or_wrong_lane() -> None:
    remote = other(STRAIGHT, 200.0, 3.5, 20.0, math.pi)
    assert found(STRAIGHT, 20.0, [remote]) == {}
    assert found(STRAIGHT, 20.0, [remote], intent="right") == {}
    assert found(STRAIGHT, 20.0, [remote], d=3.5) == {DNPW: Level.WARN}
    assert found(STRAIGHT, 20.0, [remote], intent="left") == {DNPW: Level.WARN}


@pytest.mark.parametrize(("d", "occluded"), [(0.0, True), (3.5, False)])
def test_occluded_stationary_vehicle_names_occluding_one(d: float, occluded: bool) -> None:
    """The paper's scenario: a moving vehicle occludes the stationary one."""
    red = other(STRAIGHT, 90.0, -1.05, 0.0, id="red")
    yellow = other(STRAIGHT, 30.0, d, 25.0, id="yellow")
    (alert,) = warn(ego(STRAIGHT, 0.0, 25.0), CAR, STRAIGHT, [red, yellow])
    assert (alert.application, alert.vehicle_id) == (CURB_SIDE, "red")
    assert ("occluded by yellow" in alert.reason) == occluded
    assert alert.time_to_conflict == pytest.approx(85.5 / 25.0)


def test_alerts_are_ordered_by_level_and_time() -> None:
    remotes = [
        other(STRAIGHT, 40.0, 3.5, 25.0, id="adjacent", **HARD),
        other(STRAIGHT, 19.0, 0.0, 10.0, id="close"),
        other(STRAIGHT, 70.0, 0.0, 25.0, id="far", **HARD),
    ]
    alerts = warn(ego(STRAIGHT, 0.0, 25.0), CAR, STRAIGHT, remotes)
    assert [(a.vehicle_id, a.application, a.level) for a in alerts] == [
        ("close", FCW, Level.ACT), ("far", EEBL, Level.WARN), ("adjacent", EEBL, Level.INFORM),
    ]  # fmt: skip
    assert alerts[0].time_to_conflict == pytest.approx(14.5 / 15.0)
    assert "close slower, 14 m ahead: collision in 1.0 s" in alerts[0].reason


def test_level_is_act_if_only_hard_braking_helps() -> None:
    assert found(STRAIGHT, 20.0, [other(STRAIGHT, LENGTH + 41.0, 0.0, 0.0)])[FCW] is Level.ACT
    assert found(STRAIGHT, 10.0, [other(STRAIGHT, LENGTH + 20.0, 0.0, 0.0)])[FCW] is Level.WARN


@given(st.floats(1.0, 80.0), st.floats(0.0, 35.0), st.floats(0.1, 30.0), st.floats(-8.0, 0.0))
def test_time_to_collision_equals_small_steps(gap: float, v: float, v_lead: float, a: float) -> None:
    a = 0.0 if a > -1.0 else a
    settings = AlertSettings(fcw_decelerating=60.0, fcw_slower=60.0, fcw_stopped=60.0, standstill_speed=0.0)
    remote = other(STRAIGHT, gap + LENGTH, 0.0, v_lead, a_x=a)
    alerts = warn(ego(STRAIGHT, 0.0, v), CAR, STRAIGHT, [remote], settings=settings)
    t = np.arange(0.0, 60.0, 0.005)
    until = np.minimum(t, v_lead / -a) if a else t
    gaps = gap + v_lead * until + 0.5 * a * until**2 - v * t
    times = [x.time_to_conflict for x in alerts if x.application is FCW]
    if gaps.min() < -0.01:
        assert times == [pytest.approx(t[np.argmax(gaps <= 0.0)], abs=0.02)]
    elif gaps.min() > 0.01:
        assert times == []


def random_world(seed: int) -> tuple[list[RemoteVehicle], VehicleState, Any]:
    rng = np.random.default_rng(seed)
    remotes = []
    for i in range(12):
        angle = rng.choice([0.0, math.pi, rng.uniform(-3.0, 3.0)])
        s, d = rng.uniform(-40.0, 150.0), rng.choice([-3.5, 0.0, 3.5]) + rng.uniform(-1.0, 1.0)
        v = rng.choice([0.0, rng.uniform(0.5, 30.0)])
        more = {"a_x": rng.uniform(-6.0, 2.0), "events": rng.choice([frozenset(), HARD["events"]])}
        remotes.append(replace(other(LEFT_TURN, s, d, v, angle, id=str(i), **more), r=rng.uniform(-0.3, 0.3)))
    state = ego(LEFT_TURN, rng.uniform(-60.0, 0.0), rng.uniform(0.0, 20.0), rng.uniform(-1.0, 1.0))
    return remotes, state, rng.choice(["left", "right", ""]) or None


@given(st.integers(0, 10_000), st.floats(-3.1, 3.1), st.floats(-900.0, 900.0), st.booleans())
def test_alerts_are_invariant_to_turn_shift_mirror(
    seed: int, angle: float, shift: float, mirrored: bool
) -> None:
    remotes, state, intent = random_world(seed)
    base = warn(state, CAR, LEFT_TURN, remotes, intent=intent)
    mirror = -1.0 if mirrored else 1.0
    c, k = math.cos(angle), math.sin(angle)
    turned = np.array([[c, -k], [k, c]]) @ np.diag([1.0, mirror])

    def moved(v: Any) -> Any:
        x, y = (turned @ (v.x, v.y) + shift).tolist()
        return replace(v, x=x, y=y, psi=mirror * v.psi + angle, r=mirror * v.r)

    coefficients = np.einsum("ij,njk->nik", turned, LEFT_TURN.coefficients)
    coefficients[:, :, 3] += shift
    path = Path(LEFT_TURN.breaks, coefficients)
    side = SIDES[intent] if mirrored else intent
    again = warn(moved(state), CAR, path, [moved(r) for r in remotes], intent=side)
    key = [
        (a.application, a.vehicle_id, a.level)
        for a in sorted(base, key=lambda a: (a.application.name, a.vehicle_id))
    ]
    same = [
        (a.application, a.vehicle_id, a.level)
        for a in sorted(again, key=lambda a: (a.application.name, a.vehicle_id))
    ]
    assert same == key


def test_order_of_remotes_changes_nothing() -> None:
    remotes, state, intent = random_world(3)
    assert warn(state, CAR, LEFT_TURN, remotes, intent=intent) == warn(
        state, CAR, LEFT_TURN, remotes[::-1], intent=intent
    )


@pytest.mark.parametrize(
    "bad",
    [
        {"x": math.nan}, {"v_x": math.inf}, {"length": 0.0}, {"age": 3.5}, {"age": -1.0}, {"x": 1e9},
        {"v_x": 400.0},
    ],
)  # fmt: skip
def test_invalid_vehicles_are_ignored(bad: dict[str, float]) -> None:
    remote = other(STRAIGHT, 20.0, 0.0, 5.0)
    assert FCW in found(STRAIGHT, 20.0, [remote])
    assert found(STRAIGHT, 20.0, [replace(remote, **bad)]) == {}
    assert FCW in found(STRAIGHT, 20.0, [replace(remote, **bad), remote])


def test_smaller_age_of_two_records_counts() -> None:
    old, young = other(STRAIGHT, 20.0, 0.0, 5.0, age=0.5), other(STRAIGHT, 20.5, 0.0, 20.0, age=0.1)
    for remotes in ([old, young], [young, old]):
        assert found(STRAIGHT, 20.0, remotes) == {}


def test_two_vehicles_under_one_id_both_count() -> None:
    near, far = other(STRAIGHT, 20.0, 0.0, 5.0, age=0.5), other(STRAIGHT, 200.0, 0.0, 5.0, age=0.1)
    for remotes in ([near, far], [far, near]):
        assert found(STRAIGHT, 20.0, remotes) == found(STRAIGHT, 20.0, [near]) != {}


def test_no_warning_without_vehicles() -> None:
    road = Road(STRAIGHT, [Lane(d=0.0, width=5.0), Lane(d=5.0, width=5.0)])
    hard = other(STRAIGHT, 60.0, 7.0, 25.0, **HARD)
    assert warn(ego(STRAIGHT, 0.0, 25.0), CAR, STRAIGHT, [hard]) == ()
    assert [a.application for a in warn(ego(STRAIGHT, 0.0, 25.0), CAR, road, [hard], s_guess=1.0)] == [EEBL]
    assert warn(ego(STRAIGHT, 0.0, 25.0), CAR, road, []) == ()


def test_view_positions_along_road() -> None:
    path = ROADS["left curve"]
    view = warning_view(ego(path, 10.0, 20.0, 0.5), CAR, path, [other(path, 110.0, 3.5, 15.0)])
    (other_vehicle,) = view.vehicles
    ego_view, vehicle = view.ego, other_vehicle.vehicle
    assert (ego_view.s, ego_view.d, ego_view.v_x) == pytest.approx((10.0, 0.5, 20.0), abs=1e-6)
    assert (other_vehicle.gap, other_vehicle.lateral_offset) == pytest.approx((95.5, 3.0), abs=1e-6)
    assert vehicle.v_s == pytest.approx(15.0 / (1.0 - 3.5 / 600.0), rel=1e-3)
    assert vehicle.angle == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("changes", "named"),
    [({"road": None}, "road"), ({"intent": "up"}, "intent"), ({"s_guess": math.nan}, "s_guess")],
)
def test_error_names_argument(changes: dict[str, Any], named: str) -> None:
    good = {"state": ego(STRAIGHT, 0.0, 20.0), "vehicle": CAR, "road": STRAIGHT, "remotes": []}
    with pytest.raises(InputError, match=named):
        warn(**{**good, **changes})


@pytest.mark.parametrize("changes", [{"fcw_slower": -1.0}, {"eebl_range": math.nan}, {"braking": 0.0}])
def test_error_names_setting(changes: dict[str, float]) -> None:
    with pytest.raises(InputError, match=next(iter(changes))):
        AlertSettings(**changes)

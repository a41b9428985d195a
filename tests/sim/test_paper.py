"""The paper's first three scenarios: what a driver cannot avoid, and what messages make of it."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from cca_core import Action, Command, Decision, RemoteVehicle, VehicleState
from cca_core.errors import InputError
from cca_core.sim import (
    CURBSIDE_CASES,
    EEBL_CASES,
    LOSSY_CHANNEL,
    Log,
    Scenario,
    curbside,
    eebl,
    ima,
    make_planner,
    overtaking,
    paper_scenarios,
    simulate,
)
from cca_core.sim.study.parameters import ParameterRanges, nominal_scenario, sample_scenario
from cca_core.v2x import ChannelSettings

SEEDS = (1, 2, 3, 4, 5)
IDEAL = ChannelSettings(latency=0.1)
MB = pytest.param("multi_body", marks=pytest.mark.requires("vehiclemodels"))
MB_1 = pytest.param("multi_body", 1, marks=pytest.mark.requires("vehiclemodels"))
MAKERS: dict[str, Callable[..., Scenario]] = {"eebl": eebl, "ima": ima, "curbside": curbside}
WITHOUT = [
    ("eebl", "A", "yellow"), ("ima", "left-turn", "red"), ("ima", "crossing", "red"),
    ("curbside", "fast", "red"), ("curbside", "slow", "red"),
]  # fmt: skip
WITH = [
    ("eebl", "C"), ("ima", "left-turn"), ("ima", "crossing"), ("curbside", "fast"), ("curbside", "slow"),
]  # fmt: skip


@cache
def drive(name: str, case: str, ego: str = "v2v", seed: int = 1, plant: str = "single_track") -> Log:
    maker = MAKERS[name]
    scenario = maker(case) if name == "eebl" else maker(case, ego=ego)
    assert scenario.ego_type == ego
    return simulate(scenario, seed=seed, plant=plant)


class BrakesFully:
    """The planner, but with all that the brakes give from the first sight of somebody braking on."""

    def __init__(self, scenario: Scenario) -> None:
        self.planner, self.a_x, self.begun = make_planner(scenario), 0.0, False

    def step(self, t: float, state: VehicleState, remotes: Iterable[RemoteVehicle], **kwargs: Any) -> Command:
        seen = list(remotes)
        command = self.planner.step(t, state, seen, **kwargs)
        self.begun = self.begun or any(remote.a_x <= -0.25 for remote in seen)
        if not self.begun:
            return command
        self.a_x = max(self.a_x - 12.65 * 0.02, -7.0)
        braking = Decision(action=Action.BRAKE, reason="somebody brakes")
        return replace(command, a_x=self.a_x, decision=braking)


def gap(log: Log, ahead: int, behind: int | None) -> Any:
    """Bumper gap along the road between two road users, None being the ego [m]."""
    rear = log.user_frenet[:, ahead, 0] - 2.25
    return rear - (log.ego_frenet[:, 0] if behind is None else log.user_frenet[:, behind, 0]) - 2.25


def test_lossy_channel_parameters() -> None:
    assert LOSSY_CHANNEL.latency == 0.1
    assert LOSSY_CHANNEL.loss_probability == 0.3
    assert LOSSY_CHANNEL.mean_burst_length > 1.0 / (1.0 - LOSSY_CHANNEL.loss_probability)


@pytest.mark.parametrize("plant", ["single_track", MB])
@pytest.mark.parametrize(("name", "case", "hit"), WITHOUT)
def test_the_driver_collides(name: str, case: str, hit: str, plant: str) -> None:
    log = drive(name, case, "driver", plant=plant)
    summary = log.summary()
    assert summary["collided_with"] == hit
    assert (summary["ego"], summary["v2v"], summary["plant"]) == ("driver", False, plant)
    assert not log.tracked.any()
    assert log.received == ()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("name", "case"), WITH)
def test_no_collision_with_v2v(name: str, case: str, seed: int) -> None:
    log = drive(name, case, seed=seed)
    assert log.gaps().min() >= 1.0
    assert log.t[-1] == pytest.approx(log.scenario.duration)
    assert not any("internal error" in reason for _, _, reason in log.decisions)
    assert log.scenario.channel is LOSSY_CHANNEL
    lost = 1.0 - log.messages["delivered"] / log.messages["sent"]
    assert 0.1 < lost < 0.5
    assert log.messages["ego_sent"] == pytest.approx(10.0 * log.scenario.duration, abs=1.0)


@pytest.mark.requires("vehiclemodels")
@pytest.mark.parametrize(("name", "case"), WITH)
def test_no_collision_with_v2v_multi_body(name: str, case: str) -> None:
    log = drive(name, case, plant="multi_body")
    assert log.gaps().min() >= 1.0
    assert log.t[-1] == pytest.approx(log.scenario.duration)
    if name == "ima":  # it moves off again
        assert log.ego[-1, 3] > 5.0


class TestEebl:
    @pytest.mark.parametrize(("plant", "seed"), [*(("single_track", seed) for seed in SEEDS), MB_1])
    def test_stops_gently_enough_with_room(self, plant: str, seed: int) -> None:
        log = drive("eebl", "C", seed=seed, plant=plant)
        assert -log.ego[:, 7].min() <= 6.0
        assert log.ego[-1, 3] < 0.1
        assert gap(log, 0, None)[-1] >= 2.0

    @pytest.mark.parametrize("case", EEBL_CASES)
    def test_second_car_never_hits_the_first(self, case: str) -> None:
        log = simulate(eebl(case))
        assert gap(log, 1, 0).min() > 2.0

    @pytest.mark.parametrize("seed", SEEDS)
    def test_displacement_bands_do_not_meet(self, seed: int) -> None:
        """Fig. 7: rear to front of each car over time."""
        log = drive("eebl", "C", seed=seed)
        assert gap(log, 0, None).min() > 2.0
        assert gap(log, 1, 0).min() > 2.0
        assert (log.road_users[-1, :, 3] == 0.0).all()

    @pytest.mark.parametrize("case", EEBL_CASES)
    def test_gap_is_the_same_in_all_runs_until_the_event_is_known(self, case: str) -> None:
        log = simulate(eebl(case))
        known = int(np.argmin(log.gap_held))
        assert log.t[known] > 2.0
        before = log.t < 2.0
        assert gap(log, 0, None)[before] / log.ego[before, 3] == pytest.approx(0.5, abs=0.005)
        assert log.gap_held[:known].all()
        assert not log.gap_held[known:].any()

    def test_order_of_events(self) -> None:
        log = drive("eebl", "C")
        assert log.time_of("gap_released") < log.time_of("brakes", "red") + 0.5
        assert log.time_of("brakes") < log.time_of("brakes", "yellow") + 0.5
        hears = drive("eebl", "A", "driver")
        red, yellow = (hears.time_of("brakes", name) for name in ("red", "yellow"))
        assert yellow - red == pytest.approx(1.25, abs=0.1)
        assert hears.time_of("brakes") - yellow == pytest.approx(1.25, abs=0.1)

    def test_closing_speed_without_messages(self) -> None:
        """7 m/s^2 for the reaction time and the lag of the brakes: 7.0 x (1.25 + 0.1)."""
        log = drive("eebl", "A", "driver")
        assert log.closing_speed() == pytest.approx(7.0 * 1.35, abs=0.4)

    def test_only_the_second_car_connected_does_not_help(self) -> None:
        log = simulate(eebl("D"))
        assert log.summary()["collided_with"] == "yellow"
        assert log.time_of("brakes", "yellow") < 3.0

    def test_only_the_ego_connected_helps(self) -> None:
        log = simulate(eebl("B"))
        assert gap(log, 0, None).min() >= 2.0
        assert -log.ego[:, 7].min() <= 5.0
        assert not log.tracked[:, 0].any()
        assert log.tracked[:, 1].any()
        assert log.time_of("brakes") < log.time_of("brakes", "yellow")

    @pytest.mark.parametrize(
        ("delay", "planner", "full"),
        [(0.0, 1.9, 9.4), (0.1, -1.7, 6.4), (0.2, -4.1, 3.5), (0.3, -4.7, 0.6), (0.4, -5.4, -4.1)],
    )
    def test_what_a_sensor_can_do(self, delay: float, planner: float, full: float) -> None:
        """The table of the page on simulation: gap at rest [m], or minus the speed of contact [m/s]."""
        scenario = replace(eebl("sensor"), sensor_delay=delay)
        for pilot, told in ((None, planner), (BrakesFully(scenario), full)):
            log = simulate(scenario, planner=pilot)
            found = -log.closing_speed() if log.summary()["collided"] else float(log.gaps().min())
            assert found == pytest.approx(told, abs=0.06)

    @pytest.mark.parametrize("seed", [1, 2])
    @pytest.mark.parametrize(("v_x", "headway"), [(20.0, 0.5), (33.0, 0.5), (29.06, 0.7)])
    def test_other_speeds_and_gaps(self, v_x: float, headway: float, seed: int) -> None:
        assert simulate(eebl("C", v_x=v_x, time_gap=headway), seed=seed).gaps().min() > 1.0
        assert simulate(eebl("A", v_x=v_x, time_gap=headway)).summary()["collided"]


class TestIma:
    @pytest.mark.parametrize("seed", SEEDS)
    def test_turns_only_after_the_other_has_passed(self, seed: int) -> None:
        log = drive("ima", "left-turn", seed=seed)
        passed = log.road_users[:, 0, 0] + 2.25 < 0.0  # its rear has left the ego's way
        in_its_lane = log.bodies()[0].corners()[:, 0, :, 1].max(axis=1) > 3.5
        assert not (in_its_lane & ~passed).any()
        assert log.ego[:, 3].min() < 1.0  # it really waits
        assert in_its_lane.any()
        assert log.ego_frenet[-1, 0] > 90.0
        assert np.abs(log.a_y).max() <= 3.1

    @pytest.mark.parametrize("seed", SEEDS)
    def test_waits_at_the_line(self, seed: int) -> None:
        log = drive("ima", "left-turn", seed=seed)
        line = log.scenario.stop_line
        assert line is not None
        passed = log.road_users[:, 0, 0] + 2.25 < 0.0
        assert (log.ego_frenet[~passed, 0] + 2.25).max() <= line + 0.2

    def test_is_hidden_from_the_driver_until_late(self) -> None:
        """He sees it 1.08 s before both would be at the conflict point, less than his reaction time."""
        log = drive("ima", "left-turn", "driver")
        sees = int(np.searchsorted(log.t, log.time_of("first_visible", "red") - 1e-9))
        assert (log.road_users[sees, 0, 0] - 1.29) / log.road_users[sees, 0, 3] == pytest.approx(
            1.08, abs=0.15
        )
        log = drive("ima", "crossing", "driver")
        assert log.t[-1] - log.time_of("first_visible", "red") < 1.25

    def test_a_van_does_not_hide_it(self) -> None:
        log = simulate(ima(ego_type="driver", truck=(5.3, 2.0)))
        assert not log.summary()["collided"]

    @pytest.mark.parametrize("offset", [-0.6, -0.3, 0.3, 0.6])
    def test_contrast_does_not_hang_on_the_exact_time(self, offset: float) -> None:
        assert simulate(ima(ego_type="driver", offset=offset)).summary()["collided_with"] == "red"
        assert simulate(ima(offset=offset)).gaps().min() > 1.0


@pytest.mark.parametrize("index", [328, 553])
def test_lead_braking_harder_than_downstream_vehicle(index: int) -> None:
    """Draws in which red brakes with 4 to 5 m/s^2, and yellow, late, with 7."""
    scenario, _ = sample_scenario(ParameterRanges(scenario="eebl"), 2, index)
    assert simulate(scenario).gaps().min() > 0.0


@pytest.mark.parametrize("index", [347, 1594])
def test_full_braking_for_late_crossing_vehicle(index: int) -> None:
    """Draws in which the first message leaves just the room for full braking."""
    scenario, _ = sample_scenario(ParameterRanges(scenario="ima"), 2, index)
    log = simulate(scenario)
    assert log.gaps().min() > 0.0
    assert "BRAKE" in log.actions


@pytest.mark.parametrize(
    ("name", "seed", "index"),
    [
        ("curbside", 3, 268),  # heard 26 m ahead: only a swerve at the limit helps
        ("curbside", 21, 602),  # heard 40 m ahead, told to be known to 0.9 m: no room beside its bounds
        ("curbside", 3, 646), ("curbside", 5, 1392),  # noise says that red is not in the way
        ("maneuver", 4, 3), ("maneuver", 4, 46), ("maneuver", 4, 58),  # a silent leader in sight, R1 behind
        ("maneuver", 6, 283),  # the way back is bent for the speed after falling back
        ("maneuver", 7, 56), ("maneuver", 7, 221),  # given up on the way back already, with others beside
        ("ima", 27, 1228),  # the bounds of red reached the ego, which went on into its way instead of braking
        # heard late, it braked and stood in the way of red, where going on was just enough
        ("ima", 27, 0), ("ima", 27, 1299), ("ima", 27, 1635),
        ("eebl", 9, 445),  # full braking just helps, on 0.6 of friction
        ("maneuver", 8, 64),  # the band jumped where a car beside left the sensor's sight
        ("maneuver", 9, 511),  # brakes let go slowly while swerving out in front of R2
        # falling back from beside a slower one that by then was behind; braking in front of A, stale behind
        ("maneuver", 21, 106), ("maneuver", 21, 125), ("maneuver", 21, 1221),
        # R2 unheard for seconds, 100 m ahead: braked for fully because of its bounds, in front of R1
        ("maneuver", 22, 858), ("maneuver", 22, 1650),
        ("maneuver", 24, 1002),  # still going out, so that the way back was too sharp for the tires
        ("maneuver", 25, 364),  # as fast as R1 close behind it, which a way back in front of it cannot be
        ("maneuver", 24, 370),  # crept back as slowly as the way back had been bent for, R1 behind
        ("maneuver", 8, 423),  # A unheard for seconds, dead-reckoned into the lane; R1 behind
    ],
)  # fmt: skip
def test_collision_regressions(name: str, seed: int, index: int) -> None:
    scenario, _ = sample_scenario(ParameterRanges(scenario=name), seed, index)
    log = simulate(scenario, planner=make_planner(nominal_scenario(scenario)))
    assert log.gaps().min() > 0.0
    assert np.abs(log.ego_frenet[:, 1]).max() < 5.25


class TestCurbside:
    @pytest.mark.parametrize("seed", SEEDS)
    def test_fast_evades(self, seed: int) -> None:
        log = drive("curbside", "fast", seed=seed)
        assert "EVADE_LEFT" in log.actions
        assert log.actions[-1] == "KEEP"
        assert log.ego[:, 3].min() > 20.0
        assert np.abs(log.a_y).max() <= 2.5
        assert abs(log.ego_frenet[-1, 1]) < 0.1

    @pytest.mark.parametrize("seed", SEEDS)
    def test_slow_brakes(self, seed: int) -> None:
        log = drive("curbside", "slow", seed=seed)
        assert not any(action.startswith("EVADE") for action in log.actions)
        assert log.actions[-1] == "BRAKE"
        assert -log.ego[:, 7].min() <= 4.5  # yellow may be silent for a second
        assert log.ego[-1, 3] < 0.3
        assert 2.0 < log.gaps()[-1, 1] < 5.0

    def test_slow_brakes_gently_when_it_hears_everything(self) -> None:
        log = simulate(curbside("slow", channel=IDEAL))
        assert -log.ego[:, 7].min() <= 2.5

    @pytest.mark.parametrize(("case", "left"), [("fast", 1.62), ("slow", 1.77)])
    def test_driver_sees_it_late(self, case: str, left: float) -> None:
        log = drive("curbside", case, "driver")
        v = log.scenario.v_x
        sees = int(np.searchsorted(log.t, log.time_of("first_visible", "red")))
        assert gap(log, 1, None)[sees] / v == pytest.approx(left, abs=0.2)

    def test_yellow_passes_it(self) -> None:
        for case in CURBSIDE_CASES:
            log = drive("curbside", case)
            apart = np.hypot(*(log.road_users[:, 0, :2] - log.road_users[:, 1, :2]).T)
            abeam = np.abs(log.user_frenet[:, 0, 0] - log.user_frenet[:, 1, 0]) < 4.5
            assert (log.user_frenet[abeam, 0, 1] - log.user_frenet[abeam, 1, 1]).min() > 1.8
            assert apart.min() > 1.8

    def test_parked_car_says_so(self) -> None:
        log = drive("curbside", "fast")
        assert log.time_of("first_received", "red") < 2.0
        assert log.time_of("lateral_shift") < log.time_of("first_visible", "red")


class TestSensor:
    """An automated ego without messages is better than the driver, and still late."""

    def test_at_the_curb(self) -> None:
        fast, slow = (drive("curbside", case, "sensor") for case in CURBSIDE_CASES)
        assert fast.closing_speed() < drive("curbside", "fast", "driver").closing_speed() - 4.0
        assert slow.closing_speed() < drive("curbside", "slow", "driver").closing_speed() - 4.0
        assert fast.summary()["ego"] == "sensor"
        assert fast.summary()["v2v"] is False

    def test_behind_yellow(self) -> None:
        sensor, driver = simulate(eebl("sensor")), drive("eebl", "A", "driver")
        assert sensor.time_of("brakes") < driver.time_of("brakes") - 0.5


def test_low_visibility_limits_sensor_range() -> None:
    clear, fog = simulate(ima(ego_type="driver")), simulate(ima(ego_type="driver", visibility=8.0))
    assert clear.visible[:, 1].sum() > fog.visible[:, 1].sum()


def test_all_runs_of_the_demo() -> None:
    scenarios = paper_scenarios()
    names = [(s.name, s.case, s.ego_type) for s in scenarios]
    assert len(set(names)) == len(names) == 19
    assert {name for name, _, _ in names} == {"eebl", "ima", "curbside", "maneuver"}
    assert all(s.paper_figures for s in scenarios)
    again = simulate(scenarios[0])
    assert again.seed == scenarios[0].seed


@pytest.mark.parametrize("make", [eebl, ima, curbside])
def test_unknown_case(make: Callable[..., Scenario]) -> None:
    with pytest.raises(InputError, match="case"):
        make("no such case")


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: eebl(v_x=-1.0), "v_x"), (lambda: eebl(time_gap=0.0), "time_gap"),
        (lambda: ima(ego_type="cat"), "ego_type"), (lambda: ima(v_red=0.0), "v_red"),
        (lambda: ima(offset=9.0), "offset"),
        (lambda: curbside(lane_intrusion=5.0), "lane_intrusion"), (lambda: curbside(radius=10.0), "radius"),
        (lambda: overtaking("5", None), "case"),
    ],
)  # fmt: skip
def test_bad_arguments(make: Callable[[], Scenario], named: str) -> None:
    with pytest.raises(InputError, match=rf"\b{named}\b"):
        make()

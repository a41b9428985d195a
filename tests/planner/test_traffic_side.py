"""Sides on which vehicles are passed: left-hand traffic is right-hand traffic in the mirror."""

import re
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Lane
from cca_core.planner import EvasionSettings
from tests.support.planner_drives import ClosedLoop, LaneLeavingVehicle, ScriptedVehicle, make_planner

THREE_LANES = (Lane(d=-3.5), Lane(d=0.0), Lane(d=3.5))
ALL = float("inf")


def drive(
    sign: float, lanes: tuple[Lane, ...] = THREE_LANES, seconds: float = 14.0, **more: Any
) -> ClosedLoop:
    """Drive past a slow car among others; `sign` -1 is the mirrored world, in left-hand traffic."""
    side = "right" if sign > 0.0 else "left"
    settings = EvasionSettings(awareness_range=ALL, traffic_side=side)
    mirrored = tuple(Lane(d=sign * lane.d, direction=lane.direction) for lane in THREE_LANES)
    traffic = [
        ScriptedVehicle("R", 60.0, sign * 0.2, 10.0),
        ScriptedVehicle("L", -45.0, sign * 3.5, 21.0),
        ScriptedVehicle("O", 30.0, sign * -3.5, 18.0, a=lambda t: -2.0 if 3.0 < t < 5.0 else 0.0),
    ]
    return ClosedLoop(make_planner(mirrored, evasion=settings), traffic, seconds)


def assert_mirrored(run: ClosedLoop, other: ClosedLoop) -> None:
    assert np.array(other.y) == pytest.approx(-np.array(run.y), abs=1e-6)
    assert np.array(other.v) == pytest.approx(np.array(run.v), abs=1e-6)
    swap = {"EVADE_LEFT": "EVADE_RIGHT", "EVADE_RIGHT": "EVADE_LEFT"}
    assert [swap.get(name, name) for name in other.actions] == run.actions


def test_left_hand_traffic_is_mirrored() -> None:
    run = drive(1.0)
    assert "EVADE_LEFT" in run.actions
    assert_mirrored(run, drive(-1.0))


def test_reasons_of_left_hand_traffic_are_mirrored() -> None:
    run, other = drive(1.0, seconds=6.0), drive(-1.0, seconds=6.0)
    swap = {"left": "right", "right": "left"}
    for a, b in zip(run.commands, other.commands, strict=True):
        mirrored = re.sub(r"\b(left|right)\b", lambda found: swap[found[0]], b.decision.reason)
        assert mirrored == a.decision.reason


def test_car_that_leaves_its_lane_is_passed_mirrored() -> None:
    runs = []
    for sign, side in ((1.0, "right"), (-1.0, "left")):
        settings = EvasionSettings(awareness_range=ALL, traffic_side=side)
        lanes = tuple(Lane(d=sign * d) for d in (-3.5, 0.0, 3.5))
        car = LaneLeavingVehicle(70.0, 8.0, station=120.0, range=60.0, offset=sign * 1.2)
        runs.append(ClosedLoop(make_planner(lanes, evasion=settings), [car], 12.0))
    assert_mirrored(*runs)


class TestInnerPassing:
    LANES = (Lane(d=-3.5), Lane(d=0.0))  # only a lane on the right

    @pytest.mark.parametrize(("sign", "name"), [(1.0, "EVADE_RIGHT"), (-1.0, "EVADE_LEFT")])
    def test_inner_side_is_used_if_it_is_the_only_one(self, sign: float, name: str) -> None:
        lanes = tuple(Lane(d=sign * lane.d) for lane in self.LANES)
        side = "right" if sign > 0.0 else "left"
        settings = EvasionSettings(awareness_range=ALL, traffic_side=side)
        run = ClosedLoop(make_planner(lanes, evasion=settings), [ScriptedVehicle("R", 60.0, 0.0, 10.0)], 12.0)
        assert name in run.actions

    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_ego_follows_where_inner_passing_is_not_allowed(self, sign: float) -> None:
        lanes = tuple(Lane(d=sign * lane.d) for lane in self.LANES)
        side = "right" if sign > 0.0 else "left"
        settings = EvasionSettings(awareness_range=ALL, traffic_side=side, inner_passing=False)
        run = ClosedLoop(make_planner(lanes, evasion=settings), [ScriptedVehicle("R", 60.0, 0.0, 10.0)], 20.0)
        assert run.actions == ["FOLLOW"]
        assert f"not passing on the {side}: not allowed" in run.commands[-1].decision.reason

    def test_ego_passes_within_its_lane_on_the_inner_side(self) -> None:
        """A bicycle at the left edge leaves room inside the lane."""
        settings = EvasionSettings(awareness_range=ALL, inner_passing=False)
        lanes = (Lane(d=-3.5), Lane(d=0.0, width=5.5))
        bicycle = ScriptedVehicle("R", 60.0, 2.5, 5.0, width=0.6, length=1.8)
        run = ClosedLoop(make_planner(lanes, evasion=settings), [bicycle], 14.0)
        assert run.x[-1] > bicycle.x + 10.0
        assert min(run.y) - 0.9 > -2.75


@pytest.mark.parametrize("value", ["middle", 1, None])
def test_traffic_side_that_is_none_raises(value: Any) -> None:
    with pytest.raises(InputError, match="traffic_side must be"):
        EvasionSettings(traffic_side=value)


@pytest.mark.parametrize("value", ["no", 1, None])
def test_inner_passing_that_is_no_flag_raises(value: Any) -> None:
    with pytest.raises(InputError, match="inner_passing must be True or False"):
        EvasionSettings(inner_passing=value)

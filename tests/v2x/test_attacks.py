"""Closed loop with a misbehaving sender: the ego drives on messages, some of which are false.

In these runs no attacker makes the ego collide, leave the road, or leave its lane next to a vehicle. A ghost
can still cause following, braking to a stop, and a maneuver into a lane that is clear. It can also make the
ego wait behind a slow vehicle, as long as it reports to be alongside or its stale track may be. Not covered:
a vehicle ahead whose first message comes after a Sybil flood has filled the tracker. It is unknown, as
without a radio.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from cca_core import VehicleState
from tests.support.attack_runs import (
    ALONGSIDE,
    BRAKING,
    DURATION,
    FAST,
    FROM,
    LANE,
    SLOW,
    SPEED,
    STATIONARY,
    WORLDS,
    Attack,
    Real,
    check,
    drive,
    flood_around,
    flood_close,
    flood_off_road,
    freeze,
    ghost_ahead,
    ghost_alongside,
    ghost_at_ego,
    replay,
    replay_minute,
    teleporting,
    without_attack,
)
from tests.support.sweeps import sweep


@pytest.mark.parametrize("reals", [(), (ALONGSIDE,), (FAST,)])
@pytest.mark.parametrize(("distance", "v"), sweep((60.0, 0.0), (40.0, 10.0), (25.0, 0.0)))
def test_ghost_ahead(distance: float, v: float, reals: tuple[Real, ...]) -> None:
    """The ego brakes, and changes lane only if the lane is clear: when the real car is far ahead."""
    run = drive(reals, ghost_ahead(distance, v))
    check(run, reals)
    assert reals == () or (run.gaps[run.leaves_lane] > 15.0).all()
    assert len(run.actions) > 1


@pytest.mark.parametrize("reals", WORLDS)
def test_ghost_in_adjacent_lane(reals: tuple[Real, ...]) -> None:
    """The ego waits behind a slow vehicle that it could pass."""
    run = drive(reals, ghost_alongside)
    check(run, reals)
    assert not run.leaves_lane.any()
    assert "FOLLOW" in run.actions


@pytest.mark.parametrize("reals", WORLDS)
def test_ghost_at_ego_position(reals: tuple[Real, ...]) -> None:
    """A body that moves with the ego at its position is the ego: from the fifth message on it is ignored."""
    run = drive(reals, ghost_at_ego)
    check(run, reals)
    assert len(run.tracker) == len(reals) + 1
    assert run.max_remotes == len(reals) + 1  # before that
    last = VehicleState(x=run.ego[-1, 0], y=run.ego[-1, 1], psi=run.ego[-1, 2], v_x=run.ego[-1, 3])
    assert {v.id for v in run.tracker.vehicles(DURATION, last)} == {f"{i:08x}" for i in range(len(reals))}


@pytest.mark.parametrize("reals", WORLDS)
def test_teleporting_sender(reals: tuple[Real, ...]) -> None:
    """The first position is accepted, most others are rejected; the ego waits."""
    run = drive(reals, teleporting)
    check(run, reals)
    assert run.tracker.counts["teleport"] > 30
    assert "EVADE_LEFT" in without_attack((SLOW,)).actions


@pytest.mark.parametrize("position_only", [False, True], ids=["frames", "positions"])
@pytest.mark.parametrize(
    ("reals", "which"),
    [
        ((SLOW, FAST), 1),
        ((SLOW, ALONGSIDE), 0),
        ((SLOW, ALONGSIDE), 1),
        ((BRAKING, ALONGSIDE), 0),
    ],
)
def test_frozen_sender(reals: tuple[Real, ...], which: int, position_only: bool) -> None:
    """The track coasts, its bounds grow, and the ego waits."""
    run = drive(reals, sent=freeze(which, position_only))
    check(run, reals)
    assert not run.leaves_lane.any()
    names = ("frozen",) if position_only else ("duplicate", "out_of_order", "replay")
    assert sum(run.tracker.counts[name] for name in names) > 30


@pytest.mark.parametrize("until", sweep(math.inf, 2.0, 3.0, 6.0))
@pytest.mark.parametrize("brakes_at", [1.0, 1.3, 2.5])
def test_frozen_lead_brakes_to_standstill(brakes_at: float, until: float) -> None:
    """Only the position is frozen: the reported speed shows that it brakes and where it stops."""
    reals = (replace(BRAKING, brakes_at=brakes_at),)
    run = drive(reals, sent=freeze(0, position_only=True, until=until), duration=12.0, lanes=1)
    check(run, reals)
    assert not run.leaves_lane.any()
    assert until < 10.0 or run.ego[-50:, 3].max() < 0.5
    assert (run.tracker.vehicles(12.0)[0].age < 0.3) == (until < 10.0)


@pytest.mark.parametrize("reals", WORLDS)
@pytest.mark.parametrize("delay", sweep(0.5, 0.1, 2.0))
def test_replay(delay: float, reals: tuple[Real, ...]) -> None:
    """Old frames of tracked senders change nothing."""
    run, clean = drive(reals, replay(delay)), without_attack(reals)
    check(run, reals)
    assert run.tracker.counts["out_of_order"] > 30
    np.testing.assert_array_equal(run.ego, clean.ego)


def test_replay_of_the_minute_before() -> None:
    """Under a tracked id it is a second body, under another id a ghost."""
    reals = (SLOW, ALONGSIDE)
    for number, kind, n in ((1, "separated", 1), (0xBAD, "updated", 30)):
        run = drive(reals, replay_minute(number, ALONGSIDE), t0=60.0)
        check(run, reals)
        assert not run.leaves_lane.any()
        assert run.tracker.counts[kind] >= n
    past = Real(60.0 * SPEED, LANE, SPEED)  # a minute ago it was at the ego's position
    reals = (replace(SLOW, s=85.0),)  # the maneuver is not due when the ghost appears
    run = drive(reals, replay_minute(0xBAD, past), t0=60.0)
    check(run, reals)
    assert "EVADE_LEFT" in without_attack(reals).actions
    assert "EVADE_LEFT" not in run.actions


@pytest.mark.parametrize("attack", [pytest.param(flood_around, marks=pytest.mark.slow), flood_off_road])
def test_sybil_flood(attack: Attack) -> None:
    """The ego stops or waits."""
    reals = (SLOW, ALONGSIDE)
    run = drive(reals, attack)
    check(run, reals)
    assert not run.leaves_lane.any()
    assert len(run.tracker) <= 200
    assert run.tracker.counts["full"] > 1000
    assert run.tracker.is_saturated(FROM + 5.6)


@pytest.mark.parametrize(
    "reals",
    [
        (STATIONARY,),
        pytest.param((STATIONARY, ALONGSIDE), marks=pytest.mark.slow),
        pytest.param((SLOW, ALONGSIDE), marks=pytest.mark.slow),
        pytest.param((replace(BRAKING, brakes_at=2.5), ALONGSIDE), marks=pytest.mark.slow),
    ],
)
def test_sybil_flood_keeps_confirmed_vehicles(reals: tuple[Real, ...]) -> None:
    """Ghosts closer than any vehicle, small and dense: confirmed tracks stay."""
    run = drive(reals, flood_close)
    check(run, reals)
    assert run.tracker.counts["full"] > 1000
    ids = {vehicle.id for vehicle in run.tracker.vehicles(DURATION)}
    assert ids.issuperset(f"{i:08x}" for i in range(len(reals)))


def test_sybil_flood_blocks_lane_for_new_vehicles() -> None:
    """A new sender is rejected after the flood: the adjacent lane counts as blocked."""
    reals = (replace(SLOW, s=100.0), FAST)
    assert "EVADE_LEFT" in without_attack(reals[:1]).actions
    run = drive(reals, flood_close, lambda t, i, data, before: data if i == 0 or t > 1.5 else None)
    check(run, reals)
    assert not run.leaves_lane.any()
    assert "00000001" not in {vehicle.id for vehicle in run.tracker.vehicles(DURATION)}

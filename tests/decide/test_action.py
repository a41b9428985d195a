"""Choice of action: every branch, hysteresis, reasons."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cca_core.decide import Action, Candidate, LeadVehicle, Rejection, RejectionKind, choose_action

K, F, L, R, B = Action.KEEP, Action.FOLLOW, Action.EVADE_LEFT, Action.EVADE_RIGHT, Action.BRAKE


def make_lead(need: float = 0.5, follow: float = -1.0, gap: float = 30.0) -> LeadVehicle:
    return LeadVehicle(id="R1", gap=gap, v_x=12.0, required_deceleration=need, follow_acceleration=follow)


def candidate(side: str = "left", **kwargs: Any) -> Candidate:
    return Candidate(
        side=side, **({"available_distance": 20.0, "required_distance": 50.0, "t_maneuver": 6.0} | kwargs)
    )


NO_LANE = Rejection(kind=RejectionKind.NO_LANE, side="right")
OCCUPIED = Rejection(kind=RejectionKind.LANE_BLOCKED, side="left", vehicle_id="A", distance=-12.0, value=25.0)
BLOCKED = Candidate(side="left", rejection=OCCUPIED, danger_zone=(-50.0, 10.0))
DUE, EARLY = candidate(), candidate(available_distance=80.0)
CALM, SLOWING, HARD = make_lead(0.1, -0.1), make_lead(1.0, -1.0), make_lead(5.0, -5.0)

TABLE = [
    # lead, candidates, previous -> action
    (None, [], K, K),
    (None, [], F, K),
    (None, [DUE], B, K),
    (None, [BLOCKED], L, K),
    (CALM, [], K, K),
    (SLOWING, [], K, F),
    (HARD, [], K, B),
    (CALM, [BLOCKED], K, K),
    (SLOWING, [BLOCKED], K, F),
    (HARD, [BLOCKED], K, B),
    (CALM, [BLOCKED], F, F),  # a waiting ego waits on, although following needs no braking now
    (CALM, [BLOCKED], B, F),
    (SLOWING, [BLOCKED], B, F),
    (HARD, [BLOCKED], F, B),
    (HARD, [BLOCKED], B, B),
    (CALM, [BLOCKED], L, K),
    (SLOWING, [BLOCKED], R, F),
    (SLOWING, [DUE], K, L),
    (CALM, [DUE], K, L),
    (SLOWING, [EARLY], K, K),  # the maneuver is not due
    (SLOWING, [EARLY], L, K),
    (HARD, [EARLY], K, L),  # better than braking hard
    (CALM, [EARLY], F, L),  # the ego has waited long enough
    (CALM, [EARLY], B, L),
    (HARD, [DUE], B, L),
    (SLOWING, [candidate("right")], K, R),
    (SLOWING, [BLOCKED, candidate("right")], K, R),
    (SLOWING, [BLOCKED, candidate("right", available_distance=80.0)], K, K),
]


@pytest.mark.parametrize(("ahead", "candidates", "previous", "expected"), TABLE)
def test_action_matches_table(
    ahead: LeadVehicle | None, candidates: list[Candidate], previous: Action, expected: Action
) -> None:
    decision = choose_action(ahead, candidates, previous=previous)
    assert decision.action is expected
    assert decision.reason.strip()
    assert decision.lead_id == (None if ahead is None else "R1")


@pytest.mark.parametrize(
    ("left", "right", "expected"), [(1.0, 2.0, L), (2.0, 1.0, R), (3.0, 3.0 - 1e-9, R), (-1.0, 0.0, L)]
)
@pytest.mark.parametrize("swapped", [False, True])
def test_cheaper_side_is_chosen(left: float, right: float, expected: Action, swapped: bool) -> None:
    both = [candidate("left", cost=left), candidate("right", cost=right)]
    assert choose_action(SLOWING, both[::-1] if swapped else both).action is expected


def test_rejected_side_is_not_chosen_at_any_cost() -> None:
    blocked = Candidate(side="left", rejection=OCCUPIED, cost=-100.0)
    assert choose_action(SLOWING, [blocked, candidate("right", cost=9.0)]).action is R


def test_reason_names_lead_and_every_rejection() -> None:
    two = [BLOCKED, Candidate(side="right", rejection=Rejection(kind=RejectionKind.INNER_SIDE, side="right"))]
    for ahead in (CALM, SLOWING, HARD):
        reason = choose_action(ahead, two).reason
        assert "R1" in reason
        assert reason.endswith(
            "; not passing on the left: A 12 m behind at 25.0 m/s; on the right: not allowed"
        )


def test_reason_without_candidates_mentions_missing_maneuver() -> None:
    assert "no maneuver was planned" in choose_action(SLOWING, []).reason


def test_danger_zone_is_that_of_chosen_side() -> None:
    a, b = (
        candidate("left", cost=2.0, danger_zone=(1.0, 2.0)),
        candidate("right", cost=1.0, danger_zone=(3.0, 4.0)),
    )
    assert choose_action(SLOWING, [a, b]).danger_zone == (3.0, 4.0)
    assert choose_action(SLOWING, [BLOCKED]).danger_zone == BLOCKED.danger_zone


def test_thresholds_are_strict_and_adjustable() -> None:
    assert choose_action(make_lead(4.0, -0.5), []).action is K
    assert choose_action(make_lead(4.0, -0.501), []).action is F
    assert choose_action(make_lead(4.001, 0.0), []).action is B
    assert choose_action(make_lead(4.001, -1.0), [], brake_threshold=5.0).action is F
    assert choose_action(make_lead(1.0, -1.0), [], follow_threshold=-1.5).action is K


def test_maneuver_is_due_at_equal_distances() -> None:
    assert choose_action(CALM, [candidate(available_distance=50.0, required_distance=50.0)]).action is L
    assert (
        choose_action(CALM, [candidate(available_distance=50.0 + 1e-9, required_distance=50.0)]).action is K
    )


def test_infinite_required_deceleration_brakes() -> None:
    assert choose_action(make_lead(math.inf, -7.0), []).action is B


def test_following_does_not_chatter_around_threshold() -> None:
    previous, seen = K, []
    for follow in (-0.4, -0.6, -0.4, -0.6, 0.3, -0.6):
        previous = choose_action(make_lead(0.2, follow), [BLOCKED], previous=previous).action
        seen.append(previous)
    assert seen == [K, F, F, F, F, F]


@given(
    st.one_of(
        st.none(),
        st.builds(make_lead, st.floats(0.0, 20.0), st.floats(-7.0, 3.0), st.floats(-5.0, 200.0)),
    ),
    st.lists(
        st.builds(
            Candidate, side=st.sampled_from(["left", "right"]), rejection=st.sampled_from([None, NO_LANE]),
            available_distance=st.floats(0.0, 200.0), required_distance=st.floats(0.0, 100.0),
            cost=st.floats(0.0, 5.0),
        ),
        max_size=3,
    ),
    st.sampled_from(list(Action)),
)  # fmt: skip
def test_random_cases_evade_only_to_feasible_side(
    ahead: LeadVehicle | None, candidates: list[Candidate], previous: Action
) -> None:
    decision = choose_action(ahead, candidates, previous=previous)
    usable = {c.side for c in candidates if c.rejection is None}
    assert decision.reason
    if decision.action is L:
        assert "left" in usable
    if decision.action is R:
        assert "right" in usable
    if ahead is None:
        assert decision.action is K
    elif ahead.required_deceleration > 4.0:
        assert decision.action is not K
        assert decision.action is not F
        assert decision.action.is_evading == bool(usable)

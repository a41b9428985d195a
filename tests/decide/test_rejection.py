"""Rejection: the text of every kind."""

import pytest

from cca_core.decide import Rejection, RejectionKind
from cca_core.decide.rejection import not_passing


@pytest.mark.parametrize("kind", RejectionKind)
def test_text_states_cause_without_gaps(kind: RejectionKind) -> None:
    full = Rejection(kind=kind, side="left", vehicle_id="R1", distance=43.0, value=1.5, limit=2.0)
    assert str(full)
    assert "nan" not in str(full)
    assert "{" not in str(full)


@pytest.mark.parametrize(
    ("distance", "text"), [(-12.4, "12 m behind"), (0.0, "alongside"), (43.2, "43 m ahead")]
)
def test_distance_has_a_direction(distance: float, text: str) -> None:
    rejection = Rejection(
        kind=RejectionKind.LANE_BLOCKED, side="left", vehicle_id="R2", distance=distance, value=25.0
    )
    assert str(rejection) == f"on the left: R2 {text} at 25.0 m/s"


def test_limit_stands_next_to_value() -> None:
    rejection = Rejection(kind=RejectionKind.CLEARANCE, side="right", vehicle_id="R1", value=0.62, limit=1.0)
    assert str(rejection) == "on the right: too close to R1 (0.62 m, needs 1.00 m)"


def test_text_is_made_once_and_changes_no_equality() -> None:
    one, other = (Rejection(kind=RejectionKind.NO_LANE, side="left") for _ in range(2))
    assert one.why is one.why
    assert one == other
    assert hash(one) == hash(other)
    assert repr(one) == repr(other)


@pytest.mark.parametrize(
    ("kind", "value", "limit", "text"),
    [
        (RejectionKind.LANE_ENDS, 61.0, 55.0, "lane ends too early (in 55 m, needs 61 m)"),
        (RejectionKind.LANE_ENDS, 55.0, 61.0, "lane ends too early"),
        (RejectionKind.ROUTE_ENDS, 55.4, 55.2, "route ends too early"),
        (RejectionKind.CLEARANCE, -2.3, 1.0, "too close to R1"),
        (RejectionKind.CLEARANCE, 4.0, 1.0, "too close to R1"),  # in time, not in space
        (RejectionKind.TOO_FAST, 18.04, 18.0, "R1 is too fast"),
    ],
)
def test_figures_are_shown_only_for_a_shortage(
    kind: RejectionKind, value: float, limit: float, text: str
) -> None:
    assert Rejection(kind=kind, vehicle_id="R1", value=value, limit=limit).why == text


def rejection(side: str, kind: RejectionKind = RejectionKind.INNER_SIDE) -> Rejection:
    return Rejection(kind=kind, side=side, vehicle_id="R1")


@pytest.mark.parametrize(
    ("rejections", "text"),
    [
        ([], ""),
        ([rejection("left"), rejection("right", RejectionKind.NOT_CONVERGED)],
         "not passing on the left: not allowed; on the right: no path found"),
        ([rejection("right"), rejection("left"), rejection("right", RejectionKind.NOT_CONVERGED)],
         "not passing on the left or right: not allowed"),
        ([rejection("right", RejectionKind.NO_LANE), rejection("left")],
         "not passing on the left: not allowed"),
        ([rejection("left", RejectionKind.NO_LANE)], "not passing on the left: no lane"),
        ([rejection("left"), rejection("", RejectionKind.TOO_FAST)], "not passing: R1 is too fast"),
    ],
)  # fmt: skip
def test_first_cause_of_each_side_is_given(rejections: list[Rejection], text: str) -> None:
    assert not_passing(rejections) == text

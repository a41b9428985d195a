"""Rejection: the text of every kind."""

import pytest

from cca_core.decide import Rejection, RejectionKind


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
    assert str(rejection) == f"left lane blocked by R2 ({text}, 25.0 m/s)"


def test_limit_stands_next_to_value() -> None:
    rejection = Rejection(kind=RejectionKind.CLEARANCE, side="right", vehicle_id="R1", value=0.62, limit=1.0)
    assert str(rejection) == "clearance to R1 0.62 m on the right (limit 1.00 m)"


def test_text_is_made_once_and_changes_no_equality() -> None:
    one, other = (Rejection(kind=RejectionKind.NO_LANE, side="left") for _ in range(2))
    assert str(one) is str(one)
    assert one == other
    assert hash(one) == hash(other)
    assert repr(one) == repr(other)

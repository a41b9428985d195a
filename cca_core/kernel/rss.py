"""Safe distances of responsibility-sensitive safety (RSS)."""

from typing import Annotated

from cca_core.kernel.types import Int, Real, Reals

__all__ = ["RssReaction", "lateral_distances", "opposite_distances", "same_direction_distances"]

Row = Annotated[Reals, "n"]


class RssReaction:
    """Assumed reaction of a vehicle."""

    response_time: Real
    a_max: Real
    b_min: Real
    b_max: Real
    b_correct: Real
    a_lateral: Real
    b_lateral: Real
    fluctuation: Real
    standstill_gap: Real
    v_max: Real


def stopping_distance(v: Real, reaction: RssReaction, braking: Real) -> Real:
    """Distance of a vehicle that accelerates for its response time, up to v_max, and then brakes."""
    rho = reaction.response_time
    a = reaction.a_max
    top = max(v, min(v + rho * a, reaction.v_max))
    # time at the top speed, if the vehicle reaches it within the response time
    lost = rho - (top - v) / a if a > 0.0 else 0.0
    return 0.5 * (v + top) * (rho - lost) + top * lost + top * top / (2.0 * braking)


def lateral_shift(v: Real, reaction: RssReaction) -> Real:
    """Lateral distance of a vehicle that accelerates toward the other and then brakes."""
    rho = reaction.response_time
    after = v + rho * reaction.a_lateral
    moving = max(after, 0.0)
    return 0.5 * (v + after) * rho + moving * moving / (2.0 * reaction.b_lateral)


def same_direction_distances(
    n: Int, v_rear: Row, v_front: Row, rear: RssReaction, front: RssReaction, distance: Row
) -> None:
    """Safe distances behind vehicles that may brake fully."""
    for i in range(n):
        apart = stopping_distance(v_rear[i], rear, rear.b_min) - v_front[i] * v_front[i] / (2.0 * front.b_max)
        distance[i] = max(apart, 0.0) + rear.standstill_gap


def opposite_distances(
    n: Int, v_correct: Row, v_opposite: Row, correct: RssReaction, opposite: RssReaction, distance: Row
) -> None:
    """Safe distances between vehicles that approach each other."""
    gap = max(correct.standstill_gap, opposite.standstill_gap)
    for i in range(n):
        first = stopping_distance(abs(v_correct[i]), correct, correct.b_correct)
        distance[i] = first + stopping_distance(abs(v_opposite[i]), opposite, opposite.b_min) + gap


def lateral_distances(
    n: Int, v_left: Row, v_right: Row, left: RssReaction, right: RssReaction, distance: Row
) -> None:
    """Safe lateral distances between vehicles alongside each other."""
    margin = 0.5 * (left.fluctuation + right.fluctuation)
    for i in range(n):
        apart = lateral_shift(-v_left[i], left) + lateral_shift(v_right[i], right)
        distance[i] = max(apart + margin, 0.0)

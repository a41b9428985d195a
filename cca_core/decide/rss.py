"""Safe distances of responsibility-sensitive safety (RSS): along the road, both directions, and across."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_any, check_real
from cca_core.errors import InputError

__all__ = [
    "RSS_EGO",
    "RSS_OTHER",
    "RssSettings",
    "rss_lateral",
    "rss_opposite_direction",
    "rss_same_direction",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class RssSettings:
    """How a road user is taken to react; the defaults are those of the ad-rss library for the ego.

    Parameters
    ----------
    response_time : float
        Time until it reacts [s].
    a_max : float
        Acceleration in that time [m/s^2].
    b_min : float
        Deceleration that it brakes with at least, once it reacts [m/s^2], positive.
    b_max : float
        Deceleration that it brakes with at most [m/s^2], positive.
    b_correct : float
        As `b_min`, for one that is met by oncoming traffic on its own lane [m/s^2].
    a_lateral : float
        Lateral acceleration in the response time [m/s^2].
    b_lateral : float
        Lateral deceleration at least, once it reacts [m/s^2], positive.
    fluctuation : float
        Lateral movement without meaning [m].
    standstill_gap : float
        Distance kept along the road in any case [m].
    v_max : float
        Speed above which it does not accelerate in the response time [m/s].

    Raises
    ------
    InputError
        If a value is not finite or out of range, or `b_max` is less than `b_min`.
    """

    response_time: float = 1.0
    a_max: float = 3.5
    b_min: float = 4.0
    b_max: float = 8.0
    b_correct: float = 3.0
    a_lateral: float = 0.2
    b_lateral: float = 0.8
    fluctuation: float = 0.1
    standstill_gap: float = 0.0
    v_max: float = 100.0

    def __post_init__(self) -> None:
        for name in ("response_time", "b_min", "b_correct", "b_lateral"):
            check_real(name, getattr(self, name), gt=0.0)
        for name in ("a_max", "a_lateral", "fluctuation", "standstill_gap", "v_max"):
            check_real(name, getattr(self, name), ge=0.0)
        check_real("b_max", self.b_max, ge=self.b_min)


RSS_EGO = RssSettings()
"""The ego: it reacts in 1 s."""

RSS_OTHER = RssSettings(response_time=2.0)
"""Another road user: it reacts in 2 s."""


def rss_same_direction(
    v_rear: ArrayLike, v_front: ArrayLike, *, rear: RssSettings = RSS_EGO, front: RssSettings = RSS_OTHER
) -> Array:
    """Distance behind a vehicle at which even its hardest braking is survived.

    Parameters
    ----------
    v_rear, v_front : array_like, shape (...)
        Speeds along the road [m/s], not negative.
    rear, front : RssSettings
        How they react.

    Returns
    -------
    distance : ndarray, shape (...)
        Least safe bumper-to-bumper distance [m].

    Raises
    ------
    InputError
        If a speed is negative or not finite.

    Notes
    -----
    The one behind accelerates for its response time and then brakes with `b_min`, the one in front brakes
    with `b_max` from now. The distance compares where both stand.

    Examples
    --------
    >>> round(float(rss_same_direction(20.0, 20.0)), 3)
    65.781
    """
    behind, ahead = check_any("v_rear", v_rear), check_any("v_front", v_front)
    if min(behind.min(initial=0.0), ahead.min(initial=0.0)) < 0.0:
        raise InputError("v_rear and v_front must not be negative")
    apart = _stopping(behind, rear, rear.b_min) - ahead * ahead / (2.0 * front.b_max)
    distance: Array = np.maximum(apart, 0.0) + rear.standstill_gap
    return distance


def rss_opposite_direction(
    v_correct: ArrayLike,
    v_opposite: ArrayLike,
    *,
    correct: RssSettings = RSS_EGO,
    opposite: RssSettings = RSS_OTHER,
) -> Array:
    """Distance at which two vehicles that drive toward each other both come to rest before they meet.

    Parameters
    ----------
    v_correct : array_like, shape (...)
        Speed of the one that is on its own lane [m/s].
    v_opposite : array_like, shape (...)
        Speed of the other [m/s]. Of both speeds only the amount counts.
    correct, opposite : RssSettings
        How they react: the first brakes with `b_correct`, the other with `b_min`.

    Returns
    -------
    distance : ndarray, shape (...)
        Least safe bumper-to-bumper distance [m].

    Raises
    ------
    InputError
        If a speed is not finite.

    Examples
    --------
    >>> round(float(rss_opposite_direction(20.0, -20.0)), 3)
    251.917
    """
    own, other = np.abs(check_any("v_correct", v_correct)), np.abs(check_any("v_opposite", v_opposite))
    gap = max(correct.standstill_gap, opposite.standstill_gap)
    distance: Array = (
        _stopping(own, correct, correct.b_correct) + _stopping(other, opposite, opposite.b_min) + gap
    )
    return distance


def rss_lateral(
    v_left: ArrayLike, v_right: ArrayLike, *, left: RssSettings = RSS_EGO, right: RssSettings = RSS_OTHER
) -> Array:
    """Lateral distance at which two vehicles beside each other do not touch before they have reacted.

    Parameters
    ----------
    v_left, v_right : array_like, shape (...)
        Lateral speeds of the one on the left and the one on the right [m/s], to the left positive.
    left, right : RssSettings
        How they react.

    Returns
    -------
    distance : ndarray, shape (...)
        Least safe distance between their sides [m].

    Raises
    ------
    InputError
        If a speed is not finite.

    Notes
    -----
    Both accelerate toward each other for their response times and then brake. As in ad-rss 5.0, one that
    still moves away after its response time does not brake in this reckoning, and the fluctuation margin can
    be used up by a movement apart (the publication adds it in any case).

    Examples
    --------
    >>> round(float(rss_lateral(0.0, 0.0)), 3)
    0.725
    """
    inwards = (-check_any("v_left", v_left), check_any("v_right", v_right))
    apart = _shift(inwards[0], left) + _shift(inwards[1], right)
    margin = 0.5 * (left.fluctuation + right.fluctuation)
    distance: Array = np.maximum(apart + margin, 0.0)
    return distance


def _stopping(v: Array, settings: RssSettings, braking: float) -> Array:
    """Distance driven by one that accelerates for its response time, up to v_max, and then brakes."""
    rho, a = settings.response_time, settings.a_max
    top = np.maximum(v, np.minimum(v + rho * a, settings.v_max))
    # the time at the top speed, if it is reached within the response time
    lost = rho - (top - v) / a if a > 0.0 else np.zeros_like(v)
    distance: Array = 0.5 * (v + top) * (rho - lost) + top * lost + top * top / (2.0 * braking)
    return distance


def _shift(v: Array, settings: RssSettings) -> Array:
    """Distance moved toward the other by one that accelerates toward it and then brakes."""
    rho, b = settings.response_time, settings.b_lateral
    after = v + rho * settings.a_lateral
    distance: Array = 0.5 * (v + after) * rho + np.maximum(after, 0.0) ** 2 / (2.0 * b)
    return distance

"""Safe distances of responsibility-sensitive safety (RSS): along the road, both directions, and across."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_any, check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.kernel import bind, rss
from cca_core.kernel.memory import lend, put

_same_direction, _opposite = bind(rss.same_direction_distances), bind(rss.opposite_distances)
_lateral = bind(rss.lateral_distances)


@dataclass(frozen=True, slots=True, kw_only=True)
class RssSettings:
    """Assumed reaction of a vehicle; the defaults are those of the ad-rss library for the ego.

    Parameters
    ----------
    response_time : float
        Time until the vehicle reacts [s].
    a_max : float
        Acceleration during the response time [m/s^2].
    b_min : float
        Least deceleration after the response time [m/s^2], positive.
    b_max : float
        Largest deceleration [m/s^2], positive.
    b_correct : float
        Least deceleration of a vehicle in its own lane that faces oncoming traffic [m/s^2], positive.
    a_lateral : float
        Lateral acceleration during the response time [m/s^2].
    b_lateral : float
        Least lateral deceleration after the response time [m/s^2], positive.
    fluctuation : float
        Unintended lateral movement [m].
    standstill_gap : float
        Distance along the road that is always kept [m].
    v_max : float
        Speed above which the vehicle does not accelerate in the response time [m/s].

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

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name in ("response_time", "b_min", "b_correct", "b_lateral"):
            check_real(name, getattr(self, name), gt=0.0)
        for name in ("a_max", "a_lateral", "fluctuation", "standstill_gap", "v_max"):
            check_real(name, getattr(self, name), ge=0.0)
        check_real("b_max", self.b_max, ge=self.b_min)


RSS_EGO = RssSettings()
"""The ego: response time 1 s."""

RSS_OTHER = RssSettings(response_time=2.0)
"""Another vehicle: response time 2 s."""


def rss_same_direction(
    v_rear: ArrayLike, v_front: ArrayLike, *, rear: RssSettings = RSS_EGO, front: RssSettings = RSS_OTHER
) -> Array:
    """Least distance behind a vehicle that avoids a collision even if it brakes fully.

    Parameters
    ----------
    v_rear, v_front : array_like, shape (...)
        Speeds along the road [m/s], not negative.
    rear, front : RssSettings
        Assumed reactions.

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
    The rear vehicle accelerates for its response time and then brakes with `b_min`. The front vehicle brakes
    with `b_max` from now on. The distance compares the points at which both stop.

    Examples
    --------
    >>> round(float(rss_same_direction(20.0, 20.0)), 3)
    65.781
    """
    behind, ahead = check_any("v_rear", v_rear), check_any("v_front", v_front)
    if min(behind.min(initial=0.0), ahead.min(initial=0.0)) < 0.0:
        raise InputError("v_rear and v_front must not be negative")
    return _distances(_same_direction, behind, ahead, rear, front)


def rss_opposite_direction(
    v_correct: ArrayLike,
    v_opposite: ArrayLike,
    *,
    correct: RssSettings = RSS_EGO,
    opposite: RssSettings = RSS_OTHER,
) -> Array:
    """Least distance at which two vehicles that approach each other both stop in time.

    Parameters
    ----------
    v_correct : array_like, shape (...)
        Speed of the vehicle in its own lane [m/s]; the sign does not count.
    v_opposite : array_like, shape (...)
        Speed of the vehicle in the opposing lane [m/s]; the sign does not count.
    correct, opposite : RssSettings
        Assumed reactions: the first brakes with `b_correct`, the other with `b_min`.

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
    v_own, v_other = check_any("v_correct", v_correct), check_any("v_opposite", v_opposite)
    return _distances(_opposite, v_own, v_other, correct, opposite)


def rss_lateral(
    v_left: ArrayLike, v_right: ArrayLike, *, left: RssSettings = RSS_EGO, right: RssSettings = RSS_OTHER
) -> Array:
    """Least lateral distance at which two vehicles alongside each other react in time.

    Parameters
    ----------
    v_left, v_right : array_like, shape (...)
        Lateral speeds of the left and of the right vehicle [m/s], left positive.
    left, right : RssSettings
        Assumed reactions.

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
    Both vehicles accelerate toward each other for their response times and then brake. Two details are those
    of ad-rss 5.0. A vehicle that still moves away after its response time does not brake. A movement apart
    reduces the fluctuation margin, while the publication always adds the margin.

    Examples
    --------
    >>> round(float(rss_lateral(0.0, 0.0)), 3)
    0.725
    """
    v_l, v_r = check_any("v_left", v_left), check_any("v_right", v_right)
    return _distances(_lateral, v_l, v_r, left, right)


def _distances(
    kernel: Callable[..., None], one: Array, other: Array, first: RssSettings, second: RssSettings
) -> Array:
    """Compute the distances for speeds that broadcast."""
    speeds = np.stack(np.broadcast_arrays(one, other))
    distance = np.empty(speeds.shape[1:])
    rows = speeds.reshape(2, -1)
    kernel(distance.size, rows[0], rows[1], _reaction(first), _reaction(second), distance.reshape(-1))
    return distance[()]


@lru_cache(maxsize=32)
def _reaction(settings: RssSettings) -> rss.RssReaction:
    """Return the settings as the kernel takes them, which it only reads."""
    workspace = lend(rss.RssReaction).workspace
    put(workspace, **{field.name: getattr(settings, field.name) for field in fields(settings)})
    return workspace

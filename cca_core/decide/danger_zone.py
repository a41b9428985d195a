"""Danger zone of a vehicle in the adjacent lane: eq 11 as printed, and its general form."""

import numpy as np
from numpy.typing import ArrayLike

from cca_core._checks import Array, check_any, check_array, check_real
from cca_core.errors import InputError
from cca_core.kernel import bind
from cca_core.kernel.reach import danger_zones

_danger_zones = bind(danger_zones)


def danger_zone_end(
    X_1: ArrayLike, v_adj: ArrayLike, v_ego: ArrayLike, t_maneuver: float, x_safety: float
) -> Array:
    """End point X_2 of the danger zone, eq 11 as printed.

    Parameters
    ----------
    X_1 : array_like, shape (...)
        Start of the adjacent vehicle's body along the road [m].
    v_adj, v_ego : array_like, shape (...)
        Speeds along the road [m/s].
    t_maneuver : float
        Duration of the maneuver [s].
    x_safety : float
        Additional distance [m].

    Returns
    -------
    X_2 : ndarray, shape (...)
        X_1 + (v_adj - v_ego) t_maneuver + x_safety [m].

    Raises
    ------
    InputError
        If `t_maneuver` or `x_safety` is negative, or a value is not finite.

    Notes
    -----
    This form holds only for a faster vehicle in the same direction whose front bumper is at X_1.
    `danger_zone` is the general form.

    Examples
    --------
    >>> float(danger_zone_end(0.0, 30.0, 20.0, 4.0, 10.0))
    50.0
    """
    duration = check_real("t_maneuver", t_maneuver, ge=0.0)
    relative = check_any("v_adj", v_adj) - check_any("v_ego", v_ego)
    end: Array = check_any("X_1", X_1) + relative * duration + check_real("x_safety", x_safety, ge=0.0)
    return end


def danger_zone(
    rear: ArrayLike,
    front: ArrayLike,
    v_adj: ArrayLike,
    *,
    times: ArrayLike,
    ego_travel: ArrayLike,
    x_safety: float = 7.0,
    margin: ArrayLike = 0.0,
    braking: float = 0.0,
    acceleration: float = 0.0,
    age: ArrayLike = 0.0,
    a_reported: ArrayLike = 0.0,
) -> Array:
    """Interval of the road in which a vehicle of the adjacent lane blocks a maneuver.

    Parameters
    ----------
    rear, front : array_like, shape (...)
        Least and largest path coordinate of the adjacent vehicle's body now, relative to the ego [m].
    v_adj : array_like, shape (...)
        Speed of that vehicle along the path [m/s], negative if it is oncoming.
    times : array_like, shape (n,)
        Times from now [s], from the start of the maneuver until the ego's body has left the lane again.
    ego_travel : array_like, shape (n,)
        Distance that the ego has driven at those times [m].
    x_safety : float
        Distance kept in front of and behind the vehicle [m].
    margin : array_like, shape (...)
        Further distance for position error [m].
    braking, acceleration : float
        Assumed maximum deceleration and acceleration of the vehicle [m/s^2].
    age : array_like, shape (...)
        Age of the report [s], in which the vehicle may have braked or accelerated already.
    a_reported : array_like, shape (...)
        Reported rate of change of ``|v_adj|`` [m/s^2], with which position and speed were dead-reckoned by
        `age`.

    Returns
    -------
    zone : ndarray, shape (..., 2)
        Rear and front end of the zone [m], relative to the ego; the ego's body must stay outside.

    Raises
    ------
    InputError
        If `times` and `ego_travel` differ in shape or are empty, or a value is out of range.

    Notes
    -----
    Eq (11) of the paper in general form. The zone holds the vehicle's body relative to the ego during the
    whole maneuver: [min_t (rear + low - travel) - x_s, max_t (front + high - travel) + x_s]. Here [low, high]
    is `predict.reachable_interval`. For constant speeds both extremes are at an end of the maneuver. For a
    faster vehicle behind the ego the front end is X_2 of eq 11.

    The zone is the union of the intervals that are covered at each time, and this union has no holes. The ego
    is outside if and only if the vehicle can reach its body at none of the times.

    Examples
    --------
    >>> danger_zone(-44.5, -40.0, 30.0, times=[0.0, 4.0], ego_travel=[0.0, 80.0], x_safety=10.0)
    array([-54.5,  10. ])
    """
    t = check_array("times", times, (None,))
    driven = check_array("ego_travel", ego_travel, (None,))
    if t.shape != driven.shape or not len(t) or t.min() < 0.0:
        raise InputError("times and ego_travel must have the same length, times must not be negative")
    x_safety = check_real("x_safety", x_safety, ge=0.0)
    braking = check_real("braking", braking, ge=0.0)
    acceleration = check_real("acceleration", acceleration, ge=0.0)
    back, ahead, further = check_any("rear", rear), check_any("front", front), check_any("margin", margin)
    if (back > ahead).any():
        raise InputError("rear must not be in front of front")
    if (further < 0.0).any():
        raise InputError(f"margin must not be negative, was {further.min():g}")
    aged = check_any("age", age)
    if (aged < 0.0).any():
        raise InputError(f"age must not be negative, was {aged.min():g}")
    grown = x_safety + further
    columns = (
        back - grown, ahead + grown, check_any("v_adj", v_adj), aged, check_any("a_reported", a_reported),
        braking, acceleration, 0.0,
    )  # fmt: skip
    motion = np.stack(np.broadcast_arrays(*columns), axis=-1)
    zone = np.empty((*motion.shape[:-1], 2))
    _danger_zones(zone.size // 2, len(t), motion.reshape(-1, 8), t, driven, zone.reshape(-1, 2))
    return zone

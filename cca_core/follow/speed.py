"""Speed: cruise, follow a leader at a time gap, brake; and when the ego arrives where."""

import math
from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.path.path import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSettings:
    """Limits and gaps of the speed controller.

    Parameters
    ----------
    a_max : float
        Largest acceleration [m/s^2].
    b_comfort : float
        Deceleration of a planned approach [m/s^2], positive.
    b_max : float
        Largest deceleration [m/s^2], positive.
    standstill_gap : float
        Bumper-to-bumper gap behind a standing leader [m].
    time_gap : float
        Additional gap behind a moving leader [s].
    jerk : float
        Largest change of acceleration in normal driving [m/s^3].
    jerk_emergency : float
        Largest change of acceleration when braking hard [m/s^3].

    Raises
    ------
    InputError
        If a value is not finite and positive.
    """

    a_max: float = 2.0
    b_comfort: float = 2.0
    b_max: float = 7.0
    standstill_gap: float = 3.0
    time_gap: float = 1.5
    jerk: float = 3.0
    jerk_emergency: float = 12.65

    def __post_init__(self) -> None:
        for name in self.__slots__:
            check_real(name, getattr(self, name), above=0.0)


def cruise_acceleration(v_x: float, v_target: float, settings: SpeedSettings) -> float:
    """Acceleration towards a wanted speed.

    Parameters
    ----------
    v_x, v_target : float
        Speed now and wanted [m/s].
    settings : SpeedSettings
        Limits.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2], between -b_comfort and a_max.
    """
    return min(max(v_target - v_x, -settings.b_comfort), settings.a_max)


def follow_acceleration(
    v_x: float, gap: float, v_lead: float, settings: SpeedSettings, a_lead: float = 0.0
) -> float:
    """Acceleration that closes up to a leader and then keeps its speed at the wanted gap.

    Parameters
    ----------
    v_x : float
        Own speed [m/s].
    gap : float
        Bumper-to-bumper gap [m].
    v_lead : float
        The leader's speed [m/s].
    settings : SpeedSettings
        Limits and gaps.
    a_lead : float
        The leader's acceleration [m/s^2].

    Returns
    -------
    a_x : float
        Acceleration [m/s^2], at least -b_max; not limited above.

    Notes
    -----
    The wanted speed is v_lead plus what can be shed at `b_comfort` over the surplus gap
    e = gap - standstill_gap - time_gap v_lead: sqrt(2 b (e - e0/2)) far away, linear within e0, continuous
    with its slope. If more than twice `b_comfort` is needed to keep half the standstill gap, that is done.
    """
    b = settings.b_comfort
    need = required_deceleration(v_x, gap + 0.5 * settings.standstill_gap, v_lead, settings, a_lead)
    v_lead = max(v_lead, 0.0)
    surplus = gap - settings.standstill_gap - settings.time_gap * v_lead
    linear = b / _RATE**2
    if surplus > linear:
        shed = math.sqrt(2.0 * b * (surplus - 0.5 * linear))
        slope = b / shed
    else:
        shed, slope = _RATE * surplus, _RATE
    wanted = v_lead + shed
    approach = slope * min(v_lead - v_x, 0.0) + 2.0 * _RATE * (wanted - v_x)
    if need > 2.0 * b:
        approach = min(approach, -need)
    return max(approach, -settings.b_max)


def idm_acceleration(
    v_x: float, gap: float, v_lead: float, v_target: float, settings: SpeedSettings
) -> float:
    """Intelligent Driver Model: a smooth law for cruise and following in one.

    Parameters
    ----------
    v_x : float
        Own speed [m/s].
    gap : float
        Bumper-to-bumper gap [m].
    v_lead : float
        The leader's speed [m/s].
    v_target : float
        Wanted speed [m/s].
    settings : SpeedSettings
        a = `a_max`, b = `b_comfort`, s_0 = `standstill_gap`, T = `time_gap`; limited to -`b_max`.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2]: a (1 - (v/v_0)^4 - (s*/s)^2) with
        s* = s_0 + max(0, v T + v (v - v_l) / (2 sqrt(a b))).
    """
    a, b = settings.a_max, settings.b_comfort
    wished = settings.standstill_gap + max(
        0.0, v_x * settings.time_gap + v_x * (v_x - v_lead) / (2.0 * math.sqrt(a * b))
    )
    free = 1.0 - (v_x / max(v_target, 0.1)) ** 4
    return max(a * (free - (wished / max(gap, 0.1)) ** 2), -settings.b_max)


def cacc_acceleration(
    v_x: float,
    gap: float,
    v_lead: float,
    a_lead: float,
    settings: SpeedSettings,
    *,
    k_g: float = 0.45,
    k_d: float = 0.25,
) -> float:
    """Cooperative following at a constant time gap, with the leader's acceleration from its messages.

    Parameters
    ----------
    v_x : float
        Own speed [m/s].
    gap : float
        Bumper-to-bumper gap [m].
    v_lead, a_lead : float
        The leader's speed [m/s] and acceleration [m/s^2].
    settings : SpeedSettings
        Gaps and limits.
    k_g : float
        Gain on the gap error e [1/s^2].
    k_d : float
        Gain on its rate [1/s].

    Returns
    -------
    a_x : float
        Acceleration [m/s^2] within the limits: a_lead + k_g e + k_d (v_lead - v_x), with
        e = gap - s_0 - T v_x; the errors of a platoon die out from car to car for T >= 2 / (k_d + k_g T).
    """
    error = gap - settings.standstill_gap - settings.time_gap * v_x
    wanted = a_lead + k_g * error + k_d * (v_lead - v_x)
    return min(max(wanted, -settings.b_max), settings.a_max)


def stop_acceleration(v_x: float, distance: float, settings: SpeedSettings) -> float:
    """Deceleration that brings the car to rest at a point.

    Parameters
    ----------
    v_x : float
        Own speed [m/s].
    distance : float
        Distance to the point [m]; behind it the car brakes as hard as it can.
    settings : SpeedSettings
        Limits.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2]: -v^2 / (2 distance) once that is comfortable braking or more, else `a_max`.
    """
    if v_x <= 0.0:
        return 0.0
    need = v_x * v_x / (2.0 * distance) if distance > 0.0 else math.inf
    return -min(need, settings.b_max) if need >= settings.b_comfort else settings.a_max


def jerk_limited(
    wanted: float, last: float, dt: float, settings: SpeedSettings, *, emergency: bool = False
) -> float:
    """Acceleration on its way to the wanted one.

    Parameters
    ----------
    wanted, last : float
        Acceleration asked for now and in the last cycle [m/s^2].
    dt : float
        Time between them [s].
    settings : SpeedSettings
        `jerk`, and `jerk_emergency` for braking.
    emergency : bool
        Whether braking may build up at `jerk_emergency`.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2], at most jerk dt away from `last`.
    """
    step = (settings.jerk_emergency if emergency else settings.jerk) * dt
    return min(max(wanted, last - step), last + step)


def friction_limited(a_x: float, a_y: float, mu: float, *, share: float = 0.9) -> float:
    """Longitudinal acceleration that the tyres have left beside a lateral one.

    Parameters
    ----------
    a_x : float
        Acceleration asked for [m/s^2].
    a_y : float
        Lateral acceleration in use [m/s^2].
    mu : float
        Friction coefficient [-].
    share : float
        Share of the friction circle that may be used [-].

    Returns
    -------
    a_x : float
        Limited to +-sqrt((share mu g)^2 - a_y^2) [m/s^2]; 0 where cornering takes all.

    Examples
    --------
    >>> round(friction_limited(-9.0, 4.0, 0.9), 2)
    -6.87
    """
    left = math.sqrt(max((share * mu * _G) ** 2 - a_y * a_y, 0.0))
    return min(max(a_x, -left), left)


def required_deceleration(
    v_x: float, gap: float, v_lead: float, settings: SpeedSettings, a_lead: float = 0.0
) -> float:
    """Least constant deceleration that keeps the standstill gap to a leader.

    Parameters
    ----------
    v_x : float
        Own speed [m/s].
    gap : float
        Bumper-to-bumper gap [m].
    v_lead : float
        The leader's speed [m/s]; negative if it comes towards the ego.
    settings : SpeedSettings
        Gaps.
    a_lead : float
        The leader's acceleration [m/s^2]; braking is taken to last until standstill.

    Returns
    -------
    b : float
        Deceleration [m/s^2], not negative; infinite if the gap is used up.
    """
    room = gap - settings.standstill_gap
    need = 0.0
    if v_lead < 0.0 < v_x:  # stand when it comes: v^2 / 2b + |v_lead| v / b = room
        need = (0.5 * v_x - v_lead) * v_x / room if room > 0.0 else math.inf
    elif v_x > v_lead:
        need = (v_x - v_lead) ** 2 / (2.0 * room) if room > 0.0 else math.inf
    if a_lead < 0.0 <= v_lead and v_x > 0.0:
        # the gap is least when both are equally fast, or, if the leader stands before that, at standstill
        meets = 2.0 * room / (v_x - v_lead) if v_x > v_lead else math.inf
        if meets <= v_lead / -a_lead:
            return need - a_lead
        room += v_lead**2 / (-2.0 * a_lead)
        need = v_x**2 / (2.0 * room) if room > 0.0 else math.inf
    return need


def arrival_times(v_x: float, v_target: float, distances: Array, settings: SpeedSettings) -> Array:
    """When the ego reaches places ahead if it drives freely.

    Parameters
    ----------
    v_x, v_target : float
        Speed now and wanted [m/s].
    distances : ndarray, shape (n,)
        Distances ahead [m]; negative ones lie behind, at constant speed.
    settings : SpeedSettings
        Acceleration and deceleration used until the wanted speed is reached.

    Returns
    -------
    t : ndarray, shape (n,)
        Times from now [s].
    """
    v = max(v_x, 0.5)
    target = max(v_target, 0.5)
    a = settings.a_max if target > v else -settings.b_comfort
    ramp = (target * target - v * v) / (2.0 * a)
    on_ramp = np.clip(distances, 0.0, ramp)
    t: Array = (np.sqrt(v * v + 2.0 * a * on_ramp) - v) / a
    return t + np.minimum(distances, 0.0) / v + np.maximum(distances - ramp, 0.0) / target


def squared_speed_limit(
    path: Path, cruise: float, a_y: float, settings: SpeedSettings
) -> tuple[Array, Array]:
    """Square of the highest speed along a path: cruise, bends, and standstill at its end.

    Parameters
    ----------
    path : Path
        The route.
    cruise : float
        Highest speed anywhere [m/s].
    a_y : float
        Lateral acceleration for which speed is cut in bends [m/s^2].
    settings : SpeedSettings
        Its comfortable deceleration leads down to slower places.

    Returns
    -------
    s : ndarray, shape (n,)
        Arc length [m], up to a little behind the end.
    squared : ndarray, shape (n,)
        v^2 [m^2/s^2], linear between the places; negative behind the end, so that its slope is everywhere
        twice the acceleration asked for.
    """
    s = np.linspace(path.start, path.end, max(2, math.ceil(path.length / 2.0)))
    squared = np.minimum(cruise**2, a_y / np.maximum(np.abs(path.curvature(s)), 1e-9))
    squared[-1] = 0.0
    climb = 2.0 * settings.b_comfort * s
    # v_i^2 <= v_j^2 + 2 b (s_j - s_i) for all j >= i
    squared = np.minimum.accumulate((squared + climb)[::-1])[::-1] - climb
    return np.append(s, s[-1] + _TAIL), np.append(squared, -2.0 * settings.b_comfort * _TAIL)


_TAIL = 200.0  # the profile goes on falling behind the end [m]
_G = 9.81  # [m/s^2]
_RATE = 0.5  # closing rate near the wanted gap [1/s]

"""Car following: at a time gap, as a driver model, cooperatively; required deceleration."""

import math

from cca_core._checks import formula
from cca_core.follow.speed import SpeedSettings


@formula
def follow_acceleration(
    v_x: float, gap: float, v_lead: float, settings: SpeedSettings, a_lead: float = 0.0
) -> float:
    """Acceleration that approaches a lead vehicle and then keeps the target gap.

    Parameters
    ----------
    v_x : float
        Speed of the ego [m/s].
    gap : float
        Bumper-to-bumper gap [m].
    v_lead : float
        Speed of the lead vehicle [m/s].
    settings : SpeedSettings
        Limits and gaps.
    a_lead : float
        Acceleration of the lead vehicle [m/s^2].

    Returns
    -------
    a_x : float
        Acceleration [m/s^2], at least -b_max; not limited above.

    Notes
    -----
    The target speed is v_lead plus the speed that braking at b = `b_comfort` takes off over the surplus gap
    e = gap - standstill_gap - time_gap v_lead. This is sqrt(2 b (e - e0/2)) for large e, and linear below e0,
    with a continuous slope. The result is at most the negative of `required_deceleration` for half the
    standstill gap if that exceeds twice `b_comfort`.
    """
    b = settings.b_comfort
    need = required_deceleration(v_x, gap + 0.5 * settings.standstill_gap, v_lead, settings, a_lead)
    v_lead = max(v_lead, 0.0)
    surplus = gap - settings.standstill_gap - settings.time_gap * v_lead
    rate = settings.approach_rate
    linear = b / rate**2
    if surplus > linear:
        closing = math.sqrt(2.0 * b * (surplus - 0.5 * linear))
        slope = b / closing
    else:
        closing, slope = rate * surplus, rate
    target = v_lead + closing
    approach = slope * min(v_lead - v_x, 0.0) + 2.0 * rate * (target - v_x)
    if need > 2.0 * b:
        approach = min(approach, -need)
    return max(approach, -settings.b_max)


@formula
def idm_acceleration(
    v_x: float, gap: float, v_lead: float, v_target: float, settings: SpeedSettings
) -> float:
    """Acceleration of the Intelligent Driver Model, for cruise and following.

    Parameters
    ----------
    v_x : float
        Speed of the ego [m/s].
    gap : float
        Bumper-to-bumper gap [m].
    v_lead : float
        Speed of the lead vehicle [m/s].
    v_target : float
        Target speed [m/s].
    settings : SpeedSettings
        a = `a_max`, b = `b_comfort`, s_0 = `standstill_gap`, T = `time_gap`; limited to -`b_max`.

    Returns
    -------
    a_x : float
        Acceleration [m/s^2]: a (1 - (v/v_0)^4 - (s*/s)^2) with
        s* = s_0 + max(0, v T + v (v - v_l) / (2 sqrt(a b))).
    """
    a, b = settings.a_max, settings.b_comfort
    target_gap = settings.standstill_gap + max(
        0.0, v_x * settings.time_gap + v_x * (v_x - v_lead) / (2.0 * math.sqrt(a * b))
    )
    free = 1.0 - (v_x / max(v_target, 0.1)) ** 4
    return max(a * (free - (target_gap / max(gap, 0.1)) ** 2), -settings.b_max)


@formula
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
    """Cooperative following at a constant time gap, with the reported acceleration of the lead vehicle.

    Parameters
    ----------
    v_x : float
        Speed of the ego [m/s].
    gap : float
        Bumper-to-bumper gap [m].
    v_lead, a_lead : float
        Speed [m/s] and acceleration [m/s^2] of the lead vehicle.
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
        e = gap - s_0 - T v_x. A platoon is string stable for T >= 2 / (k_d + k_g T).
    """
    error = gap - settings.standstill_gap - settings.time_gap * v_x
    target = a_lead + k_g * error + k_d * (v_lead - v_x)
    return min(max(target, -settings.b_max), settings.a_max)


@formula
def required_deceleration(
    v_x: float, gap: float, v_lead: float, settings: SpeedSettings, a_lead: float = 0.0
) -> float:
    """Least constant deceleration that keeps the standstill gap to a lead vehicle.

    Parameters
    ----------
    v_x : float
        Speed of the ego [m/s].
    gap : float
        Bumper-to-bumper gap [m].
    v_lead : float
        Speed of the lead vehicle [m/s]; negative if it is oncoming.
    settings : SpeedSettings
        Gaps.
    a_lead : float
        Acceleration of the lead vehicle [m/s^2]; braking is assumed to last until standstill.

    Returns
    -------
    b : float
        Deceleration [m/s^2], not negative; infinite if the gap is used up.
    """
    distance = gap - settings.standstill_gap
    need = 0.0
    if v_lead < 0.0 < v_x:  # stop before it arrives: v^2 / 2b + |v_lead| v / b = distance
        need = (0.5 * v_x - v_lead) * v_x / distance if distance > 0.0 else math.inf
    elif v_x > v_lead:
        need = (v_x - v_lead) ** 2 / (2.0 * distance) if distance > 0.0 else math.inf
    if a_lead < 0.0 <= v_lead and v_x > 0.0:
        # the gap is least at equal speeds, or at standstill if the lead vehicle stops before that
        t_equal = 2.0 * distance / (v_x - v_lead) if v_x > v_lead else math.inf
        if t_equal <= v_lead / -a_lead:
            return need - a_lead
        distance += v_lead**2 / (-2.0 * a_lead)
        need = v_x**2 / (2.0 * distance) if distance > 0.0 else math.inf
    return need

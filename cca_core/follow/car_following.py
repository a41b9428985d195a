"""Following a leader: at a time gap, as a driver model, cooperatively; and what braking it takes."""

import math

from cca_core.follow.speed import SpeedSettings

__all__ = ["cacc_acceleration", "follow_acceleration", "idm_acceleration", "required_deceleration"]


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
    rate = settings.approach_rate
    linear = b / rate**2
    if surplus > linear:
        shed = math.sqrt(2.0 * b * (surplus - 0.5 * linear))
        slope = b / shed
    else:
        shed, slope = rate * surplus, rate
    wanted = v_lead + shed
    approach = slope * min(v_lead - v_x, 0.0) + 2.0 * rate * (wanted - v_x)
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
        The leader's speed [m/s]; negative if it comes toward the ego.
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

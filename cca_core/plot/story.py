"""What happened in a run: in words, and the moments worth a picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cca_core.decide import Action
from cca_core.plot.style import row_at
from cca_core.sim import Log

_NEAR = 60.0  # vehicles that stay farther away were not met [m]
_APART = 0.3  # least time between two frames chosen automatically [s]


def describe_run(log: Log) -> str:
    """Tell a run in one sentence.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    story : str
        What the ego did and when, what it waited for, and how the run ended.
    """
    told = []
    ends = [begin for begin, _, _ in log.decisions[1:]] + [float(log.t[-1])]
    for i, ((begin, name, reason), end) in enumerate(zip(log.decisions, ends, strict=True)):
        last = i + 1 == len(log.decisions)
        head, _, why = reason.partition(";")
        head = head.partition(":")[0]
        if Action(name) in (Action.FOLLOW, Action.BRAKE):
            through = vehicles_waited_for(log, begin, end)
            until = f" until {join_names(through)} is through" if through else ""
            if last:
                reason = f" ({why.strip()})" if why.strip() else ""
                told.append(f"{head}, from {begin:.1f} s to the end{reason}")
            else:
                told.append(f"{head} for {end - begin:.1f} s{until} ({begin:.1f} s)")
        elif Action(name).is_evading:
            told.append(f"{head} ({begin:.1f} s)")
        elif last and i > 0:
            told.append(f"back on the route ({begin:.1f} s)")
    if (log.gaps() <= 0.0).any():
        told.append(
            f"{describe_outcome(log)} at {log.t[-1]:.1f} s, relative speed {log.closing_speed():.1f} m/s"
        )
    else:
        told.append(f"{describe_outcome(log)} at {log.ego[-1, 3]:.0f} m/s")
    text = ", ".join(told)
    return text[0].upper() + text[1:] + "."


def describe_participants(log: Log) -> str:
    """Tell who takes part in a run.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    cast : str
        Speed and place of everybody at the start.
    """
    own = log.scenario.road.ego_lane
    told = [f"The ego wants to drive at {log.scenario.cruise_speed:.0f} m/s"]
    for user, (s, d) in zip(log.scenario.road_users, log.user_frenet[0], strict=True):
        does = f"drives at {user.v_x:.0f} m/s" if user.v_x > 0.0 else "stands"
        if user.route is not None:
            away = np.hypot(*(log.road_users[0, len(told) - 1, :2] - log.ego[0, :2]))
            told.append(f"{user.id} {does} on another way, {away:.0f} m away")
            continue
        ahead = s - log.ego_frenet[0, 0]
        where = f"{abs(ahead):.0f} m {'ahead' if ahead > 0.0 else 'behind'}"
        lane = "its lane" if own.right < d < own.left else f"the lane to the {'left' if d > 0.0 else 'right'}"
        toward = ", oncoming" if user.direction < 0 else ""
        told.append(f"{user.id} {does} on {lane}, {where}{toward}")
    pinned = log.scenario.fixed_gap
    if pinned is not None:
        told.append(f"the ego keeps {pinned.time_gap:g} s behind {pinned.lead_id} until it knows of a hazard")
    return "; ".join(told) + "."


def describe_outcome(log: Log) -> str:
    """How a run ended.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    outcome : str
        The collision, or who was overtaken and who was not.
    """
    gaps, users = log.gaps(), log.scenario.road_users
    hit = [user.id for user, gap in zip(users, gaps.min(axis=0), strict=True) if gap <= 0.0]
    if hit:
        return f"collides with {join_names(hit)}"
    ahead = log.user_frenet[..., 0] > log.ego_frenet[:, None, 0]
    slow = [i for i, user in enumerate(users) if user.direction > 0 and ahead[0, i]]
    passed = [users[i].id for i in slow if not ahead[-1, i]]
    missed = [users[i].id for i in slow if ahead[-1, i]]
    words = [f"{where} {join_names(ids)}" for where, ids in (("ahead of", passed), ("behind", missed)) if ids]
    return "ends " + (" and ".join(words) or "alone on its lane")


def vehicles_waited_for(log: Log, begin: float, end: float) -> list[str]:
    """Vehicles on other lanes that came past the ego during a part of a run.

    Parameters
    ----------
    log : Log
        The run.
    begin, end : float
        From when until when [s].

    Returns
    -------
    ids : list of str
        Who came past.
    """
    first, last = row_at(log, begin), row_at(log, end)
    own = log.scenario.road.ego_lane
    ahead = log.user_frenet[[first, last], :, 0] > log.ego_frenet[[first, last], None, 0]
    d = log.user_frenet[last, :, 1]
    past = (ahead[0] != ahead[1]) & ((d > own.left) | (d < own.right))
    return [user.id for user, is_past in zip(log.scenario.road_users, past, strict=True) if is_past]


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyFrame:
    """A moment of a run that is worth a picture.

    Parameters
    ----------
    t : float
        When [s].
    text : str
        What happens, in words.
    """

    t: float
    text: str


def key_frames(log: Log, *, most: int = 6) -> list[KeyFrame]:
    """Choose the moments that tell what happened.

    Parameters
    ----------
    log : Log
        The run.
    most : int
        Largest number of frames [-].

    Returns
    -------
    frames : list of Frame
        In order of time: a collision; where the ego begins to evade, follow or brake; where another begins to
        brake or swerve, and where the ego is beside each; if there is room, where it goes back to its lane,
        and the end.
    """
    gaps, ends = log.gaps(), float(log.t[-1])
    ranked: list[tuple[int, KeyFrame]] = []
    for t, name, reason in log.decisions[1:]:
        ranked.append((2 if name == Action.KEEP.value else 0, KeyFrame(t=t, text=f"{name}: {reason}")))
    for i, user in enumerate(log.scenario.road_users):
        apart = np.hypot(*(log.road_users[:, i, :2] - log.ego[:, :2]).T)
        row = int(np.argmin(apart))
        if apart[row] < _NEAR and 0 < row < len(log.t) - 1:
            beside = abs(log.user_frenet[row, i, 0] - log.ego_frenet[row, 0]) < user.length
            where = "beside" if beside else "closest to"
            text = f"{where} {user.id}, {gaps[row, i]:.1f} m apart"
            ranked.append((1, KeyFrame(t=float(log.t[row]), text=text)))
    names = {user.id for user in log.scenario.road_users}
    for t, what, who in log.events:
        if who in names and what in ("brakes", "lateral_shift"):
            ranked.append((1, KeyFrame(t=t, text=f"{who} {what}")))
    hit = " in a collision" if (gaps <= 0.0).any() else ""
    ranked.append((-1 if hit else 3, KeyFrame(t=ends, text=f"the run ends{hit}")))
    ranked.sort(key=lambda entry: (entry[0], -entry[1].t if entry[0] == 2 else entry[1].t))
    chosen: list[KeyFrame] = []
    for _, frame in ranked:
        if len(chosen) < most and all(abs(frame.t - other.t) >= _APART for other in chosen):
            chosen.append(frame)
    return sorted(chosen, key=lambda frame: frame.t)


def join_names(ids: Sequence[str]) -> str:
    """Enumerate.

    Parameters
    ----------
    ids : sequence of str
        What is enumerated.

    Returns
    -------
    text : str
        With commas and "and".
    """
    return " and ".join(filter(None, (", ".join(ids[:-1]), ids[-1])))

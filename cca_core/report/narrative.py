"""What happened in a run, and in a set of runs, in words made from the logs."""

import re
from collections.abc import Sequence

import numpy as np

from cca_core.decide import Action
from cca_core.plot.labels import case_name, gap_words, is_called_oncoming, join_names, scenario_name
from cca_core.report.selection import baseline_and_v2v, compares_v2v, one_run_per_ego
from cca_core.sim import Log
from cca_core.sim.outcome import MOVING_SPEED, ahead_at_ends, final_lead, first_collision, overtaken, row_at
from cca_core.sim.overlaps import describe_overlap, explain_overlaps


def headline(groups: Sequence[Sequence[Log]]) -> str:
    """State in a sentence or two what V2V changed.

    Parameters
    ----------
    groups : sequence of sequence of Log
        Runs by scenario, as `group_by_case` sorts them.

    Returns
    -------
    text : str
        In how many scenarios the ego collides without V2V and with it, and what else V2V makes possible.
    """
    pairs = [pair for pair in map(baseline_and_v2v, groups) if compares_v2v(pair)]
    if not pairs:
        n = len(groups)
        n_collided = sum(first_collision(group[-1]) is not None for group in groups)
        runs = "1 scenario was driven" if n == 1 else f"{n} scenarios were driven"
        end = f"collides in {_count(n_collided, n)}"
        if n == 1:
            end = "collides" if n_collided else "does not collide"
        return f"{runs}; none of them both with and without V2V. The ego {end}."
    shown_runs = [log for group in groups for log in one_run_per_ego(group)]
    parts: list[str] = []
    for ego_type, condition in (
        ("driver", "if a person drives"), ("sensor", "if a program drives with its sensor alone"),
        ("v2v", "with V2V"),
    ):  # fmt: skip
        chosen = [log for log in shown_runs if log.scenario.ego_type == ego_type]
        if chosen:
            k, n = sum(first_collision(log) is not None for log in chosen), len(chosen)
            unit = "" if parts else " scenario" if n == 1 else " scenarios"
            parts.append(f"in {k} of {n}{unit} {condition}")
    text = f"The ego collides {join_names(parts)}."
    freed = [
        pair[1]
        for pair in pairs
        if not any(first_collision(log) is not None for log in pair)
        and len(overtaken(pair[1])) > len(overtaken(pair[0]))
    ]
    if freed:
        where = f"In {join_names([scenario_name(log.scenario) for log in freed])}"
        if all(log.scenario.name == "maneuver" for log in freed):
            where = f"When maneuvering ({join_names([case_name(log.scenario) for log in freed])})"
        text += f" {where} the ego stays behind slow traffic without V2V and passes it with V2V."
    return text


def _count(k: int, n: int) -> str:
    number = "none" if k == 0 else f"all {n}" if k == n else str(k)
    return number if k in (0, n) else f"{number} of {n} scenarios"


def summarize_outcome(log: Log) -> str:
    """State in a few words how a run ended.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    text : str
        The rest of a sentence that begins with the ego: the collision and its speed, the vehicle behind which
        the ego stopped, the time it waited, or the vehicles it passed and how closely. Road users that drive
        into each other are added to it.
    """
    outcome = _summarize_ego(log)
    return f"{outcome}; {describe_overlap(log.overlaps[0])}" if log.overlaps else outcome


def _summarize_ego(log: Log) -> str:
    collision = first_collision(log)
    if collision is not None:
        return f"collides with {collision.id} at {collision.speed:.1f} m/s"
    gaps, names = log.gaps(), [user.id for user in log.scenario.road_users]
    stationary = log.ego[:, 3] < MOVING_SPEED
    lead, passed = final_lead(log), overtaken(log)
    passes = ""
    if passed:
        which, pronoun = join_names([names[i] for i in passed]), "it" if len(passed) == 1 else "them"
        passes = f"passes {which}, min gap to {pronoun} {gap_words(gaps[:, passed].min())}"
    if stationary[-1]:
        stops = "stops" if lead is None else f"stops {gap_words(gaps[-1, lead])} behind {names[lead]}"
        return f"{passes}, then {stops}" if passes else stops
    min_gap = gaps.min(initial=np.inf)
    if stationary.any():
        waited = float(np.sum(np.diff(log.t)[stationary[:-1]]))
        return f"waits {waited:.1f} s, then drives on, min gap {gap_words(min_gap)}"
    if passes:
        return passes
    if lead is not None:
        return f"ends {gap_words(gaps[-1, lead])} behind {names[lead]}, at {log.ego[-1, 3]:.1f} m/s"
    if any(user.route is not None for user in log.scenario.road_users):
        return f"slows down to {log.ego[:, 3].min():.1f} m/s and drives on, min gap {gap_words(min_gap)}"
    return describe_outcome(log)


def describe_run(log: Log) -> str:
    """Describe a run in one sentence.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    text : str
        What the ego did and when, the vehicles it waited for, how the run ended, and whether road users drove
        into each other.
    """
    events: list[tuple[float, str]] = []
    reasons = log.reasons or [(reason, "") for _, _, reason in log.decisions]
    ends = [begin for begin, _, _ in log.decisions[1:]] + [float(log.t[-1])]
    for i, ((begin, name, _), (activity, cause), end) in enumerate(
        zip(log.decisions, reasons, ends, strict=True)
    ):
        is_last = i + 1 == len(log.decisions)
        if Action(name) in (Action.FOLLOW, Action.BRAKE):
            until = _describe_wait(log, begin, end, cause if is_last else None)
            does, _, rest = activity.partition(" ")
            phrase = f"starts {activity}" if does.endswith("ing") else f"is {activity}"
            events.append((begin, f"it {f'stops {rest}' if does == 'stopping' else phrase}{until}."))
        elif Action(name).is_evading:
            events.append((begin, f"it starts {activity}."))
        elif is_last and i > 0:
            was_evading = Action(log.decisions[i - 1][1]).is_evading
            events.append((begin, "it is back in its lane." if was_evading else "it drives on."))
    collision = first_collision(log)
    end_of_run = f" It {describe_outcome(log)}, at {log.ego[-1, 3]:.0f} m/s."
    if collision is not None:
        speed = f"{log.closing_speed():.1f} m/s"
        events.append((collision.t, f"it {describe_outcome(log)}, at a relative speed of {speed}."))
        end_of_run = ""
    events.sort(key=lambda event: event[0])
    text = (" ".join(f"At {t:.1f} s {text}" for t, text in events) + end_of_run).strip()
    text = re.sub(r"\b[Ii]t\b", lambda found: "the ego" if found[0] == "it" else "The ego", text, count=1)
    return f"{text} {explain_overlaps(log.overlaps)}." if log.overlaps else text


def _describe_wait(log: Log, begin: float, end: float, cause: str | None) -> str:
    """Until when the ego follows or brakes; `cause` is given if it lasts to the end."""
    if cause is not None:
        return f", up to the end{f': {cause}' if cause else ''}"
    names = vehicles_waited_for(log, begin, end)
    until = f", until {join_names(names)} {'has' if len(names) == 1 else 'have'} passed" if names else ""
    return f" for {end - begin:.1f} s{until}"


def describe_participants(log: Log) -> str:
    """Describe the participants of a run at its start.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    text : str
        Speed, lane and gap to the ego of each road user, or the time at which it appears.
    """
    lane, vehicle, gaps = log.scenario.road.ego_lane, log.scenario.vehicle, log.gaps()[0]
    parts = [f"The ego's cruise speed is {log.scenario.cruise_speed:.0f} m/s"]
    for i, (user, (s, d)) in enumerate(zip(log.scenario.road_users, log.user_frenet[0], strict=True)):
        if not log.present[0, i]:
            appears = log.t[int(log.present[:, i].argmax())]
            parts.append(f"{user.id} appears at {appears:.1f} s")
            continue
        motion = f"drives at {user.v_x:.0f} m/s" if user.v_x > 0.0 else "is stationary"
        if user.route is not None:
            parts.append(f"{user.id} {motion} on another road, {gaps[i]:.0f} m away")
            continue
        ahead = s - log.ego_frenet[0, 0] - vehicle.box_offset
        gap = abs(ahead) - 0.5 * (user.length + vehicle.length)
        where = f"{gap:.0f} m {'ahead' if ahead > 0.0 else 'behind'}" if gap > 0.0 else "alongside"
        side = "ego" if lane.right < d < lane.left else "left" if d > 0.0 else "right"
        oncoming = ", oncoming" if is_called_oncoming(user) else ""
        parts.append(f"{user.id} {motion} in the {side} lane, {where}{oncoming}")
    fixed = log.scenario.fixed_gap
    if fixed is not None:
        parts.append(f"the ego keeps {fixed.time_gap:g} s behind {fixed.lead_id} until it knows of a hazard")
    return "; ".join(parts) + "."


def describe_outcome(log: Log) -> str:
    """Describe how a run ended.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    text : str
        The collision, or the vehicles that the ego overtook and those that it did not.
    """
    gaps, users = log.gaps(), log.scenario.road_users
    collided = [user.id for user, gap in zip(users, gaps.min(axis=0), strict=True) if gap <= 0.0]
    if collided:
        return f"collides with {join_names(collided)}"
    ahead = ahead_at_ends(log)
    along = [user.direction > 0 and user.route is None for user in users]
    slower = [i for i, is_along in enumerate(along) if is_along and ahead[0, i]]
    passed = [users[i].id for i in slower if not ahead[-1, i]]
    missed = [users[i].id for i in slower if ahead[-1, i]]
    parts = [f"{where} {join_names(ids)}" for where, ids in (("ahead of", passed), ("behind", missed)) if ids]
    return "ends " + (" and ".join(parts) or "with no vehicle ahead")


def vehicles_waited_for(log: Log, begin: float, end: float) -> list[str]:
    """Find the vehicles on other lanes that passed the ego during a part of a run.

    Parameters
    ----------
    log : Log
        The run.
    begin, end : float
        First and last time [s].

    Returns
    -------
    ids : list of str
        Their ids.
    """
    rows = [row_at(log, begin), row_at(log, end)]
    lane = log.scenario.road.ego_lane
    ahead = log.user_frenet[rows, :, 0] > log.ego_frenet[rows, None, 0]
    d = log.user_frenet[rows[1], :, 1]
    passed = log.present[rows].all(axis=0) & (ahead[0] != ahead[1]) & ((d > lane.left) | (d < lane.right))
    return [user.id for user, has_passed in zip(log.scenario.road_users, passed, strict=True) if has_passed]

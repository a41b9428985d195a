"""Runs grouped by scenario and case, and the runs of a group that are shown."""

from collections import Counter
from collections.abc import Iterable, Sequence

from cca_core.sim import Log

_EGO_ORDER = ("driver", "sensor", "v2v")


def group_by_case(logs: Iterable[Log]) -> list[list[Log]]:
    """Group runs by scenario and case.

    Parameters
    ----------
    logs : iterable of Log
        The runs.

    Returns
    -------
    groups : list of list of Log
        Scenarios in the order in which they first occur. In each group the runs without V2V come first, and
        the plants of an ego type in the order in which they first occur. The cases of ``eebl`` differ in
        the connected vehicles and are one group. Runs that differ in none of these, such as recorded runs
        of one name, are groups of their own.
    """
    groups: dict[tuple[str, str | None, int], list[Log]] = {}
    repeats: Counter[tuple[str, str | None, str, str | None]] = Counter()
    for log in logs:
        scenario = log.scenario
        case = None if scenario.name == "eebl" else scenario.case
        kind = scenario.name, scenario.case, scenario.ego_type, log.plant
        groups.setdefault((scenario.name, case, repeats[kind]), []).append(log)
        repeats[kind] += 1
    return [
        sorted(group, key=lambda log: _EGO_ORDER.index(log.scenario.ego_type)) for group in groups.values()
    ]


def one_run_per_ego(group: Sequence[Log]) -> list[Log]:
    """Choose one run for each ego type.

    Parameters
    ----------
    group : sequence of Log
        Runs of one scenario.

    Returns
    -------
    runs : list of Log
        Those of the driver, the sensor and V2V, as far as they exist, on the plant of the first run with
        V2V or else of the first run. Without V2V the run with fewest connected vehicles is chosen, with V2V
        the one with most.
    """
    plant = next((log.plant for log in group if log.scenario.v2v), group[0].plant)
    best: dict[str, tuple[int, Log]] = {}
    for log in group:
        ego = log.scenario.ego_type
        connected = sum(user.connected for user in log.scenario.road_users)
        rank = -connected if log.scenario.v2v else connected
        if log.plant == plant and (ego not in best or rank < best[ego][0]):
            best[ego] = rank, log
    return [best[ego][1] for ego in _EGO_ORDER if ego in best]


def compared_runs(group: Sequence[Log]) -> list[Log]:
    """Choose the runs that are shown next to each other: each ego type, and V2V with each set of vehicles.

    On the plant of `one_run_per_ego`; with V2V the fewest connected vehicles come first.
    """
    chosen = one_run_per_ego(group)
    others = {
        tuple(user.connected for user in log.scenario.road_users): log
        for log in reversed(group)
        if log.scenario.v2v and log.plant == chosen[-1].plant
    }
    with_v2v = sorted(
        others.values(), key=lambda log: sum(user.connected for user in log.scenario.road_users)
    )
    return [log for log in chosen if not log.scenario.v2v] + with_v2v


def baseline_and_v2v(group: Sequence[Log]) -> list[Log]:
    """Choose the runs that show what V2V changed.

    Parameters
    ----------
    group : sequence of Log
        Runs of one scenario.

    Returns
    -------
    pair : list of Log
        The first and the last of `one_run_per_ego`: the driver or else the sensor, and V2V; one run if
        there is no other.
    """
    runs = one_run_per_ego(group)
    return runs if len(runs) < 2 else [runs[0], runs[-1]]


def compares_v2v(pair: Sequence[Log]) -> bool:
    """Whether some runs of a scenario have V2V and others have not."""
    return len({log.scenario.v2v for log in pair}) == 2

"""How a run ended, in words made from its log: who drove, what was hit or how it was avoided."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cca_core.plot.story import describe_outcome, join_names
from cca_core.sim import Log

__all__ = [
    "Collision",
    "baseline_and_v2v",
    "first_collision",
    "group_by_case",
    "one_run_per_ego",
    "summarize_outcome",
]

_STANDS = 0.1  # speed below which a car counts as standing [m/s]
_CASES_ARE_EGOS = ("eebl",)  # scenarios whose cases say who is connected
_EGOS = ("driver", "sensor", "v2v")


@dataclass(frozen=True, slots=True, kw_only=True)
class Collision:
    """The first contact of a run.

    Parameters
    ----------
    t : float
        When [s].
    id : str
        With whom.
    speed : float
        Magnitude of the difference of both velocities [m/s].
    xy : tuple of float
        Where: between the two nearest points of the bodies' outlines [m].
    """

    t: float
    id: str
    speed: float
    xy: tuple[float, float]

    def __str__(self) -> str:
        return f"contact with {self.id} at {self.t:.1f} s, {self.speed:.1f} m/s"


def first_collision(log: Log) -> Collision | None:
    """Find the contact in which a run ended.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    contact : Contact or None
        None if nothing was touched.
    """
    gaps = log.gaps()
    rows = np.flatnonzero((gaps <= 0.0).any(axis=1))
    if not len(rows):
        return None
    row = int(rows[0])
    i = int(np.argmin(gaps[row]))
    ego, others = log.bodies()
    own, other = (
        np.vstack((corners, 0.5 * (corners + np.roll(corners, 1, axis=0))))
        for corners in (ego.corners()[row, 0], others.corners()[row, i])
    )
    apart = np.linalg.norm(own[:, None] - other, axis=2)
    a, b = np.unravel_index(np.argmin(apart), apart.shape)
    x, y = (0.5 * (own[a] + other[b])).tolist()
    velocity = (log.ego[row, 3] + 1j * log.ego[row, 4]) * np.exp(1j * log.ego[row, 2])
    velocity -= log.road_users[row, i, 3] * np.exp(1j * log.road_users[row, i, 2])
    return Collision(
        t=float(log.t[row]), id=log.scenario.road_users[i].id, speed=float(abs(velocity)), xy=(x, y)
    )


def summarize_outcome(log: Log) -> str:
    """Say in a few words how a run ended.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    verdict : str
        What was hit and how fast, behind whom the ego stands, for how long it waited, whom it passed and how
        closely; it continues a sentence that begins with who drives.
    """
    hit = first_collision(log)
    if hit is not None:
        return f"hits {hit.id} at {hit.speed:.1f} m/s"
    gaps = log.gaps()
    stands = log.ego[:, 3] < _STANDS
    if stands[-1]:
        i = _leader(log)
        if i is not None:
            return f"stops {gaps[-1, i]:.1f} m behind {log.scenario.road_users[i].id}"
        return "stops"
    if stands.any():
        waited = float(np.sum(np.diff(log.t)[stands[:-1]]))
        return f"waits {waited:.1f} s, then drives on, least gap {gaps.min(initial=np.inf):.1f} m"
    passed = _passed(log)
    if passed:
        names = join_names([log.scenario.road_users[i].id for i in passed])
        return f"passes {names}, {gaps[:, passed].min():.1f} m apart"
    v = f"{log.ego[-1, 3]:.1f} m/s"
    leader = _leader(log)
    if leader is not None:
        return f"ends {gaps[-1, leader]:.1f} m behind {log.scenario.road_users[leader].id}, at {v}"
    if any(user.route is not None for user in log.scenario.road_users):
        slowest = f"slows down to {log.ego[:, 3].min():.1f} m/s"
        return f"{slowest} and drives on, least gap {gaps.min():.1f} m"
    return describe_outcome(log)


def _leader(log: Log) -> int | None:
    """Index of the nearest user in front of the ego, on its way, at the end."""
    users, vehicle = log.scenario.road_users, log.scenario.vehicle
    ahead, beside = (log.user_frenet[-1] - log.ego_frenet[-1]).T
    wide = 0.5 * (vehicle.width + np.array([user.width for user in users]))
    ahead = np.where((ahead > 0.0) & (np.abs(beside) < wide), ahead, np.inf)
    return int(np.argmin(ahead)) if np.isfinite(ahead).any() else None


def _passed(log: Log) -> list[int]:
    """Find users in the ego's direction that were in front of it at first and are behind it at last."""
    ahead = log.user_frenet[[0, -1], :, 0] > log.ego_frenet[[0, -1], None, 0]
    along = [user.direction > 0 and user.route is None for user in log.scenario.road_users]
    return np.flatnonzero(ahead[0] & ~ahead[1] & np.array(along, dtype=bool)).tolist()


def group_by_case(logs: Iterable[Log]) -> list[list[Log]]:
    """Sort runs by scenario and case.

    Parameters
    ----------
    logs : iterable of Log
        The runs.

    Returns
    -------
    groups : list of list of Log
        Scenarios in the order in which they first occur; in each the runs without V2V first, and for each
        ego the plants in the order in which they first occur.
    """
    groups: dict[tuple[str, str | None], list[Log]] = {}
    for log in logs:
        scenario = log.scenario
        case = None if scenario.name in _CASES_ARE_EGOS else scenario.case
        groups.setdefault((scenario.name, case), []).append(log)
    return [sorted(group, key=lambda log: _EGOS.index(log.scenario.ego_type)) for group in groups.values()]


def one_run_per_ego(group: Sequence[Log]) -> list[Log]:
    """Choose one run for each who drives.

    Parameters
    ----------
    group : sequence of Log
        Runs of one scenario.

    Returns
    -------
    runs : list of Log
        On the plant of the first run with V2V, or else of the first run: the driver's, the sensor's and the
        one with V2V, as far as they are there. Without V2V fewer connected vehicles go before more, with V2V
        more before fewer.
    """
    plant = next((log.plant for log in group if log.scenario.v2v), group[0].plant)
    best: dict[str, tuple[int, Log]] = {}
    for log in group:
        ego = log.scenario.ego_type
        connected = sum(user.connected for user in log.scenario.road_users)
        rank = -connected if log.scenario.v2v else connected
        if log.plant == plant and (ego not in best or rank < best[ego][0]):
            best[ego] = rank, log
    return [best[ego][1] for ego in _EGOS if ego in best]


def baseline_and_v2v(group: Sequence[Log]) -> list[Log]:
    """Choose the runs that show what V2V changed.

    Parameters
    ----------
    group : sequence of Log
        Runs of one scenario.

    Returns
    -------
    pair : list of Log
        The first and the last of `one_run_per_ego`: without V2V, the driver before the sensor, and with it; one run
        if there is no other.
    """
    runs = one_run_per_ego(group)
    return runs if len(runs) < 2 else [runs[0], runs[-1]]

"""Facts of a run, computed from its log: collision, lead vehicle, overtaken vehicles, lane change."""

from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.errors import InputError
from cca_core.sim.log import Log

MOVING_SPEED = 0.1
"""Speed from which a vehicle counts as moving in words and figures; slower is creeping [m/s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Collision:
    """The first collision of a run; a simulated run ends in it.

    Parameters
    ----------
    t : float
        Time [s].
    id : str
        Id of the other road user.
    speed : float
        Magnitude of the difference of both velocities [m/s].
    xy : tuple of float
        Point between the two nearest corners or edge midpoints of the bodies [m].
    """

    t: float
    id: str
    speed: float
    xy: tuple[float, float]

    def __str__(self) -> str:
        return f"collision with {self.id} at {self.t:.1f} s, {self.speed:.1f} m/s"


def first_collision(log: Log) -> Collision | None:
    """Find the first collision of a run; a simulated run ends in it.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    collision : Collision or None
        None if the ego did not collide.
    """
    row = log.collision_row
    if row is None:
        return None
    i = int(np.argmin(log.gaps()[row]))
    ego, other = (
        np.vstack((corners, 0.5 * (corners + np.roll(corners, 1, axis=0))))
        for corners in (body.corners()[row, k] for body, k in zip(log.bodies(), (0, i), strict=True))
    )
    distance = np.linalg.norm(ego[:, None] - other, axis=2)
    a, b = np.unravel_index(np.argmin(distance), distance.shape)
    x, y = (0.5 * (ego[a] + other[b])).tolist()
    velocity = (log.ego[row, 3] + 1j * log.ego[row, 4]) * np.exp(1j * log.ego[row, 2])
    velocity -= log.road_users[row, i, 3] * np.exp(1j * log.road_users[row, i, 2])
    return Collision(
        t=float(log.t[row]), id=log.scenario.road_users[i].id, speed=float(abs(velocity)), xy=(x, y)
    )


def first_lane_change(log: Log) -> tuple[float, float]:
    """Station at which the first lane change of a run begins, and at which it ends.

    Parameters
    ----------
    log : Log
        The run.

    Returns
    -------
    start, end : float
        Stations at which the ego has made 5 % and 95 % of the lateral distance [m].

    Raises
    ------
    InputError
        If the ego never left its lane.
    """
    s, d = log.ego_frenet.T
    outside = np.flatnonzero(np.abs(d) > log.scenario.road.ego_lane.width / 2.0)
    if not len(outside):
        raise InputError("log must be of a run in which the ego leaves its lane")
    back = np.flatnonzero(np.abs(d[outside[0] :]) < 0.5)
    until = outside[0] + back[0] if len(back) else len(d)
    peak = outside[0] + int(np.argmax(np.abs(d[outside[0] : until])))
    fraction = np.abs(d[: peak + 1] / d[peak])
    start = int(np.flatnonzero(fraction < 0.05)[-1])
    end = start + int(np.argmax(fraction[start:] > 0.95))
    return float(s[start]), float(s[end])


def lead_speed(log: Log, *, max_distance: float = 100.0) -> Array:
    """Speed of the lead vehicle in the ego lane.

    Parameters
    ----------
    log : Log
        The run.
    max_distance : float
        Largest distance ahead of the ego [m].

    Returns
    -------
    v_x : ndarray, shape (n,)
        Its speed [m/s], NaN while there is none.
    """
    if not log.scenario.road_users:
        return np.full(len(log.t), np.nan)
    lane = log.scenario.road.ego_lane
    ahead = log.user_frenet[..., 0] - log.ego_frenet[:, None, 0]
    d = log.user_frenet[..., 1]
    is_lead = (ahead > 0.0) & (ahead < max_distance) & (d < lane.left) & (d > lane.right)
    ahead = np.where(is_lead, ahead, np.inf)
    nearest = np.argmin(ahead, axis=1)
    rows = np.arange(len(log.t))
    v_x: Array = np.where(np.isfinite(ahead[rows, nearest]), log.road_users[rows, nearest, 3], np.nan)
    return v_x


def final_lead(log: Log) -> int | None:
    """Index of the nearest road user ahead of the ego that overlaps it laterally at the end."""
    users, vehicle = log.scenario.road_users, log.scenario.vehicle
    ahead, lateral_offset = (log.user_frenet[-1] - log.ego_frenet[-1]).T
    overlap = np.abs(lateral_offset) < 0.5 * (vehicle.width + np.array([user.width for user in users]))
    ahead = np.where((ahead > 0.0) & overlap, ahead, np.inf)
    return int(np.argmin(ahead)) if np.isfinite(ahead).any() else None


def overtaken(log: Log) -> list[int]:
    """Index of each road user in the ego's direction that it overtook."""
    ahead = ahead_at_ends(log)
    along = [user.direction > 0 and user.route is None for user in log.scenario.road_users]
    return np.flatnonzero(ahead[0] & ~ahead[1] & np.array(along, dtype=bool)).tolist()


def ahead_at_ends(log: Log) -> Mask:
    """Whether each road user is ahead of the ego in its first and in its last cycle, shape (2, n_users)."""
    users = np.arange(len(log.scenario.road_users))
    rows = np.stack((log.present.argmax(axis=0), len(log.t) - 1 - log.present[::-1].argmax(axis=0)))
    ahead: Mask = log.user_frenet[rows, users, 0] > log.ego_frenet[rows, 0]
    return ahead


def final_station(log: Log, i: int) -> float:
    """Station of the i-th road user in its last cycle [m]."""
    s = log.user_frenet[:, i, 0]
    return float(s[np.isfinite(s)][-1])


def row_at(log: Log, t: float) -> int:
    """Index of the cycle of a log that is nearest to a time [s]."""
    return int(np.argmin(np.abs(log.t - t)))

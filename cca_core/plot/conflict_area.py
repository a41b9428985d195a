"""Stations and times of a run at which the ego would collide with another vehicle."""

from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import box_gap, boxes
from cca_core.sim import Log
from cca_core.sim.outcome import first_collision

EVERY = 2
"""Cycles between two times [-]."""


def ego_stations(log: Log) -> Array:
    """Stations of the ego's center of gravity at which collisions are looked for, every 0.25 m [m]."""
    path = log.scenario.road.path
    return np.arange(log.ego_frenet[0, 0], min(log.ego_frenet[-1, 0] + 15.0, path.end), 0.25)


def blocked(log: Log) -> "np.ndarray[Any, np.dtype[np.bool_]]":
    """Whether the ego would collide at a time (row) and a station (column)."""
    path, vehicle, stations = log.scenario.road.path, log.scenario.vehicle, ego_stations(log)
    (x, y), psi = path.position(stations).T, path.heading(stations)
    ego = vehicle.body_at(x, y, psi)
    poses = _poses_of_others(log)
    area = np.zeros((len(poses), len(stations)), dtype=bool)
    for i, user in enumerate(log.scenario.road_users):
        ux, uy, upsi = poses[:, i].T[:, :, None]
        area |= box_gap(ego, boxes(ux, uy, upsi, user.length, user.width)) <= 0.0
    return area


def _poses_of_others(log: Log) -> Array:
    """Poses of the other road users, shape (m, n_users, 3); after a collision continued for 2 s."""
    poses = log.road_users[::EVERY, :, :3]
    collision = first_collision(log)
    if collision is None or collision.t < log.t[-1]:
        return poses
    step = log.t[1] - log.t[0]
    rows = EVERY * np.arange(len(poses), len(poses) + int(2.0 / (EVERY * step)))
    after = step * (rows - len(log.t) + 1)
    _, _, psi, v = log.road_users[-1].T
    velocity = np.stack((v * np.cos(psi), v * np.sin(psi), 0.0 * v), axis=-1)
    return np.concatenate((poses, log.road_users[-1, :, :3] + after[:, None, None] * velocity))

"""Time to collision and post-encroachment time of crossing conflicts."""

from dataclasses import dataclass

import numpy as np

from cca_core._checks import Array
from cca_core.geometry import box_gap, boxes
from cca_core.plot.conflict_area import EVERY, blocked, ego_stations
from cca_core.sim import Log
from cca_core.sim.outcome import MOVING_SPEED


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CrossingTimes:
    """Times of a conflict between crossing routes [s]."""

    t: Array
    ttc: Array  # until the bodies would touch if both kept their speeds; infinite beyond the horizon
    pet: float | None  # post-encroachment time; 0 in a collision, None if one of both does not come


def crossing_times(log: Log, *, period: float = 0.1, horizon: float = 8.0) -> CrossingTimes | None:
    """Compute the times of a run in which a moving vehicle crosses the ego's route; None if none does."""
    crossing = [
        i
        for i, user in enumerate(log.scenario.road_users)
        if user.route is not None and user.v_x > MOVING_SPEED
    ]
    if not crossing:
        return None
    every = max(round(period / (log.t[1] - log.t[0])), 1) if len(log.t) > 1 else 1
    rows = np.arange(0, len(log.t), every)
    ahead = np.arange(0.0, horizon + 1e-9, period)
    ttc = np.full(len(rows), np.inf)
    path, vehicle = log.scenario.road.path, log.scenario.vehicle
    s = np.minimum(log.ego_frenet[rows, :1] + log.ego[rows, 3:4] * ahead, path.end)
    (x, y), psi = np.moveaxis(path.position(s), -1, 0), path.heading(s)
    ego = vehicle.body_at(x, y, psi)
    for i in crossing:
        user = log.scenario.road_users[i]
        ux, uy, upsi, v = log.road_users[rows, i].T[:, :, None]
        other = boxes(
            ux + v * ahead * np.cos(upsi), uy + v * ahead * np.sin(upsi), upsi + 0.0 * ahead,
            user.length, user.width,
        )  # fmt: skip
        touches = box_gap(ego, other) <= 0.0
        first = np.where(touches.any(axis=1), ahead[touches.argmax(axis=1)], np.inf)
        ttc = np.minimum(ttc, np.where(log.present[rows, i], first, np.inf))
    return CrossingTimes(t=log.t[rows], ttc=ttc, pet=_pet(log))


def _pet(log: Log) -> float | None:
    """Post-encroachment time [s]."""
    if log.collision_row is not None:
        return 0.0
    area = blocked(log)
    # a vehicle that stands in the area forever does not cross it
    crossed = area.any(axis=0) & ~area[-1]
    if not crossed.any():
        return None
    stations = ego_stations(log)[crossed]
    inside = (log.ego_frenet[:, 0] >= stations[0]) & (log.ego_frenet[:, 0] <= stations[-1])
    occupied = np.flatnonzero(area[:, crossed].any(axis=1)) * EVERY
    if not inside.any():
        return None
    enters, leaves = log.t[np.flatnonzero(inside)[[0, -1]]]
    first, last = log.t[np.minimum(occupied[[0, -1]], len(log.t) - 1)]
    return float(max(enters - last, first - leaves))

"""Bodies of a run in path coordinates."""

import numpy as np

from cca_core._checks import Array
from cca_core.sim import Log


def frenet_corners(log: Log, rows: slice = slice(None)) -> Array:
    """Corners of all bodies, the ego first, shape (n, 1 + n_users, 4, 2) [m]; NaN of absent ones."""
    corners = np.concatenate([body.corners()[rows] for body in log.bodies()], axis=1)
    s_guess = np.concatenate((log.ego_frenet[rows, None, 0], log.user_frenet[rows, :, 0]), axis=1)
    present = np.isfinite(s_guess)
    guesses = np.repeat(s_guess[present][:, None], 4, axis=-1)
    found = np.full(corners.shape, np.nan)
    found[present] = np.stack(log.scenario.road.path.project(corners[present], s_guess=guesses), axis=-1)
    return found

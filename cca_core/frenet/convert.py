"""Conversion of remote vehicles to Frenet coordinates."""

import math
from collections.abc import Iterable

import numpy as np

from cca_core.frenet.records import FrenetVehicle
from cca_core.path import Path
from cca_core.vehicle import RemoteVehicle

__all__ = ["CROSSING_SINE", "to_frenet", "valid_vehicles"]

CROSSING_SINE = 0.35
"""Sine of the angle to the route above which a vehicle may cross it [-]; 20 degrees."""

_SCALAR_LIMIT = 25  # vehicles up to which foot points are found faster one by one than in a batch


def to_frenet(
    remotes: Iterable[RemoteVehicle],
    path: Path,
    last_s: dict[str, float],
    lateral_range: tuple[float, float] = (-15.0, 15.0),
) -> tuple[list[FrenetVehicle], tuple[tuple[str, str], ...]]:
    """Convert remote vehicles to Frenet coordinates.

    Parameters
    ----------
    remotes : iterable of RemoteVehicle
        The vehicles; of two with one id the one with the smaller age counts.
    path : Path
        The route.
    last_s : dict
        Station of each vehicle in the last cycle by id [m], the initial guess; updated here.
    lateral_range : tuple of float
        Lateral offsets of the right and left end of the relevant area [m]. A vehicle beyond, with its
        uncertainty bound, is left out unless it may cross the route.

    Returns
    -------
    vehicles : list of FrenetVehicle
        The valid and relevant ones.
    dropped : tuple of (str, str)
        Id and reason of the invalid ones.
    """
    valid, dropped = valid_vehicles(remotes)
    feet = _foot_points(valid, path, last_s)
    last_s.clear()
    last_s.update(zip(valid, (foot[0] for foot in feet), strict=True))
    vehicles = []
    for remote, (s, d, heading, kappa) in zip(valid.values(), feet, strict=True):
        angle = remote.psi - heading
        if not lateral_range[0] <= d <= lateral_range[1]:
            sine = abs(math.sin(angle))
            reach = (0.5 * remote.length + 2.0 * remote.sigma_along) * sine
            reach += 0.5 * remote.width + 2.0 * remote.sigma_across
            if sine < CROSSING_SINE and not lateral_range[0] - reach <= d <= lateral_range[1] + reach:
                continue
        vehicles.append(FrenetVehicle.from_remote(remote, s, d, angle, kappa))
    return vehicles, dropped


def valid_vehicles(
    remotes: Iterable[RemoteVehicle],
) -> tuple[dict[str, RemoteVehicle], tuple[tuple[str, str], ...]]:
    """Return the valid vehicles by id, of two the one with the smaller age, and why others are dropped."""
    valid: dict[str, RemoteVehicle] = {}
    dropped = []
    records: Iterable[object] = remotes if hasattr(remotes, "__iter__") else (remotes,)
    for remote in records:
        if not isinstance(remote, RemoteVehicle):
            dropped.append((str(remote)[:20], "not a RemoteVehicle"))
            continue
        reason = remote.invalid_reason
        if reason is not None:
            dropped.append((str(remote.id), reason))
        elif remote.id not in valid or remote.age < valid[remote.id].age:
            valid[remote.id] = remote
    return valid, tuple(dropped)


def _foot_points(
    remotes: dict[str, RemoteVehicle], path: Path, last_s: dict[str, float]
) -> list[tuple[float, float, float, float]]:
    """Station, lateral offset, heading and curvature of the route at the foot point of each vehicle."""
    new = [(remote.x, remote.y) for name, remote in remotes.items() if name not in last_s]
    first_guess = iter(path.project(new)[0].tolist() if new else ())
    guesses = [last_s[name] if name in last_s else next(first_guess) for name in remotes]
    if len(guesses) <= _SCALAR_LIMIT:
        pairs = zip(remotes.values(), guesses, strict=True)
        return [path.foot_point(remote.x, remote.y, guess) for remote, guess in pairs]
    s, d = path.project([(remote.x, remote.y) for remote in remotes.values()], guesses)
    _, first, second = path.derivatives(s)
    heading = np.arctan2(first[:, 1], first[:, 0])
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    kappa = cross / np.hypot(first[:, 0], first[:, 1]) ** 3
    return list(zip(s.tolist(), d.tolist(), heading.tolist(), kappa.tolist(), strict=True))

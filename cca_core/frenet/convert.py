"""Conversion of remote vehicles to Frenet coordinates."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from operator import attrgetter

from cca_core.frenet.branches import Branches
from cca_core.frenet.extent import extent_in_bend
from cca_core.frenet.records import FrenetVehicle
from cca_core.geometry import Boxes, box_gap, boxes
from cca_core.path import Path
from cca_core.vehicle import RemoteVehicle
from cca_core.vehicle.remote import is_finite_number, is_plain

__all__ = ["CROSSING_SINE", "INCOMPLETE", "to_frenet", "valid_vehicles"]

CROSSING_SINE = 0.35
"""Sine of the angle to the route above which a vehicle may cross it [-]; 20 degrees."""

INCOMPLETE = "the list is incomplete"
"""Beginning of the reason with which the rest of a list is dropped that cannot be read."""

NO_VEHICLE = "not a RemoteVehicle"
"""Reason with which a record of another type is dropped."""

_FIELDS = tuple(field.name for field in fields(RemoteVehicle))
_VALUES = attrgetter(*_FIELDS)


def to_frenet(
    remotes: Iterable[RemoteVehicle],
    path: Path,
    last_s: dict[str, float],
    lateral_range: tuple[float, float] = (-15.0, 15.0),
    branches: tuple[Branches, float] | None = None,
) -> tuple[list[FrenetVehicle], tuple[tuple[str, str], ...]]:
    """Convert remote vehicles to Frenet coordinates.

    Parameters
    ----------
    remotes : iterable of RemoteVehicle
        The vehicles. Of two records of one body with one id the one with the smaller age counts; two bodies
        with one id are two vehicles.
    path : Path
        The route.
    last_s : dict
        Station of each vehicle in the last cycle by id [m], the initial guess; updated here.
    lateral_range : tuple of float
        Lateral offsets of the right and left end of the relevant area [m]. A vehicle beyond, with its
        uncertainty bound, is left out unless it may cross the route.
    branches : tuple of Branches and float, optional
        For a route that passes near itself: its branches, and the station of the ego [m]. A vehicle near two
        branches is on both.

    Returns
    -------
    vehicles : list of FrenetVehicle
        The valid and relevant ones.
    dropped : tuple of (str, str)
        Id and reason of the invalid ones.
    """
    valid, dropped = valid_vehicles(remotes)
    pairs: Iterable[tuple[RemoteVehicle, tuple[float, float, float, float]]]
    if branches is None:
        feet = _foot_points(valid, path, last_s)
        last_s.clear()
        for name, foot in zip(valid, feet, strict=True):
            last_s[name] = foot[0]
        pairs = zip(valid.values(), feet, strict=True)
    else:
        pairs = _feet_on_branches(valid, path, *branches)
    vehicles = []
    for remote, foot in pairs:
        s, d, heading, kappa = foot
        angle = remote.psi - heading
        extent = extent_in_bend(remote, path, foot, lateral_range)
        if extent is None and not lateral_range[0] <= d <= lateral_range[1]:
            sine = abs(math.sin(angle))
            reach = (0.5 * remote.length + 2.0 * remote.sigma_along) * sine
            reach += 0.5 * remote.width + 2.0 * remote.sigma_across
            if sine < CROSSING_SINE and not lateral_range[0] - reach <= d <= lateral_range[1] + reach:
                continue
        vehicles.append(FrenetVehicle.from_remote(remote, s, d, angle, kappa, extent))
    return vehicles, dropped


def valid_vehicles(
    remotes: Iterable[RemoteVehicle],
) -> tuple[dict[str, RemoteVehicle], tuple[tuple[str, str], ...]]:
    """Return the valid vehicles by id, each body once, and why others are dropped.

    A second body under the same id is named ``id#2``.
    """
    valid: dict[str, RemoteVehicle] = {}
    dropped: list[tuple[str, str]] = []
    for record in remotes if type(remotes) in (list, tuple) else _each(remotes, dropped):
        try:
            remote = _plain(record)
        except Exception as error:  # a class or number type of the caller's
            dropped.append((_label(record), f"its {type(error).__name__} when read"))
            continue
        if isinstance(remote, str):
            dropped.append((_label(record), remote))
        elif remote.id not in valid:
            valid[remote.id] = remote
        else:
            _add_namesake(valid, remote, dropped)
    return valid, tuple(dropped)


def _each(remotes: object, dropped: list[tuple[str, str]]) -> Iterator[object]:
    """Yield the records; an iterable that fails is dropped from there on."""
    if not isinstance(remotes, Iterable):
        yield remotes
        return
    try:
        yield from remotes
    except Exception as error:  # an iterable of the caller's
        dropped.append(("", f"{INCOMPLETE}: {type(error).__name__} when read; awareness range 0 m"))


def _plain(record: object) -> RemoteVehicle | str:
    """Return a record of plain numbers, or why there is none."""
    if is_plain(record):
        return record
    if not isinstance(record, RemoteVehicle):
        return NO_VEHICLE
    reason = record.invalid_reason
    if reason is not None:
        return str(reason)  # a class of the caller's may return anything
    # what classes of the caller's compute is read once
    values = dict(zip(_FIELDS, _VALUES(record), strict=True))
    heights = [values.pop(name) for name in ("z", "sigma_z")]
    z, sigma_z = map(float, heights) if all(map(is_finite_number, heights)) else (None, 0.0)
    labels = {kind: values.pop(kind) for kind in ("id", "events", "source")}
    plain = RemoteVehicle(
        id=str(labels["id"]), events=frozenset(labels["events"]), source=str(labels["source"]), z=z,
        sigma_z=sigma_z, **{name: float(value) for name, value in values.items()},
    )  # fmt: skip
    return plain.invalid_reason or plain


def _add_namesake(
    valid: dict[str, RemoteVehicle], remote: RemoteVehicle, dropped: list[tuple[str, str]]
) -> None:
    """Add a record whose id is taken: the same body counts once, as last measured; another body is added."""
    names = [name for name in valid if name == remote.id or name.startswith(f"{remote.id}#")]
    for name in names:
        known = valid[name]
        if float(box_gap(_body(known), _body(remote))) > 0.0:
            continue
        if remote.age < known.age:
            valid[name] = replace(remote, id=name)
        dropped.append((remote.id, "older record of a vehicle with the same id and place"))
        return
    number = len(names) + 1
    while f"{remote.id}#{number}" in valid:
        number += 1
    valid[f"{remote.id}#{number}"] = replace(remote, id=f"{remote.id}#{number}")


def _body(remote: RemoteVehicle) -> Boxes:
    return boxes(remote.x, remote.y, remote.psi, remote.length, remote.width)


def _label(record: object) -> str:
    """Return what a dropped record is called."""
    try:
        return str(record.id if isinstance(record, RemoteVehicle) else record)[:20]
    except Exception:  # a class of the caller's
        return type(record).__name__


def _feet_on_branches(
    remotes: dict[str, RemoteVehicle], path: Path, branches: Branches, s_ego: float
) -> Iterator[tuple[RemoteVehicle, tuple[float, float, float, float]]]:
    """Yield each vehicle with its foot point on each branch near it."""
    for remote in remotes.values():
        for guess in branches.near(remote.x, remote.y, s_ego):
            yield remote, path.foot_point(remote.x, remote.y, guess)


def _foot_points(
    remotes: dict[str, RemoteVehicle], path: Path, last_s: dict[str, float]
) -> list[tuple[float, float, float, float]]:
    """Station, lateral offset, heading and curvature of the route at the foot point of each vehicle."""
    for name in [name for name in remotes if "#" in name]:  # of one id: which is which may have changed
        last_s.pop(name, None)
        last_s.pop(name.rpartition("#")[0], None)
    guesses = last_s
    new = [name for name in remotes if name not in last_s]
    if new:
        found = path.project([(remotes[name].x, remotes[name].y) for name in new])[0].tolist()
        guesses = last_s | dict(zip(new, found, strict=True))
    return [path.foot_point(remote.x, remote.y, guesses[name]) for name, remote in remotes.items()]

"""Runs in motion: inline SVG seen from above, side by side and in step."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np

from cca_core._checks import Array, check_bool
from cca_core.errors import InputError
from cca_core.plot.labels import action_words, begin_sentence, sanitize_text, scenario_name
from cca_core.plot.run_labels import run_labels
from cca_core.plot.style import assign_colors
from cca_core.report.files import fill, read_text
from cca_core.report.road_svg import roads_svg
from cca_core.sim import Log
from cca_core.sim.outcome import first_collision
from cca_core.sim.world.radio import sender_id
from cca_core.v2x import decode_bsm


@dataclass(frozen=True, slots=True, kw_only=True)
class Camera:
    """What a view shows, and how often."""

    behind: float = 0.22  # of the length of a view is behind the ego, if the camera moves [-]
    length: float = 90.0  # before the script fits it to the window, if the camera moves [m]
    margin: float = 6.0  # for texts above the road and below it, before the script fits it [m]
    max_height: float = 40.0  # of the road in a view [m]
    fixed_size: tuple[float, float] = (64.0, 41.0)  # if roads cross [m]
    frame_period: float = 0.1  # between stored frames; the player interpolates [s]
    ring_period: float = 0.5  # least time between two messages of a sender that are shown [s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """Camera (x, y, heading) of each stored frame, and the view box (left, top, width, height) [m].

    `road` is the height of the road in a view that the script fits to the window; 0 if the view is fixed [m].
    """

    camera: Array
    box: tuple[float, float, float, float]
    road: float = 0.0


_CAMERA = Camera()


def animate(logs: Sequence[Log], *, standalone: bool = True) -> str:
    """Show runs from above, side by side and in step.

    Parameters
    ----------
    logs : sequence of Log
        The runs, from left to right; the paper puts the one without V2V left.
    standalone : bool
        Whether the fragment contains its style and script. A page with several animations needs them once
        (``player.css`` and ``player.js`` of `cca_core.report`, the script behind the last animation).

    Returns
    -------
    fragment : str
        HTML and well-formed XML, for example for ``IPython.display.HTML``. Without a script it shows the
        start. A vehicle that the ego does not know, by messages or by its sensor, is drawn hollow.

    Raises
    ------
    InputError
        If there is no run.

    Notes
    -----
    The fragment holds times since the start [ms] and, as differences between frames, the poses of all body
    centers [cm, 0.1 mrad] and speeds [cm/s] at 10 Hz. Positions are relative to the ego's first one, which is
    stored too [m]. The camera moves along the route, so lane changes are visible. In a scenario with other
    roads it is fixed. A vehicle that comes later or leaves is hidden while it is not there.
    """
    check_bool("standalone", standalone)
    if not logs:
        raise InputError("logs must hold at least one run")
    views = _views(logs)
    data = json.dumps([_data(*each) for each in zip(logs, views, strict=True)], separators=(",", ":"))
    for sign in "<>&":
        data = data.replace(sign, f"\\u{ord(sign):04x}")
    names = [begin_sentence(label) for label in run_labels(logs)]
    fragment = fill(
        "player.html",
        label=escape(f"{sanitize_text(scenario_name(logs[0].scenario))}: {', '.join(names)}"),
        runs="".join(_run(*each) for each in zip(logs, views, names, strict=True)),
        end=f"{max(log.duration for log in logs):.3f}",
        data=data,
    )
    if not standalone:
        return fragment
    style, script = read_text("player.css"), read_text("player.js")
    return f"<div><style>\n{style}</style>{fragment}<script>\n{script}</script></div>"


def _rows(log: Log) -> "np.ndarray[Any, np.dtype[np.intp]]":
    """Cycles that are stored: the nearest ones to the frame period, and the last."""
    grid = np.arange(log.t[0], log.t[-1], _CAMERA.frame_period)
    return np.unique(np.append(np.searchsorted(log.t, grid - 1e-6), len(log.t) - 1))


def _poses(log: Log) -> Array:
    """Body center, heading and speed of all, the ego first, shape (n, 1 + n_users, 4)."""
    box, _ = log.bodies()
    ego = np.stack((box.x[:, 0], box.y[:, 0], log.ego[:, 2], log.ego[:, 3]), axis=-1)
    # an absent vehicle is hidden where it was last, or where it appears
    users = log.road_users.copy()
    for i, present in enumerate(log.present.T):
        rows = np.maximum.accumulate(np.where(present, np.arange(len(present)), int(present.argmax())))
        users[:, i] = users[rows, i]
    return np.concatenate((ego[:, None], users), axis=1)


def _views(logs: Sequence[Log]) -> list[View]:
    if any(log.scenario.other_roads for log in logs):
        return _fixed_views(logs)
    road = min(max(map(_road_height, logs)), _CAMERA.max_height)
    height = road + 2.0 * _CAMERA.margin
    box = (-_CAMERA.behind * _CAMERA.length, -0.5 * height, _CAMERA.length, height)
    views = []
    for log in logs:
        path, s = log.scenario.road.path, log.ego_frenet[_rows(log), 0]
        camera = np.column_stack((path.position(s), np.unwrap(path.heading(s))))
        views.append(View(camera=camera, box=box, road=road))
    return views


def _fixed_views(logs: Sequence[Log]) -> list[View]:
    """Cameras that stay at the point at which the ego is closest to another vehicle in any run."""
    nearest = min((log for log in logs), key=lambda log: log.gaps().min(initial=np.inf))
    x, y = nearest.ego[int(np.argmin(nearest.gaps().min(axis=1, initial=np.inf))), :2]
    heading = float(logs[0].scenario.road.path.heading(logs[0].ego_frenet[0, 0]))
    width, height = _CAMERA.fixed_size
    box = (-0.5 * width, -0.5 * height, width, height)
    return [View(camera=np.tile((x, y, heading), (len(_rows(log)), 1)), box=box) for log in logs]


def _road_height(log: Log) -> float:
    """Height of a moving view that shows the whole road, curves included [m]."""
    road, height = log.scenario.road, 0.0
    path = road.path
    for s in np.arange(log.ego_frenet[0, 0], log.ego_frenet[-1, 0] + 1.0, 25.0):
        near = s + _CAMERA.length * np.arange(-_CAMERA.behind, 1.0 - _CAMERA.behind, 0.1)
        stations = np.clip(near, path.start, path.end)
        away = path.position(stations) - path.position(s)
        psi = float(path.heading(s))
        across = np.abs(away[:, 1] * np.cos(psi) - away[:, 0] * np.sin(psi)).max()
        height = max(height, 2.0 * (across + max(road.left_edge, -road.right_edge) + 0.5))
    return height


def _data(log: Log, view: View) -> dict[str, Any]:
    """Poses, texts and messages of one run for the script."""
    rows, poses, users = _rows(log), _poses(log), log.scenario.road_users
    poses[:, :, 2] = np.unwrap(poses[:, :, 2], axis=0)
    origin = poses[0, 0, :2].copy()
    poses[:, :, :2] -= origin
    camera = view.camera - (*origin, 0.0)
    known = np.where(log.present, np.where(log.tracked | log.visible, "1", "0"), "-")
    start = float(log.t[0])
    collision = first_collision(log)
    units = np.array([100.0, 100.0, 1e4, 100.0])  # cm, cm, 0.1 mrad, cm/s
    return {
        "origin": origin.round(3).tolist(),
        "names": ["ego", *(sanitize_text(user.id) for user in users)],
        "start": start,
        "road": round(view.road, 2),
        "behind": _CAMERA.behind,
        "sizes": [[log.scenario.vehicle.length, log.scenario.vehicle.width]]
        + [[user.length, user.width] for user in users],
        "t": _steps(1e3 * (log.t[rows] - start)),
        "camera": [_steps(column) for column in (camera * units[:3]).T],
        "bodies": [[_steps(column) for column in (poses[rows, i] * units).T] for i in range(1 + len(users))],
        "known": ["".join(known[rows, i]) for i in range(len(users))],
        "received": _rings(log),
        "actions": [
            [round(t - start, 3), action_words(name), sanitize_text(reason)]
            for t, name, reason in log.decisions
        ],
        "collision": None if collision is None else sanitize_text(str(collision)),
    }


def _steps(values: Array) -> list[int]:
    """Whole numbers as differences, the first from 0."""
    whole = np.rint(values).astype(np.int64)
    steps: list[int] = np.diff(whole, prepend=0).tolist()
    return steps


def _rings(log: Log) -> list[list[int]]:
    """Reception times of the messages of each road user that are shown [ms]."""
    shown: dict[str, list[int]] = {sender_id(i): [] for i in range(len(log.scenario.road_users))}
    for row, data in log.received:
        times = shown.get(decode_bsm(data).id)
        now = round(1e3 * float(log.t[row] - log.t[0]))
        if times is not None and (not times or now - times[-1] >= 1e3 * _CAMERA.ring_period):
            times.append(now)
    return list(shown.values())


def _run(log: Log, view: View, name: str) -> str:
    """One run at its start."""
    origin, users = _poses(log)[0, 0, :2], log.scenario.road_users
    x, y, psi = view.camera[0]
    pulses = '<circle class="pulse"/>' * len(users)
    return fill(
        "player_run.html",
        name=escape(sanitize_text(name)),
        view_box=" ".join(f"{value:g}" for value in view.box),
        transform=f"scale(1 -1) rotate({-np.degrees(psi):.3f}) "
        f"translate({origin[0] - x:.3f} {origin[1] - y:.3f})",
        world=roads_svg(log, origin, (90.0, 180.0)) + pulses,
        bodies=_bodies(log, origin) + _collision(log, origin),
        labels="<text/>" * (1 + len(users)),
        kind="fixed" if log.scenario.other_roads else "moving",
        key=_key(view.box),
    )


def _key(box: tuple[float, float, float, float]) -> str:
    """Legend at the lower border of a view; the script fits it to the window."""
    left, top, width, height = box
    transform = f"translate({left:g} {top + height - 2.0:g}) scale({width / 400.0:g})"
    return fill("player_key.html", transform=transform)


def _bodies(log: Log, origin: Array) -> str:
    users, vehicle = log.scenario.road_users, log.scenario.vehicle
    palette = assign_colors([user.id for user in users])
    bodies = [(vehicle.length, vehicle.width, "car ego", "")]
    bodies += [(u.length, u.width, "car", f' fill="{palette[u.id]}"') for u in users]
    return "".join(
        f'<g class="{kind}" transform="translate({x - origin[0]:.2f} {y - origin[1]:.2f}) '
        f'rotate({np.degrees(psi):.2f})"><rect class="body" x="{-0.5 * length:g}" y="{-0.5 * width:g}" '
        f'width="{length:g}" height="{width:g}" rx=".4"{color}/><rect class="glass" x="{0.1 * length:g}" '
        f'y="{-0.36 * width:g}" width="{0.12 * length:g}" height="{0.72 * width:g}"/></g>'
        for (length, width, kind, color), (x, y, psi, _) in zip(bodies, _poses(log)[0], strict=True)
    )


def _collision(log: Log, origin: Array) -> str:
    collision = first_collision(log)
    if collision is None:
        return ""
    x, y = collision.xy - origin
    return (
        f'<g class="collision" transform="translate({x:.2f} {y:.2f})"><circle r="3.4"/>'
        '<path d="M-1.2 -1.2L1.2 1.2M-1.2 1.2L1.2 -1.2"/></g>'
    )

"""Runs that move: inline SVG seen from above, side by side and in step, nothing from elsewhere."""

import json
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core.errors import InputError
from cca_core.path import Road
from cca_core.plot.player import SCRIPT, STYLE
from cca_core.plot.road_surface import lane_boundaries, offset_line
from cca_core.plot.style import assign_colors, ego_label, sanitize_text, scenario_name
from cca_core.plot.verdict import first_collision
from cca_core.sim import Log
from cca_core.sim.world.radio import sender_id
from cca_core.v2x import decode_bsm

__all__ = ["animate"]

_PERIOD = 0.1  # between two frames that are stored; in between is interpolated [s]
_BEHIND, _AHEAD = 30.0, 90.0  # what a moving view shows of the road [m]
_STILL = 90.0, 56.0  # size of a view that stands [m]
_LEAST, _MOST = 26.0, 60.0  # height of a moving view [m]
_RINGS = 0.5  # least time between two messages of a sender that are shown [s]
_SPAN = 25.0  # between the places at which the height of the view is chosen [m]
_PULSE = '<circle class="pulse"/>'
_ANGLE = 1e4  # stored angles are in 0.1 mrad


def animate(logs: Sequence[Log], *, alone: bool = True) -> str:
    """Show runs from above, side by side and in step.

    Parameters
    ----------
    logs : sequence of Log
        The runs, from left to right; the paper puts the one without V2V left.
    alone : bool
        Whether style and script (`STYLE`, `SCRIPT` of `cca_core.plot.player`) come with it; a page with
        several animations needs them once, the script behind the last.

    Returns
    -------
    fragment : str
        HTML and well-formed XML, for example for ``IPython.display.HTML``. Without a script it shows the
        first moment. Who is unknown to the ego, by messages or by sight, is drawn hollow.

    Raises
    ------
    InputError
        If there is no run.

    Notes
    -----
    Embedded are times [ms] and, as differences from frame to frame, the poses of all bodies' centers [cm,
    0.1 mrad] and speeds [cm/s] at 10 Hz, relative to the ego's first place, whose coordinates [m] are with
    them. The view moves along the route, so that the ego's way across the lanes is seen; a scenario with
    other roads is shown by a view that stands.
    """
    if not logs:
        raise InputError("logs must hold at least one run")
    views = _views(logs)
    embedded = [_data(log, view) for log, view in zip(logs, views, strict=True)]
    data = json.dumps(embedded, separators=(",", ":"))
    for sign in "<>&":
        data = data.replace(sign, f"\\u{ord(sign):04x}")
    figures = "".join(_figure(log, view) for log, view in zip(logs, views, strict=True))
    end = max(float(log.t[-1]) for log in logs)
    label = f"{sanitize_text(scenario_name(logs[0].scenario))}: {', '.join(_name(log) for log in logs)}"
    speeds = "".join(
        f'<option value="{speed}"{chosen}>{speed}×</option>'
        for speed, chosen in (("0.25", ""), ("0.5", ""), ("1", ' selected=""'), ("2", ""), ("4", ""))
    )
    return (
        f"{f'<div><style>{STYLE}</style>' if alone else ''}"
        f'<section class="cca" tabindex="0" role="group" aria-label="{escape(label)}">'
        f'<div class="cca-pair">{figures}</div>'
        '<div class="cca-controls"><button type="button">Play</button>'
        f'<input type="range" min="0" max="{end:.3f}" step="0.02" value="0" '
        'aria-label="Time"/><span class="cca-clock"></span>'
        f'<select aria-label="Speed of the animation">{speeds}</select></div>'
        '<p class="cca-key">Blue: the ego and its way. Hollow: not known to the ego. '
        "Rings: a message arrives.</p>"
        f'<script type="application/json">{data}</script></section>\n'
        f"{f'<script>{SCRIPT}</script></div>' if alone else ''}"
    )


def _name(log: Log) -> str:
    name = ego_label(log)
    return name[0].upper() + name[1:]


def _rows(log: Log) -> "np.ndarray[Any, np.dtype[np.intp]]":
    """Cycles that are stored: the nearest ones to 10 Hz, and the last."""
    grid = np.arange(log.t[0], log.t[-1], _PERIOD)
    return np.unique(np.append(np.searchsorted(log.t, grid - 1e-6), len(log.t) - 1))


def _poses(log: Log) -> Array:
    """Place of the bodies' centers, heading and speed of all, the ego first, shape (n, 1 + n_users, 4)."""
    ego, _ = log.bodies()
    own = np.stack((ego.x[:, 0], ego.y[:, 0], log.ego[:, 2], log.ego[:, 3]), axis=-1)
    return np.concatenate((own[:, None], log.road_users), axis=1)


def _views(logs: Sequence[Log]) -> list[tuple[Array, tuple[float, float, float, float]]]:
    """Camera (x, y, heading) of each stored frame, and view box of each run; the runs share the box."""
    if any(log.scenario.other_roads for log in logs):
        nearest = min((log for log in logs), key=lambda log: log.gaps().min(initial=np.inf))
        x, y = nearest.ego[int(np.argmin(nearest.gaps().min(axis=1, initial=np.inf))), :2]
        turn = float(logs[0].scenario.road.path.heading(logs[0].ego_frenet[0, 0]))
        wide, high = _STILL
        box = (-0.5 * wide, -0.5 * high, wide, high)
        return [(np.tile((x, y, turn), (len(_rows(log)), 1)), box) for log in logs]
    cameras = []
    for log in logs:
        path, s = log.scenario.road.path, log.ego_frenet[_rows(log), 0]
        cameras.append(np.column_stack((path.position(s), np.unwrap(path.heading(s)))))
    high = _LEAST
    for log in logs:
        road = log.scenario.road
        for s in np.arange(log.ego_frenet[0, 0], log.ego_frenet[-1, 0] + 1.0, _SPAN):
            seen = np.clip(np.arange(s - _BEHIND, s + _AHEAD, 10.0), road.path.start, road.path.end)
            away = road.path.position(seen) - road.path.position(s)
            turn = float(road.path.heading(s))
            across = np.abs(away[:, 1] * np.cos(turn) - away[:, 0] * np.sin(turn)).max()
            high = max(high, 2.0 * (across + max(road.left_edge, -road.right_edge) + 2.0))
    high = min(high, _MOST)
    return [(camera, (-_BEHIND, -0.5 * high, _BEHIND + _AHEAD, high)) for camera in cameras]


def _data(log: Log, view: tuple[Array, tuple[float, float, float, float]]) -> dict[str, Any]:
    """Collect what the script needs of one run."""
    rows, poses, users = _rows(log), _poses(log), log.scenario.road_users
    poses[:, :, 2] = np.unwrap(poses[:, :, 2], axis=0)
    origin = poses[0, 0, :2].copy()
    poses[:, :, :2] -= origin
    camera = view[0] - (*origin, 0.0)
    known = log.tracked | log.visible
    hit = first_collision(log)
    return {
        "origin": origin.round(3).tolist(),
        "names": ["ego", *(sanitize_text(user.id) for user in users)],
        "t": _steps(1e3 * log.t[rows]),
        "camera": [_steps(column) for column in (camera * (100.0, 100.0, _ANGLE)).T],
        "bodies": [
            [_steps(column) for column in (poses[rows, i] * (100.0, 100.0, _ANGLE, 100.0)).T]
            for i in range(1 + len(users))
        ],
        "known": ["".join("01"[int(k)] for k in known[rows, i]) for i in range(len(users))],
        "heard": _rings(log),
        "actions": [[round(t, 3), name, sanitize_text(reason)] for t, name, reason in log.decisions],
        "contact": None if hit is None else sanitize_text(str(hit)),
    }


def _steps(values: Array) -> list[int]:
    """Whole numbers as differences, the first from 0."""
    whole = np.rint(values).astype(np.int64)
    steps: list[int] = np.diff(whole, prepend=0).tolist()
    return steps


def _rings(log: Log) -> list[list[int]]:
    """Choose the times of the messages of each road user that are shown [ms]."""
    shown: dict[str, list[int]] = {sender_id(i): [] for i in range(len(log.scenario.road_users))}
    for row, data in log.received:
        times = shown.get(decode_bsm(data).id)
        now = round(1e3 * float(log.t[row]))
        if times is not None and (not times or now - times[-1] >= 1e3 * _RINGS):
            times.append(now)
    return list(shown.values())


def _figure(log: Log, view: tuple[Array, tuple[float, float, float, float]]) -> str:
    """One run at its first moment."""
    camera, (left, top, wide, high) = view
    poses = _poses(log)[0]
    origin = poses[0, :2]
    users, vehicle = log.scenario.road_users, log.scenario.vehicle
    palette = assign_colors([user.id for user in users])
    bodies = [(vehicle.length, vehicle.width, "car ego", "")]
    bodies += [(u.length, u.width, "car", f' fill="{palette[u.id]}"') for u in users]
    cars = "".join(
        f'<g class="{kind}" transform="translate({x - origin[0]:.2f} {y - origin[1]:.2f}) '
        f'rotate({np.degrees(psi):.2f})"><rect class="body" x="{-0.5 * long:g}" y="{-0.5 * wide:g}" '
        f'width="{long:g}" height="{wide:g}" rx=".4"{fill}/><rect class="glass" x="{0.1 * long:g}" '
        f'y="{-0.36 * wide:g}" width="{0.12 * long:g}" height="{0.72 * wide:g}"/></g>'
        for (long, wide, kind, fill), (x, y, psi, _) in zip(bodies, poses, strict=True)
    )
    hit = first_collision(log)
    cross = ""
    if hit is not None:
        x, y = hit.xy[0] - origin[0], hit.xy[1] - origin[1]
        cross = (
            f'<g class="contact" transform="translate({x:.2f} {y:.2f})"><circle r="2.6"/>'
            '<path d="M-1.6 -1.6L1.6 1.6M-1.6 1.6L1.6 -1.6"/></g>'
        )
    x, y, turn = camera[0]
    what = f"{_name(log)}, seen from above"
    return (
        f'<figure class="cca-run"><figcaption>{escape(_name(log))}</figcaption>'
        f'<svg viewBox="{left:g} {top:g} {wide:g} {high:g}" role="img" aria-label="{escape(what)}">'
        f"<title>{escape(what)}</title>"
        f'<g class="world" transform="scale(1 -1) rotate({-np.degrees(turn):.3f}) '
        f'translate({origin[0] - x:.3f} {origin[1] - y:.3f})">'
        f"{_roads(log, origin)}{_PULSE * len(users)}"
        f'<polyline class="trail" points=""/>{cars}{cross}</g>'
        f"{'<text/>' * len(bodies)}</svg>"
        '<p class="cca-state"><b class="cca-now"></b><br/><span class="cca-why"></span></p></figure>'
    )


def _roads(log: Log, origin: Array) -> str:
    scenario = log.scenario
    path = scenario.road.path
    ends = (
        float(log.ego_frenet[:, 0].min()) - _BEHIND - 60.0,
        float(log.ego_frenet[:, 0].max()) + _AHEAD + 60.0,
    )
    own = (max(ends[0], path.start), min(ends[1], path.end))
    roads = [(road, (road.path.start, road.path.end)) for road in scenario.other_roads] + [
        (scenario.road, own)
    ]
    drawn = [part for road, (start, end) in roads for part in _road(road, start, end, origin)]
    drawn.sort(key=lambda part: part[0])
    stop = ""
    if scenario.stop_line is not None:
        lane = scenario.road.ego_lane
        points = path.to_cartesian([scenario.stop_line] * 2, [lane.right, lane.left])
        stop = f'<polyline class="stop" points="{_points(points - origin)}"/>'
    route = offset_line(path, *own, 0.0) - origin
    return "".join(text for _, text in drawn) + f'<polyline class="route" points="{_points(route)}"/>{stop}'


def _road(road: Road, start: float, end: float, origin: Array) -> list[tuple[int, str]]:
    """Edges (level 0), surface (1) and dashes (2) of a road; edges are hidden where another road joins."""
    edges, between = lane_boundaries(road)
    lines = [offset_line(road.path, start, end, d) - origin for d in (*edges, *between)]
    parts = [(1, f'<polygon class="asphalt" points="{_points(np.vstack((lines[0], lines[1][::-1])))}"/>')]
    for line, (level, style) in zip(lines, [(0, "border")] * 2 + [(2, "dashes")] * len(between), strict=True):
        parts.append((level, f'<polyline class="{style}" points="{_points(line)}"/>'))
    return parts


def _points(xy: Array) -> str:
    return " ".join(f"{x:.2f},{y:.2f}" for x, y in xy)

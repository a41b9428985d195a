"""Key frames of a run: times that are worth a picture."""

from dataclasses import dataclass

import numpy as np

from cca_core.decide import Action
from cca_core.plot.labels import gap_words
from cca_core.sim import Log
from cca_core.sim.outcome import first_collision


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyFrame:
    """A time [s] of a run, and what happens in words."""

    t: float
    text: str


def key_frames(
    log: Log, *, max_frames: int = 6, min_spacing: float = 0.3, max_distance: float = 60.0
) -> list[KeyFrame]:
    """Choose times in ascending order, at least `min_spacing` [s] apart."""
    # most important first: a collision; where the ego begins to evade, follow or brake; what others do, and
    # where they are nearest, if within `max_distance` [m]; where the ego goes back to its lane; the end
    ranked: list[tuple[int, KeyFrame]] = []
    for t, name, reason in log.decisions[1:]:
        ranked.append((2 if name == Action.KEEP.value else 0, KeyFrame(t=t, text=f"{name}: {reason}")))
    ranked += [(1, frame) for frame in _encounters(log, max_distance) + _actions_of_others(log)]
    collision, t_end = first_collision(log), float(log.t[-1])
    if collision is not None:
        text = "the run ends in a collision" if collision.t == t_end else str(collision)
        ranked.append((-1, KeyFrame(t=collision.t, text=text)))
    if collision is None or collision.t < t_end:
        ranked.append((3, KeyFrame(t=t_end, text="the run ends")))
    ranked.sort(key=lambda entry: (entry[0], -entry[1].t if entry[0] == 2 else entry[1].t))
    chosen: list[KeyFrame] = []
    for _, frame in ranked:
        if len(chosen) < max_frames and all(abs(frame.t - other.t) >= min_spacing for other in chosen):
            chosen.append(frame)
    return sorted(chosen, key=lambda frame: frame.t)


def _encounters(log: Log, max_distance: float) -> list[KeyFrame]:
    """Where the ego is alongside or closest to each road user."""
    frames, gaps = [], log.gaps()
    for i, user in enumerate(log.scenario.road_users):
        distance = np.hypot(*(log.road_users[:, i, :2] - log.ego[:, :2]).T)
        distance[~log.present[:, i]] = np.inf
        row = int(np.argmin(distance))
        if distance[row] < max_distance and 0 < row < len(log.t) - 1:
            alongside = abs(log.user_frenet[row, i, 0] - log.ego_frenet[row, 0]) < user.length
            text = f"{'alongside' if alongside else 'closest to'} {user.id}, gap {gap_words(gaps[row, i])}"
            frames.append(KeyFrame(t=float(log.t[row]), text=text))
    return frames


def _actions_of_others(log: Log) -> list[KeyFrame]:
    texts = {"brakes": "brakes", "lateral_shift": "moves laterally"}
    return [
        KeyFrame(t=t, text=f"{id_} {texts[kind]}")
        for t, kind, id_ in log.events
        if id_ != "ego" and kind in texts
    ]

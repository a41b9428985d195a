"""Points of a stationary or creeping receiver."""

import numpy as np

from cca_core._checks import Array, Mask

__all__ = ["slow_rows", "thinned"]

_SLOW = 0.5  # speed of a stationary receiver, with the drift of its position [m/s]
_TIME = 5.0  # over which the speed is taken, before and after a row [s]
_WIDTH = 5  # points of a window that is checked for jitter


def slow_rows(points: Array, t: Array) -> Mask:
    """Find the rows at which the receiver was slower than a pedestrian."""
    order = np.maximum.accumulate(t)  # clocks may step back
    first = np.searchsorted(order, order - _TIME).clip(0, len(t) - 1)
    last = (np.searchsorted(order, order + _TIME, side="right") - 1).clip(0, len(t) - 1)
    span = order[last] - order[first]
    moved = np.hypot(*(points[last] - points[first]).T)
    slow: Mask = (span > 0.0) & (moved < _SLOW * span)
    return slow


def thinned(points: Array, slow: Mask) -> Mask:
    """Find which points stay: of a stationary receiver, one for each position."""
    still = slow | _jitters(points)
    kept = np.ones(len(points), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False])).astype(int)))
    for first, end in edges.reshape(-1, 2).tolist():
        run = points[first:end]
        if len(run) < 2:
            continue
        kept[first:end] = False
        reach = 3.0 * float(np.median(np.hypot(*np.diff(run, axis=0).T)))
        begin = 0
        while begin < len(run):
            off = np.hypot(*(run[begin:] - run[begin]).T) > max(reach, 1e-9)
            stop = begin + (int(np.argmax(off)) if off.any() else len(off))
            group = run[begin:stop]
            middle = np.median(group, axis=0)
            kept[first + begin + int(np.argmin(np.hypot(*(group - middle).T)))] = True
            begin = stop
    return kept


def _jitters(points: Array) -> Mask:
    """Find points of windows without progress, with sharp turns to both sides, even without any one point."""
    n = len(points) - _WIDTH + 1
    found = np.zeros(len(points), dtype=bool)
    if n < 1:
        return found
    window = points[np.arange(n)[:, None] + np.arange(_WIDTH)]
    jitter = _leads_nowhere(window)
    for k in range(1, _WIDTH - 1):
        jitter &= _is_long(np.delete(window, k, axis=1))
    for k in range(_WIDTH):
        found[k : k + n] |= jitter
    return found


def _leads_nowhere(window: Array) -> Mask:
    """Return which windows are long and turn sharply to both sides."""
    steps = np.diff(window, axis=1)
    cross = steps[:, :-1, 0] * steps[:, 1:, 1] - steps[:, :-1, 1] * steps[:, 1:, 0]
    turn = np.arctan2(cross, (steps[:, :-1] * steps[:, 1:]).sum(axis=-1))
    turned = np.abs(turn).sum(axis=1)
    sharp = turned > turn.shape[1] * np.radians(60.0)
    nowhere: Mask = _is_long(window) & sharp & (np.abs(turn.sum(axis=1)) < 0.6 * turned)
    return nowhere


def _is_long(window: Array) -> Mask:
    """Return whether the points of windows cover twice the distance between the first and the last."""
    steps = np.diff(window, axis=1)
    net = window[:, -1] - window[:, 0]
    far: Mask = np.hypot(steps[..., 0], steps[..., 1]).sum(axis=1) > 2.0 * np.hypot(net[:, 0], net[:, 1])
    return far

"""Conflicts of a path with vehicles that cross the route: where and when their ways overlap."""

import math

from cca_core.kernel.box_gaps import norm, oriented_box_gap
from cca_core.kernel.gap_checks import pose
from cca_core.kernel.scene import Scene, at_station, lateral, slope
from cca_core.kernel.types import Int, Real

__all__ = ["find_conflicts"]

BLOCK = 8  # stations that are looked at together
SKIPPED = 1e-9  # [s]


def set_blocks(w: Scene, p: Int, reach: Int) -> Int:
    """Place the ego's body at stations ahead on a path; return the number of their blocks."""
    blocks = 0
    first = 0
    for i in range(reach):
        at = w.s_0 + i
        d = lateral(w, p, at)
        w.x_p[i], w.y_p[i], w.c_p[i], w.s_p[i] = pose(w, at, d, slope(w, p, at))
        if i == first:
            w.x_b[blocks] = at_station(w.n, w.x, at + 0.5 * BLOCK)
            w.y_b[blocks] = at_station(w.n, w.y, at + 0.5 * BLOCK)
            w.r_b[blocks] = 0.0
        x = w.x_p[i] - w.x_b[blocks]
        y = w.y_p[i] - w.y_b[blocks]
        w.r_b[blocks] = max(w.r_b[blocks], norm(x, y))
        if i == first + BLOCK - 1:
            blocks += 1
            first = i + 1
    return blocks if first == reach else blocks + 1


def add_conflict(w: Scene, j: Int, k: Int, first: Int, last: Int, c: Real, s: Real, margin: Real) -> None:
    """Extend the conflict of a vehicle by the stations over which it is at a step."""
    for i in range(first, last):
        at = w.s_0 + i
        if w.s_enter[j] <= at <= w.s_exit[j] and w.t_enter[j] <= w.t[k] <= w.t_exit[j]:
            continue
        gap = oriented_box_gap(
            w.x_o[j, k] - w.x_p[i], w.y_o[j, k] - w.y_p[i], w.c_p[i], w.s_p[i], c, s, w.half_length,
            w.half_width, w.half_l[j], w.half_w[j],
        )  # fmt: skip
        if gap < margin:
            w.s_enter[j] = min(w.s_enter[j], at)
            w.s_exit[j] = max(w.s_exit[j], at)
            w.t_enter[j] = min(w.t_enter[j], w.t[k])
            w.t_exit[j] = max(w.t_exit[j], w.t[k])


def find_conflicts(w: Scene, p: Int, reach: Int, margin: Real) -> None:
    """Find the stations of a path that each crossing vehicle passes over, and when; infinite if none."""
    blocks = set_blocks(w, p, reach)
    for j in range(w.m):
        w.s_enter[j] = math.inf
        w.s_exit[j] = -math.inf
        w.t_enter[j] = math.inf
        w.t_exit[j] = -math.inf
        if w.crosses[j] == 0:
            continue
        size = w.half_l[j] + w.half_w[j] + w.half_length + w.half_width + margin
        for b in range(blocks):
            free_until = -math.inf
            for k in range(w.steps):
                if w.t[k] < free_until:
                    continue
                away = norm(w.x_o[j, k] - w.x_b[b], w.y_o[j, k] - w.y_b[b]) - w.r_b[b] - size
                if away > 0.0:  # nor is it there before it has driven so far
                    free_until = w.t[k] + away / max(w.v_o[j, 0], 0.1) - SKIPPED
                    continue
                c = math.cos(w.psi_o[j, k])
                s = math.sin(w.psi_o[j, k])
                add_conflict(w, j, k, BLOCK * b, min(BLOCK * b + BLOCK, reach), c, s, margin)

"""Boxes of the obstacles: their places at each node, headings, radii and steps."""

import math

from cca_core.kernel.band_workspace import BandBatch, BandWork
from cca_core.kernel.box_gaps import norm
from cca_core.kernel.types import Flag, Int


def are_equal(q: BandBatch, first: Int, next_quantity: Int) -> Flag:
    """Return whether the boxes of an obstacle of a band are the same at all nodes."""
    boxes = q.boxes
    for k in range(5):
        at = first + k * next_quantity
        value = boxes[at]
        for i in range(at + 1, at + q.n):
            if boxes[i] != value:
                return False
    return True


def node_of(w: BandWork, o: Int, i: Int) -> Int:
    """Return the node at which the box of a node is kept: the first one has that of a fixed obstacle."""
    return 0 if w.is_fixed[o] != 0 else i


def load_boxes(q: BandBatch, b: Int, w: BandWork, o: Int) -> None:
    """Copy the boxes of an obstacle, with headings, radii and largest step; check their numbers."""
    boxes = q.boxes
    at = (o * q.bands + b) * q.max_n  # of each quantity
    next_quantity = w.m * q.bands * q.max_n
    x = 0.0
    y = 0.0
    psi = 0.0
    half_length = 0.0
    half_width = 0.0
    ahead_x = 0.0
    ahead_y = 0.0
    radius = 0.0
    fixed = are_equal(q, at, next_quantity)
    w.is_fixed[o] = 1 if fixed else 0
    w.max_step[o] = 0.0
    w.max_radius[o] = 0.0
    for i in range(1 if fixed else w.n):
        last_x = x
        last_y = y
        x = boxes[at]
        y = boxes[at + next_quantity]
        new_psi = boxes[at + 2 * next_quantity]
        new_length = 0.5 * boxes[at + 3 * next_quantity]
        new_width = 0.5 * boxes[at + 4 * next_quantity]
        at += 1
        moves = i == 0 or x != last_x or y != last_y
        turns = i == 0 or new_psi != psi
        resizes = i == 0 or new_length != half_length or new_width != half_width
        turn = 0.0
        if moves and not (abs(x) < math.inf and abs(y) < math.inf):
            w.has_valid_boxes = False
        if resizes:
            half_length = new_length
            half_width = new_width
            radius = norm(half_length, half_width)
            w.max_radius[o] = max(w.max_radius[o], radius)
            if not (0.0 <= half_length < math.inf and 0.0 <= half_width < math.inf):
                w.has_valid_boxes = False
        if turns:
            psi = new_psi
            if not abs(psi) < math.inf:
                w.has_valid_boxes = False
                return
            new_x = math.cos(psi)
            new_y = math.sin(psi)
            turn = norm(new_x - ahead_x, new_y - ahead_y)
            ahead_x = new_x
            ahead_y = new_y
        if i > 0 and (moves or turns or resizes):
            w.max_step[o] = max(w.max_step[o], norm(x - last_x, y - last_y) + turn * radius)
        w.box_x[o, i] = x
        w.box_y[o, i] = y
        w.half_length[o, i] = half_length
        w.half_width[o, i] = half_width
        w.box_ahead_x[o, i] = ahead_x
        w.box_ahead_y[o, i] = ahead_y
        w.radius[o, i] = radius

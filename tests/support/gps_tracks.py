"""Tracks of the kinds that public logs contain, with the faults of ordinary receivers."""

import math

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


def winding(n: int, spacing: float, radius: float) -> Points:
    """A winding road of a least radius."""
    s = spacing * np.arange(n)
    psi = np.cumsum(np.sin(2.0 * math.pi * s / 700.0)) * spacing / radius
    return np.column_stack((np.cumsum(np.cos(psi)), np.cumsum(np.sin(psi)))) * spacing


def ordinary_receiver(seed: int) -> Points:
    """A winding road of least radius 111 m: noise of 1 m, duplicates, gaps and one outlier of 4 m."""
    rng = np.random.default_rng(seed)
    xy = winding(300, 8.0, 111.0) + rng.normal(0.0, 1.0, (300, 2))
    bearing = rng.uniform(0.0, 2.0 * math.pi)
    xy[int(rng.integers(20, 280))] += 4.0 * np.array([math.cos(bearing), math.sin(bearing)])
    kept = np.ones(300, dtype=bool)
    for first in rng.integers(20, 270, 2):
        kept[first : first + 5] = False
    xy = xy[kept]
    rows = np.sort(rng.integers(5, len(xy) - 5, 3))
    return np.insert(xy, rows, xy[rows], axis=0)


def along(corners: list[tuple[float, float]], spacing: float, rounding: float = 0.0) -> Points:
    """Points along a polyline, whose corners may be cut by a moving mean."""
    xy = np.array(corners, dtype=np.float64)
    s = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))))
    fine = np.arange(0.0, s[-1], 0.5)
    dense = np.column_stack([np.interp(fine, s, xy[:, k]) for k in (0, 1)])
    width = max(1, round(rounding / 0.5)) | 1
    if width > 1:
        pad = width // 2
        padded = np.vstack((np.repeat(dense[:1], pad, axis=0), dense, np.repeat(dense[-1:], pad, axis=0)))
        kernel = np.ones(width) / width
        dense = np.column_stack([np.convolve(padded[:, k], kernel, "valid") for k in (0, 1)])
    return dense[:: max(1, round(spacing / 0.5))]


def _arc(x: float, y: float, radius: float, start: float, end: float, spacing: float) -> Points:
    phi = np.linspace(start, end, max(3, math.ceil(abs(end - start) * radius / spacing)))
    return np.column_stack((x + radius * np.cos(phi), y + radius * np.sin(phi)))


def u_turn(rng: np.random.Generator) -> Points:
    """Out and back on the other side of the street, 4 m apart."""
    return along([(0.0, 0.0), (300.0, 0.0), (300.0, 4.0), (0.0, 4.0)], float(rng.uniform(4.0, 12.0)))


def out_and_back(rng: np.random.Generator) -> Points:
    """A winding road, a turn in a lot of radius 9 m, and the same road back."""
    out = winding(60, 8.0, 120.0)
    psi = math.atan2(*(out[-1] - out[-2])[::-1])
    turn = _arc(0.0, 9.0, 9.0, -0.5 * math.pi, 0.5 * math.pi + 1.0, 4.0)
    rotation = np.array([[math.cos(psi), math.sin(psi)], [-math.sin(psi), math.cos(psi)]])
    back = out[::-1] + np.array([-math.sin(psi), math.cos(psi)]) * 3.5
    return np.vstack((out, out[-1] + np.array([8.0, 0.0]) @ rotation + turn[:-2] @ rotation, back[2:]))


def laps(rng: np.random.Generator) -> Points:
    """Three laps of a circuit."""
    phi = np.arange(0.0, 6.0 * math.pi, float(rng.uniform(0.05, 0.12)))
    return np.column_stack((90.0 * np.sin(phi), 50.0 * np.cos(phi) + 15.0 * np.cos(2.0 * phi)))


def lights(rng: np.random.Generator) -> Points:
    """A street with two stops of a minute, where the receiver wanders by 2 m."""
    street = along([(0.0, 0.0), (150.0, 0.0), (300.0, 40.0), (500.0, 40.0)], 9.0, 40.0)
    first, second = 15, 35
    stops = [street[i] + rng.normal(0.0, 2.0, (60, 2)) for i in (first, second)]
    return np.vstack((street[:first], stops[0], street[first:second], stops[1], street[second:]))


def tunnel(rng: np.random.Generator) -> Points:
    """A road without fixes for 200 m, twice."""
    xy = winding(150, 8.0, 200.0)
    return np.vstack((xy[:40], xy[65:100], xy[125:]))


def parking_lot(rng: np.random.Generator) -> Points:
    """A street, the aisles of a lot at walking speed, and the street again."""
    return along(
        [(0, 0), (100, 0), (100, 30), (140, 30), (140, 45), (100, 45), (100, 60), (200, 60), (300, 60)],
        float(rng.uniform(2.0, 4.0)), 8.0,
    )  # fmt: skip


def grid(rng: np.random.Generator) -> Points:
    """City blocks with right angles."""
    corners = [(0, 0), (120, 0), (120, 90), (240, 90), (240, -60), (360, -60), (360, 90), (500, 90)]
    return along(corners, float(rng.uniform(5.0, 12.0)), float(rng.choice([0.0, 10.0])))


def hairpins(rng: np.random.Generator) -> Points:
    """A mountain road with hairpins of radius 9 m."""
    parts, y = [], 0.0
    for k in range(5):
        x = np.arange(0.0, 120.0, 6.0)
        leg = np.column_stack((x if k % 2 == 0 else 120.0 - x, 0.0 * x + y))
        side = 1.0 if k % 2 == 0 else -1.0
        curve = _arc(0.0, 0.0, 9.0, -0.5 * math.pi, 0.5 * math.pi, 4.0)[1:-1] * np.array([side, 1.0])
        parts += [leg, curve + np.array([120.0 if k % 2 == 0 else 0.0, y + 9.0])]
        y += 18.0
    return np.vstack(parts)


def creeping(rng: np.random.Generator) -> Points:
    """A jam: half a meter between fixes for 60 m of a street."""
    street = along([(0.0, 0.0), (300.0, 0.0)], 8.0)
    jam = np.column_stack((np.arange(120.0, 180.0, 0.5), np.zeros(120)))
    return np.vstack((street[street[:, 0] < 120.0], jam, street[street[:, 0] > 180.0]))


def out_and_back_on_one_line(rng: np.random.Generator) -> Points:
    """A street with two dead ends, out and back on the same line."""
    corners = [(0, 0), (150, 0), (150, 80), (150, 0), (300, 0), (300, -60), (300, 0), (420, 0)]
    return along(corners, float(rng.uniform(4.0, 9.0)))


def zig_zags(rng: np.random.Generator) -> Points:
    """A steep footpath with turns under the turning circle of a car."""
    legs = [(60.0 + 14.0 * (k % 2), 5.0 * k) for k in range(9)]
    return along([(0, 0), *legs, (60, 60), (200, 60)], 3.0)


def sparse_corners(rng: np.random.Generator) -> Points:
    """A route as a planner stores it: corners alone, 60 to 300 m apart."""
    steps = rng.uniform(60.0, 300.0, 30)
    psi = np.cumsum(rng.choice([-1.0, 0.0, 1.0], 30) * rng.uniform(0.3, 1.5, 30))
    return np.cumsum(steps[:, None] * np.column_stack((np.cos(psi), np.sin(psi))), axis=0)


KINDS = {
    kind.__name__: kind
    for kind in (
        u_turn,
        out_and_back,
        laps,
        lights,
        tunnel,
        parking_lot,
        grid,
        hairpins,
        creeping,
        out_and_back_on_one_line,
        zig_zags,
        sparse_corners,
    )
}


def recorded(kind: str, seed: int, noise: float) -> Points:
    """A track of a kind as a receiver with white noise records it."""
    rng = np.random.default_rng(seed)
    xy = KINDS[kind](rng)
    return xy + rng.normal(0.0, noise, xy.shape)

"""Random cases for `relax_band`: roads, traffic on them, edges and limits."""

import math
import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path as FilePath
from typing import Any, Literal

import numpy as np

from cca_core.geometry import Boxes, box_gap, boxes
from cca_core.path import LocalFrame, Path, Waypoints, clean_route, fit_path, read_waypoints
from cca_core.sim import demo_route
from cca_core.vehicle import VehicleParams
from tests.support.band_measure import curve_through, left_of, peak_curvature, poses, stations

Array = np.ndarray[Any, np.dtype[np.float64]]
Kind = Literal["straight", "curved", "recorded"]

KINDS: tuple[Kind, ...] = ("straight", "curved", "recorded")
LANE = 3.5  # [m]
TIGHTEST = 40.0  # radius of a recorded road [m]
TRIES = 30  # for an obstacle clear of the pinned ends
SIZES = ((3.9, 1.7), (4.5, 1.8), (4.9, 1.95), (6.0, 2.1), (8.0, 2.45), (12.0, 2.55))  # [m]
MOTORWAY = ((700, 900), (1500, 1700), (4000, 4200), (8000, 8200))  # rows of the recorded file


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """Arguments of `relax_band`: obstacles, edges of the road and limits along a stretch of a route."""

    nodes: Array
    obstacles: list[Boxes]
    corridor: tuple[Array, Array]
    curvature_limit: Array
    clearance: float
    vehicle: VehicleParams
    kind: Kind


def case(rng: np.random.Generator, count: int, kind: Kind | None = None) -> Case:
    """Sample a case with so many obstacles; its obstacles have one box per node."""
    vehicle = VehicleParams.bmw_320i()
    kind = kind or KINDS[rng.choice(3, p=(0.3, 0.4, 0.3))]
    spacing = float(rng.choice((0.5, 1.0, 2.0), p=(0.12, 0.76, 0.12)))
    fewest = 60 + 6 * count if spacing >= 1.0 else 110
    n = int(rng.integers(fewest, max(fewest + 1, min(141, 68 + 15 * count))))
    nodes = _route(rng, kind, n, spacing)
    slowest = 12.0 if count < 4 else 8.0
    speed = float(rng.uniform(slowest, 8.0 + min(22.0, 0.28 * spacing * n)))
    clearance = float(rng.uniform(0.2, 1.0))
    corridor = _corridor(rng, n, 0.8 if count < 4 else 0.6, vehicle)
    strict = rng.random() > 0.03
    obstacles: list[Boxes] = []
    for passage in _passages(rng, count):
        for _ in range(TRIES):
            obstacle = _obstacle(rng, nodes, spacing, speed, passage)
            if not strict or _leaves_ends(nodes, obstacle, vehicle, clearance):
                break
        obstacles.append(obstacle)
    limit = min(0.15, float(rng.uniform(3.0, 7.0)) / speed**2)
    limits = np.asarray(limit)
    if rng.random() < 0.3:  # another speed farther on
        limits = limit * np.interp(np.arange(n), (0.3 * n, 0.7 * n), (1.0, rng.uniform(0.6, 1.5)))
    return Case(
        nodes=nodes,
        obstacles=obstacles,
        corridor=corridor,
        curvature_limit=np.clip(limits, 1.3 * peak_curvature(nodes) + 0.002, 0.15),
        clearance=clearance,
        vehicle=vehicle,
        kind=kind,
    )


def _route(rng: np.random.Generator, kind: Kind, n: int, spacing: float) -> Array:
    """Nodes of a stretch of road, turned and moved at random."""
    if kind == "recorded":
        roads = _recorded()
        while True:
            path = roads[-1 if rng.random() < 0.5 else int(rng.integers(len(roads)))]
            s = rng.uniform(path.start, path.end - n * spacing) + spacing * np.arange(n)
            if np.abs(path.curvature(s)).max() < 1.0 / TIGHTEST:
                return path.position(s)
    turn, fine = rng.uniform(-math.pi, math.pi), 20
    s = np.arange((n - 1) * fine + 1) * spacing / fine
    kappa = np.zeros_like(s)
    if kind != "straight":
        ends = rng.choice((-1.0, 1.0)) / np.exp(rng.uniform(math.log(60.0), math.log(1000.0), 2))
        shape = rng.choice(("arc", "clothoid", "s"))
        if shape == "arc":
            kappa = np.full_like(s, ends[0])
        elif shape == "clothoid":
            kappa = np.interp(s, s[[0, -1]], ends * rng.choice((0.0, 1.0), 2))
        else:
            kappa = ends[0] * np.sin(2.0 * math.pi * (s / s[-1] * rng.uniform(0.5, 1.5) + rng.random()))
    psi = turn + np.concatenate(([0.0], np.cumsum(0.5 * (kappa[1:] + kappa[:-1]) * np.diff(s))))
    middle = 0.5 * (psi[1:] + psi[:-1])
    steps = np.column_stack((np.cos(middle), np.sin(middle))) * np.diff(s)[:, None]
    xy = np.vstack((np.zeros(2), np.cumsum(steps, axis=0)))[::fine]
    return xy + rng.uniform(-500.0, 500.0, 2)


@cache
def _recorded() -> list[Path]:
    """Recorded roads, the most curved last; without the data, the demo road."""
    root = FilePath(__file__).resolve().parents[3]
    folder = FilePath(os.environ.get("CCA_DATA_DIR", root / "shared" / "data")) / "gps"
    tables = [demo_route()]
    if folder.is_dir():
        motorway = read_waypoints(folder / "I_80_Eastbound_Vertices.csv")
        tables += [Waypoints(lat=motorway.lat[a:b], lon=motorway.lon[a:b], duplicates=0) for a, b in MOTORWAY]
        tables.append(read_waypoints(folder / "around-visnjan-with-car.gpx"))
    roads = []
    for table in tables:
        xy = LocalFrame(table.lat[0], table.lon[0]).to_local(table.lat, table.lon)
        part = max(clean_route(xy).parts, key=len)
        roads.append(fit_path(part, tolerance=0.5))
    return roads


def _corridor(rng: np.random.Generator, n: int, narrow: float, vehicle: VehicleParams) -> tuple[Array, Array]:
    """Edges of two (their fraction: narrow) or three lanes, the ego in any; some narrow farther on."""
    lanes, shoulder = int(rng.choice((2, 3), p=(narrow, 1.0 - narrow))), rng.uniform(0.0, 0.6, 2)
    own = int(rng.integers(lanes))
    right = np.full(n, -(own + 0.5) * LANE - shoulder[0])
    left = np.full(n, (lanes - own - 0.5) * LANE + shoulder[1])
    if rng.random() < 0.3:
        first = rng.uniform(0.1, 0.7) * n
        ramp = np.interp(np.arange(n), (first, first + rng.uniform(0.1, 0.4) * n), (0.0, 1.0))
        if rng.random() < 0.5:
            right = right + rng.uniform(0.3, 2.0) * ramp
        else:
            left = left - rng.uniform(0.3, 2.0) * ramp
    margin = 0.5 * vehicle.width + 0.3
    return np.minimum(right, -margin), np.maximum(left, margin)


def _passages(rng: np.random.Generator, count: int) -> list[tuple[float, float]]:
    """Fraction of the route at which the ego passes each obstacle, and its lateral offset [m]."""
    fractions = (np.arange(count) + rng.uniform(0.1, 0.9, count)) / count
    if rng.random() < 0.3:
        fractions = np.sort(rng.random(count))
    lateral = rng.uniform(-4.5, 4.5, count) * (0.5 if count < 3 else 1.0)
    if rng.random() < 0.5:  # traffic keeps to one side
        lateral = np.abs(lateral) * rng.choice((-1.0, 1.0))
    return [(float(0.28 + 0.44 * a), float(b)) for a, b in zip(fractions, lateral, strict=True)]


def _obstacle(
    rng: np.random.Generator, nodes: Array, spacing: float, speed: float, passage: tuple[float, float]
) -> Boxes:
    """A vehicle of constant velocity that the ego passes at about that position."""
    n = len(nodes)
    fraction = float(np.clip(passage[0] + rng.uniform(-0.06, 0.06), 0.2, 0.8))
    met = fraction * (n - 1)
    curve = curve_through(nodes)
    at = float(np.interp(met, np.arange(n), stations(nodes)))
    t = curve(at, 1)
    psi = math.atan2(t[1], t[0])
    lateral = float(np.clip(passage[1] + rng.uniform(-0.3, 0.3), -4.5, 4.5))
    point = curve(at) + lateral * left_of(t[None, :] / np.hypot(*t))[0]
    length, width = SIZES[int(rng.choice(len(SIZES), p=(0.25, 0.3, 0.2, 0.1, 0.1, 0.05)))]
    heading = psi + rng.uniform(-0.2, 0.2) * (rng.random() < 0.7)
    motion = rng.choice(("stands", "ahead", "oncoming", "crosses"), p=(0.45, 0.2, 0.2, 0.15))
    if motion == "oncoming":
        heading += math.pi
    velocity = rng.uniform(0.1, 0.7) * speed * np.array((math.cos(heading), math.sin(heading)))
    if motion == "ahead":
        velocity *= 0.6
    elif motion == "crosses":
        across = rng.choice((-1.0, 1.0)) * rng.uniform(0.3, 2.0)
        velocity = across * np.array((-math.sin(psi), math.cos(psi)))
        if rng.random() < 0.3:
            heading = math.atan2(velocity[1], velocity[0])
    elif motion == "stands":
        velocity = np.zeros(2)
    x, y = (point + np.outer((np.arange(n) - met) * spacing / speed, velocity)).T
    return boxes(x, y, np.full(n, heading), np.full(n, length), np.full(n, width))


def _leaves_ends(nodes: Array, obstacle: Boxes, vehicle: VehicleParams, clearance: float) -> bool:
    """Whether the pinned ends are clear of the obstacle."""
    ends = np.array((0, 1, 2, 3, -4, -3, -2, -1))
    x, y, psi = poses(nodes, np.arange(len(nodes), dtype=float), vehicle)[ends, :3].T
    ego = boxes(x, y, psi, vehicle.length, vehicle.width)
    there = Boxes(*(f[ends] for f in (obstacle.x, obstacle.y, obstacle.psi, obstacle.length, obstacle.width)))
    return bool(box_gap(ego, there).min() > clearance + 0.1)

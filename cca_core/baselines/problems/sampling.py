"""Random planning problems, each with a plan that proves it solvable, and blocked ones."""

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from cca_core._checks import Array
from cca_core._repr import short_repr
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.errors import InputError, Status
from cca_core.geometry import QUINTIC_PEAK, quintic_step
from cca_core.path import Lane, Path, Road, interpolate_path
from cca_core.vehicle import RemoteVehicle, VehicleParams

Kind = Literal["one car", "slalom", "curve", "moving", "narrow gap", "blocked"]
"""Kind of the obstacles."""

KINDS: tuple[Kind, ...] = get_args(Kind)
"""All kinds."""

Gate = tuple[float, float, float]  # first and last station with this lateral offset of the proof [m]
Car = tuple[float, float, float]  # station, lateral offset [m], speed along the road [m/s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledProblem:
    """A random problem with its seed and its proof.

    Parameters
    ----------
    kind : str
        Kind of the obstacles.
    seed : int
        Seed of the random numbers.
    problem : Problem
        The problem.
    proof : Plan or None
        A plan that keeps all limits; None if the problem is blocked.
    """

    kind: Kind
    seed: int
    problem: Problem
    proof: Plan | None

    __repr__ = short_repr


@dataclass(frozen=True, slots=True, kw_only=True)
class SamplingSettings:
    """Vehicles, road and limits that all sampled problems have in common.

    Parameters
    ----------
    ego : VehicleParams
        The ego.
    length, width : float
        Size of the other vehicles [m].
    lane_width : float
        Width of both lanes [m].
    clearance : float
        Smallest distance allowed between the bodies [m].
    a_y_max : float
        Largest lateral acceleration [m/s^2].
    extra_clearance : float
        Clearance that the proof keeps in addition [m].
    turned_length : float
        Extra length along the road of a body that is turned in a shift [m].
    a_y_fraction : tuple of float
        Smallest and largest fraction of `a_y_max` that the proof uses [-].
    run_out : float
        Length of the road beyond the goal [m].
    """

    ego: VehicleParams = field(default_factory=VehicleParams.bmw_320i)
    length: float = 4.5
    width: float = 1.8
    lane_width: float = 3.5
    clearance: float = 0.3
    a_y_max: float = 4.0
    extra_clearance: float = 0.05
    turned_length: float = 0.3
    a_y_fraction: tuple[float, float] = (0.5, 0.85)
    run_out: float = 150.0

    __repr__ = short_repr

    @property
    def center_distance(self) -> float:
        """Lateral distance of the centers at the clearance [m]."""
        return 0.5 * (self.ego.width + self.width) + self.clearance

    @property
    def overlap_length(self) -> float:
        """Longitudinal distance of the centers below which the bodies are alongside [m]."""
        return 0.5 * (self.ego.length + self.length) + self.clearance + self.turned_length


def sample_problem(kind: Kind, seed: int, settings: SamplingSettings | None = None) -> SampledProblem:
    """Sample a problem.

    Parameters
    ----------
    kind : {"one car", "slalom", "curve", "moving", "narrow gap", "blocked"}
        Obstacles: one stationary car; three stationary cars to be passed left, right and left; one
        stationary car on a curve; a slower car, and a second one, oncoming in half of the problems; two
        stationary cars with a gap between them; or a blocked road: a wall of cars, a car too close, or a
        stationary car that the ego reaches together with an oncoming one.
    seed : int
        Seed of the ego's speed and of the positions and speeds of the other vehicles.
    settings : SamplingSettings, optional
        Vehicles, road and limits.

    Returns
    -------
    sampled : SampledProblem
        Equal seeds give equal problems.

    Raises
    ------
    InputError
        If the kind is unknown.

    Notes
    -----
    Two lanes of 3.5 m, the ego on the right one at 14 to 22 m/s. The proof is a sequence of quintic shifts
    that uses 50 to 85 % of the lateral acceleration allowed, which bounds the difficulty.
    """
    if kind not in KINDS:
        raise InputError(f"kind must be one of {', '.join(KINDS)}, was {kind!r}")
    own = settings or SamplingSettings()
    rng = np.random.default_rng([KINDS.index(kind), seed])
    v = rng.uniform(15.0, 22.0)
    if kind == "curve":
        radius = float(rng.uniform(200.0, 400.0) * rng.choice((-1.0, 1.0)))
        v = rng.uniform(14.0, 18.0)
        return _with_proof(own, kind, seed, v, *_one(own, rng, v, v * v / abs(radius)), radius)
    if kind == "blocked":
        cars, goal = (_wall, _too_close, _meeting)[seed % 3](own, rng, v)
        problem = _problem(own, kind, v, cars, goal, math.inf, solvable=False)
        return SampledProblem(kind=kind, seed=seed, problem=problem, proof=None)
    make = {"one car": _one, "slalom": _slalom, "moving": _moving, "narrow gap": _gap}[kind]
    return _with_proof(own, kind, seed, v, *make(own, rng, v), math.inf)


def parked(cars: int, length: float, *, v_x: float = 20.0) -> Problem:
    """Straight road with evenly spaced parked cars, in turn on the ego lane and on the left lane."""
    own = SamplingSettings()
    stations = np.linspace(0.0, length, cars + 2)[1:-1]
    stationary = [(float(s), own.lane_width * (i % 2), 0.0) for i, s in enumerate(stations)]
    return _problem(own, "parked", v_x, stationary, length, math.inf, solvable=True)


def _shift_length(
    own: SamplingSettings, rng: np.random.Generator, v: float, offset: float, a_y_used: float = 0.0
) -> float:
    """Length of a quintic shift at a random fraction of the remaining lateral acceleration [m]."""
    a_y = rng.uniform(*own.a_y_fraction) * (own.a_y_max - a_y_used)
    return v * math.sqrt(QUINTIC_PEAK * max(abs(offset), 0.3) / a_y)


def _one(
    own: SamplingSettings, rng: np.random.Generator, v: float, a_y_used: float = 0.0
) -> tuple[list[Car], list[Gate], float]:
    """One stationary car."""
    d = rng.uniform(-0.5, 0.5)
    offset = d + own.center_distance + own.extra_clearance
    first = _shift_length(own, rng, v, offset, a_y_used)
    s = first + own.overlap_length
    last = s + own.overlap_length
    goal = last + _shift_length(own, rng, v, offset, a_y_used)
    return [(s, d, 0.0)], [(first, last, offset)], goal


def _slalom(own: SamplingSettings, rng: np.random.Generator, v: float) -> tuple[list[Car], list[Gate], float]:
    """Three stationary cars, passed left, right and left."""
    cars, gates, end, at = [], [], 0.0, 0.0
    for left in (True, False, True):
        d = rng.uniform(-0.3, 0.3) + (0.0 if left else rng.uniform(0.5, 1.0) * own.lane_width)
        offset = d + (
            (own.center_distance + own.extra_clearance)
            if left
            else -(own.center_distance + own.extra_clearance)
        )
        begin = end + _shift_length(own, rng, v, offset - at)
        cars.append((begin + own.overlap_length, d, 0.0))
        end, at = begin + 2.0 * own.overlap_length, offset
        gates.append((begin, end, offset))
    return cars, gates, end + _shift_length(own, rng, v, at)


def _moving(own: SamplingSettings, rng: np.random.Generator, v: float) -> tuple[list[Car], list[Gate], float]:
    """Slower car, and another one on the left lane that the ego meets after it."""
    slow = rng.uniform(4.0, 8.0)
    d = rng.uniform(-0.3, 0.3)
    offset = d + own.center_distance + own.extra_clearance
    first = _shift_length(own, rng, v, offset)
    ahead = first * (v - slow) / v + own.overlap_length
    last = (ahead + own.overlap_length) * v / (v - slow)
    back = last + _shift_length(own, rng, v, offset)
    other = rng.uniform(-18.0, -10.0) if rng.random() < 0.5 else rng.uniform(4.0, 8.0)
    met = back / v + rng.uniform(0.2, 0.8)
    start = (v - other) * met + own.overlap_length
    goal = v * met + 2.0 * own.overlap_length * v / (v - other)
    cars = [(ahead, d, slow), (start, rng.uniform(0.95, 1.05) * own.lane_width, other)]
    return cars, [(first, last, offset)], goal


def _gap(own: SamplingSettings, rng: np.random.Generator, v: float) -> tuple[list[Car], list[Gate], float]:
    """Two stationary cars with a gap between them."""
    middle, slack = rng.uniform(0.3, 1.0), rng.uniform(0.05, 0.2)
    apart = 2.0 * own.center_distance + 2.0 * slack
    first = _shift_length(own, rng, v, middle)
    s = first + own.overlap_length + 0.5
    last = s + own.overlap_length + 0.5
    cars = [(s + rng.uniform(-0.5, 0.5), middle + side * 0.5 * apart, 0.0) for side in (-1.0, 1.0)]
    return cars, [(first, last, middle)], last + _shift_length(own, rng, v, middle)


def _wall(own: SamplingSettings, rng: np.random.Generator, v: float) -> tuple[list[Car], float]:
    """Stationary cars on both lanes."""
    s = rng.uniform(40.0, 80.0)
    return [(s, rng.uniform(-0.3, 0.3), 0.0), (s, rng.uniform(3.0, 3.6), 0.0)], s + 60.0


def _too_close(own: SamplingSettings, rng: np.random.Generator, v: float) -> tuple[list[Car], float]:
    """Car at 75 % of the distance that a shift at constant lateral acceleration needs."""
    d = rng.uniform(-0.3, 0.3)
    s = 0.75 * v * math.sqrt(2.0 * (d + own.center_distance) / own.a_y_max)
    s += 0.5 * (own.ego.length + own.length)
    return [(s, d, 0.0)], s + 60.0


def _meeting(own: SamplingSettings, rng: np.random.Generator, v: float) -> tuple[list[Car], float]:
    """Stationary car, and an oncoming one that is alongside it when the ego is."""
    s, oncoming = rng.uniform(60.0, 90.0), rng.uniform(10.0, 16.0)
    met = s / v + rng.uniform(-0.05, 0.05)
    lane = own.lane_width
    return [(s, rng.uniform(-0.2, 0.2), 0.0), (s + oncoming * met, lane, -oncoming)], s + 60.0


def _with_proof(
    own: SamplingSettings,
    kind: Kind,
    seed: int,
    v: float,
    cars: list[Car],
    gates: list[Gate],
    goal: float,
    radius: float,
) -> SampledProblem:
    """Solvable problem with the plan through its gates."""
    problem = _problem(own, kind, v, cars, goal, radius, solvable=True)
    return SampledProblem(kind=kind, seed=seed, problem=problem, proof=_proof(problem, gates))


def _problem(
    own: SamplingSettings, name: str, v: float, cars: list[Car], goal: float, radius: float, *, solvable: bool
) -> Problem:
    """Problem on a road of two lanes."""
    route = _route(goal + own.run_out, radius)
    road = Road(route, [Lane(d=0.0), Lane(d=own.lane_width)])
    others = []
    for i, (s, d, speed) in enumerate(cars):
        x, y = road.path.to_cartesian(s, d).tolist()
        psi = float(road.path.heading(s)) + (math.pi if speed < 0.0 else 0.0)
        others.append(
            RemoteVehicle(id=f"{i}", x=x, y=y, psi=psi, v_x=abs(speed), length=own.length, width=own.width)
        )
    return Problem(
        name=name, road=road, vehicle=own.ego, others=tuple(others), start=0.0, goal=goal, v_x=v,
        clearance=own.clearance, a_y_max=own.a_y_max, solvable=solvable,
    )  # fmt: skip


def _route(length: float, radius: float) -> Path:
    """Straight line or circle."""
    if math.isinf(radius):
        return Path([0.0, length], [[[0.0, 0.0, length, 0.0], [0.0, 0.0, 0.0, 0.0]]])
    angle = np.linspace(0.0, length / radius, math.ceil(length))
    nodes = radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    end = (math.cos(angle[-1]), math.sin(angle[-1]))
    return interpolate_path(nodes, start_tangent=(1.0, 0.0), end_tangent=end)


def _proof(problem: Problem, gates: list[Gate]) -> Plan:
    """Quintic shifts from gate to gate and back to the route."""
    s = np.linspace(problem.start, problem.goal, math.ceil((problem.goal - problem.start) / 0.25))
    d, end, at = np.zeros_like(s), problem.start, 0.0
    for begin, until, offset in [*gates, (problem.goal, problem.goal, 0.0)]:
        tau = np.clip((s - end) / (begin - end), 0.0, 1.0)
        d = np.where(s >= end, at + quintic_step(tau, offset - at), d)
        end, at = until, offset
    return plan_at_stations(problem, s, problem.road.path.to_cartesian(s, d))


def plan_at_stations(problem: Problem, s: Array, xy: Array) -> Plan:
    """Plan along positions (n, 2) that passes their stations (n,) at the wanted speed."""
    t = (s - problem.start) / problem.v_x
    v_x = np.hypot(*np.gradient(xy, t, axis=0, edge_order=2).T)
    return Plan(status=Status.OK, t=t, xy=xy, v_x=v_x)

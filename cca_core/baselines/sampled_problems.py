"""Planning problems drawn at random, each with a plan that proves it solvable; and some that are not."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.problem import Plan, Problem
from cca_core.errors import InputError, Status
from cca_core.path import Lane, Path, Road, interpolate_path
from cca_core.vehicle import RemoteVehicle, VehicleParams

__all__ = ["KINDS", "Kind", "SampledProblem", "parked", "sample_problem"]

Kind = Literal["one car", "slalom", "curve", "moving", "narrow gap", "blocked"]
"""What stands or moves in the way."""

KINDS: tuple[Kind, ...] = get_args(Kind)
"""All of them."""

_EGO = VehicleParams.bmw_320i()
_LENGTH, _WIDTH = 4.5, 1.8  # of the others [m]
_LANE = 3.5
_SPARE = 0.05  # kept by the proof beyond the clearance asked [m]
_TURNED = 0.3  # by which turned bodies may be longer than straight ones [m]
_QUINTIC = 5.7735  # peak of the second derivative of the quintic step
_EASY, _HARD = 0.5, 0.85  # share of the lateral acceleration that the proof uses
_BEYOND = 150.0  # of the road behind the goal [m]
_CLEARANCE, _A_Y = 0.3, 4.0  # what is asked [m], [m/s^2]
_BESIDE = 0.5 * (_EGO.width + _WIDTH) + _CLEARANCE  # centers side by side are so far apart [m]
# bodies are beside each other nearer than [m]
_ABREAST = 0.5 * (_EGO.length + _LENGTH) + _CLEARANCE + _TURNED

Gate = tuple[float, float, float]  # from and to this station the proof is at this offset [m]
Car = tuple[float, float, float]  # station, offset [m], speed along the road [m/s]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampledProblem:
    """A problem and how it was drawn.

    Parameters
    ----------
    kind : str
        What stands or moves in the way.
    seed : int
        Seed from which it was drawn.
    problem : Problem
        What is to be planned.
    proof : Plan or None
        A plan that keeps all limits, made from what was drawn; None if there is no way.
    """

    kind: Kind
    seed: int
    problem: Problem
    proof: Plan | None


def sample_problem(kind: Kind, seed: int) -> SampledProblem:
    """Draw a problem.

    Parameters
    ----------
    kind : {"one car", "slalom", "curve", "moving", "narrow gap", "blocked"}
        One car that stands in the way; three that stand left, right and left of the way round; one in a bend;
        one that is slower and another that is met later, half of these oncoming; two with a gap between;
        and no way: a wall of cars, a car too near, or one that stands where an oncoming one is met.
    seed : int
        Seed of speed, places and speeds of the others.

    Returns
    -------
    drawn : Drawn
        Equal seeds give equal problems.

    Raises
    ------
    InputError
        If there is no such kind.

    Notes
    -----
    Two lanes of 3.5 m, the ego on the right one at 15 to 22 m/s. The proof is a sequence of quintic shifts
    with 50 to 85 % of the lateral acceleration allowed, so that no problem is harder than that.
    """
    if kind not in KINDS:
        raise InputError(f"kind must be one of {', '.join(KINDS)}, was {kind!r}")
    rng = np.random.default_rng([KINDS.index(kind), seed])
    v = rng.uniform(15.0, 22.0)
    if kind == "curve":
        radius = float(rng.uniform(200.0, 400.0) * rng.choice((-1.0, 1.0)))
        v = rng.uniform(14.0, 18.0)
        return _drawn(kind, seed, v, *_one(rng, v, v * v / abs(radius)), radius)
    if kind == "blocked":
        cars, goal = (_wall, _too_near, _met_abreast)[seed % 3](rng, v)
        return _drawn(kind, seed, v, cars, None, goal, math.inf)
    make = {"one car": _one, "slalom": _slalom, "moving": _moving, "narrow gap": _gap}[kind]
    return _drawn(kind, seed, v, *make(rng, v), math.inf)


def parked(cars: int, length: float, *, v_x: float = 20.0) -> Problem:
    """Cars that stand on both lanes in turn, to see how time grows with their number and with the road.

    Parameters
    ----------
    cars : int
        How many [-]; evenly spaced, the first on the ego's lane.
    length : float
        From start to goal [m].
    v_x : float
        Speed of the ego [m/s].

    Returns
    -------
    problem : Problem
        Straight road of two lanes; solvable if the cars are 40 m apart at 20 m/s.
    """
    places = np.linspace(0.0, length, cars + 2)[1:-1]
    standing = [(float(s), _LANE * (i % 2), 0.0) for i, s in enumerate(places)]
    return _posed("parked", v_x, standing, length, math.inf, True)


def _shift(rng: np.random.Generator, v: float, width: float, turning: float = 0.0) -> float:
    """Length of a quintic shift at a random share of what lateral acceleration is left."""
    a_y = rng.uniform(_EASY, _HARD) * (_A_Y - turning)
    return v * math.sqrt(_QUINTIC * max(abs(width), 0.3) / a_y)


def _one(rng: np.random.Generator, v: float, turning: float = 0.0) -> tuple[list[Car], list[Gate], float]:
    d = rng.uniform(-0.5, 0.5)
    beside = d + _BESIDE + _SPARE
    first = _shift(rng, v, beside, turning)
    s = first + _ABREAST
    last = s + _ABREAST
    goal = last + _shift(rng, v, beside, turning)
    return [(s, d, 0.0)], [(first, last, beside)], goal


def _slalom(rng: np.random.Generator, v: float) -> tuple[list[Car], list[Gate], float]:
    cars, gates, end, at = [], [], 0.0, 0.0
    for left in (True, False, True):
        d = rng.uniform(-0.3, 0.3) + (0.0 if left else rng.uniform(0.5, 1.0) * _LANE)
        beside = d + (_BESIDE + _SPARE if left else -_BESIDE - _SPARE)
        begin = end + _shift(rng, v, beside - at)
        cars.append((begin + _ABREAST, d, 0.0))
        end, at = begin + 2.0 * _ABREAST, beside
        gates.append((begin, end, beside))
    return cars, gates, end + _shift(rng, v, at)


def _moving(rng: np.random.Generator, v: float) -> tuple[list[Car], list[Gate], float]:
    slow = rng.uniform(4.0, 8.0)
    d = rng.uniform(-0.3, 0.3)
    beside = d + _BESIDE + _SPARE
    first = _shift(rng, v, beside)
    ahead = first * (v - slow) / v + _ABREAST
    last = (ahead + _ABREAST) * v / (v - slow)
    back = last + _shift(rng, v, beside)
    other = rng.uniform(-18.0, -10.0) if rng.random() < 0.5 else rng.uniform(4.0, 8.0)
    met = back / v + rng.uniform(0.2, 0.8)
    start = (v - other) * met + _ABREAST
    goal = v * met + 2.0 * _ABREAST * v / (v - other)
    cars = [(ahead, d, slow), (start, rng.uniform(0.95, 1.05) * _LANE, other)]
    return cars, [(first, last, beside)], goal


def _gap(rng: np.random.Generator, v: float) -> tuple[list[Car], list[Gate], float]:
    middle, slack = rng.uniform(0.3, 1.0), rng.uniform(0.05, 0.2)
    apart = 2.0 * _BESIDE + 2.0 * slack
    first = _shift(rng, v, middle)
    s = first + _ABREAST + 0.5
    last = s + _ABREAST + 0.5
    cars = [(s + rng.uniform(-0.5, 0.5), middle + side * 0.5 * apart, 0.0) for side in (-1.0, 1.0)]
    return cars, [(first, last, middle)], last + _shift(rng, v, middle)


def _wall(rng: np.random.Generator, v: float) -> tuple[list[Car], float]:
    s = rng.uniform(40.0, 80.0)
    return [(s, rng.uniform(-0.3, 0.3), 0.0), (s, rng.uniform(3.0, 3.6), 0.0)], s + 60.0


def _too_near(rng: np.random.Generator, v: float) -> tuple[list[Car], float]:
    """At three quarters of the distance that constant lateral acceleration needs to be beside it."""
    d = rng.uniform(-0.3, 0.3)
    s = 0.75 * v * math.sqrt(2.0 * (d + _BESIDE) / _A_Y) + 0.5 * (_EGO.length + _LENGTH)
    return [(s, d, 0.0)], s + 60.0


def _met_abreast(rng: np.random.Generator, v: float) -> tuple[list[Car], float]:
    s, oncoming = rng.uniform(60.0, 90.0), rng.uniform(10.0, 16.0)
    met = s / v + rng.uniform(-0.05, 0.05)
    return [(s, rng.uniform(-0.2, 0.2), 0.0), (s + oncoming * met, _LANE, -oncoming)], s + 60.0


def _drawn(
    kind: Kind, seed: int, v: float, cars: list[Car], gates: list[Gate] | None, goal: float, radius: float
) -> SampledProblem:
    problem = _posed(kind, v, cars, goal, radius, gates is not None)
    return SampledProblem(
        kind=kind, seed=seed, problem=problem, proof=None if gates is None else _proof(problem, gates)
    )


def _posed(name: str, v: float, cars: list[Car], goal: float, radius: float, solvable: bool) -> Problem:
    road = Road(_route(goal + _BEYOND, radius), [Lane(d=0.0), Lane(d=_LANE)])
    others = []
    for i, (s, d, speed) in enumerate(cars):
        x, y = road.path.to_cartesian(s, d).tolist()
        psi = float(road.path.heading(s)) + (math.pi if speed < 0.0 else 0.0)
        others.append(
            RemoteVehicle(id=f"{i}", x=x, y=y, psi=psi, v_x=abs(speed), length=_LENGTH, width=_WIDTH)
        )
    return Problem(
        name=name, road=road, vehicle=_EGO, others=tuple(others), start=0.0, goal=goal, v_x=v,
        clearance=_CLEARANCE, a_y_max=_A_Y, solvable=solvable,
    )  # fmt: skip


def _route(length: float, radius: float) -> Path:
    if math.isinf(radius):
        return Path([0.0, length], [[[0.0, 0.0, length, 0.0], [0.0, 0.0, 0.0, 0.0]]])
    angle = np.linspace(0.0, length / radius, math.ceil(length))
    nodes = radius * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    end = (math.cos(angle[-1]), math.sin(angle[-1]))
    return interpolate_path(nodes, start_tangent=(1.0, 0.0), end_tangent=end)


def _proof(problem: Problem, gates: list[Gate]) -> Plan:
    s = np.linspace(problem.start, problem.goal, math.ceil((problem.goal - problem.start) / 0.25))
    d, end, at = np.zeros_like(s), problem.start, 0.0
    for begin, until, beside in [*gates, (problem.goal, problem.goal, 0.0)]:
        tau = np.clip((s - end) / (begin - end), 0.0, 1.0)
        d = np.where(s >= end, at + (beside - at) * tau**3 * (10.0 - 15.0 * tau + 6.0 * tau**2), d)
        end, at = until, beside
    return at_stations(problem, s, problem.road.path.to_cartesian(s, d))


def at_stations(problem: Problem, s: Array, xy: Array) -> Plan:
    """Give a way the times at which its stations are passed at the wanted speed.

    Parameters
    ----------
    problem : Problem
        What was asked.
    s : ndarray, shape (n,)
        Stations: path coordinates of the foot points [m], increasing.
    xy : ndarray, shape (n, 2)
        The way of the center of gravity [m].

    Returns
    -------
    plan : Plan
        `Status.OK`.
    """
    t = (s - problem.start) / problem.v_x
    v_x = np.hypot(*np.gradient(xy, t, axis=0, edge_order=2).T)
    return Plan(status=Status.OK, t=t, xy=xy, v_x=v_x)

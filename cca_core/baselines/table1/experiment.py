"""What is measured for Table 1: the methods, the points of the scaling, the closed-loop planners."""

from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from typing import Any, Literal

from cca_core.baselines.methods.band_methods import OneShotBand, RelaxedBand
from cca_core.baselines.methods.fiss import Fiss
from cca_core.baselines.methods.mpc.horizon import MpcSettings
from cca_core.baselines.methods.mpc.linear import LinearMpc
from cca_core.baselines.methods.mpc.nonlinear import NonlinearMpc
from cca_core.baselines.methods.mpc.planner import MpcPlanner
from cca_core.baselines.methods.primitives import MotionPrimitives
from cca_core.baselines.methods.rrt import Rrt, Variant
from cca_core.baselines.problems.sampling import parked, sample_problem
from cca_core.baselines.table1.scaling import ScalingPoint
from cca_core.sim import Scenario
from cca_core.sim.loop import make_planner

EQ9, BAND, SMOOTH = "band, eq 9", "band, relaxed", "band, QP"
LATTICE, TREE, STAR = "primitives", "RRT", "RRT*"
LINEAR, FATROP, IPOPT, FISS = "LTV MPC", "NMPC, FATROP", "NMPC, IPOPT", "FISS"
BANDS = (BAND, SMOOTH)
NODES, LENGTH, CARS = "nodes or intervals on 120 m", "length [m]", "cars on 300 m"
AXES = (NODES, LENGTH, CARS)
SEEDS = "seed of the tree"

Make = Callable[[], Any]


def methods() -> dict[str, Make]:
    """Methods by name; FISS only if its package is installed."""
    found: dict[str, Make] = {
        EQ9: OneShotBand, BAND: RelaxedBand, SMOOTH: partial(RelaxedBand, smooth=True),
        LATTICE: MotionPrimitives, TREE: partial(_tree, "rrt"), STAR: partial(_tree, "rrt_star"),
        LINEAR: LinearMpc, FATROP: partial(NonlinearMpc, MpcSettings(solver="fatrop")), IPOPT: NonlinearMpc,
    }  # fmt: skip
    if find_spec("fiss_planner") is not None:
        found[FISS] = Fiss
    return found


def scaling_points() -> Iterator[ScalingPoint]:
    """Points of growing size, and ten seeds of the tree on one problem."""
    for n in (30, 60, 120):
        yield from _points(NODES, n, 120.0, 1, n)
    for length in (100.0, 200.0, 400.0):
        yield from _points(LENGTH, length, length, 1, round(length / 4.0))
    for cars in (1, 2, 4, 6):
        yield from _points(CARS, cars, 300.0, cars, 75)
    example = sample_problem("one car", 1).problem
    for seed in range(1, 11):
        make = partial(_tree, "rrt", seed)
        yield ScalingPoint(method=TREE, axis=SEEDS, value=seed, make=make, problem=example)


def _tree(variant: Variant, seed: int = 1) -> Rrt:
    """Random tree of up to 40 000 samples, which take about half a second."""
    return Rrt(variant=variant, seed=seed, iterations=40_000, time_limit=8.0)


def _points(axis: str, value: float, length: float, cars: int, intervals: int) -> Iterator[ScalingPoint]:
    """One point for each method that has a mesh, or for all that take part on this axis."""
    spacing = length / value if axis == NODES else 1.0
    made: dict[str, Make] = {
        BAND: partial(RelaxedBand, spacing=spacing),
        SMOOTH: partial(RelaxedBand, spacing=spacing, smooth=True),
        LINEAR: partial(LinearMpc, MpcSettings(intervals=intervals)),
        FATROP: partial(NonlinearMpc, MpcSettings(intervals=intervals, solver="fatrop")),
    }
    if axis != NODES:
        made |= {name: make for name, make in methods().items() if name in (LATTICE, TREE, FISS)}
    elif value <= 60:
        made[LATTICE] = partial(MotionPrimitives, step=length / 20.0 / value)
    for name, make in made.items():
        yield ScalingPoint(method=name, axis=axis, value=value, make=make, problem=parked(cars, length))


def planners() -> dict[str, Callable[[Scenario], Any]]:
    """Planners in closed loop by name."""
    return {
        "band": make_planner,
        LINEAR: partial(_mpc_planner, "linear", "ipopt"),
        FATROP: partial(_mpc_planner, "nonlinear", "fatrop"),
        IPOPT: partial(_mpc_planner, "nonlinear", "ipopt"),
    }


def _mpc_planner(
    method: Literal["nonlinear", "linear"], solver: Literal["ipopt", "fatrop"], scenario: Scenario
) -> MpcPlanner:
    """Model predictive planner for a scenario."""
    return MpcPlanner(
        scenario.vehicle, scenario.road, cruise_speed=scenario.cruise_speed, method=method,
        settings=MpcSettings(solver=solver), speed=scenario.speed,
    )  # fmt: skip

"""Other people's methods, and this library's, on the same problems."""

from cca_core.baselines.band_methods import OneShotBand, RelaxedBand, SmoothedBand
from cca_core.baselines.mpc import LinearMpc, MpcPlanner, MpcSettings, NonlinearMpc
from cca_core.baselines.primitives import MotionPrimitives
from cca_core.baselines.problem import Method, Plan, Problem
from cca_core.baselines.rrt import Rrt
from cca_core.baselines.steering import LqrSteering, PurePursuit, Stanley

__all__ = [
    "LinearMpc",
    "LqrSteering",
    "Method",
    "MotionPrimitives",
    "MpcPlanner",
    "MpcSettings",
    "NonlinearMpc",
    "OneShotBand",
    "Plan",
    "Problem",
    "PurePursuit",
    "RelaxedBand",
    "Rrt",
    "SmoothedBand",
    "Stanley",
]

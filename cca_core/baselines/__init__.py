"""Published planning methods and steering laws, and the problems on which they are compared."""

from cca_core.baselines.methods.band_methods import OneShotBand, RelaxedBand
from cca_core.baselines.methods.mpc.horizon import MpcSettings
from cca_core.baselines.methods.mpc.linear import LinearMpc
from cca_core.baselines.methods.mpc.nonlinear import NonlinearMpc
from cca_core.baselines.methods.mpc.planner import MpcPlanner
from cca_core.baselines.methods.mpc.planner_settings import MpcPlannerSettings
from cca_core.baselines.methods.primitives import MotionPrimitives
from cca_core.baselines.methods.rrt import Rrt
from cca_core.baselines.problems.compare import ComparisonRow, compare
from cca_core.baselines.problems.drive import DriveResult, drive_plan
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.baselines.problems.sampling import SampledProblem, SamplingSettings, sample_problem
from cca_core.baselines.problems.verify import Tolerances, Verification, verify_plan
from cca_core.baselines.steering import LqrSteering, PurePursuit, Stanley

__all__ = [
    "ComparisonRow",
    "DriveResult",
    "LinearMpc",
    "LqrSteering",
    "MotionPrimitives",
    "MpcPlanner",
    "MpcPlannerSettings",
    "MpcSettings",
    "NonlinearMpc",
    "OneShotBand",
    "Plan",
    "Problem",
    "PurePursuit",
    "RelaxedBand",
    "Rrt",
    "SampledProblem",
    "SamplingSettings",
    "Stanley",
    "Tolerances",
    "Verification",
    "compare",
    "drive_plan",
    "sample_problem",
    "verify_plan",
]

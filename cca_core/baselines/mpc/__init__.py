"""Model predictive control: linear time-varying and nonlinear, planned once or in closed loop."""

from cca_core.baselines.mpc.horizon import FrenetState, Horizon, MpcSettings
from cca_core.baselines.mpc.linear import LinearMpc
from cca_core.baselines.mpc.nonlinear import NonlinearMpc
from cca_core.baselines.mpc.planner import MpcPlanner

__all__ = ["FrenetState", "Horizon", "LinearMpc", "MpcPlanner", "MpcSettings", "NonlinearMpc"]

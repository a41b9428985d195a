"""Nonlinear program of the nonlinear predictive controller, built once and fed with parameters."""

from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core._optional import require_extra
from cca_core.baselines.methods.mpc.horizon import SAMPLES, Horizon

NX, NU = 6, 2  # states s, d, angle, v, delta, a_x; inputs rates of delta and a_x


@lru_cache(maxsize=16)
def cached_program(
    n: int, slots: int, solver: str, iterations: int, cpu_time: float, penalty: float
) -> "NonlinearProgram":
    """Program that is built once for the same numbers."""
    return NonlinearProgram(n, slots, solver, iterations, cpu_time, penalty)


class NonlinearProgram:
    """Nonlinear program for a number of intervals and vehicles; everything else is a parameter."""

    def __init__(
        self, n: int, slots: int, solver: str, iterations: int, cpu_time: float, penalty: float
    ) -> None:
        casadi = require_extra("casadi", "mpc")
        self._n, self.slots, self._staged = n, slots, solver == "fatrop"
        model = _Model(casadi, n, slots, self._staged, penalty)
        self._low, self._high = np.array(model.low), np.array(model.high)
        self._is_a_y = np.isnan(self._low)
        if self._staged:
            variables = casadi.vec(casadi.vertcat(model.states, model.violation.T, model.inputs))
            options = _fatrop_options(n, slots, iterations, (self._low == self._high).tolist())
        else:
            variables = casadi.vertcat(
                casadi.vec(casadi.vertcat(model.states, model.inputs)), model.violation
            )
            options = _ipopt_options(iterations, cpu_time)
        self._solver = casadi.nlpsol(
            "nmpc", solver,
            {"x": variables, "p": model.parameters, "f": model.cost, "g": casadi.vertcat(*model.constraints)},
            {"print_time": False, "error_on_fail": False, **options},
        )  # fmt: skip
        self._within = model.motion_within_interval().map(n)

    def run(
        self, guess: Array, low: Array, high: Array, p: Array, horizon: Horizon
    ) -> tuple[Array, float, str]:
        """Solution in the shape of the guess, its cost, and the reason of a failure, empty if none."""
        self._low[self._is_a_y], self._high[self._is_a_y] = -horizon.a_y_max, horizon.a_y_max
        self._low[-2:], self._high[-2:] = (horizon.final_d[0], -np.inf), (np.inf, horizon.final_d[1])
        x0, low, high = self._vector(guess, 0.0), self._vector(low, -np.inf), self._vector(high, np.inf)
        low[-1 - NU if self._staged else -1] = 0.0
        given = np.concatenate((guess[0, :NX], p))
        answer = self._solver(x0=x0, p=given, lbx=low, ubx=high, lbg=self._low, ubg=self._high)
        stats, z = self._solver.stats(), np.array(answer["x"]).ravel()
        z = np.delete(z.reshape(self._n + 1, -1), NX, axis=1) if self._staged else z[:-1].reshape(guess.shape)
        failure = "" if stats["success"] and np.isfinite(z).all() else str(stats["return_status"])
        return z, float(answer["f"]), failure

    def _vector(self, values: Array, violation: float) -> Array:
        """Values of states, inputs and the violation in the order of the variables."""
        if self._staged:
            return np.insert(values, NX, violation, axis=1).ravel()
        return np.append(values, violation)

    def sampled(self, z: Array, common: Array, road: Array) -> Array:
        """States (6, 5 n + 1) at the nodes and four times between them."""
        n = self._n
        within = np.array(
            self._within(z[:n, :NX].T, z[:n, NX:].T, np.tile(common[:, None], n), road[None, :n])
        )
        return np.vstack((within.T.reshape(-1, NX), z[n, :NX])).T


class _Model:
    """Variables, parameters, cost and constraints with their bounds."""

    # A bound is NaN where it is the lateral acceleration. The violation of all limits to vehicles is one
    # number, or for a staged solver a state that stays the same.

    def __init__(self, casadi: ModuleType, n: int, slots: int, staged: bool, penalty: float) -> None:
        self._casadi = casadi
        self.states, self.inputs = casadi.SX.sym("states", NX, n + 1), casadi.SX.sym("inputs", NU, n + 1)
        self._common, self._road = casadi.SX.sym("common", 8), casadi.SX.sym("road", n + 1)
        self._wanted, self._first = casadi.SX.sym("wanted", n + 1), casadi.SX.sym("first", NX)
        self._boxes = casadi.SX.sym("boxes", 4 * slots, n + 1)
        self.violation = casadi.SX.sym("violation", n + 1 if staged else 1)
        self.parameters = casadi.vertcat(
            self._first, self._common, self._road, self._wanted, casadi.vec(self._boxes)
        )
        self.constraints: list[Any] = []
        self.low: list[float] = []
        self.high: list[float] = []
        self.cost: Any = penalty * self.violation[-1]
        for k in range(n + 1):
            self._add_node(k, n, staged)
            if k > 0:
                self._add_limits(k, slots, self.violation[k] if staged else self.violation)
        self._add(self.states[1, n] + self.violation[-1], -np.inf, np.inf)
        self._add(self.states[1, n] - self.violation[-1], -np.inf, np.inf)

    def _add(self, g: Any, low: float, high: float, rows: int = 1) -> None:
        self.constraints.append(g)
        self.low += [low] * rows
        self.high += [high] * rows

    def _add_node(self, k: int, n: int, staged: bool) -> None:
        """Add the cost of a node's inputs, and the motion to the next node."""
        h, wheelbase, understeer, _, _, w_j, _, _ = self._casadi.vertsplit(self._common)
        x, u = self.states[:, k], self.inputs[:, k]
        gain = self._wanted[k] ** 2 / (wheelbase + understeer * self._wanted[k] ** 2)
        self.cost += h * w_j * ((gain * u[0]) ** 2 + u[1] ** 2)
        if k < n:
            after = _after(self._casadi, x, u, h, wheelbase, understeer, self._road[k])
            self._add(self.states[:, k + 1] - after, 0.0, 0.0, NX)
            if staged:
                self._add(self.violation[k + 1] - self.violation[k], 0.0, 0.0)
        if k == 0 and staged:
            self._add(x - self._first, 0.0, 0.0, NX)

    def _add_limits(self, k: int, slots: int, violation: Any) -> None:
        """Add the cost of a node's state, and its distances to all vehicles."""
        casadi, x, wanted = self._casadi, self.states[:, k], self._wanted[k]
        h, wheelbase, understeer, w_d, w_a, _, w_v, w_x = casadi.vertsplit(self._common)
        gain = wanted**2 / (wheelbase + understeer * wanted**2)
        a = gain * x[4] - wanted**2 * self._road[k]
        self.cost += h * (w_d * x[1] ** 2 + w_a * a**2 + w_v * (x[3] - wanted) ** 2 + w_x * x[5] ** 2)
        for i in range(slots):
            s, d, length, width = casadi.vertsplit(self._boxes[4 * i : 4 * i + 4, k])
            distance = (((x[0] - s) / length) ** 8 + ((x[1] - d) / width) ** 8 + 1e-12) ** 0.125
            self._add(distance + violation, 1.0, np.inf)
        self._add(x[3] ** 2 * x[4] / (wheelbase + understeer * x[3] ** 2), np.nan, np.nan)

    def motion_within_interval(self) -> Any:
        """Make the function of the states at the samples of an interval."""
        casadi, x, u, road = self._casadi, self.states[:, 0], self.inputs[:, 0], self._road[0]
        h, wheelbase, understeer, *_ = casadi.vertsplit(self._common)
        fine = [_after(casadi, x, u, h * j / SAMPLES, wheelbase, understeer, road) for j in range(SAMPLES)]
        return casadi.Function("within", [x, u, self._common, road], [casadi.vertcat(*fine)])


def _fatrop_options(n: int, slots: int, iterations: int, equality: list[bool]) -> dict[str, Any]:
    """Options of FATROP, with the structure of the stages."""
    return {
        "structure_detection": "manual", "N": n, "nx": [NX + 1] * (n + 1), "nu": [NU] * (n + 1),
        "ng": [NX] + [slots + 1] * (n - 1) + [slots + 3], "equality": equality,
        "fatrop": {"print_level": 0, "max_iter": iterations, "tolerance": 1e-3, "mu_init": 1e-1},
    }  # fmt: skip


def _ipopt_options(iterations: int, cpu_time: float) -> dict[str, Any]:
    """Options of IPOPT, tuned for a start close to the solution."""
    return {
        "ipopt": {
            "sb": "yes", "print_level": 0, "max_iter": iterations, "max_cpu_time": cpu_time,
            "linear_solver": "mumps", "tol": 1e-3, "constr_viol_tol": 1e-4, "acceptable_tol": 1e-2,
            "acceptable_iter": 2, "mu_init": 1e-2, "mu_linear_decrease_factor": 0.05,
            "mu_superlinear_decrease_power": 1.8, "fast_step_computation": "yes",
        },
    }  # fmt: skip


def _after(casadi: ModuleType, x: Any, u: Any, h: Any, wheelbase: Any, understeer: Any, road: Any) -> Any:
    """State after a time, by a Runge-Kutta step."""

    def rate(x: Any) -> Any:
        along = x[3] * casadi.cos(x[2]) / (1.0 - x[1] * road)
        kappa = x[4] / (wheelbase + understeer * x[3] ** 2)
        return casadi.vertcat(along, x[3] * casadi.sin(x[2]), x[3] * kappa - road * along, x[5], u[0], u[1])

    a = rate(x)
    b = rate(x + 0.5 * h * a)
    c = rate(x + 0.5 * h * b)
    return x + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(x + h * c))

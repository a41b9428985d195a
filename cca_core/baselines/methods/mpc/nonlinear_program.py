"""The nonlinear program of the nonlinear predictive controller, built once and fed with parameters."""

from functools import lru_cache
from typing import Any

import numpy as np

from cca_core._checks import Array
from cca_core._optional import require_extra
from cca_core.baselines.methods.mpc.horizon import Horizon

NX, NU = 6, 2  # s, d, angle, v, delta, a_x; rates of delta and a_x
FINE = 5  # samples in an interval
_COMMON = 8  # parameters that are not those of a node
_ELASTIC = 1e3  # weight of what a limit to others is left by, in half widths [-]


@lru_cache(maxsize=16)
def cached_program(n: int, slots: int, solver: str, iterations: int, cpu_time: float) -> "NonlinearProgram":
    """Program that is built once for the same numbers."""
    return NonlinearProgram(n, slots, solver, iterations, cpu_time)


class NonlinearProgram:
    """The nonlinear program for a number of intervals and others, all else being its parameters."""

    def __init__(self, n: int, slots: int, solver: str, iterations: int, cpu_time: float) -> None:
        casadi = require_extra("casadi", "mpc")
        self._n, self.slots, self._staged = n, slots, solver == "fatrop"
        states, inputs = casadi.SX.sym("states", NX, n + 1), casadi.SX.sym("inputs", NU, n + 1)
        common, road = casadi.SX.sym("common", _COMMON), casadi.SX.sym("road", n + 1)
        wanted, first = casadi.SX.sym("wanted", n + 1), casadi.SX.sym("first", NX)
        places = casadi.SX.sym("places", 4 * slots, n + 1)
        h, wheelbase, grip, w_d, w_a, w_j, w_v, w_x = casadi.vertsplit(common)
        # the elastic way out of all limits to others: one number, or for a staged solver a state that stays
        out = casadi.SX.sym("out", n + 1 if self._staged else 1)
        cost, rows = _ELASTIC * out[-1], _Rows()
        for k in range(n + 1):
            x, u, way_out = states[:, k], inputs[:, k], out[k] if self._staged else out
            gain = wanted[k] ** 2 / (wheelbase + grip * wanted[k] ** 2)
            cost += h * w_j * ((gain * u[0]) ** 2 + u[1] ** 2)
            if k < n:
                after = _after(casadi, x, u, h, wheelbase, grip, road[k])
                rows.add(states[:, k + 1] - after, 0.0, 0.0, NX)
                if self._staged:
                    rows.add(out[k + 1] - way_out, 0.0, 0.0)
            if k == 0 and self._staged:
                rows.add(x - first, 0.0, 0.0, NX)
            if k > 0:
                a = gain * x[4] - wanted[k] ** 2 * road[k]
                cost += h * (w_d * x[1] ** 2 + w_a * a**2 + w_v * (x[3] - wanted[k]) ** 2 + w_x * x[5] ** 2)
                for i in range(slots):
                    s, d, length, width = casadi.vertsplit(places[4 * i : 4 * i + 4, k])
                    away = (((x[0] - s) / length) ** 8 + ((x[1] - d) / width) ** 8 + 1e-12) ** 0.125
                    rows.add(away + way_out, 1.0, np.inf)
                rows.add(x[3] ** 2 * x[4] / (wheelbase + grip * x[3] ** 2), np.nan, np.nan)  # filled in later
        rows.add(states[1, n] + out[-1], -np.inf, np.inf)
        rows.add(states[1, n] - out[-1], -np.inf, np.inf)
        self._low, self._high = np.array(rows.low), np.array(rows.high)
        self._pull = np.isnan(self._low)
        if self._staged:
            variables = casadi.vec(casadi.vertcat(states, out.T, inputs))
            options = {
                "structure_detection": "manual", "N": n, "nx": [NX + 1] * (n + 1), "nu": [NU] * (n + 1),
                "ng": [NX] + [slots + 1] * (n - 1) + [slots + 3],
                "equality": (self._low == self._high).tolist(),
                "fatrop": {"print_level": 0, "max_iter": iterations, "tolerance": 1e-3, "mu_init": 1e-1},
            }  # fmt: skip
        else:
            variables = casadi.vertcat(casadi.vec(casadi.vertcat(states, inputs)), out)
            options = {
                "ipopt": {
                    "sb": "yes", "print_level": 0, "max_iter": iterations, "max_cpu_time": cpu_time,
                    "linear_solver": "mumps", "tol": 1e-3, "constr_viol_tol": 1e-4, "acceptable_tol": 1e-2,
                    "acceptable_iter": 2, "mu_init": 1e-2, "mu_linear_decrease_factor": 0.05,
                    "mu_superlinear_decrease_power": 1.8, "fast_step_computation": "yes",
                },
            }  # fmt: skip
        p = casadi.vertcat(first, common, road, wanted, casadi.vec(places))
        self._solver = casadi.nlpsol(
            "nmpc", solver, {"x": variables, "p": p, "f": cost, "g": casadi.vertcat(*rows.g)},
            {"print_time": False, "error_on_fail": False, **options},
        )  # fmt: skip
        x, u = states[:, 0], inputs[:, 0]
        fine = [_after(casadi, x, u, h * j / FINE, wheelbase, grip, road[0]) for j in range(FINE)]
        self._within = casadi.Function("within", [x, u, common, road[0]], [casadi.vertcat(*fine)]).map(n)

    def run(
        self, guess: Array, low: Array, high: Array, p: Array, horizon: Horizon
    ) -> tuple[Array, float, str]:
        """Solution in the shape of the guess, its cost, and why there is none, empty if there is one."""
        self._low[self._pull], self._high[self._pull] = -horizon.a_y_max, horizon.a_y_max
        self._low[-2:], self._high[-2:] = (horizon.final[0], -np.inf), (np.inf, horizon.final[1])
        x0, low, high = self._laid(guess, 0.0), self._laid(low, -np.inf), self._laid(high, np.inf)
        low[-1 - NU if self._staged else -1] = 0.0
        given = np.concatenate((guess[0, :NX], p))
        answer = self._solver(x0=x0, p=given, lbx=low, ubx=high, lbg=self._low, ubg=self._high)
        stats, z = self._solver.stats(), np.array(answer["x"]).ravel()
        z = np.delete(z.reshape(self._n + 1, -1), NX, axis=1) if self._staged else z[:-1].reshape(guess.shape)
        failure = "" if stats["success"] and np.isfinite(z).all() else str(stats["return_status"])
        return z, float(answer["f"]), failure

    def _laid(self, values: Array, out: float) -> Array:
        """Values of states, inputs and the elastic way out in the order of the variables."""
        if self._staged:
            return np.insert(values, NX, out, axis=1).ravel()
        return np.append(values, out)

    def sampled(self, z: Array, common: Array, road: Array) -> Array:
        """States at the nodes and four times between them, shape (6, 5 n + 1)."""
        n = self._n
        within = np.array(
            self._within(z[:n, :NX].T, z[:n, NX:].T, np.tile(common[:, None], n), road[None, :n])
        )
        return np.vstack((within.T.reshape(-1, NX), z[n, :NX])).T


class _Rows:
    """Constraints with their bounds, in order."""

    def __init__(self) -> None:
        self.g: list[Any] = []
        self.low: list[float] = []
        self.high: list[float] = []

    def add(self, g: Any, low: float, high: float, times: int = 1) -> None:
        self.g.append(g)
        self.low += [low] * times
        self.high += [high] * times


def _after(casadi: Any, x: Any, u: Any, h: Any, wheelbase: Any, grip: Any, road: Any) -> Any:
    """State after a time, by a Runge-Kutta step."""

    def rate(x: Any) -> Any:
        along = x[3] * casadi.cos(x[2]) / (1.0 - x[1] * road)
        kappa = x[4] / (wheelbase + grip * x[3] ** 2)
        return casadi.vertcat(along, x[3] * casadi.sin(x[2]), x[3] * kappa - road * along, x[5], u[0], u[1])

    a = rate(x)
    b = rate(x + 0.5 * h * a)
    c = rate(x + 0.5 * h * b)
    return x + h / 6.0 * (a + 2.0 * b + 2.0 * c + rate(x + h * c))

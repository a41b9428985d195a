"""Quadratic program of the linear predictive controller, set up once and changed in place."""

import math
from typing import Any

import numpy as np
from scipy import sparse

from cca_core._checks import Array, Index
from cca_core._optional import require_extra
from cca_core.baselines.methods.mpc.horizon import MpcSettings
from cca_core.errors import Status

_UNBOUNDED = 1e3  # bound of a variable without one
_STATUS = {"PIQP_SOLVED": Status.OK, "PIQP_PRIMAL_INFEASIBLE": Status.INFEASIBLE}


def exponentials(c: Array, h: Array | float) -> tuple[Array, Array, Array, Array]:
    """Return exp(c h) and its first three integrals over h, for small c h."""
    z = c * h
    return (
        1.0 + z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z / 24.0))),
        h * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z / 24.0))),
        h**2 * (0.5 + z * (1.0 / 6.0 + z * (1.0 / 24.0 + z / 120.0))),
        h**3 * (1.0 / 6.0 + z * (1.0 / 24.0 + z * (1.0 / 120.0 + z / 720.0))),
    )


class LateralQp:
    """Quadratic program in d, w, a (n + 1 each), j and the distance e outside the corridor (n each)."""

    def __init__(self, settings: MpcSettings) -> None:
        self._piqp: Any = require_extra("piqp", "qp")
        self.settings, n = settings, settings.intervals
        self._n, self._solver = n, self._piqp.SparseSolver()
        self._solver.settings.verbose = False
        self._solver.settings.max_iter = settings.iterations
        k, at = np.arange(n), np.arange(n + 1)
        d, w, a, j, e = at, at + n + 1, at + 2 * (n + 1), k + 3 * (n + 1), k + 4 * n + 3
        row = 3 + k
        motion = _Pattern(
            np.concatenate([[0, 1, 2], *[row] * 5, *[row + n] * 4, *[row + 2 * n] * 3]),
            np.concatenate(
                [[d[0], w[0], a[0]], d[1:], d[:-1], w[:-1], a[:-1], j, w[1:], w[:-1], a[:-1], j, a[1:],
                 a[:-1], j]
            ),
            5 * n + 3,
        )  # fmt: skip
        corridor = _Pattern(
            np.concatenate([*[k] * 3, *[k + n] * 3]), np.concatenate([d[1:], w[1:], e] * 2), 5 * n + 3
        )
        self._motion, self._corridor = motion, corridor
        self._low, self._high = np.full(5 * n + 3, -_UNBOUNDED), np.full(5 * n + 3, _UNBOUNDED)
        self._now = np.zeros(3 * n + 3)
        self._given: Array | None = None

    def solve(
        self, h: float, growth: Array, levers: Array, now: tuple[float, float, float],
        corridor: tuple[Array, Array], a: tuple[Array, Array], rate: Array,
    ) -> tuple[tuple[Array, Array, Array, Array], Status, float]:  # fmt: skip
        """Lateral coordinate, rate and acceleration at the nodes, jerk between them; status; cost."""
        n = self._n
        self._set(h, growth, levers)
        low, high = corridor[0].ravel(), corridor[1].ravel()
        middle, crossed = 0.5 * (low + high), low > high
        low, high = np.where(crossed, middle, low), np.where(crossed, middle, high)
        self._low[2 * n + 3 : 3 * n + 3], self._high[2 * n + 3 : 3 * n + 3] = a
        self._low[3 * n + 3 : 4 * n + 3], self._high[3 * n + 3 : 4 * n + 3] = -rate, rate
        self._now[:3] = now
        self._solver.update(b=self._now, h_l=low, h_u=high, x_l=self._low, x_u=self._high)
        status = _STATUS.get(self._solver.solve().name, Status.NOT_CONVERGED)
        if status is not Status.OK:
            return (np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1), np.zeros(n)), status, math.inf
        x = np.array(self._solver.result.x)
        parts = x[: n + 1], x[n + 1 : 2 * n + 2], x[2 * n + 2 : 3 * n + 3], x[3 * n + 3 : 4 * n + 3]
        return parts, status, float(self._solver.result.info.primal_obj)

    def _set(self, h: float, growth: Array, levers: Array) -> None:
        """Set a step and speeds in the matrices if they have changed."""
        given = np.concatenate(([h], growth, levers.ravel()))
        if self._given is not None and np.array_equal(given, self._given):
            return
        one, own, n = np.ones(self._n), self.settings, self._n
        p0, p1, p2, p3 = exponentials(growth, h)
        A = self._motion.set(
            np.concatenate([np.ones(3), -one, one, p1, p2, p3, -one, p0, p1, p2, -one, one, h * one])
        )
        G = self._corridor.set(np.concatenate([one, levers[0, 1:], -one, one, levers[1, 1:], -one]))
        P = sparse.diags(
            2.0 * h * np.concatenate(
                [np.full(n + 1, own.weight_d), np.zeros(n + 1), np.full(n + 1, own.weight_a),
                 np.full(n, own.weight_jerk), np.full(n, own.corridor_penalty)]
            ), format="csc",
        )  # fmt: skip
        if self._given is None:
            self._solver.setup(
                P, np.zeros(5 * n + 3), A, self._now, G, np.full(2 * n, -_UNBOUNDED),
                np.full(2 * n, _UNBOUNDED),
                self._low, self._high,
            )  # fmt: skip
        else:
            self._solver.update(P=P, A=A, G=G)
        self._given = given


class _Pattern:
    """Sparse matrix of a fixed pattern, whose values can be set."""

    def __init__(self, rows: Index, columns: Index, width: int) -> None:
        self._order = np.lexsort((rows, columns))
        self.matrix = sparse.csc_matrix((np.ones(len(rows)), (rows, columns)), shape=(rows.max() + 1, width))

    def set(self, values: Array) -> Any:
        """Set the values in the order of the pattern, and return the matrix."""
        self.matrix.data[:] = values[self._order]
        return self.matrix

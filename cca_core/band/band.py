"""Band: the deformed route with its certificate and status."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from importlib import import_module
from typing import Annotated, Any, Self

import numpy as np

from cca_core._checks import Array, Index, Mask
from cca_core.band.certificate import Certificate
from cca_core.band.corridor import Side
from cca_core.band.energy import kkt_residual
from cca_core.band.problem import MAX_DISPLACEMENT, BandProblem
from cca_core.errors import InfeasibleError, InputError, Status
from cca_core.path import Path
from cca_core.path.interpolate import cubics_along

_ROUNDING = 1e-9  # violations up to here are rounding errors [m]

Failure = tuple[Status, str, int | str]
"""Status, message and active constraint (obstacles by index) of a band that was not solved."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Band:
    """A stretch of the route, deformed around obstacles, or a batch of them.

    Fields of a batch have its shape as leading axes.

    Parameters
    ----------
    nodes : ndarray, shape (..., n, 2)
        Deformed nodes [m] (eq 10). The last is on the route; so is the first, unless `start` was given.
    displacement : ndarray, shape (..., n)
        Lateral displacement u of each node [m], left positive.
    clearance : float or ndarray, shape (...)
        Least distance between the ego's box, swept along the band, and any obstacle's box at the same time
        [m]. It is infinite without obstacles and negative where boxes overlap. It is a lower bound for
        displacements below 30 m. If it is less than 1 cm above the clearance asked, it is within 5 mm (and
        the bulge of the band between nodes).
    edge_clearance : float or ndarray, shape (...)
        Least distance between the swept box and the edges of the corridor [m].
    curvature : float or ndarray, shape (...)
        Largest curvature along the band [1/m], without sign.
    passes_left : ndarray of bool, shape (n_obstacles, ...)
        Whether the ego passes each obstacle on the obstacle's left.
    lower, upper : ndarray, shape (..., n)
        Tightened bounds of the displacement [m].
    spacing : float or ndarray, shape (...)
        Distance between nodes [m].
    status : Status or ndarray of Status, shape (...)
        `Status.OK` only if clearance, edges and curvature limit are all satisfied.
    message : str or ndarray of str, shape (...)
        Reason for the status.
    active_constraint : str or ndarray of str, shape (...)
        Closest or violated constraint: "obstacle 0", "left edge", "right edge", "curvature" or "".
    active_obstacle : int, optional, or ndarray of object, shape (...)
        Index of the obstacle that is the active constraint; None if it is another.
    n_solves : int or ndarray of int, shape (...)
        Banded systems solved [-].
    moment_over_6 : ndarray, shape (..., n, 2)
        Spline moments (second derivatives of the C2 cubic at the nodes), divided by 6 [1/m].
    problem : BandProblem
        Checked arguments, for a new band with the same ones.
    qp_residual : float, optional
        Largest KKT residual of the quadratic program, if the band was smoothed by one [-].
    """

    nodes: Array
    displacement: Array
    clearance: Annotated[Any, float]
    edge_clearance: Annotated[Any, float]
    curvature: Annotated[Any, float]
    passes_left: Mask
    lower: Array
    upper: Array
    spacing: Annotated[Any, float]
    status: Annotated[Any, Status]
    message: Annotated[Any, str]
    active_constraint: Annotated[Any, str]
    n_solves: Annotated[Any, int]
    moment_over_6: Array
    problem: BandProblem
    active_obstacle: Annotated[Any, int | None] = None
    qp_residual: float | None = None

    def __repr__(self) -> str:
        if self.nodes.ndim > 2:
            return f"Band({self.nodes.shape[:-2]} bands, {int(np.sum(self.ok))} OK)"
        return (
            f"Band({self.status.name}, {len(self.nodes)} nodes, {self.side} by "
            f"{np.abs(self.displacement).max():.2f} m, clearance {self.clearance:.2f} m, "
            f"curvature {self.curvature:.4f} 1/m)"
        )

    def _repr_svg_(self) -> str | None:
        if self.nodes.ndim > 2:
            return None
        svg: str = import_module("cca_core.plot.svg").to_svg(self)
        return svg

    def __len__(self) -> int:
        return len(self.nodes)

    def __getitem__(self, index: int) -> "Band":
        """Return one band of a batch."""
        if self.nodes.ndim < 3:
            raise InputError("this is a single band, it has no batch_shape axis to index")
        n_bands, others = self.nodes.shape[0], self.nodes.shape[1:-2]
        at = range(n_bands)[index]
        chosen = {}
        for f in fields(self):
            value = getattr(self, f.name)
            if f.name == "passes_left":
                chosen[f.name] = value[:, at]
            elif value is None:
                chosen[f.name] = None
            elif f.name == "problem":
                chosen[f.name] = value.select(np.arange(len(value.route_nodes)).reshape(n_bands, -1)[at])
            else:
                item = value[at]
                chosen[f.name] = item.item() if not others and isinstance(item, np.generic) else item
        return Band(**chosen)

    @property
    def ok(self) -> Any:
        """Whether the status is OK; for a batch an array of shape (...)."""
        return self.status == Status.OK

    @property
    def side(self) -> Side:
        """Side of the largest displacement of a single band; left if there is none."""
        u = self._single().displacement
        return "left" if u.max() >= -u.min() else "right"

    @property
    def sides(self) -> tuple[Side, ...]:
        """Side on which a single band passes each obstacle."""
        return tuple("left" if left else "right" for left in self._single().passes_left)

    @property
    def residual(self) -> float:
        """KKT residual of a single band: largest unbalanced force, as the violation of a bound [m]."""
        band = self._single()
        free = band.problem.free_displacement[0]
        return float(
            kkt_residual(
                band.displacement - free, lower=band.lower - free, upper=band.upper - free,
                spacing=band.spacing, stiffness=band.problem.stiffness,
            )
        )  # fmt: skip

    def path(self, start: float = 0.0) -> Path:
        """Return the C2 curve through the nodes of a single band, with the route's curvature at both ends.

        Parameters
        ----------
        start : float
            Arc length of the first node [m].

        Returns
        -------
        path : Path
            Reference path.
        """
        band = self._single()
        return cubics_along(band.nodes, band.moment_over_6, float(start))

    def require(self) -> Self:
        """Return this band if its status is OK.

        Returns
        -------
        band : Band
            The band itself.

        Raises
        ------
        InfeasibleError
            If the status is not OK; for a batch, of any band.
        """
        if not np.all(self.ok):
            failed = self.message if self.nodes.ndim == 2 else self.message[~self.ok].flat[0]
            raise InfeasibleError(failed, self)
        return self

    def _single(self) -> Self:
        if self.nodes.ndim > 2:
            raise InputError("band must be a single band, was a batch; choose one, as in band[0]")
        return self


def assemble_band(
    problem: BandProblem,
    batch_shape: tuple[int, ...],
    u: Array,
    certificate: Certificate,
    *,
    passes_left: Mask,
    lower: Array,
    upper: Array,
    solves: Index,
    failures: Mapping[int, Failure],
) -> Band:
    """Return the bands of displacements (bands, n), with the status that their certificate gives them."""
    results = [failures.get(i) or _compare(problem, i, u[i], certificate) for i in range(len(u))]
    nodes = problem.route_nodes + 1j * problem.tangents * u
    shaped: dict[str, Any] = {
        "nodes": nodes.view(np.float64).reshape(*batch_shape, -1, 2),
        "displacement": u.reshape(*batch_shape, -1),
        "moment_over_6": certificate.moment_over_6.view(np.float64).reshape(*batch_shape, -1, 2),
        "lower": lower.reshape(*batch_shape, -1), "upper": upper.reshape(*batch_shape, -1),
        "passes_left": passes_left.reshape(-1, *batch_shape),
    }  # fmt: skip
    for array in shaped.values():
        array.setflags(write=False)
    values = {
        "clearance": certificate.min_gap, "edge_clearance": certificate.min_edge_clearance,
        "curvature": np.abs(certificate.curvature).max(axis=1), "spacing": problem.h, "n_solves": solves,
    }  # fmt: skip
    for name, value in values.items():
        shaped[name] = value.reshape(batch_shape) if batch_shape else value.item()
    status, message, active = zip(*results, strict=True)
    columns: dict[str, tuple[Any, ...]] = {
        "status": status, "message": message,
        "active_constraint": tuple(f"obstacle {a}" if isinstance(a, int) else a for a in active),
        "active_obstacle": tuple(a if isinstance(a, int) else None for a in active),
    }  # fmt: skip
    for name, column in columns.items():
        shaped[name] = np.array(column, dtype=object).reshape(batch_shape) if batch_shape else column[0]
    return Band(problem=problem, **shaped)


def _compare(problem: BandProblem, i: int, u: Array, certificate: Certificate) -> Failure:
    """Return status, message and active constraint of band `i`."""
    gap, edge = float(certificate.min_gap[i]), float(certificate.min_edge_clearance[i])
    excess = gap - problem.clearance
    nearest = int(certificate.gaps[:, i].min(axis=1).argmin()) if excess < math.inf else ""
    closest: int | str = nearest
    if edge < excess:
        closest = f"{'right' if certificate.right_margin[i].min() == edge else 'left'} edge"
    displacement = float(np.abs(u).max())
    if excess < -_ROUNDING:
        reason = f"clearance to obstacle {nearest} is {gap:.3f} m (limit {problem.clearance:.3f} m)"
        return Status.INFEASIBLE, reason, nearest
    if edge < -_ROUNDING:
        return Status.INFEASIBLE, f"the body crosses the {closest} by {-edge:.3f} m", closest
    if displacement > MAX_DISPLACEMENT:
        reason = f"displacement is {displacement:.0f} m (limit {MAX_DISPLACEMENT:.0f} m)"
        return Status.INFEASIBLE, reason, nearest
    if certificate.curvature_ratio[i] > 1.0 + _ROUNDING:
        curvature, limit = np.abs(certificate.curvature[i]), problem.curvature_limit[i]
        node = int((curvature / limit).argmax())
        reason = f"curvature is {curvature[node]:.4f} 1/m (limit {limit[node]:.4f} 1/m)"
        return Status.INFEASIBLE, reason, "curvature"
    return Status.OK, "clearance and limits satisfied", closest

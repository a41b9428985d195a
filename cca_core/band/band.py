"""The bent route, what it was asked to keep and what it keeps."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Annotated, Any, Self

import numpy as np

from cca_core._checks import Array, Index, Mask
from cca_core._svg import drawing
from cca_core.band.certificate import Certificate
from cca_core.band.corridor import Side
from cca_core.band.energy import kkt_residual
from cca_core.band.picture import band_marks
from cca_core.band.problem import MAX_DISPLACEMENT, BandProblem
from cca_core.errors import InfeasibleError, InputError, Status
from cca_core.path import Path
from cca_core.path.interpolate import cubics_along

_EXACT = 1e-9  # rounding error that is forgiven [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Band:
    """A stretch of the route, bent around obstacles; or many of them, with leading axes in every field.

    Parameters
    ----------
    nodes : ndarray, shape (..., n, 2)
        Deformed nodes [m] (eq 10), the last on the route, and the first unless it begins off it.
    displacement : ndarray, shape (..., n)
        Lateral displacement u of each node [m], left positive.
    clearance : float or ndarray, shape (...)
        Least distance between the ego's box, swept along the band between nodes as at nodes, and any
        obstacle's box at the same time [m]; infinite without obstacles, negative where they overlap. A lower
        bound of bands that swerve by less than 30 m; within 5 mm, and the bulge of the band between nodes,
        where it is less than 1 cm above what was asked.
    edge_clearance : float or ndarray, shape (...)
        The same toward the edges of the corridor [m].
    curvature : float or ndarray, shape (...)
        Largest curvature along the band [1/m], without sign.
    passes_left : ndarray of bool, shape (n_obstacles, ...)
        Whether the ego passes each obstacle on the obstacle's left.
    lower, upper : ndarray, shape (..., n)
        Bounds of the displacement that hold the band [m].
    spacing : float or ndarray, shape (...)
        Distance between nodes [m].
    status : Status or ndarray of Status, shape (...)
        `Status.OK` only if the clearance is at least what was asked, the body stays between the edges and
        the curvature within its limit.
    message : str or ndarray of str, shape (...)
        Why the status is what it is.
    active_constraint : str or ndarray of str, shape (...)
        What the band comes closest to or is stopped by: "obstacle 0", "left edge", "right edge", "curvature"
        or nothing.
    n_solves : int or ndarray of int, shape (...)
        Banded systems solved [-].
    moment_over_6 : ndarray, shape (..., n, 2)
        A sixth of the second derivative of the C2 cubic through the nodes [1/m].
    problem : Task
        What was asked, for those who go on with the band.
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
    qp_residual: float | None = None

    def __repr__(self) -> str:
        if self.nodes.ndim > 2:
            return f"Band({self.nodes.shape[:-2]} bands, {int(np.sum(self.ok))} OK)"
        return (
            f"Band({self.status.name}, {len(self.nodes)} nodes, swerves {self.side} by "
            f"{np.abs(self.displacement).max():.2f} m, clearance {self.clearance:.2f} m, "
            f"curvature {self.curvature:.4f} 1/m)"
        )

    def to_svg(self) -> str:
        """Draw a single band to scale, with route, edges and obstacles, as Jupyter shows it.

        Returns
        -------
        svg : str
            One ``svg`` element that needs nothing else.

        Raises
        ------
        InputError
            If these are many bands.
        """
        band = self._single()
        return drawing(band_marks(band), repr(band) if band.ok else f"{band.status.name}: {band.message}")

    def _repr_svg_(self) -> str | None:
        return self.to_svg() if self.nodes.ndim == 2 else None

    def __len__(self) -> int:
        return len(self.nodes)

    def __getitem__(self, index: int) -> "Band":
        """One band of many."""
        if self.nodes.ndim < 3:
            raise InputError("this is a single band, it has no leading axis to index")
        first, rest = self.nodes.shape[0], self.nodes.shape[1:-2]
        at = range(first)[index]
        chosen = {}
        for f in fields(self):
            value = getattr(self, f.name)
            if f.name == "passes_left":
                chosen[f.name] = value[:, at]
            elif value is None:
                chosen[f.name] = None
            elif f.name == "problem":
                chosen[f.name] = value.select(np.arange(len(value.route_nodes)).reshape(first, -1)[at])
            else:
                item = value[at]
                chosen[f.name] = item.item() if not rest and isinstance(item, np.generic) else item
        return Band(**chosen)

    @property
    def ok(self) -> Any:
        """Whether the status is OK; for many bands an array of shape (...)."""
        return self.status == Status.OK

    @property
    def side(self) -> Side:
        """Side to which a single band swerves farthest; left if it does not swerve."""
        u = self._single().displacement
        return "left" if u.max() >= -u.min() else "right"

    @property
    def sides(self) -> tuple[Side, ...]:
        """Side on which a single band passes each obstacle."""
        return tuple("left" if left else "right" for left in self._single().passes_left)

    @property
    def residual(self) -> float:
        """KKT residual of a single band: largest missing force, as the violation of a bound [m]."""
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
            The bent route to be driven.
        """
        band = self._single()
        return cubics_along(band.nodes, band.moment_over_6, float(start))

    def require(self) -> Self:
        """Return this band if it is usable.

        Returns
        -------
        band : Band
            The band itself.

        Raises
        ------
        InfeasibleError
            If the status is not OK, of any band if there are many.
        """
        if not np.all(self.ok):
            failed = self.message if self.nodes.ndim == 2 else self.message[~self.ok].flat[0]
            raise InfeasibleError(failed, self)
        return self

    def _single(self) -> Self:
        if self.nodes.ndim > 2:
            raise InputError("these are many bands; choose one, as in band[0]")
        return self


def assemble_band(
    task: BandProblem,
    batch_shape: tuple[int, ...],
    u: Array,
    certificate: Certificate,
    *,
    passes_left: Mask,
    lower: Array,
    upper: Array,
    solves: Index,
    stuck: Mapping[int, tuple[Status, str, str]],
) -> Band:
    """Compare what bands keep with what was asked.

    Parameters
    ----------
    task : Task
        What was asked.
    batch_shape : tuple of int
        Leading axes of the result; () for a single band.
    u : ndarray, shape (bands, n)
        Displacement [m].
    certificate : Certificate
        What it keeps.
    passes_left : ndarray of bool, shape (m, bands)
        Sides.
    lower, upper : ndarray, shape (bands, n)
        Bounds that hold the displacement [m].
    solves : ndarray of int, shape (bands,)
        Banded systems solved [-].
    stuck : mapping of int to (Status, str, str)
        Status, message and what binds of those bands that were not solved.

    Returns
    -------
    band : Band
        The bands with their status.
    """
    kept, edge, bent = certificate.min_gap, certificate.min_edge_clearance, certificate.curvature_ratio
    curvature = np.abs(certificate.curvature).max(axis=1)
    farthest = np.abs(u).max(axis=1)
    outcomes = []
    for i in range(len(u)):
        spare = float(kept[i]) - task.clearance
        nearest = f"obstacle {certificate.gaps[:, i].min(axis=1).argmin()}" if spare < math.inf else ""
        closest = nearest
        if edge[i] < spare:
            closest = f"{'right' if certificate.right_margin[i].min() == edge[i] else 'left'} edge"
        outcome = Status.OK, "clearance and limits kept", closest
        if i in stuck:
            outcome = stuck[i]
        elif spare < -_EXACT:
            reason = f"{kept[i]:.3f} m from {nearest} is below the {task.clearance:.3f} m asked"
            outcome = Status.INFEASIBLE, reason, nearest
        elif edge[i] < -_EXACT:
            outcome = Status.INFEASIBLE, f"the body crosses the {closest} by {-edge[i]:.3f} m", closest
        elif farthest[i] > MAX_DISPLACEMENT:
            outcome = Status.INFEASIBLE, f"it would swerve by {farthest[i]:.0f} m", nearest
        elif bent[i] > 1.0 + _EXACT:
            how = f"{bent[i]:.2f} times the limit" if bent[i] >= 1.005 else "just above the limit"
            reason = f"curvature {curvature[i]:.4f} 1/m is {how}"
            outcome = Status.INFEASIBLE, reason, "curvature"
        outcomes.append(outcome)
    nodes = task.route_nodes + 1j * task.tangents * u
    shaped: dict[str, Any] = {
        "nodes": nodes.view(np.float64).reshape(*batch_shape, -1, 2), "displacement": u.reshape(*batch_shape, -1),
        "moment_over_6": certificate.sixth.view(np.float64).reshape(*batch_shape, -1, 2),
        "lower": lower.reshape(*batch_shape, -1), "upper": upper.reshape(*batch_shape, -1),
        "passes_left": passes_left.reshape(-1, *batch_shape),
    }  # fmt: skip
    for array in shaped.values():
        array.setflags(write=False)
    values = {
        "clearance": kept, "edge_clearance": edge, "curvature": curvature, "spacing": task.h,
        "n_solves": solves,
    }  # fmt: skip
    for name, value in values.items():
        shaped[name] = value.reshape(batch_shape) if batch_shape else value.item()
    for name, column in zip(
        ("status", "message", "active_constraint"), zip(*outcomes, strict=True), strict=True
    ):
        shaped[name] = np.array(column, dtype=object).reshape(batch_shape) if batch_shape else column[0]
    return Band(problem=task, **shaped)

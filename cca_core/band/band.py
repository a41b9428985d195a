"""Band: the deformed route with its certificate and status."""

from dataclasses import dataclass, fields
from importlib import import_module
from typing import Annotated, Any, Self

import numpy as np

from cca_core._checks import Array, Mask, check_real
from cca_core.band.corridor import Side
from cca_core.band.energy import kkt_residual
from cca_core.band.outcome import Outcome, outcome_of
from cca_core.band.problem import BandProblem
from cca_core.band.solver import Relaxed, measure
from cca_core.errors import InfeasibleError, InputError, Status
from cca_core.kernel import bind
from cca_core.kernel.band_cubics import join_cubics
from cca_core.kernel.band_workspace import REALS
from cca_core.path import Path

_join_cubics = bind(join_cubics)


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
        Least distance between the swept box and the edges of the corridor [m]. In bends it may exceed the
        true one by up to 5 mm.
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
                chosen[f.name] = value.select(np.arange(len(value.nodes)).reshape(n_bands, -1)[at])
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
        free = measure(band.problem).free
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

        Raises
        ------
        InputError
            If `start` is not finite, or so large that it has no digits left for the band.
        """
        band, start = self._single(), check_real("start", start)
        segments = len(band) - 1
        breaks, coefficients = np.empty(segments + 1), np.empty((segments, 8))
        _join_cubics(segments, band.nodes, band.moment_over_6, start, breaks, coefficients)
        if not breaks[0] < breaks[1]:
            raise InputError(f"start must be less in magnitude, was {start:g}")
        return Path._trusted(breaks, coefficients.reshape(segments, 2, 4))

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


def assemble_band(problem: BandProblem, batch_shape: tuple[int, ...], found: Relaxed) -> Band:
    """Return the bands that the kernel has found."""
    found.reals.setflags(write=False)
    found.passes_left.setflags(write=False)
    if not batch_shape:
        return _assemble_one(problem, found)
    arrays: dict[str, Any] = {
        "nodes": found.points(0).reshape(*batch_shape, -1, 2),
        "moment_over_6": found.points(2).reshape(*batch_shape, -1, 2),
        "displacement": found.row(4).reshape(*batch_shape, -1),
        "lower": found.row(5).reshape(*batch_shape, -1), "upper": found.row(6).reshape(*batch_shape, -1),
        "passes_left": found.passes_left.reshape(-1, *batch_shape),
    }  # fmt: skip
    reals, codes = found.reals[:, :REALS].tolist(), found.codes.tolist()
    results = [outcome_of(*rows, problem.clearance) for rows in zip(reals, codes, strict=True)]
    shaped: dict[str, Any] = {
        name: np.array(column, dtype=object).reshape(batch_shape)
        for name, column in zip(Outcome._fields, zip(*results, strict=True), strict=True)
    }
    for i, name in enumerate(("clearance", "edge_clearance", "curvature", "spacing")):
        shaped[name] = found.reals[:, i].reshape(batch_shape)
    shaped["n_solves"] = found.codes[:, 5].astype(np.intp).reshape(batch_shape)
    return Band(problem=problem, **shaped, **arrays)


def _assemble_one(problem: BandProblem, found: Relaxed) -> Band:
    """Return a band that is no batch."""
    n, row, codes = found.n, found.reals[0], found.codes[0].tolist()
    reals = row[:REALS].tolist()
    status, message, active_constraint, active_obstacle = outcome_of(reals, codes, problem.clearance)
    nodes, moments, displacement, lower, upper = (
        REALS,
        REALS + 2 * n,
        REALS + 4 * n,
        REALS + 5 * n,
        REALS + 6 * n,
    )
    return Band(
        nodes=row[nodes:moments].reshape(n, 2), moment_over_6=row[moments:displacement].reshape(n, 2),
        displacement=row[displacement:lower], lower=row[lower:upper], upper=row[upper:],
        passes_left=found.passes_left.reshape(-1), clearance=reals[0], edge_clearance=reals[1],
        curvature=reals[2], spacing=reals[3], n_solves=codes[5], status=status, message=message,
        active_constraint=active_constraint, active_obstacle=active_obstacle, problem=problem,
    )  # fmt: skip

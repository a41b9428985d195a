"""The band of the kernel: problems into its workspaces, results out of them."""

from dataclasses import dataclass, fields

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.band.corridor import refuse_boxes
from cca_core.band.problem import MAX_DISPLACEMENT, BandProblem, check_nodes
from cca_core.band.settings import BandSettings
from cca_core.band.stiffness import BandStiffness
from cca_core.errors import InputError
from cca_core.kernel import bind
from cca_core.kernel.band_batch import measure_band, relax_bands
from cca_core.kernel.band_workspace import (
    CODES,
    INVALID_BOXES,
    OK,
    REALS,
    REALS_PER_NODE,
    TOO_LONG,
    UNEVEN_SPACING,
    BandBatch,
    BandWork,
    Equilibrium,
)
from cca_core.kernel.batches import in_chunks
from cca_core.kernel.memory import keep, lend, pick, put
from cca_core.vehicle import VehicleParams

_relax_bands, _measure_band = bind(relax_bands), bind(measure_band)
_CHUNK = 32  # bands that are lent to the kernel at once
_MAX_KEPT = 2**18  # boxes of a workspace that a thread keeps
_MAX_BOXES = 2**28  # of a workspace, whose indices are C's int
_MAX_CERTIFIED = 2**16  # side assignments; there are no more
_MAX_INT = 2**31 - 1
_STIFFNESS = tuple(field.name for field in fields(BandStiffness))
_FRACTIONS = tuple(field.name for field in fields(BandSettings) if isinstance(field.default, float))
_COUNTS = tuple({field.name for field in fields(BandSettings)} - {*_FRACTIONS, "max_certified_sides"})
_ROWS = "free", "route_curvature", "lower", "upper", "curvature", "right_margin", "left_margin"
_GRIDS = "passing_right", "passing_left"


class Relaxed:
    """What the kernel finds for a batch of bands: a row of reals and one of codes for each."""

    def __init__(self, n: int, reals: Array, codes: Array, passes_left: Mask) -> None:
        self.n, self.reals, self.codes, self.passes_left = n, reals, codes, passes_left

    @classmethod
    def empty(cls, bands: int, m: int, n: int) -> "Relaxed":
        """Make room for the results of bands."""
        reals = np.empty((bands, REALS + REALS_PER_NODE * n))  # [m], clearance, ..., as in the kernel
        return cls(n, reals, np.empty((bands, CODES), np.int32), np.empty((m, bands), np.bool_))

    def part(self, bands: slice) -> "Relaxed":
        """Return the results of some bands, in the same memory."""
        return Relaxed(self.n, self.reals[bands], self.codes[bands], self.passes_left[:, bands])

    def points(self, first: int) -> Array:
        """Return pairs of reals of each node, of which so many rows stand before, shape (bands, n, 2)."""
        n = self.n
        begin = REALS + first * n
        return self.reals[:, begin : begin + 2 * n].reshape(-1, n, 2)

    def row(self, first: int) -> Array:
        """Return a real of each node, of which so many rows stand before, shape (bands, n)."""
        begin = REALS + first * self.n
        return self.reals[:, begin : begin + self.n]


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Frame, bounds and certificate of a displacement of one band."""

    free: Array  # response to the start alone [m], (n,), as the next ones
    tangents: Array  # unit tangents of the route [-], (n, 2)
    route_curvature: Array  # [1/m]
    lower: Array  # bounds of the displacement for the sides [m]
    upper: Array
    passing_right: Array  # displacement at which obstacles are passed [m], infinite if far, (m, n)
    passing_left: Array
    curvature: Array  # of the band [1/m]
    gaps: Array  # least gap to each obstacle around each node [m], infinite if far, (m, n)
    right_margin: Array  # of the body to the edges [m]
    left_margin: Array
    spacing: float  # [m]
    min_gap: float  # [m]
    min_edge_clearance: float  # [m]
    curvature_ratio: float  # largest curvature as a multiple of its limit [-]
    found: Relaxed  # with the bounds for the sides


class Workspace:
    """Memory for bands of up to some size, and what it holds already."""

    def __init__(self, bands: int, n: int, m: int, certified: int) -> None:
        self.key = bands, n, m, certified
        self.batch = lend(BandBatch, max_n=n, max_m=m, max_bands=bands)
        self.work = lend(BandWork, max_n=n, max_m=m, max_certified=certified)
        self.equilibrium = lend(Equilibrium, max_n=n)
        self.kernel_arguments = self.batch.workspace, self.work.workspace, self.equilibrium.workspace
        self.boxes = self.batch.arrays["boxes"].reshape(-1, n)
        self.constants: tuple[object, ...] = ()

    def give_back(self) -> None:
        """Leave the memory to the next band of this thread."""
        bands, n, m, _ = self.key
        if bands * n * m <= _MAX_KEPT:
            keep(self.key, self)

    def take(self, problem: BandProblem, rule: int, sides: Mask | None, former: Mask | None) -> None:
        """Copy a problem."""
        q, asked = self.batch.workspace, self.batch.arrays
        bands, n = problem.nodes.shape[:2]
        m = problem.boxes.shape[1]
        q.n, q.m, q.bands, q.side_rule = n, m, bands, rule
        q.has_edges, q.has_former = problem.edges is not None, former is not None
        asked["nodes"][:bands, : 2 * n] = problem.nodes.reshape(bands, -1)
        self.boxes[: 5 * m * bands, :n] = problem.boxes.reshape(-1, n)
        if problem.edges is not None:
            asked["right_edge"][:bands, :n], asked["left_edge"][:bands, :n] = problem.edges
        asked["curvature_limit"][:bands, :n] = problem.curvature_limit
        asked["start"][:bands] = problem.start
        asked["lead_distance"][:m] = problem.lead_distance
        if sides is not None:
            asked["passes_left"][: m * bands] = sides.reshape(-1)
        if former is not None:
            asked["former"][: m * bands] = former.reshape(-1)
        self.work.workspace.clearance = problem.clearance
        constants = problem.vehicle, problem.stiffness, problem.settings
        if self.constants != constants:
            self._take_constants(*constants)
            self.constants = constants

    def _take_constants(
        self, vehicle: VehicleParams, stiffness: BandStiffness, settings: BandSettings
    ) -> None:
        """Copy what is frozen and often the same."""
        w = self.work.workspace
        put(
            w, length=vehicle.length, width=vehicle.width, box_offset=vehicle.box_offset,
            max_displacement=MAX_DISPLACEMENT,
            **{name: getattr(stiffness, name) for name in _STIFFNESS},
            **{name: getattr(settings, name) for name in _FRACTIONS},
        )  # fmt: skip
        for name in _COUNTS:
            setattr(w, name, int(min(getattr(settings, name), _MAX_INT)))
        w.n_certified = w.max_certified


def borrow(problem: BandProblem) -> Workspace:
    """Return memory for a problem: what this thread has given back, or new."""
    bands, n = problem.nodes.shape[:2]
    m = problem.boxes.shape[1]
    # powers of 2, so that a band that grows by a node does not need new memory
    bands, n, m = _power_of_2(bands), _power_of_2(n), _power_of_2(m)
    if bands * m * n > _MAX_BOXES:
        raise InputError(f"obstacles times nodes must be at most {_MAX_BOXES}, was {m} times {n}")
    certified = int(min(problem.settings.max_certified_sides, _MAX_CERTIFIED))
    kept: Workspace | None = pick((bands, n, m, certified))
    return Workspace(bands, n, m, certified) if kept is None else kept


def _power_of_2(size: int) -> int:
    """Return the least power of 2 that is not less than a size."""
    return 1 << (size - 1).bit_length() if size > 1 else 1


def relax(problem: BandProblem, rule: int, sides: Mask | None, former: Mask | None, threads: int) -> Relaxed:
    """Relax the bands of a problem; sides have the shape (m, bands)."""
    bands = len(problem.nodes)
    found = Relaxed.empty(bands, problem.boxes.shape[1], problem.nodes.shape[1])
    if bands == 1:
        _relax_part(problem, rule, sides, former, found)
        return found

    per_band = problem.boxes[0, :, 0].size
    size = max(min(_CHUNK, _MAX_KEPT // max(per_band, 1)), 1)

    def relax_chunks(_: int, first: int, end: int) -> None:
        for begin in range(first, end, size):
            part = slice(begin, min(begin + size, end))
            given, last = (None if of is None else of[:, part] for of in (sides, former))
            _relax_part(problem.select(part), rule, given, last, found.part(part))

    in_chunks(relax_chunks, bands, threads)
    return found


def _relax_part(
    problem: BandProblem, rule: int, sides: Mask | None, former: Mask | None, found: Relaxed
) -> None:
    """Relax bands that a workspace holds."""
    bands, m = len(problem.nodes), problem.boxes.shape[1]
    space = borrow(problem)
    space.take(problem, rule, sides, former)
    reals, codes = found.reals, found.codes
    _relax_bands(*space.kernel_arguments, bands, reals.shape[1], reals.reshape(-1), codes.reshape(-1))
    status = codes[:, 0].tolist()
    if max(status) >= UNEVEN_SPACING:
        _refuse(problem, status)
    found.passes_left[...] = space.batch.arrays["passes_left"][: m * bands].reshape(m, bands)
    space.give_back()


def _refuse(problem: BandProblem, status: list[int]) -> None:
    """Raise for obstacles that are none, or a route that no band can begin on."""
    if INVALID_BOXES in status:
        refuse_boxes(problem.boxes)
    if TOO_LONG in status:
        raise InputError(f"nodes must be fewer if a band begins off its route, was {problem.nodes.shape[1]}")
    if len(problem.nodes) == 1:
        check_nodes(problem.nodes[0])
    steps = np.diff(problem.nodes, axis=1)
    lengths = np.hypot(steps[..., 0], steps[..., 1])
    raise InputError(
        f"nodes must be equally spaced along the route, as those of Path.sample are; "
        f"neighbors are {lengths.min():.3g} to {lengths.max():.3g} m apart"
    )


def measure(problem: BandProblem, u: Array | None = None, passes_left: Mask | None = None) -> Measured:
    """Certify a displacement (n,) of a single band, by default none; find its bounds for sides (m,)."""
    n, m = problem.nodes.shape[1], problem.boxes.shape[1]
    space, result = borrow(problem), Relaxed.empty(1, m, n)
    space.take(problem, 0, np.ones(m, dtype=np.bool_) if passes_left is None else passes_left, None)
    status = _measure_band(
        *space.kernel_arguments, n, np.zeros(n) if u is None else u, result.reals.shape[1],
        result.reals.reshape(-1), result.codes.reshape(-1),
    )  # fmt: skip
    if status != OK:
        _refuse(problem, [status])
    result.passes_left[:, 0] = space.batch.arrays["passes_left"][:m]
    w, found = space.work.workspace, space.work.arrays
    rows = {name: found[name][:n].copy() for name in _ROWS}
    grids = {name: found[name][:m, :n].copy() for name in _GRIDS}
    gaps = np.full((m, n), np.inf)
    obstacles, near, bounds = (found[name][: w.n_pairs] for name in ("pair_obstacle", "pair_node", "bound"))
    gaps[obstacles, near] = bounds
    tangents = np.stack((found["tangent_x"][:n], found["tangent_y"][:n]), axis=1)
    measured = Measured(
        **rows, **grids, found=result, gaps=gaps, tangents=tangents, spacing=w.spacing, min_gap=w.min_gap,
        min_edge_clearance=w.min_edge_clearance, curvature_ratio=w.curvature_ratio,
    )  # fmt: skip
    space.give_back()
    return measured

"""Double lane changes of ISO 3888: tracks, and a path through the gates."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.band import Band, relax_band, smooth_band
from cca_core.errors import InputError
from cca_core.geometry import Boxes, boxes
from cca_core.vehicle import VehicleParams

Offset = Literal["center to center", "edge to center", "edge to edge"]
"""Reference of the lane offset of 3.5 m in part 1."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DoubleLaneChange:
    """Three gates; x counts from the entry, y from the right edge of the first.

    Parameters
    ----------
    gates : ndarray, shape (3, 4)
        Begin, end, right and left edge of each gate [m].
    release : float
        Position of the front of the car at which the throttle is released [m]; infinite for constant speed.
    """

    gates: Array
    release: float = math.inf

    def nodes(self, *, run_in: float = 40.0, run_out: float = 60.0, spacing: float = 0.5) -> Array:
        """Return the undeformed route, the centerline of the first gate.

        Parameters
        ----------
        run_in, run_out : float
            Length before and after the track [m].
        spacing : float
            Distance of nodes [m].

        Returns
        -------
        nodes : ndarray, shape (n, 2)
            Points of the route [m].
        """
        x = np.arange(-run_in, self.gates[-1, 1] + run_out + 0.5 * spacing, spacing)
        return np.column_stack((x, np.full(len(x), 0.5 * (self.gates[0, 2] + self.gates[0, 3]))))

    def obstacles(self, *, depth: float = 10.0) -> list[Boxes]:
        """Return the ground outside the gates.

        Parameters
        ----------
        depth : float
            Lateral extent of the ground on each side [m].

        Returns
        -------
        blocks : list of Boxes
            To the right and to the left of the first gate, of the second and of the third.
        """
        return [
            boxes(0.5 * (start + end), y, 0.0, end - start, depth)
            for start, end, right, left in self.gates.tolist()
            for y in (right - 0.5 * depth, left + 0.5 * depth)
        ]


def iso3888_1(width: float, *, offset: Offset = "center to center") -> DoubleLaneChange:
    """Track of ISO 3888-1, the severe double lane change of 125 m.

    Parameters
    ----------
    width : float
        Width of the car without its mirrors [m].
    offset : {"center to center", "edge to center", "edge to edge"}
        Reference of the lane offset of 3.5 m: between the centerlines of the first two gates; between the
        centerline of the first and the right edge of the second (the largest, as in Project Chrono); or 1 m
        between the left edge of the first and the right edge of the second (the smallest).

    Returns
    -------
    course : DoubleLaneChange
        Gates 15 m, 25 m and 30 m long (the last with its tail), 30 m and 25 m apart; constant speed.

    Raises
    ------
    InputError
        If `width` is not positive or `offset` is unknown.

    Notes
    -----
    The standard [1]_ was not available: the dimensions are those of public programs, which interpret the lane
    offset differently. The tail, the last 15 m, is unconfirmed.

    References
    ----------
    .. [1] ISO 3888-1, *Passenger cars - Test track for a severe lane-change maneuver - Part 1: Double
       lane-change*.
    """
    a, b, c = (k * check_real("width", width, gt=0.0) + 0.25 for k in (1.1, 1.2, 1.3))
    right = {
        "center to center": 0.5 * a + 3.5 - 0.5 * b, "edge to center": 0.5 * a + 3.5, "edge to edge": a + 1.0,
    }.get(offset)  # fmt: skip
    if right is None:
        raise InputError(f"offset must be one of {get_args(Offset)}, was {offset!r}")
    gates = [[0.0, 15.0, 0.0, a], [45.0, 70.0, right, right + b], [95.0, 125.0, 0.0, c]]
    return DoubleLaneChange(gates=np.array(gates))


def iso3888_2(width: float) -> DoubleLaneChange:
    """Track of ISO 3888-2, the obstacle avoidance of 61 m.

    Parameters
    ----------
    width : float
        Width of the car without its mirrors [m].

    Returns
    -------
    course : DoubleLaneChange
        Gates 12 m, 11 m and 12 m long, 13.5 m and 12.5 m apart, the second 1 m to the left of the first, the
        third at least 3 m wide; the throttle is released 2 m after the entry.

    Raises
    ------
    InputError
        If `width` is not positive.

    Notes
    -----
    Of the standard [1]_ only the total length was available; the other dimensions are those of public
    programs. They disagree on the width of the third gate: its minimum of 3 m is unconfirmed, and so is the
    position of the throttle release.

    References
    ----------
    .. [1] ISO 3888-2, *Passenger cars - Test track for a severe lane-change maneuver - Part 2: Obstacle
       avoidance*.
    """
    width = check_real("width", width, gt=0.0)
    a, c = 1.1 * width + 0.25, max(1.3 * width + 0.25, 3.0)
    gates = [[0.0, 12.0, 0.0, a], [25.5, 36.5, a + 1.0, a + width + 2.0], [49.0, 61.0, 0.0, c]]
    return DoubleLaneChange(gates=np.array(gates), release=2.0)


def plan_gate_path(
    course: DoubleLaneChange,
    vehicle: VehicleParams,
    speed: float,
    *,
    a_y: float = 6.6,
    jerk: float = 20.0,
    tolerance: float = 0.005,
) -> Band:
    """Plan the smoothest path through the gates with the largest feasible clearance.

    Parameters
    ----------
    course : DoubleLaneChange
        The track.
    vehicle : VehicleParams
        The car, whose body is swept along the path.
    speed : float
        Constant speed that the limits refer to [m/s].
    a_y : float
        Maximum lateral acceleration [m/s^2].
    jerk : float
        Maximum rate of change of the lateral acceleration [m/s^3].
    tolerance : float
        Tolerance of the maximized clearance [m].

    Returns
    -------
    band : Band
        The path; its clearance is the minimum distance of the body to a gate. Not OK if there is none.

    Raises
    ------
    InputError
        If a value is not positive.
    MissingExtraError
        If the extra ``qp`` is not installed.

    Notes
    -----
    The band keeps clear of the ground outside the gates. The edges of a corridor begin and end at nodes; with
    them the car driven through part 2 has a clearance of 3 cm instead of 7 cm. The band is planned first
    without limits. The result is the route of the next bands: on it the heading in the gates is known well
    enough for hard limits. The clearance grows until there is no path.
    """
    speed = check_real("speed", speed, gt=0.0)
    limit = check_real("a_y", a_y, gt=0.0) / speed**2
    rate = check_real("jerk", jerk, gt=0.0) / speed**3
    tolerance = check_real("tolerance", tolerance, gt=0.0)
    blocks = course.obstacles()

    def plan(nodes: Array, clearance: float, limit: float, rate: float) -> Band:
        band = relax_band(
            nodes, blocks, side=["left", "right"] * 3, vehicle=vehicle, clearance=clearance,
            curvature_limit=limit,
        )  # fmt: skip
        return smooth_band(band, curvature_rate_limit=rate)

    best = plan(course.nodes(), 0.0, math.inf, math.inf)
    clearance, step = 0.0, 16.0 * tolerance
    while step >= tolerance:
        path = best.path()
        nodes = path.position(np.linspace(path.start, path.end, len(best)))
        band = plan(nodes, clearance, limit, rate)
        if band.ok:
            best = band
        elif clearance == 0.0:
            return band
        else:
            clearance, step = clearance - step, 0.5 * step
        clearance += step
    return best

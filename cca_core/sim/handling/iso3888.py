"""The double lane changes of ISO 3888: their tracks, and a path through the gates."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.band import Band, relax_band, smooth_band
from cca_core.errors import InputError
from cca_core.geometry import Boxes, boxes
from cca_core.vehicle import VehicleParams

__all__ = ["DoubleLaneChange", "Offset", "iso3888_1", "iso3888_2", "plan_gate_path"]

Offset = Literal["center to center", "edge to center", "edge to edge"]
"""What the 3.5 m of lane offset are measured between in part 1."""

_RUN_IN, _RUN_OUT = 40.0, 60.0  # [m]
_SPACING = 0.5  # of nodes [m]
_BESIDE = 10.0  # to the side of a gate the ground is taken up to here [m]
_FINEST = 0.005  # to which the distance to the gates is maximized [m]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DoubleLaneChange:
    """Three gates, the middle one to the left; x counts from the entry, y from the right edge of the first.

    Parameters
    ----------
    gates : ndarray, shape (3, 4)
        Beginning, end, right and left edge of each gate [m].
    release : float
        Where the front of the car is when the throttle is released [m]; infinite if speed is held.
    """

    gates: Array
    release: float = math.inf

    def nodes(self) -> Array:
        """Return the centerline of the first gate, from 40 m before the track to 60 m behind it.

        Returns
        -------
        nodes : ndarray, shape (n, 2)
            Points of the undeformed route, half a meter apart [m].
        """
        x = np.arange(-_RUN_IN, self.gates[-1, 1] + _RUN_OUT + 0.5 * _SPACING, _SPACING)
        return np.column_stack((x, np.full(len(x), 0.5 * (self.gates[0, 2] + self.gates[0, 3]))))

    def obstacles(self) -> list[Boxes]:
        """Return the ground beside the gates.

        Returns
        -------
        blocks : list of Boxes
            To the right and to the left of the first gate, of the second and of the third.
        """
        ground = []
        for start, end, right, left in self.gates.tolist():
            for y in (right - 0.5 * _BESIDE, left + 0.5 * _BESIDE):
                ground.append(boxes(0.5 * (start + end), y, 0.0, end - start, _BESIDE))
        return ground


def iso3888_1(width: float, *, offset: Offset = "center to center") -> DoubleLaneChange:
    """Track of ISO 3888-1, the severe double lane change of 125 m.

    Parameters
    ----------
    width : float
        Of the car without its mirrors [m].
    offset : {"center to center", "edge to center", "edge to edge"}
        What the 3.5 m of lane offset are measured between: the centerlines of the first two gates; the
        centerline of the first and the right edge of the second (the longest way, as in Project Chrono); or
        the left edge of the first and the right edge of the second less 2.5 m, which leaves 1 m between them
        (the shortest).

    Returns
    -------
    course : DoubleLaneChange
        Gates 15 m, 25 m and 30 m long (the last with its tail), 30 m and 25 m apart; speed is held.

    Raises
    ------
    InputError
        If `width` is not positive or `offset` is unknown.

    Notes
    -----
    The standard [1]_ was not at hand: the dimensions are those of public programs, which read the lane offset
    differently. The tail, the last 15 m, is unconfirmed.

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
        Of the car without its mirrors [m].

    Returns
    -------
    course : DoubleLaneChange
        Gates 12 m, 11 m and 12 m long, 13.5 m and 12.5 m apart, the second 1 m to the left of the first, the
        third at least 3 m wide; the throttle is released 2 m behind the entry.

    Raises
    ------
    InputError
        If `width` is not positive.

    Notes
    -----
    The standard [1]_ was not at hand but for its total length; the other dimensions are those of public
    programs. They disagree on the width of the third gate: that 3 m is its least width is unconfirmed, and
    so is where the throttle is released.

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
    course: DoubleLaneChange, vehicle: VehicleParams, speed: float, *, a_y: float = 6.6, jerk: float = 20.0
) -> Band:
    """Smoothest path through the gates with as much room to them as the limits allow.

    Parameters
    ----------
    course : DoubleLaneChange
        The track.
    vehicle : VehicleParams
        The car, whose body is swept along the path.
    speed : float
        Entry speed, taken to be held [m/s].
    a_y : float
        Largest lateral acceleration [m/s^2].
    jerk : float
        Largest change of lateral acceleration [m/s^3].

    Returns
    -------
    band : Band
        The path; its clearance is the least distance of the body to a gate. Not OK if there is none.

    Raises
    ------
    InputError
        If a value is not positive.
    MissingExtraError
        If the extra ``qp`` is not installed.

    Notes
    -----
    The ground beside the gates is what the band keeps clear of: edges of a corridor begin and end at nodes,
    and with them the car driven through part 2 is left 3 cm instead of 7 cm. The band is bent once without
    limits and then becomes the route to be bent again, on which the heading in the gates is known well enough
    for hard limits; the distance asked grows until there is no path.
    """
    speed = check_real("speed", speed, gt=0.0)
    limit = check_real("a_y", a_y, gt=0.0) / speed**2
    rate = check_real("jerk", jerk, gt=0.0) / speed**3
    blocks = course.obstacles()

    def bent(nodes: Array, room: float, limit: float, rate: float) -> Band:
        band = relax_band(
            nodes, blocks, side=["left", "right"] * 3, vehicle=vehicle, clearance=room, curvature_limit=limit
        )
        return smooth_band(band, curvature_rate_limit=rate)

    best = bent(course.nodes(), 0.0, math.inf, math.inf)
    room, step = 0.0, 16.0 * _FINEST
    while step >= _FINEST:
        path = best.path()
        nodes = path.position(np.linspace(path.start, path.end, len(best)))
        band = bent(nodes, room, limit, rate)
        if band.ok:
            best = band
        elif room == 0.0:
            return band
        else:
            room, step = room - step, 0.5 * step
        room += step
    return best

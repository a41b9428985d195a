"""Certificate of a plan, and the safe stop that it holds for."""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from cca_core._checks import Array
from cca_core._repr import short_repr
from cca_core.path import Path, interpolate_path

__all__ = ["Certificate", "Grade", "SafeStop"]

_NODE_SPACING = 1.0  # of a path through poses [m]


class Grade(IntEnum):
    """What a plan is certified against; lower is better.

    Attributes
    ----------
    COMFORTABLE
        The worst case: no vehicle within the declared bounds can collide with an ego that drives its safe
        stop. The stop needs at most `CertificateSettings.comfortable_braking`; in a maneuver, the path is
        comfortable.
    FULL
        The same; the stop needs more, or the path is beyond comfort.
    RESPONSE
        The worst case cannot be excluded. Until it can, the ego brakes in comfort or harder, up to fully:
        the proper response of RSS.
    NOMINAL
        The nominal motion of others only.
    SEVERITY
        Nothing: a collision or too small a gap is predicted, and the least severe plan is driven.
    REFUSED
        The same in an adjacent lane that is not known to be free, or past a stop line ahead of a crossing
        vehicle. Such a plan is driven if there is no other.
    """

    COMFORTABLE = 0
    FULL = 1
    RESPONSE = 2
    NOMINAL = 3
    SEVERITY = 4
    REFUSED = 5

    @property
    def tier(self) -> int:
        """Rank of the choice: the first three are compared by cost."""
        return max(int(self), 2)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SafeStop:
    """Steering and braking that stop the ego without a planner: what the certificate of a command is about.

    It drives the plan for `CertificateSettings.reaction_time` and brakes then, on the path of the plan or on
    a way back to the ego lane; or it completes a maneuver first.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times from the command on [s], until standstill, at least 5 s and at most 20 s. The first ones lie
        before a command that was not decided anew.
    delta : ndarray, shape (n,)
        Road-wheel angles [rad], left positive.
    a_x : ndarray, shape (n,)
        Accelerations [m/s^2].
    v : ndarray, shape (n,)
        Speeds [m/s].
    poses : ndarray, shape (n, 3)
        x [m], y [m] of the center of gravity, and heading [rad].
    """

    t: Array
    delta: Array
    a_x: Array
    v: Array
    poses: Array

    __repr__ = short_repr

    def path(self) -> Path | None:
        """Path through the poses.

        Returns
        -------
        path : Path or None
            Its first station is 0; None if the stop does not move by 2 m.
        """
        driven = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(self.poses[:, :2], axis=0).T))))
        if driven[-1] < 2.0 * _NODE_SPACING:
            return None
        # the first pose of each meter; the last one stays even if its cell has another
        rows = np.flatnonzero(np.diff(np.floor(driven / _NODE_SPACING), prepend=-1.0) > 0.0)
        rows[-1] = len(driven) - 1
        x, y, psi = self.poses[rows].T
        tangents = np.column_stack((np.cos(psi), np.sin(psi)))
        return interpolate_path(np.column_stack((x, y)), start_tangent=tangents[0], end_tangent=tangents[-1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """What is certified of the plan that is driven.

    Parameters
    ----------
    grade : Grade
        What it is certified against.
    braking : float
        Deceleration that the safe stop needs [m/s^2]; 0 if the plan is safe in the worst case without, for
        all of its 20 s; infinite if none suffices. Of a maneuver it is
        `CertificateSettings.comfortable_braking`, although the stop may brake harder.
    gap : float
        Least gap to the nominal motion of other vehicles [m], negative if they overlap; infinite without any.
    vehicle_id : str
        The vehicle that decides: the one to which the certificate leaves least, or that prevents it; empty if
        there is none.
    passed : frozenset of str
        The vehicles that the safe stop still passes. They are assumed to accelerate with at most
        `EvasionSettings.assumed_acceleration_passed`.

    Notes
    -----
    `safety.md` lists the bounds within which the worst case holds.
    """

    grade: Grade
    braking: float = math.inf
    gap: float = math.inf
    vehicle_id: str = ""
    passed: frozenset[str] = frozenset()

    __repr__ = short_repr

    @property
    def keeps_worst_case(self) -> bool:
        """Whether no vehicle within the declared bounds can collide with an ego that drives its safe stop."""
        return self.grade <= Grade.FULL

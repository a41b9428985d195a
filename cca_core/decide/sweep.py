"""Where two bodies that move along curves could touch: samples of both, grown so that nothing is missed."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from cca_core._checks import Array, Complex
from cca_core.path import Path
from cca_core.vehicle import RemoteVehicle, VehicleParams

__all__ = ["Sweep", "always_parallel", "heading_range"]

_SPACING = 1.0  # of the samples, at most [m]
_BLOCK = 4  # samples that are looked at together first
_ROWS, _COLUMNS = np.divmod(np.arange(_BLOCK * _BLOCK), _BLOCK)  # all pairs of places in two blocks
_CORNER = 0.5 * math.pi  # a turning vehicle goes on straight after a right angle [rad]
_STRAIGHT = 1.0e-3  # curvature below which it is not turning [1/m]; the paths differ by 5 m after 100 m


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep:
    """A body at equidistant places of its way, each box so large that it holds the body half a step on.

    Parameters
    ----------
    station : ndarray, shape (n,)
        Distance along the way [m], of the body's reference point.
    center : ndarray of complex, shape (n,)
        Centers of the boxes, x + iy [m].
    ahead : ndarray of complex, shape (n,)
        Headings as unit numbers exp(i psi) [-].
    half_length, half_width : float
        Half extents of the boxes [m].
    step : float
        Distance of the places [m].
    bend : float
        Largest change of heading between them [rad].
    headings : tuple of float
        Least and largest heading along the way [rad], not wrapped.
    """

    station: Array
    center: Complex
    ahead: Complex
    half_length: float
    half_width: float
    step: float
    bend: float
    headings: tuple[float, float]

    @classmethod
    def along_path(
        cls, path: Path, start: float, end: float, vehicle: VehicleParams, clearance: float
    ) -> Self:
        """Follow a path with the center of gravity, the body along the tangent.

        Parameters
        ----------
        path : Path
            The way.
        start, end : float
            Its stretch [m].
        vehicle : VehicleParams
            The body.
        clearance : float
            By which it grows on each side [m].

        Returns
        -------
        sweep : Sweep
            The body along the path.
        """
        n = max(math.ceil((end - start) / _SPACING), 1) + 1
        station = np.linspace(start, end, n)
        point, tangent, _ = path.derivatives(station)
        ahead: Complex = tangent[:, 0] + 1j * tangent[:, 1]
        ahead /= np.abs(ahead)
        center = point[:, 0] + 1j * point[:, 1] + vehicle.box_offset * ahead
        turns = np.angle(ahead[1:] * ahead[:-1].conj())
        heading = float(np.angle(ahead[0])) + np.concatenate(([0.0], np.cumsum(turns)))
        bend = float(np.abs(turns).max())
        half = 0.5 * vehicle.length + clearance, 0.5 * vehicle.width + clearance
        span = float(heading.min()), float(heading.max())
        return cls._grown(station, center, ahead, half, (end - start) / (n - 1), bend, span)

    @classmethod
    def from_remote(cls, remote: RemoteVehicle, reach: float, along: float, across: float) -> Self:
        """Let a vehicle go on straight or on the circle that it drives now, but no more than round a corner.

        Parameters
        ----------
        remote : RemoteVehicle
            The vehicle; one that drives backwards does so here.
        reach : float
            How far [m].
        along, across : float
            What its body is longer and wider by on each side [m].

        Returns
        -------
        sweep : Sweep
            The body along its way.
        """
        n = max(math.ceil(reach / _SPACING), 1) + 1
        station = np.linspace(0.0, reach, n)
        psi, kappa = remote.psi + (math.pi if remote.v_x < 0.0 else 0.0), _curvature(remote)
        on_arc = np.minimum(station, _CORNER / max(abs(kappa), 1e-9))
        turned = kappa * on_arc
        start, ahead = complex(math.cos(psi), math.sin(psi)), np.exp(1j * (psi + turned))
        chord = on_arc * np.sinc(turned / (2.0 * math.pi)) * np.exp(0.5j * turned) * start
        center = remote.x + 1j * remote.y + chord + (station - on_arc) * ahead
        step = reach / (n - 1)
        half = 0.5 * remote.length + along, 0.5 * remote.width + across
        span = heading_range(remote, reach)
        return cls._grown(station, center, ahead, half, step, abs(kappa) * step, span)

    @classmethod
    def _grown(
        cls, station: Array, center: Complex, ahead: Complex,
        half: tuple[float, float], step: float, bend: float, headings: tuple[float, float],
    ) -> Self:  # fmt: skip
        # half a step on the body has moved by half a step and turned by half the bend
        return cls(
            station=station, center=center, ahead=ahead, step=step, bend=bend, headings=headings,
            half_length=half[0] + 0.5 * step + 0.5 * bend * half[1],
            half_width=half[1] + 0.5 * bend * (half[0] + 0.5 * step),
        )  # fmt: skip

    def heading_at(self, station: float) -> float:
        """Heading at the nearest place of the way.

        Parameters
        ----------
        station : float
            Distance along the way [m].

        Returns
        -------
        psi : float
            Heading [rad] in (-pi, pi].
        """
        index = round((station - float(self.station[0])) / self.step)
        ahead = complex(self.ahead[min(max(index, 0), len(self.ahead) - 1)])
        return math.atan2(ahead.imag, ahead.real)

    def find_overlap(self, other: "Sweep", min_angle: float) -> tuple[int, int, int, int] | None:
        """Find where two bodies could touch.

        Parameters
        ----------
        other : Sweep
            The other body.
        min_angle : float
            Angle that the headings must reach somewhere where they touch [rad].

        Returns
        -------
        places : tuple of int, or None
            First and last place of this body and of the other; None if they are apart, or parallel.
        """
        a, b = self.center[_BLOCK // 2 :: _BLOCK], other.center[_BLOCK // 2 :: _BLOCK]
        # the last block may be short: its own last place stands for it
        a = np.append(a, self.center[-1]) if _BLOCK * len(a) < len(self.center) else a
        b = np.append(b, other.center[-1]) if _BLOCK * len(b) < len(other.center) else b
        reach = math.hypot(self.half_length, self.half_width) + 0.5 * _BLOCK * self.step
        reach += math.hypot(other.half_length, other.half_width) + 0.5 * _BLOCK * other.step
        near = a[:, None] - b
        rows, columns = np.nonzero(near.real**2 + near.imag**2 <= reach * reach)
        if not len(rows):
            return None
        i, j = (_BLOCK * rows[:, None] + _ROWS).ravel(), (_BLOCK * columns[:, None] + _COLUMNS).ravel()
        # beyond the end the last place is looked at again
        i, j = np.minimum(i, len(self.center) - 1), np.minimum(j, len(other.center) - 1)
        turn = other.ahead[j] * self.ahead[i].conj()
        offset = (other.center[j] - self.center[i]) * self.ahead[i].conj()
        c, s = np.abs(turn.real), np.abs(turn.imag)
        la, wa, lb, wb = self.half_length, self.half_width, other.half_length, other.half_width
        touch = (np.abs(offset.real) <= la + lb * c + wb * s) & (np.abs(offset.imag) <= wa + lb * s + wb * c)
        offset = offset * turn.conj()
        touch &= (np.abs(offset.real) <= lb + la * c + wa * s) & (np.abs(offset.imag) <= wb + la * s + wa * c)
        if not touch.any() or float(s[touch].max()) < math.sin(min_angle):
            return None
        i, j = i[touch], j[touch]
        return int(i.min()), int(i.max()), int(j.min()), int(j.max())


def heading_range(remote: RemoteVehicle, reach: float) -> tuple[float, float]:
    """Least and largest heading of a vehicle on its way [rad], not wrapped.

    Parameters
    ----------
    remote : RemoteVehicle
        The vehicle.
    reach : float
        How far it goes [m].

    Returns
    -------
    least, largest : float
        Headings in the direction in which it moves [rad].
    """
    kappa, psi = _curvature(remote), remote.psi + (math.pi if remote.v_x < 0.0 else 0.0)
    turned = math.copysign(min(abs(kappa) * reach, _CORNER), kappa)
    return min(psi, psi + turned), max(psi, psi + turned)


def always_parallel(one: tuple[float, float], other: tuple[float, float], min_angle: float) -> bool:
    """Tell whether headings from two ranges never are at more than an angle, along or against each other.

    Parameters
    ----------
    one, other : tuple of float
        Least and largest heading [rad].
    min_angle : float
        The angle [rad].

    Returns
    -------
    parallel : bool
        True if there is no such pair.
    """
    low, high = other[0] - one[1], other[1] - one[0]
    turns = math.pi * round(0.5 * (low + high) / math.pi)
    return low - turns > -min_angle and high - turns < min_angle


def _curvature(remote: RemoteVehicle) -> float:
    """Curvature of a vehicle's way, in the direction in which it moves [1/m]."""
    kappa = remote.r / max(abs(remote.v_x), 1.0)
    return kappa if abs(kappa) >= _STRAIGHT else 0.0

"""Bodies swept along curves: samples of both, enlarged so that no overlap is missed."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from cca_core._checks import Array, Complex
from cca_core.path import Path
from cca_core.vehicle import RemoteVehicle, VehicleParams

_SPACING = 1.0  # upper limit of the distance between samples [m]
_BLOCK = 4  # samples that are compared together first
_MAX_TURN = 0.5 * math.pi  # a turning vehicle drives straight on after a right angle [rad]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sweep:
    """A body at equidistant samples of its path; each box holds the body up to half a step away."""

    station: Array  # distance of the reference point along the path [m]
    center: Complex  # of the boxes, x + iy [m]
    ahead: Complex  # headings exp(i psi) [-]
    half_length: float  # [m]
    half_width: float  # [m]
    step: float  # between samples [m]
    max_turn: float  # change of heading between samples [rad]
    headings: tuple[float, float]  # least and largest along the path [rad], not wrapped

    @classmethod
    def along_path(
        cls, path: Path, start: float, end: float, vehicle: VehicleParams, clearance: float
    ) -> Self:
        """Body of the ego along a path, with a margin `clearance` on each side."""
        n = max(math.ceil((end - start) / _SPACING), 1) + 1
        station = np.linspace(start, end, n)
        point, tangent, _ = path.derivatives(station)
        ahead: Complex = tangent[:, 0] + 1j * tangent[:, 1]
        ahead /= np.abs(ahead)
        center = point[:, 0] + 1j * point[:, 1] + vehicle.box_offset * ahead
        turns = np.angle(ahead[1:] * ahead[:-1].conj())
        heading = float(np.angle(ahead[0])) + np.concatenate(([0.0], np.cumsum(turns)))
        turn = float(np.abs(turns).max())
        half = 0.5 * vehicle.length + clearance, 0.5 * vehicle.width + clearance
        span = float(heading.min()), float(heading.max())
        return cls._grown(station, center, ahead, half, (end - start) / (n - 1), turn, span)

    @classmethod
    def from_remote(cls, remote: RemoteVehicle, reach: float, along: float, across: float) -> Self:
        """Body of a vehicle straight ahead or on its present circle, up to a right angle."""
        n = max(math.ceil(reach / _SPACING), 1) + 1
        station = np.linspace(0.0, reach, n)
        psi, kappa = remote.psi + (math.pi if remote.v_x < 0.0 else 0.0), _curvature(remote)
        on_arc = np.minimum(station, _MAX_TURN / max(abs(kappa), 1e-9))
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
        half: tuple[float, float], step: float, turn: float, headings: tuple[float, float],
    ) -> Self:  # fmt: skip
        # within half a step the body moves by half a step and turns by half the turn of a step
        return cls(
            station=station, center=center, ahead=ahead, step=step, max_turn=turn, headings=headings,
            half_length=half[0] + 0.5 * step + 0.5 * turn * half[1],
            half_width=half[1] + 0.5 * turn * (half[0] + 0.5 * step),
        )  # fmt: skip

    def heading_at(self, station: float) -> float:
        """Heading at the nearest sample [rad], in (-pi, pi]."""
        index = round((station - float(self.station[0])) / self.step)
        ahead = complex(self.ahead[min(max(index, 0), len(self.ahead) - 1)])
        return math.atan2(ahead.imag, ahead.real)

    def find_overlap(self, other: "Sweep", min_angle: float) -> tuple[int, int, int, int] | None:
        """First and last sample of both bodies that overlap; None if apart or always parallel."""
        a, b = self.center[_BLOCK // 2 :: _BLOCK], other.center[_BLOCK // 2 :: _BLOCK]
        # the last block may be short: its last sample represents it
        a = np.append(a, self.center[-1]) if _BLOCK * len(a) < len(self.center) else a
        b = np.append(b, other.center[-1]) if _BLOCK * len(b) < len(other.center) else b
        reach = math.hypot(self.half_length, self.half_width) + 0.5 * _BLOCK * self.step
        reach += math.hypot(other.half_length, other.half_width) + 0.5 * _BLOCK * other.step
        near = a[:, None] - b
        rows, columns = np.nonzero(near.real**2 + near.imag**2 <= reach * reach)
        if not len(rows):
            return None
        row, column = np.divmod(np.arange(_BLOCK * _BLOCK), _BLOCK)  # all pairs of samples in two blocks
        i, j = (_BLOCK * rows[:, None] + row).ravel(), (_BLOCK * columns[:, None] + column).ravel()
        # beyond the end the last sample is compared again
        i, j = np.minimum(i, len(self.center) - 1), np.minimum(j, len(other.center) - 1)
        turn = other.ahead[j] * self.ahead[i].conj()
        offset = (other.center[j] - self.center[i]) * self.ahead[i].conj()
        c, s = np.abs(turn.real), np.abs(turn.imag)
        la, wa, lb, wb = self.half_length, self.half_width, other.half_length, other.half_width
        overlaps = (np.abs(offset.real) <= la + lb * c + wb * s) & (
            np.abs(offset.imag) <= wa + lb * s + wb * c
        )
        offset = offset * turn.conj()
        overlaps &= (np.abs(offset.real) <= lb + la * c + wa * s) & (
            np.abs(offset.imag) <= wb + la * s + wa * c
        )
        if not overlaps.any() or float(s[overlaps].max()) < math.sin(min_angle):
            return None
        i, j = i[overlaps], j[overlaps]
        return int(i.min()), int(i.max()), int(j.min()), int(j.max())


def heading_range(remote: RemoteVehicle, reach: float) -> tuple[float, float]:
    """Least and largest heading of a vehicle over a distance [rad], not wrapped."""
    kappa, psi = _curvature(remote), remote.psi + (math.pi if remote.v_x < 0.0 else 0.0)
    turned = math.copysign(min(abs(kappa) * reach, _MAX_TURN), kappa)
    return min(psi, psi + turned), max(psi, psi + turned)


def always_parallel(one: tuple[float, float], other: tuple[float, float], min_angle: float) -> bool:
    """Return whether headings from two ranges differ by less than an angle, in either direction."""
    low, high = other[0] - one[1], other[1] - one[0]
    turns = math.pi * round(0.5 * (low + high) / math.pi)
    return low - turns > -min_angle and high - turns < min_angle


def _curvature(remote: RemoteVehicle) -> float:
    """Curvature of a vehicle's path, in its direction of motion [1/m]."""
    kappa = remote.r / max(abs(remote.v_x), 1.0)
    return kappa if abs(kappa) >= 1.0e-3 else 0.0  # a wider circle is straight within 5 m after 100 m

"""The elastic band as a planning method: as printed in the paper, relaxed, and smoothed."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.band import Band, deformed, displacement, external_force, relax_band, smooth_band
from cca_core.baselines.problems.problem import Plan, Problem
from cca_core.baselines.problems.sampling import plan_at_stations
from cca_core.errors import Status
from cca_core.path import Path, interpolate_path


@dataclass(frozen=True, slots=True, kw_only=True)
class OneShotBand:
    """Eqs 8-10 of the paper as printed, with the forces at the undeformed nodes.

    Parameters
    ----------
    spacing : float
        Distance between nodes [m].
    ratio : float
        External stiffness over spring stiffness, k_e / k_s [-].

    Raises
    ------
    InputError
        If a value is not positive.

    Notes
    -----
    The threshold r_0 is the center distance of bodies alongside each other at the clearance of the problem.
    Each node sees the other vehicles at the time at which the ego passes it at the wanted speed.
    """

    spacing: float = 1.0
    ratio: float = 0.03

    def __post_init__(self) -> None:
        check_real("spacing", self.spacing, gt=0.0)
        check_real("ratio", self.ratio, gt=0.0)

    def plan(self, problem: Problem) -> Plan:
        """Displace the nodes once.

        Parameters
        ----------
        problem : Problem
            The problem.

        Returns
        -------
        plan : Plan
            Always `Status.OK`: the paper's equations contain no limits.
        """
        s = _stations(problem, self.spacing)
        nodes, force = problem.road.path.position(s), np.zeros((len(s), 2))
        for box in problem.boxes_at((s - problem.start) / problem.v_x):
            r_0 = 0.5 * (problem.vehicle.width + float(box.width)) + problem.clearance
            relative = nodes - np.column_stack((box.x, box.y))
            force += external_force(relative, (0.0, 0.0), k_e=self.ratio, r_0=r_0)
        return _plan_along(problem, s, interpolate_path(deformed(nodes, displacement(force, k_s=1.0))))


@dataclass(frozen=True, slots=True, kw_only=True)
class RelaxedBand:
    """The relaxed band, which chooses the sides itself.

    Parameters
    ----------
    spacing : float
        Distance between nodes [m].
    smooth : bool
        Whether a quadratic program smooths it within its corridor.

    Raises
    ------
    InputError
        If `spacing` is not positive.
    """

    spacing: float = 1.0
    smooth: bool = False

    def __post_init__(self) -> None:
        check_real("spacing", self.spacing, gt=0.0)

    def plan(self, problem: Problem) -> Plan:
        """Relax a band from start to goal.

        Parameters
        ----------
        problem : Problem
            The problem.

        Returns
        -------
        plan : Plan
            `Status.OK` only if the band is certified; without a trajectory otherwise. If smoothing fails, the
            plan of the relaxed band.
        """
        s, band = _relax(problem, self.spacing)
        smooth = smooth_band(band) if self.smooth else band
        band = band if smooth.status is Status.DEGRADED else smooth
        if band.status is not Status.OK:
            return Plan(status=band.status, message=band.message)
        return replace(_plan_along(problem, s, band.path()), message=band.message)


def _stations(problem: Problem, spacing: float) -> Array:
    """Stations of the nodes, at least nine."""
    length = problem.goal - problem.start
    return np.linspace(problem.start, problem.goal, max(round(length / spacing) + 1, 9))


def _relax(problem: Problem, spacing: float) -> tuple[Array, Band]:
    """Stations and band."""
    s, road = _stations(problem, spacing), problem.road
    width = road.left_edge - road.right_edge - problem.vehicle.width
    slope = math.sqrt(max(width, 0.0) * problem.kappa_max)  # of a shift across the whole road
    # the band is longer than its stations, so that the ego is faster on it
    speed_factor = 1.0 + 0.25 * slope**2
    scale = 1.0 + max(abs(road.left_edge), abs(road.right_edge)) * np.abs(road.path.curvature(s))
    band = relax_band(
        road.path.position(s), problem.boxes_at((s - problem.start) / problem.v_x), vehicle=problem.vehicle,
        clearance=problem.clearance, corridor=(road.right_edge, road.left_edge),
        curvature_limit=problem.kappa_max / (speed_factor * scale**2),
    )  # fmt: skip
    return s, band


def _plan_along(problem: Problem, s: Array, path: Path) -> Plan:
    """Plan with samples at most 0.25 m apart along a path whose breaks are the nodes at stations."""
    n = max(math.ceil(float(s[1] - s[0]) / 0.25), 1)
    fraction, breaks = np.arange(n) / n, path.breaks
    length = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * fraction).ravel(), breaks[-1])
    stations = np.append((s[:-1, None] + np.diff(s)[:, None] * fraction).ravel(), s[-1])
    return plan_at_stations(problem, stations, path.position(length))

"""The elastic band as a method among others: as printed in the paper, relaxed, and smoothed."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cca_core._checks import Array, check_real
from cca_core.band import Band, deformed, displacement, external_force, relax_band, smooth_band
from cca_core.baselines.problem import Plan, Problem
from cca_core.baselines.sampled_problems import at_stations
from cca_core.errors import Status
from cca_core.path import Path, interpolate_path

__all__ = ["OneShotBand", "RelaxedBand", "SmoothedBand"]

_FINE = 0.25  # between samples of a plan [m]
_NODES = 9  # at least


@dataclass(frozen=True, slots=True, kw_only=True)
class OneShotBand:
    """Eqs 8-10 of the paper as printed, forces at the undeformed nodes; it knows no failure.

    Parameters
    ----------
    spacing : float
        Distance between nodes [m].
    ratio : float
        External per spring stiffness k_e / k_s [-].

    Raises
    ------
    InputError
        If a value is not positive.

    Notes
    -----
    The threshold r_0 is that of bodies side by side with the clearance asked. Each node sees the others where
    they are when its station is passed at the wanted speed.
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
            What is to be driven.

        Returns
        -------
        plan : Plan
            Always `Status.OK`: the paper's equations say nothing of limits.
        """
        s = _stations(problem, self.spacing)
        nodes, force = problem.road.path.position(s), np.zeros((len(s), 2))
        for box in problem.boxes_at((s - problem.start) / problem.v_x):
            r_0 = 0.5 * (problem.vehicle.width + float(box.width)) + problem.clearance
            seen = nodes - np.column_stack((box.x, box.y))
            force += external_force(seen, (0.0, 0.0), k_e=self.ratio, r_0=r_0)
        bent = deformed(nodes, displacement(force, k_s=1.0))
        return _along(problem, s, interpolate_path(bent))


@dataclass(frozen=True, slots=True, kw_only=True)
class RelaxedBand:
    """The band of this library, sides chosen by it.

    Parameters
    ----------
    spacing : float
        Distance between nodes [m].

    Raises
    ------
    InputError
        If `spacing` is not positive.
    """

    spacing: float = 1.0

    def __post_init__(self) -> None:
        check_real("spacing", self.spacing, gt=0.0)

    def plan(self, problem: Problem) -> Plan:
        """Relax a band from start to goal.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        plan : Plan
            `Status.OK` only if the band is certified; without a way if it is not.
        """
        s, band = _relaxed(problem, self.spacing)
        return _answer(problem, s, band)


@dataclass(frozen=True, slots=True, kw_only=True)
class SmoothedBand:
    """The same band, smoothed by a quadratic program within its corridor.

    Parameters
    ----------
    spacing : float
        Distance between nodes [m].

    Raises
    ------
    InputError
        If `spacing` is not positive.
    """

    spacing: float = 1.0

    def __post_init__(self) -> None:
        check_real("spacing", self.spacing, gt=0.0)

    def plan(self, problem: Problem) -> Plan:
        """Relax and smooth a band from start to goal.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        plan : Plan
            As for the relaxed band; where smoothing fails, that one if it is OK.
        """
        s, band = _relaxed(problem, self.spacing)
        smooth = smooth_band(band)
        return _answer(problem, s, band if smooth.status is Status.DEGRADED else smooth)


def _stations(problem: Problem, spacing: float) -> Array:
    length = problem.goal - problem.start
    return np.linspace(problem.start, problem.goal, max(round(length / spacing) + 1, _NODES))


def _relaxed(problem: Problem, spacing: float) -> tuple[Array, Band]:
    s = _stations(problem, spacing)
    road = problem.road
    width = road.left_edge - road.right_edge - problem.vehicle.width
    slope = math.sqrt(max(width, 0.0) * problem.kappa_max)  # of a shift across the whole road
    faster = 1.0 + 0.25 * slope**2  # the way is longer than its stations
    bend = 1.0 + max(abs(road.left_edge), abs(road.right_edge)) * np.abs(road.path.curvature(s))
    band = relax_band(
        road.path.position(s), problem.boxes_at((s - problem.start) / problem.v_x), vehicle=problem.vehicle,
        clearance=problem.clearance, corridor=(road.right_edge, road.left_edge),
        curvature_limit=problem.kappa_max / (faster * bend**2),
    )  # fmt: skip
    return s, band


def _answer(problem: Problem, s: Array, band: Band) -> Plan:
    if band.status is not Status.OK:
        return Plan(status=band.status, message=band.message)
    plan = _along(problem, s, band.path())
    return replace(plan, message=band.message)


def _along(problem: Problem, s: Array, path: Path) -> Plan:
    """Sample a path whose breaks are the nodes at stations."""
    fine = max(math.ceil(float(s[1] - s[0]) / _FINE), 1)
    share = np.arange(fine) / fine
    breaks = path.breaks
    at = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * share).ravel(), breaks[-1])
    stations = np.append((s[:-1, None] + np.diff(s)[:, None] * share).ravel(), s[-1])
    return at_stations(problem, stations, path.position(at))

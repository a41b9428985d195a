"""Elastic band: eqs 3-10 of the paper, and the relaxed band with its certificate."""

from cca_core.band.band import Band
from cca_core.band.corridor import Side
from cca_core.band.energy import band_energy, band_gradient, band_hessian, kkt_residual
from cca_core.band.equilibrium import CurvatureBounds, equilibrium
from cca_core.band.forces import external_force
from cca_core.band.relax import relax_band
from cca_core.band.settings import BandSettings
from cca_core.band.smooth import smooth_band
from cca_core.band.stiffness import (
    BandStiffness,
    balancing_force,
    deformed,
    displacement,
    internal_force,
    stiffness_matrix,
)

__all__ = [
    "Band",
    "BandSettings",
    "BandStiffness",
    "CurvatureBounds",
    "Side",
    "balancing_force",
    "band_energy",
    "band_gradient",
    "band_hessian",
    "deformed",
    "displacement",
    "equilibrium",
    "external_force",
    "internal_force",
    "kkt_residual",
    "relax_band",
    "smooth_band",
    "stiffness_matrix",
]

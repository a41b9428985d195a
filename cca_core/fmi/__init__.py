"""Functional mock-up units: the controller and the single-track plant as FMUs, and any plant FMU as plant."""

from cca_core.fmi.export import export_plant, export_steering
from cca_core.fmi.fmu_plant import FmuPlant

__all__ = ["FmuPlant", "export_plant", "export_steering"]

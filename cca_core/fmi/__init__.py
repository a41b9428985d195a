"""The controller as C and as functional mock-up unit, the plant as one, and any vehicle FMU as plant."""

from cca_core.codegen.export.project import export_c
from cca_core.fmi.export import export_plant, export_steering
from cca_core.fmi.fmu_plant import FmuPlant

__all__ = ["FmuPlant", "export_c", "export_plant", "export_steering"]

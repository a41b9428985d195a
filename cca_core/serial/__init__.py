"""Conversion of settings and results to plain dictionaries for JSON, and back."""

from cca_core.serial.fields import VERSION
from cca_core.serial.read import from_dict
from cca_core.serial.write import to_dict

__all__ = ["VERSION", "from_dict", "to_dict"]

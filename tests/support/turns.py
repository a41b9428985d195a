"""Paths that turn."""

import math

import numpy as np

from cca_core.path import Path, interpolate_path


def quarter_turn(radius: float = 10.0, sign: float = 1.0, before: float = 60.0, after: float = 60.0) -> Path:
    """Straight along +x, a quarter turn from the origin (left if sign is 1), straight on."""
    quarter = 0.5 * math.pi * radius
    s = np.arange(-before, quarter + after, 1.0)
    phi = np.clip(s / radius, 0.0, 0.5 * math.pi)
    x = radius * np.sin(phi) + np.minimum(s, 0.0)
    y = radius * (1.0 - np.cos(phi)) + np.maximum(s - quarter, 0.0)
    return interpolate_path(np.column_stack((x, sign * y)))

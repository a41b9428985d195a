"""Quantities of vehicles and their reports: each has one value in the library."""

from cca_core.kernel import constants

__all__ = ["GRAVITY", "MAX_COORDINATE", "MAX_SPEED", "STALE_AGE", "STANDSTILL_SPEED"]

GRAVITY = constants.GRAVITY
"""Acceleration of gravity [m/s^2]."""

MAX_COORDINATE = 1.0e6
"""Largest coordinate in a local frame [m]."""

MAX_SPEED = 100.0
"""Largest speed of a road vehicle [m/s]."""

STALE_AGE = constants.STALE_AGE  # ten messages of SAE J2945/1 are missing
"""Age above which a report is stale [s]."""

STANDSTILL_SPEED = constants.STANDSTILL_SPEED  # reported speeds err by 0.2 m/s
"""Reported speed below which a vehicle counts as stationary [m/s]."""

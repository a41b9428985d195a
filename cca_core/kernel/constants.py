"""Quantities of which kernels and the rest of the library use one value."""

GRAVITY = 9.81  # [m/s^2]
STALE_AGE = 1.0  # age above which a report is stale [s]
STANDSTILL_SPEED = 0.5  # reported speed below which a vehicle counts as stationary [m/s]
TINY = 1e-12  # least length that is divided by [m]

"""Speed profile along a route: curves, the speed limit, and a lead vehicle."""

import math

import numpy as np

from cca_core._checks import Array
from cca_core.baselines.methods.mpc.horizon import FrenetState
from cca_core.follow import SpeedSettings, cruise_acceleration, follow_acceleration, jerk_limited
from cca_core.frenet import FrenetVehicle
from cca_core.path import Path
from cca_core.vehicle import VehicleParams


class SpeedProfile:
    """Speeds up to `v_max` and to a lateral acceleration on curves."""

    def __init__(
        self, path: Path, vehicle: VehicleParams, settings: SpeedSettings, v_max: float, curve_a_y: float
    ) -> None:
        self._vehicle, self._settings = vehicle, settings
        self._s = np.linspace(path.start, path.end, max(2, math.ceil(path.length / 5.0)))
        curvature = np.maximum(np.abs(path.curvature(self._s)), 1e-9)
        self._v_limit = np.minimum(np.sqrt(curve_a_y / curvature), v_max)

    def at(self, t: Array, start: FrenetState, lead: FrenetVehicle | None) -> tuple[Array, Array]:
        """Stations and speeds at equidistant times, freely or behind a lead vehicle."""
        s, v, own = np.empty_like(t), np.empty_like(t), self._settings
        s[0], v[0], h, last = start.s, max(start.v, 0.0), float(t[1] - t[0]), start.a_x
        for k in range(len(t) - 1):
            a = cruise_acceleration(v[k], float(np.interp(s[k], self._s, self._v_limit)), own)
            if lead is not None:
                rear = lead.occupied_interval(t[k : k + 1], braking=0.0, acceleration=0.0)[0][0]
                gap = rear - s[k] - self._vehicle.front
                a = min(a, follow_acceleration(v[k], gap, lead.v_s, own))
            last = jerk_limited(a, last, h, own, emergency=a < -2.0 * own.b_comfort)
            v[k + 1] = max(v[k] + h * last, 0.0)
            s[k + 1] = s[k] + 0.5 * h * (v[k] + v[k + 1])
        return s, v

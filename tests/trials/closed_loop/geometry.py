"""Straight or winding road, sampled every half meter."""

import math
import random

import numpy as np


class Geometry:
    """Centerline of a road: straight, or curves of a random radius."""

    ds, length = 0.5, 2000.0

    def __init__(self, rng: random.Random) -> None:
        n = int(self.length / self.ds) + 1
        self.kappa, self.radius = np.zeros(n), math.inf
        if rng.random() < 0.5:
            self.radius = math.exp(rng.uniform(math.log(80.0), math.log(500.0)))
            i, sign = 0, rng.choice([-1, 1])
            while i < n:
                radius = self.radius * rng.uniform(1.0, 1.6)
                arc, line = rng.uniform(0.5, 1.3) * radius, rng.uniform(0.0, 150.0)
                j = i + int(line / self.ds)
                i = j + int(arc / self.ds)
                self.kappa[j:i] = sign / radius
                sign = -sign if rng.random() < 0.8 else sign
            window = int(30.0 / self.ds)
            self.kappa = np.convolve(self.kappa, np.ones(window) / window, mode="same")
        self.psi = np.concatenate(([0.0], np.cumsum(0.5 * (self.kappa[1:] + self.kappa[:-1])) * self.ds))
        middle = 0.5 * (self.psi[1:] + self.psi[:-1])
        self.x = np.concatenate(([0.0], np.cumsum(np.cos(middle)) * self.ds))
        self.y = np.concatenate(([0.0], np.cumsum(np.sin(middle)) * self.ds))

    def at(self, s: float, d: float) -> tuple[float, float, float, float]:
        """Position, heading and curvature at (s, d)."""
        u = s / self.ds
        i = min(max(int(u), 0), len(self.x) - 2)
        f = u - i
        psi = self.psi[i] + min(max(f, 0.0), 1.0) * (self.psi[i + 1] - self.psi[i])
        x = self.x[i] + f * (self.x[i + 1] - self.x[i]) - d * math.sin(psi)
        y = self.y[i] + f * (self.y[i + 1] - self.y[i]) + d * math.cos(psi)
        return float(x), float(y), float(psi), float(self.kappa[i])

    def to_frenet(self, x: float, y: float, s: float) -> tuple[float, float]:
        """Frenet coordinates (s, d) of a point; `s` is the initial guess."""
        for _ in range(6):
            x_0, y_0, psi, kappa = self.at(s, 0.0)
            along = (x - x_0) * math.cos(psi) + (y - y_0) * math.sin(psi)
            d = (y - y_0) * math.cos(psi) - (x - x_0) * math.sin(psi)
            s += along / max(1.0 - kappa * d, 0.3)
            if abs(along) < 1e-4:
                break
        return s, d

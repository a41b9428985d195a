"""Reports of other vehicles to the ego: perfect, noisy, late, with gaps or under changing ids."""

import math
import random
from typing import TYPE_CHECKING, Any, NamedTuple

from cca_core import RemoteVehicle
from tests.trials.closed_loop.car import Car

if TYPE_CHECKING:
    from tests.trials.closed_loop.episode import Episode

KINDS = "perfect", "perfect", "noisy", "delayed", "flicker", "idchange", "understated"
CORRELATION_TIME = 8.0  # of position errors [s]


class Report(NamedTuple):
    """Reported state of a car, extrapolated to now."""

    x: float
    y: float
    psi: float
    v: float
    a: float
    r: float
    age: float = 0.0


class Reports:
    """Reports of one kind up to a distance."""

    def __init__(self, rng: random.Random, kind: str, max_distance: float) -> None:
        self.rng, self.kind, self.max_distance = rng, kind, max_distance
        self.memory: dict[str, Any] = {}  # by car, of the kind
        self.errors: dict[str, tuple[float, float, float]] = {}  # along and across the heading, and when

    def records(self, sim: "Episode") -> list[RemoteVehicle]:
        """Records of the cars that the ego receives now."""
        records, t = [], sim.t
        for car in sim.cars:
            x, y, psi = car.pose(sim.road)
            if math.hypot(x - sim.plant.x, y - sim.plant.y) > self.max_distance or not car.is_visible(sim):
                continue
            name, report = car.id, Report(x, y, psi, car.v, car.a, car.r)
            if self.kind == "flicker" and not self._is_on(car.id, t):
                continue
            if self.kind == "idchange":
                name = self._changing_id(car.id, t)
            elif self.kind == "delayed":
                report = self._delayed(car.id, report, t)
            sigma = 0.0
            if self.kind in ("noisy", "delayed", "understated"):
                sigma, true = (0.1, 0.5) if self.kind == "understated" else (0.3, 0.3)
                report = self._noisy(car.id, report, true, t)
            car.first_report = t if car.first_report is None else car.first_report
            records.append(record(name, car, report, sigma))
        return records

    def _is_on(self, name: str, t: float) -> bool:
        """Whether a flickering sender is on: 0.2 to 2 s, then off for up to 0.6 s."""
        known = self.memory.get(name)
        if known is None or t > known[1]:
            on = known is None or not known[0]
            lasts = self.rng.uniform(0.2, 2.0) if on else self.rng.uniform(0.05, 0.6)
            known = self.memory[name] = on, t + lasts
        return known[0]

    def _changing_id(self, name: str, t: float) -> str:
        """Id of a sender that changes it after 0.3 to 2 s."""
        known = self.memory.get(name)
        if known is None or t > known[1]:
            known = self.memory[name] = self.rng.randrange(10**9), t + self.rng.uniform(0.3, 2.0)
        return f"{name}~{known[0]}"

    def _delayed(self, name: str, report: Report, t: float) -> Report:
        """The last message, 0.1 to 0.8 s old, dead-reckoned."""
        known = self.memory.get(name)
        if known is None or t - known[0] > known[1]:
            known = self.memory[name] = t, self.rng.choice([0.1, 0.1, 0.3, 0.5, 0.8]), report
        age, (x, y, psi, v, a, r, _) = t - known[0], known[2]
        x, y = x + v * age * math.cos(psi + 0.5 * r * age), y + v * age * math.sin(psi + 0.5 * r * age)
        return Report(x, y, psi + r * age, v, a, r, age)

    def _noisy(self, name: str, report: Report, sigma: float, t: float) -> Report:
        """The report with an error that changes slowly, at most 2 sigma."""
        rng = self.rng
        old = self.errors.get(name) or (rng.gauss(0.0, sigma), rng.gauss(0.0, sigma), t)
        keep = math.exp((old[2] - t) / CORRELATION_TIME)
        new = [keep * e + math.sqrt(max(0.0, 1.0 - keep * keep)) * rng.gauss(0.0, sigma) for e in old[:2]]
        self.errors[name] = new[0], new[1], t
        ahead, left = (max(-2.0 * sigma, min(2.0 * sigma, e)) for e in new)
        x = report.x + (ahead * math.cos(report.psi) - left * math.sin(report.psi))
        y = report.y + (ahead * math.sin(report.psi) + left * math.cos(report.psi))
        return report._replace(x=x, y=y)


def record(name: str, car: Car, report: Report, sigma: float) -> RemoteVehicle:
    """A report as the planner takes it."""
    x, y, psi, v, a, r, age = report
    return RemoteVehicle(
        id=name,
        x=x,
        y=y,
        psi=psi,
        v_x=v,
        a_x=a,
        r=r,
        length=car.length,
        width=car.width,
        age=age,
        sigma_along=sigma,
        sigma_across=sigma,
    )

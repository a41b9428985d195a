"""Random traffic situations with true motions, and the maneuver driven among them."""

import math
from dataclasses import dataclass, replace

import numpy as np

from cca_core import Lane, Planner, RemoteVehicle, Road, VehicleParams, VehicleState
from cca_core.path import fit_path
from cca_core.planner import EvasionSettings

CAR = replace(VehicleParams.bmw_320i(), length=4.5, width=1.8)
LANE = 3.5
START = 400.0  # of the ego on its road [m]
STEP = 0.02  # of the simulation [s]
SETTINGS = EvasionSettings(awareness_range=math.inf)


@dataclass(frozen=True)
class Other:
    """A vehicle as it is and as it is reported."""

    remote: RemoteVehicle
    s: float  # true station when the message was sent [m]
    d: float
    v: float  # along the route [m/s]
    changes: np.ndarray  # accelerations of each half second since then [m/s^2]

    def stations(self, t: np.ndarray) -> np.ndarray:
        """True stations at times from now [m]; it never reverses."""
        speeds, driven = [abs(self.v)], [0.0]
        for a in self.changes.tolist():
            v = speeds[-1]
            moves = 0.5 if a >= 0.0 else min(0.5, v / -a)
            driven.append(driven[-1] + v * moves + 0.5 * a * moves * moves)
            speeds.append(max(v + 0.5 * a, 0.0))
        since = t + self.remote.age
        i = np.minimum((since / 0.5).astype(int), len(self.changes) - 1)
        v, a = np.array(speeds)[i], self.changes[i]
        within = since - 0.5 * i
        moves = np.where(a < 0.0, np.minimum(within, v / np.maximum(-a, 1e-9)), within)
        along = np.array(driven)[i] + v * moves + 0.5 * a * moves * moves
        return self.s + math.copysign(1.0, self.v) * along


@dataclass(frozen=True)
class Situation:
    """The ego at `START` on a road, with others around."""

    road: Road
    v_x: float
    cruise: float
    others: tuple[Other, ...]  # the first is the lead vehicle


def roads() -> list[Road]:
    """Straight and curved, with an adjacent lane in either direction."""
    made = []
    for radius in (math.inf, 500.0, -800.0):
        s = np.arange(0.0, 2401.0, 10.0)
        x, y = (s, 0.0 * s) if math.isinf(radius) else (
            radius * np.sin(s / radius), radius * (1.0 - np.cos(s / radius))
        )  # fmt: skip
        path = fit_path(np.column_stack((x, y)), tolerance=0.02)
        for direction in (1, -1):
            lanes = (Lane(d=0.0, width=LANE), Lane(d=LANE, width=LANE, direction=direction))
            made.append(Road(path, lanes, speed_limit=40.0))
    return made


def situation(rng: np.random.Generator, road: Road) -> Situation:
    """Sample a situation: a lead vehicle to be passed and up to six others in both lanes."""
    v_x = rng.uniform(0.0, 40.0)
    behind = rng.uniform(0.4, 1.0) * v_x
    gap = rng.uniform(1.5, 3.8) * max(v_x, 4.0) + 5.0
    sampled = [_other(rng, road, "lead", START + gap, 0.0, v_x - behind, 0.0)]
    for i in range(int(rng.integers(0, 7))):
        if rng.random() < 0.75:
            lane = road.lanes[1]
            s = START + rng.uniform(-250.0, 700.0)
            sampled.append(_other(rng, road, f"b{i}", s, LANE, lane.direction * rng.uniform(0.0, 40.0), 3.0))
        else:
            s = sampled[0].s + rng.uniform(10.0, 300.0)
            sampled.append(_other(rng, road, f"o{i}", s, 0.0, rng.uniform(0.0, 40.0), 3.0))
    return Situation(road=road, v_x=v_x, cruise=rng.uniform(v_x, 40.0), others=tuple(sampled))


def _other(
    rng: np.random.Generator, road: Road, name: str, s: float, lane: float, v: float, a_max: float
) -> Other:
    age, along, across = rng.uniform(0.0, 1.0), rng.uniform(0.0, 0.75), rng.uniform(0.0, 0.15)
    d = lane + rng.uniform(-0.5, 0.5)
    style = rng.random()
    changes = rng.uniform(-8.0, a_max, 120)
    if style < 0.3:
        changes[:] = -8.0
    elif style < 0.6:
        changes[:] = a_max
    elif style < 0.7:
        changes[:] = 0.0
    reported_s = s + v * age + rng.uniform(-2.0, 2.0) * along
    reported_d = d + rng.uniform(-2.0, 2.0) * across
    x, y = road.path.to_cartesian(reported_s, reported_d)
    psi = float(road.path.heading(reported_s)) + (math.pi if v < 0.0 else 0.0)
    long = rng.random() < 0.2
    remote = RemoteVehicle(
        id=name, x=float(x), y=float(y), psi=psi, v_x=abs(v), age=age, sigma_along=along, sigma_across=across,
        length=12.0 if long else 4.5, width=2.5 if long else 1.8,
    )  # fmt: skip
    return Other(remote=remote, s=s, d=d, v=v, changes=changes)


def decide(case: Situation, others: tuple[Other, ...]) -> Planner:
    """Return a planner after its first cycle in the situation."""
    planner = Planner(CAR, case.road, cruise_speed=case.cruise, evasion=SETTINGS)
    x, y = case.road.path.position(START).tolist()
    state = VehicleState(x=x, y=y, psi=float(case.road.path.heading(START)), v_x=case.v_x)
    planner.step(0.0, state, [o.remote for o in others])
    return planner

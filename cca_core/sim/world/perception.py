"""Perception of the ego: messages and sensor, shared by a run and its replay."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.radio import Receiver
from cca_core.sim.world.sensor import Sensor
from cca_core.v2x import TrackerHealth
from cca_core.vehicle import RemoteVehicle, VehicleState

_MAX_PRECISE_SIGMA = 0.1  # reported standard deviation up to which a position is not corrected [m]
_BIAS_TIME = 30.0  # correlation time of the error of a GNSS receiver [s]


@dataclass(frozen=True, slots=True)
class _SenderBias:
    """Position error of a sender when it was last visible."""

    t: float  # time of that [s]
    x: float  # true minus reported position [m]
    y: float
    along: float  # reported standard deviations then [m]
    across: float

    def correct(self, reported: RemoteVehicle, t: float) -> RemoteVehicle:
        """Subtract the remaining error from a reported position, and enlarge its uncertainty."""
        left = math.exp((self.t - t) / _BIAS_TIME)
        return replace(
            reported, x=reported.x + left * self.x, y=reported.y + left * self.y,
            sigma_along=_remaining_sigma(reported.sigma_along, left * self.along),
            sigma_across=_remaining_sigma(reported.sigma_across, left * self.across),
        )  # fmt: skip


class Perception:
    """Receiver and sensor of the ego."""

    # With V2V, messages count. A visible vehicle comes from the sensor if it sends nothing or its message is
    # older than the sensor delay; its reported events stay. If a sender is less precise than the sensor,
    # the sensor's position counts while it is visible. While it is occluded, its reported position is
    # corrected by the error found before. Without V2V, the sensor alone counts.

    def __init__(self, scenario: Scenario) -> None:
        self._has_v2v = scenario.v2v
        self._sensor_only = not all(user.connected and self._has_v2v for user in scenario.road_users)
        self._receiver, self._sensor = Receiver(scenario), Sensor(scenario)
        self._biases: dict[str, _SenderBias] = {}

    @property
    def needs_every_cycle(self) -> bool:
        """Whether a road user is known by the sensor alone, so that every cycle counts."""
        return self._sensor_only

    def health(self, t: float) -> TrackerHealth:
        """Return the health of the radio at a time."""
        return self._receiver.tracker.health(t)

    def awareness_range(self, t: float) -> float:
        """Return the awareness range at a time [m]: 0 while the radio cannot be trusted, else infinity."""
        return self.health(t).awareness_range if self._has_v2v else math.inf

    def visible(self, rows: Sequence[Sequence[float]], ego: VehicleState) -> list[bool]:
        """Return which road users are visible."""
        return self._sensor.visible(rows, ego)

    def remotes(
        self,
        t: float,
        rows: Sequence[Sequence[float]],
        visible: Sequence[bool],
        messages: Iterable[bytes],
        ego: VehicleState,
    ) -> list[RemoteVehicle]:
        """Return the remote vehicles known now; their source is "sensor" if there was no message."""
        return self.fuse(t, self._sensor.detections(t, rows, visible), messages, ego)

    def fuse(
        self, t: float, detections: Iterable[RemoteVehicle], messages: Iterable[bytes], ego: VehicleState
    ) -> list[RemoteVehicle]:
        """Return the remote vehicles known from detections and messages."""
        reported = {v.id: v for v in self._receiver.take(t, messages, ego)} if self._has_v2v else {}
        detected = {v.id: v for v in detections}
        self._biases = {name: bias for name, bias in self._biases.items() if name in reported}
        for name, report in reported.items():
            v = detected.pop(name, None)
            recent, precise = report.age <= self._sensor.delay, report.sigma_across <= _MAX_PRECISE_SIGMA
            if v is not None and not recent:
                reported[name] = replace(v, events=report.events, source="v2v")
            elif v is not None and not precise:
                off = v.x - report.x, v.y - report.y
                if math.hypot(*off) <= 3.0 * math.hypot(report.sigma_along, report.sigma_across):
                    self._biases[name] = _SenderBias(t, *off, report.sigma_along, report.sigma_across)
                else:  # beyond three standard deviations it is not the error of a receiver
                    self._biases.pop(name, None)
                reported[name] = replace(report, x=v.x, y=v.y, sigma_along=0.0, sigma_across=0.0)
            elif not precise and name in self._biases:
                reported[name] = self._biases[name].correct(report, t)
        return [*reported.values(), *detected.values()]


def _remaining_sigma(sigma: float, known: float) -> float:
    """Return the standard deviation that remains when a part of it is known [m]."""
    return math.sqrt(max(sigma * sigma - known * known, 0.0))

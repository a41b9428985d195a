"""A rig in virtual time: plant and vehicle on links in memory, with faults between them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

from cca_core import VehicleState
from cca_core.rig import ClockMap, Codec, Frame, KitSettings, KitState, PlantNode, SteeringMap, VehicleNode
from cca_core.sim import Scenario

CYCLE = 0.02
Tamper = Callable[[list[Frame], float], list[Frame]]


class MemoryBus:
    """One end of a bus: what it sends arrives in the inbox of the other end."""

    def __init__(self) -> None:
        self.inbox: list[Frame] = []
        self.other: MemoryBus | None = None
        self.tamper: Tamper = lambda frames, t: frames
        self.t = 0.0

    def send(self, frames: Iterable[Frame]) -> bool:
        assert self.other is not None
        self.other.inbox += self.tamper(list(frames), self.t)
        return True

    def drain(self, limit: int = 1000) -> list[Frame]:
        found, self.inbox = self.inbox[:limit], self.inbox[limit:]
        return found


class MemoryLink:
    """One end of a radio or a sensor."""

    def __init__(self) -> None:
        self.inbox: list[bytes] = []
        self.other: MemoryLink | None = None
        self.tamper: Callable[[bytes], list[bytes]] = lambda data: [data]

    def send(self, data: bytes) -> None:
        assert self.other is not None
        self.other.inbox += self.tamper(data)

    def drain(self, limit: int = 500) -> list[bytes]:
        found, self.inbox = self.inbox[:limit], self.inbox[limit:]
        return found


def pair(kind: type) -> tuple:
    """Both ends of a link."""
    here, there = kind(), kind()
    here.other, there.other = there, here
    return here, there


@dataclass
class RigWorld:
    """Plant and vehicle, cycle by cycle; `stopped` holds the vehicle, `utc_offset` is its clock's error."""

    scenario: Scenario
    utc_offset: float = 0.0
    t: float = 1000.0
    stopped: bool = False
    dead: bool = False
    override: bool = False
    states: list[KitState] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.codec = Codec(SteeringMap(15.0))
        self.plant_bus, self.vehicle_bus = pair(MemoryBus)
        self.plant_radio, self.vehicle_radio = pair(MemoryLink)
        self.plant_sensor, self.vehicle_sensor = pair(MemoryLink)
        car = self.scenario.vehicle
        kit = KitSettings(delta_max=car.delta_max, delta_rate_max=car.delta_rate_max)
        self.plant = PlantNode(
            self.scenario, self.plant_bus, self.plant_radio, self.plant_sensor, self.codec, kit=kit
        )
        self.start_vehicle()
        self.last_vehicle = self.t

    def start_vehicle(self) -> None:
        """Start the vehicle computer, or start it again."""
        self.clocks = ClockMap(self.t, 1.7e9 + self.t + self.utc_offset)
        self.vehicle = VehicleNode(
            self.scenario, self.vehicle_bus, self.vehicle_radio, self.vehicle_sensor, self.codec, self.clocks
        )
        self.dead = False

    def utc(self) -> float:
        """UTC of the plant."""
        return (1.7e9 + self.t) % 3600.0

    def cycle(self) -> None:
        """One cycle of 20 ms: plant, then vehicle."""
        self.t += CYCLE
        self.plant_bus.t = self.vehicle_bus.t = self.t
        self.plant.cycle(self.t, self.utc, driver_override=self.override)
        self.states.append(self.plant.kit.state)
        if self.stopped or self.dead:
            self.vehicle_bus.inbox = self.vehicle_bus.inbox[-270:]
            return
        now = self.t + 0.001
        frames = self.vehicle_bus.drain()
        if now - self.last_vehicle > 0.1:  # as the process does after a pause
            frames = []
            self.vehicle_radio.drain()
            self.vehicle_sensor.drain()
        self.last_vehicle = now
        if self.vehicle.take(frames, now):
            self.vehicle.answer(now, self.utc)
        else:
            self.vehicle.watch(now)

    def run(self, until: Callable[["RigWorld"], bool] = lambda world: False, cycles: int = 5000) -> None:
        """Run to the end of the scenario, or until something holds."""
        for _ in range(cycles):
            if self.plant.is_over or until(self):
                return
            self.cycle()

    @property
    def s(self) -> float:
        """Station of the ego [m]."""
        return self.scenario.road.path.project((self.state.x, self.state.y))[0]

    @property
    def d(self) -> float:
        """Lateral offset of the ego [m]."""
        return self.scenario.road.path.project((self.state.x, self.state.y))[1]

    @property
    def state(self) -> VehicleState:
        """Motion of the ego in the last row."""
        return self.plant.rows[-1].state


def shortened(scenario: Scenario, duration: float) -> Scenario:
    """The same scenario with another duration [s]."""
    return replace(scenario, duration=duration)

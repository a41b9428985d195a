"""Plant computer: the ego's plant, traffic, drive-by-wire kit and the modem of all other vehicles."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from cca_core.follow import steady_turn
from cca_core.rig.detections import encode_detections
from cca_core.rig.frames import Frame, KitStatus
from cca_core.rig.kit import DriveByWireKit, KitSettings, KitState
from cca_core.rig.messages import Codec
from cca_core.rig.receivers import CommandReceiver
from cca_core.rig.records import PlantRow
from cca_core.rig.wrap import wrap_message
from cca_core.sim.log_builder import bodies_of, find_collision
from cca_core.sim.plants.build import make_plant
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.radio import Radio
from cca_core.sim.world.sensor import Sensor
from cca_core.sim.world.traffic import CYCLE_TIME, Traffic

_MAX_STEPS = 25  # of the plant in one cycle, after a pause of the process
_STALE_STEPS = 5  # cycles since the last call beyond which no command that has queued up is fresh


class Bus(Protocol):
    """CAN bus as the computers use it: a `BusLink`, or one in a test."""

    def send(self, frames: list[Frame]) -> bool:
        """Send frames."""

    def drain(self, limit: int = ...) -> list[Frame]:
        """Return what has arrived."""


class Datagrams(Protocol):
    """Radio or sensor as the computers use them: a `UdpLink`, or one in a test."""

    def send(self, data: bytes) -> None:
        """Send a datagram."""

    def drain(self, limit: int = ...) -> list[bytes]:
        """Return what has arrived."""


class PlantNode:
    """Plant computer, one call a cycle.

    Parameters
    ----------
    scenario : Scenario
        Road, ego and road users.
    bus : Bus
        CAN bus to the vehicle.
    radio : Datagrams
        Modem of all other vehicles.
    sensor : Datagrams
        Detections of the ego's sensor.
    codec : Codec
        CAN messages.
    plant : {"single_track", "multi_body"}
        The ego's plant.
    seed : int, optional
        Seed of the senders' phases and of the channel; the default is the scenario's.
    wrapper : str
        Wrapper around sent messages, one of `WRAPPERS`.
    kit : KitSettings, optional
        Limits of the drive-by-wire kit.
    records : bool
        Whether every row is kept; else the last two, so that memory does not grow.

    Attributes
    ----------
    kit : DriveByWireKit
        The kit.
    receiver : CommandReceiver
        Its receiver.
    rows : list of PlantRow
        Every cycle since the start.
    messages : dict
        Numbers of messages, as in `Log.messages`.

    Raises
    ------
    InputError
        If the plant is unknown.

    Notes
    -----
    The scenario begins when the kit is enabled. Until then the state is sent with cycle 0.
    """

    def __init__(
        self,
        scenario: Scenario,
        bus: Bus,
        radio: Datagrams,
        sensor: Datagrams,
        codec: Codec,
        *,
        plant: str = "single_track",
        seed: int | None = None,
        wrapper: str = "unsecured",
        kit: KitSettings | None = None,
        records: bool = True,
    ) -> None:
        path, vehicle = scenario.road.path, scenario.vehicle
        self.kit = DriveByWireKit(kit)
        self.receiver = CommandReceiver(self.kit, codec)
        self.rows: list[PlantRow] = []
        self.messages = {"sent": 0, "delivered": 0, "ego_sent": 0, "ego_delivered": 0}
        self._scenario, self._bus, self._radio, self._sensor = scenario, bus, radio, sensor
        self._codec, self._wrapper, self._records = codec, wrapper, records
        self._seed = scenario.seed if seed is None else seed
        self._car = make_plant(plant, vehicle, steady_turn(path, scenario.start, scenario.v_x, vehicle))
        self._traffic, self._detector = Traffic(scenario), Sensor(scenario)
        self._air: Radio | None = None
        self._s = scenario.start
        self._actuation = self._car.state.delta, 0.0
        self._visible = [False] * len(scenario.road_users)
        self._counter = self._cycle = 0

    @property
    def is_running(self) -> bool:
        """Whether the scenario has begun."""
        return self._cycle > 0

    @property
    def is_over(self) -> bool:
        """Whether the scenario's time is over or the ego has collided."""
        n = round(self._scenario.duration / CYCLE_TIME) + 1
        return self._cycle >= n or (bool(self.rows) and self.rows[-1].collided_with != "")

    def cycle(
        self, t: float, utc: Callable[[], float], *, steps: int = 1, driver_override: bool = False
    ) -> None:
        """Take commands, move the world on and send its state.

        Parameters
        ----------
        t : float
            Control time [s].
        utc : callable
            UTC of the clock map now [s].
        steps : int
            Number of cycles of 20 ms since the last call [-].
        driver_override : bool
            Whether the driver steers or brakes.
        """
        frames = self._bus.drain()
        # after a pause of this process nothing that has queued up is fresh
        self.receiver.take(frames if steps <= _STALE_STEPS else [], t, self._cycle)
        self.messages["ego_delivered"] += len(self._radio.drain())
        actuation = self.kit.step(t, self._car.state, driver_override=driver_override)
        if not actuation.by_driver:
            self._actuation = actuation.delta, actuation.a_x
        elif self.is_running:  # the driver keeps the wheels and coasts
            self._actuation = self._car.state.delta, 0.0
        if self.is_running:
            for i in range(min(steps, _MAX_STEPS)):
                self._advance()
                self._observe(utc(), is_last=i == min(steps, _MAX_STEPS) - 1)
        elif self.kit.state is KitState.ENABLED:
            rng = np.random.default_rng(self._seed)
            self._air = Radio(self._scenario, rng, utc_at_start=utc())
            self._cycle = 1
            self._observe(utc(), is_last=True)
        self._send_state()

    def _advance(self) -> None:
        """Move the ego and the road users by one cycle."""
        before = self._car.state
        self._car.step(*self._actuation, CYCLE_TIME)
        self._traffic.step((self._cycle - 1) * CYCLE_TIME, before)
        self._cycle += 1

    def _observe(self, utc: float, *, is_last: bool) -> None:
        """Let radio and sensor work on the present world, and record it."""
        state, users, t = self._car.state, self._traffic.rows(), (self._cycle - 1) * CYCLE_TIME
        self._visible = self._detector.visible(users, state)
        if self._air is not None:
            for data in self._air.exchange(t, self._traffic, state, ego_sends=False):
                self._radio.send(wrap_message(data, self._wrapper))
            self.messages["sent"] = self._air.counts["sent"]
            self.messages["delivered"] = self._air.counts["delivered"]
        detections = self._detector.detections(t, users, self._visible)
        if is_last:
            self._sensor.send(encode_detections(self._cycle, detections))
        self.rows.append(PlantRow(
            cycle=self._cycle, state=state, a_y=self._car.a_y, users=tuple(users),
            frenet=tuple(self._traffic.frenet()),
            shifting=tuple(agent.is_shifting for agent in self._traffic.agents),
            visible=tuple(self._visible), actuation=self._actuation, kit=self.kit.state, sent=utc,
            sent_radio=self.messages["delivered"], answered=self.receiver.cycle,
            collided_with=find_collision(
                self._scenario.vehicle, state, bodies_of(self._scenario, users)
            ),
        ))  # fmt: skip

        if not self._records:
            del self.rows[:-2]

    def _send_state(self) -> None:
        status = KitStatus(
            state=self.kit.state, has_timed_out=self.kit.has_timed_out, has_safe_stop=self.kit.has_plan,
            cycle=self._cycle, wrong_crc=self.receiver.wrong_crc, wrong_counter=self.receiver.wrong_counter,
        )  # fmt: skip
        self._counter += 1
        self._bus.send(self._codec.state_frames(self._car.state, status, self._counter))

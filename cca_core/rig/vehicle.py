"""Vehicle computer: receives state and messages, plans, and sends commands and the safe stop."""

import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from cca_core.band import Band
from cca_core.geometry import wrap_angle
from cca_core.planner import Command
from cca_core.rig.clocks import ClockMap
from cca_core.rig.detections import decode_detections
from cca_core.rig.ego_sender import EgoSender
from cca_core.rig.frames import Frame, KitStatus
from cca_core.rig.kit import AccelerationCommand, KitState, SteeringCommand
from cca_core.rig.messages import Codec
from cca_core.rig.plant import Bus, Datagrams
from cca_core.rig.receivers import StateReceiver, StateSettings
from cca_core.rig.records import VehicleRow
from cca_core.rig.safe_stop import SAFE_STOP_POINTS, StoredStop
from cca_core.rig.settings import VehicleSettings
from cca_core.rig.stop_rollout import SafeStopSettings, plan_safe_stop
from cca_core.rig.takeover import Takeover
from cca_core.rig.wrap import wrap_message
from cca_core.sim.loop import make_controller
from cca_core.sim.plants.single_track import SingleTrackPlant
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.perception import Perception
from cca_core.sim.world.tailgating import LeadMotion, Tailgating
from cca_core.v2x import TrackerHealth
from cca_core.vehicle import RemoteVehicle, VehicleState


class VehicleNode:
    """Vehicle computer: one call for each state, or for each period without one.

    Parameters
    ----------
    scenario : Scenario
        Road, vehicle and settings; nothing of its road users is used but their names.
    bus : Bus
        CAN bus to the kit.
    radio : Datagrams
        On-board unit.
    sensor : Datagrams
        Detections of the ego's sensor.
    codec : Codec
        CAN messages.
    clocks : ClockMap
        Map between control time and UTC.
    wrapper : str
        Wrapper around the ego's messages, one of `WRAPPERS`.
    settings : VehicleSettings, optional
        Cycle.
    state_settings : StateSettings, optional
        When a state is not to be trusted.
    safe_stop : SafeStopSettings, optional
        How a safe stop is planned.
    records : bool
        Whether every row is kept; else the last two, so that memory does not grow.

    Attributes
    ----------
    receiver : StateReceiver
        State of the ego and of the kit.
    rows : list of VehicleRow
        Every command since the start.
    counts : Counter
        Numbers of ``"answered"`` states, of commands without a state (``"blind"``), of safe stops that were
        sent (``"plans"``), of those that brake at once because the planner has none (``"braking_plans"``), of
        the ego's own messages (``"ego_sent"``), and of unreadable detections.
    last : VehicleRow or None
        The last command; None before the first.
    band : Band or None
        Band of the last command.
    health : TrackerHealth or None
        Health of the radio in the last cycle.
    """

    def __init__(
        self,
        scenario: Scenario,
        bus: Bus,
        radio: Datagrams,
        sensor: Datagrams,
        codec: Codec,
        clocks: ClockMap,
        *,
        wrapper: str = "unsecured",
        settings: VehicleSettings | None = None,
        state_settings: StateSettings | None = None,
        safe_stop: SafeStopSettings | None = None,
        records: bool = True,
    ) -> None:
        self.settings, self._safe_stop = settings or VehicleSettings(), safe_stop or SafeStopSettings()
        self.receiver = StateReceiver(codec, state_settings)
        self.rows: list[VehicleRow] = []
        self.counts: Counter[str] = Counter()
        self._scenario, self._bus, self._radio, self._sensor = scenario, bus, radio, sensor
        self._codec, self._clocks, self._wrapper, self._records = codec, clocks, wrapper, records
        self._controller, self._perception = make_controller(scenario), Perception(scenario)
        gap = scenario.fixed_gap
        self._tailgating = None if gap is None else Tailgating(scenario, gap)
        self._takeover = Takeover(clears=self.settings.clears)
        self._unit = EgoSender(scenario, self.settings.ego_id)
        self._detections: tuple[float, list[RemoteVehicle]] = -np.inf, []
        self._heading, self._s, self._lead_s = 0.0, scenario.start, scenario.start
        self._counter = self._plan_counter = self._plan_age = 0
        self._stop = StoredStop()
        self._plan_state = KitState.DISABLED  # of the kit when the last plan was sent
        self._t_sent = self._t_moved = -np.inf
        self._command = 0.0, 0.0  # the last one: road-wheel angle and acceleration
        self._model: SingleTrackPlant | None = None  # motion while the state is lost
        self.last: VehicleRow | None = None
        self.band: Band | None = None
        self.health: TrackerHealth | None = None

    def take(self, frames: Iterable[Frame], t: float) -> bool:
        """Take frames from the bus.

        Parameters
        ----------
        frames : iterable of Frame
            In order.
        t : float
            Control time [s].

        Returns
        -------
        is_complete : bool
            Whether a new state is complete.
        """
        return any([self.receiver.take(frame, t) for frame in frames])

    def answer(self, t: float, utc: Callable[[], float]) -> None:
        """Answer the last state by a command.

        Parameters
        ----------
        t : float
            Control time [s].
        utc : callable
            UTC of the clock map now [s].
        """
        state, status = self._unwrapped(), self.receiver.status
        if state is None or status is None:
            return
        received, now = utc(), self._clocks.utc(t)
        messages = tuple(self._radio.drain())
        self._take_detections(t)
        self._stop.move(state.v_x, state.r, t)
        self._model, self._t_moved = None, t
        is_ready = self._stop.plan is not None and self._plan_state is status.state
        enable, clear = self._takeover.next(status.state, is_ready=is_ready)
        delta, a_x, command = state.delta, 0.0, None
        has_begun = status.cycle > 0 or self.last is not None  # the number begins anew after 22 minutes
        if has_begun and status.state in (KitState.ENABLED, KitState.SAFE_STOP):
            row = self._plan_cycle(t, now, state, status.cycle, messages, received)
            delta, a_x, command = row.command.delta, row.a_x, row.command
        self._send(delta, a_x, enable, clear, status.cycle, t)
        if self.last is not None:
            self._record_sent(utc())
        self.counts["answered"] += 1
        self._plan_stop(state, status, command, t)
        message = self._unit.poll(self._clocks.senders(t), state) if has_begun else None
        if message is not None:
            self._radio.send(wrap_message(message, self._wrapper))
            self.counts["ego_sent"] += 1

    def watch(self, t: float) -> None:
        """Send the stored safe stop if the state is lost.

        Parameters
        ----------
        t : float
            Control time [s].
        """
        status = self.receiver.status
        due = t - self._t_sent >= self.settings.period - 1e-9
        if status is None or not self.receiver.is_lost(t) or not due:
            return
        if self.receiver.state is None or self._stop.plan is None:
            return
        if self._model is None:
            self._model = SingleTrackPlant(self._scenario.vehicle, self.receiver.state)
        self._model.step(*self._command, min(t - self._t_moved, 1.0))
        self._stop.move(self._model.state.v_x, self._model.state.r, t)
        self._t_moved = t
        command = self._stop.execute()
        if command is None:
            return
        self.counts["blind"] += 1
        enable, cycle = status.state is KitState.ENABLED, status.cycle + self._blind_cycles(t)
        self._send(*command, enable, False, cycle, t)

    def _blind_cycles(self, t: float) -> int:
        """Return the number of states that should have arrived since the last."""
        return max(round(self.receiver.age(t) / self.receiver.settings.period) - 1, 0)

    def _unwrapped(self) -> VehicleState | None:
        """Return the last state with a heading that does not jump at half a turn."""
        state = self.receiver.state
        if state is None:
            return None
        self._heading += wrap_angle(state.psi - self._heading)
        return VehicleState(
            x=state.x, y=state.y, psi=self._heading, v_x=state.v_x, v_y=state.v_y, r=state.r,
            delta=state.delta, a_x=state.a_x, t=state.t,
        )  # fmt: skip

    def _plan_cycle(
        self,
        t: float,
        now: float,
        state: VehicleState,
        cycle: int,
        messages: tuple[bytes, ...],
        received: float,
    ) -> VehicleRow:
        """Run the controller on what is known now."""
        recent = self._detections[1] if t - self._detections[0] <= self.settings.detection_timeout else []
        remotes = self._perception.fuse(now, recent, messages, state)
        self.health = self._perception.health(now)
        self._clocks.feed(self.health)
        tick = time.perf_counter()
        awareness = self._perception.awareness_range(now)
        if self._scenario.v2v and not self.health.received:  # a silent radio knows nothing about a lane
            awareness = 0.0
        command = self._controller.step(t, state, remotes, awareness_range=awareness)
        cycle_us = 1e6 * (time.perf_counter() - tick)
        self.band = command.band
        a_x, held = command.a_x, False
        if self._tailgating is not None:
            a_x = self._tailgating.acceleration(remotes, command, *self._to_lead(state, remotes))
            held = not self._tailgating.released
        self.last = VehicleRow(
            cycle=cycle, command=replace(command, band=None), remotes=tuple(remotes), messages=messages,
            a_x=a_x, gap_held=held,
            cycle_us=cycle_us, received=received, sent=received,
        )  # fmt: skip
        return self.last

    def _to_lead(
        self, state: VehicleState, remotes: Iterable[RemoteVehicle]
    ) -> tuple[float, float, LeadMotion]:
        """Return station and speed of the ego, and the motion of the lead; unknown, it keeps the gap."""
        path, gap = self._scenario.road.path, self._scenario.fixed_gap
        self._s = path.foot_point(state.x, state.y, self._s)[0]
        lead = next((r for r in remotes if gap is not None and r.id == gap.lead_id), None)
        if lead is None or gap is None:
            rear = self._s + self._scenario.vehicle.front + (gap.time_gap if gap else 0.0) * state.v_x
            return self._s, state.v_x, LeadMotion(rear, state.v_x, 0.0)
        self._lead_s = path.foot_point(lead.x, lead.y, max(self._lead_s, self._s))[0]
        return self._s, state.v_x, LeadMotion(self._lead_s - 0.5 * lead.length, lead.v_x, lead.a_x)

    def _take_detections(self, t: float) -> None:
        for data in self._sensor.drain():
            found = decode_detections(data)
            if found is None:
                self.counts["unreadable_detections"] += 1
            else:
                self._detections = t, found[1]

    def _send(self, delta: float, a_x: float, enable: bool, clear: bool, cycle: int, t: float) -> None:
        self._counter, self._command = self._counter + 1, (delta, a_x)
        steering = SteeringCommand(
            delta=delta, delta_rate=self._scenario.vehicle.delta_rate_max, enable=enable, clear=clear
        )
        acceleration = AccelerationCommand(a_x=a_x, enable=enable)
        self._bus.send(self._codec.command_frames(steering, acceleration, self._counter, cycle))
        self._t_sent = t

    def _plan_stop(self, state: VehicleState, status: KitStatus, command: Command | None, t: float) -> None:
        """Send a safe stop if the planner has decided anew, the last one is old, or the kit needs one."""
        stop = None if command is None else command.safe_stop
        is_new = stop is not None and stop.t[0] >= 0.0
        self._plan_age += 1
        is_old = self._plan_age >= self.settings.safe_stop_cycles or self._plan_state is not status.state
        if not (is_new or is_old or self._stop.plan is None):
            return
        reference = self._scenario.road.path if command is None else command.reference
        plan = plan_safe_stop(self._scenario.vehicle, reference, state, self._safe_stop, stop=stop)
        self._bus.send(self._codec.safe_stop_frames(plan, status.cycle, self._plan_counter))
        self._plan_counter += SAFE_STOP_POINTS
        self._plan_age, self._plan_state = 0, status.state
        self._stop.load(plan, t)
        self.counts["plans"] += 1
        self.counts["braking_plans"] += stop is None

    def _record_sent(self, utc: float) -> None:
        row = self.last
        if row is not None and (not self.rows or self.rows[-1].cycle != row.cycle):
            self.rows.append(replace(row, sent=utc))
            if not self._records:
                del self.rows[:-2]

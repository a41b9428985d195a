"""CAN messages of the rig: records to protected frames and back, by the DBC."""

import math
from collections.abc import Iterable, Mapping
from importlib.resources import files
from typing import Any

import numpy as np

from cca_core._optional import require_extra
from cca_core.rig.frames import Frame, KitStatus
from cca_core.rig.kit import AccelerationCommand, KitState, SteeringCommand
from cca_core.rig.protection import protect
from cca_core.rig.safe_stop import StopProfile
from cca_core.rig.settings import SteeringMap
from cca_core.vehicle import VehicleState

DBC_FILE = files("cca_core.rig").joinpath("rig.dbc")
"""Database of all messages and signals, for the tools of a CAN bus."""

STATE_MESSAGES = ("EGO_POSE", "EGO_MOTION", "EGO_DYNAMICS", "KIT_STATUS")
"""Messages of one state in the order of sending."""

COMMAND_MESSAGES = ("STEERING_COMMAND", "ACCELERATION_COMMAND", "SAFE_STOP")
"""Messages to the kit."""

N_CYCLES = 65_536
"""Numbers of states are sent modulo this."""

N_PLAN_CYCLES = 32
"""Numbers of the states at which safe stops begin are sent modulo this."""

_HEADING_RANGE = 4.096  # headings of safe stops are sent modulo this [rad]


class Codec:
    """Conversion of records to CAN frames and back.

    Parameters
    ----------
    steering : SteeringMap
        Between road-wheel and steering-wheel angles.

    Raises
    ------
    MissingExtraError
        If cantools is not installed.

    Notes
    -----
    Values beyond the range of a signal are sent as its limit. The data id of a message is its identifier.
    """

    def __init__(self, steering: SteeringMap) -> None:
        cantools = require_extra("cantools", "rig")
        self._steering = steering
        database = cantools.database.load_string(DBC_FILE.read_text(encoding="utf-8"), "dbc")
        self._messages: dict[str, Any] = {m.name: m for m in database.messages}
        self._names: dict[int, str] = {m.frame_id: m.name for m in database.messages}
        self._limits = {
            m.name: {s.name: (s.minimum, s.maximum) for s in m.signals} for m in database.messages
        }

    @property
    def ids(self) -> dict[str, int]:
        """Identifier of each message by its name."""
        return {name: message.frame_id for name, message in self._messages.items()}

    def name_of(self, frame_id: int) -> str:
        """Return the name of a message.

        Parameters
        ----------
        frame_id : int
            Identifier [-].

        Returns
        -------
        name : str
            Name in the DBC; empty if the identifier is not in it.
        """
        return self._names.get(frame_id, "")

    def content(self, frame: Frame) -> bytes:
        """Return the data of a frame that has the length of its message.

        Parameters
        ----------
        frame : Frame
            Frame of a message in the DBC.

        Returns
        -------
        data : bytes
            Its data; empty if the length is another one, so that no check accepts it.
        """
        length = self._messages[self._names[frame.id]].length
        return frame.data if len(frame.data) == length else b""

    def state_frames(self, state: VehicleState, status: KitStatus, counter: int) -> list[Frame]:
        """Frames of one state of the vehicle.

        Parameters
        ----------
        state : VehicleState
            Motion of the center of gravity.
        status : KitStatus
            State of the kit.
        counter : int
            Number of the frames [-], sent modulo 15.

        Returns
        -------
        frames : list of Frame
            One for each of `STATE_MESSAGES`, with one counter.
        """
        angle = self._steering.to_steering_wheel(state.delta)
        motion = {
            "Heading": math.remainder(state.psi, math.tau), "SpeedX": max(state.v_x, 0.0), "YawRate": state.r
        }  # fmt: skip
        dynamics = {"SteeringWheelAngle": angle, "SpeedY": state.v_y, "AccelerationX": state.a_x}
        report = {
            "State": status.state.value, "TimedOut": status.has_timed_out,
            "HasSafeStop": status.has_safe_stop, "Cycle": status.cycle % N_CYCLES,
            "WrongCrc": status.wrong_crc % 65536, "WrongCounter": status.wrong_counter % 65536,
        }  # fmt: skip
        return [
            self._frame("EGO_POSE", counter, {"PositionX": state.x, "PositionY": state.y}),
            self._frame("EGO_MOTION", counter, motion),
            self._frame("EGO_DYNAMICS", counter, dynamics),
            self._frame("KIT_STATUS", counter, report),
        ]

    def command_frames(
        self, steering: SteeringCommand, acceleration: AccelerationCommand, counter: int, cycle: int
    ) -> list[Frame]:
        """Frames of one command.

        Parameters
        ----------
        steering : SteeringCommand
            Road-wheel angle with its rate, enable and clear.
        acceleration : AccelerationCommand
            Acceleration with enable.
        counter : int
            Number of the frames [-], sent modulo 15.
        cycle : int
            Number of the state that is answered [-].

        Returns
        -------
        frames : list of Frame
            Steering and acceleration.
        """
        rate = steering.delta_rate
        turn = {
            "Enable": steering.enable, "Clear": steering.clear, "Cycle": cycle % N_CYCLES,
            "SteeringWheelAngle": self._steering.to_steering_wheel(steering.delta),
            "SteeringWheelRate": self._steering.to_steering_wheel(rate) if math.isfinite(rate) else math.inf,
        }  # fmt: skip
        brake = {
            "Enable": acceleration.enable, "Acceleration": acceleration.a_x, "Cycle": cycle % N_CYCLES
        }  # fmt: skip
        return [
            self._frame("STEERING_COMMAND", counter, turn),
            self._frame("ACCELERATION_COMMAND", counter, brake),
        ]

    def safe_stop_frames(self, plan: StopProfile, cycle: int, counter: int) -> list[Frame]:
        """Frames of a safe stop.

        Parameters
        ----------
        plan : StopProfile
            Steering and braking over distance.
        cycle : int
            Number of the state at which the plan begins [-], sent modulo 32.
        counter : int
            Number of the first frame [-]; each further one adds 1.

        Returns
        -------
        frames : list of Frame
            One for each point.
        """
        frames = []
        for i, (heading, delta, a_x) in enumerate(zip(plan.heading, plan.delta, plan.a_x, strict=True)):
            content = {
                "Cycle": cycle % N_PLAN_CYCLES, "Index": i, "Acceleration": a_x, "Spacing": plan.spacing,
                "SteeringWheelAngle": self._steering.to_steering_wheel(delta),
                "Heading": math.remainder(heading, _HEADING_RANGE),
            }  # fmt: skip
            frames.append(self._frame("SAFE_STOP", counter + i, content))
        return frames

    def decode(self, frame: Frame) -> dict[str, float]:
        """Read the signals of a frame.

        Parameters
        ----------
        frame : Frame
            Frame of a message in the DBC.

        Returns
        -------
        signals : dict
            Values by the names of the DBC, in its units.
        """
        message = self._messages[self._names[frame.id]]
        signals: dict[str, float] = message.decode(frame.data, decode_choices=False)
        return signals

    def state(self, frames: Iterable[Frame]) -> tuple[VehicleState, KitStatus]:
        """Read the frames of one state.

        Parameters
        ----------
        frames : iterable of Frame
            One for each of `STATE_MESSAGES`.

        Returns
        -------
        state : VehicleState
            Motion of the center of gravity.
        status : KitStatus
            State of the kit.
        """
        s = {name: value for frame in frames for name, value in self.decode(frame).items()}
        state = VehicleState(
            x=s["PositionX"], y=s["PositionY"], psi=s["Heading"], v_x=s["SpeedX"], v_y=s["SpeedY"],
            r=s["YawRate"], delta=self._steering.to_road_wheel(s["SteeringWheelAngle"]),
            a_x=s["AccelerationX"],
        )  # fmt: skip
        status = KitStatus(
            state=KitState(int(s["State"])), has_timed_out=bool(s["TimedOut"]),
            has_safe_stop=bool(s["HasSafeStop"]), cycle=int(s["Cycle"]), wrong_crc=int(s["WrongCrc"]),
            wrong_counter=int(s["WrongCounter"]),
        )  # fmt: skip
        return state, status

    def command(self, frame: Frame) -> SteeringCommand | AccelerationCommand:
        """Read a command.

        Parameters
        ----------
        frame : Frame
            Frame of a steering or an acceleration command.

        Returns
        -------
        command : SteeringCommand or AccelerationCommand
            Its content.
        """
        s = self.decode(frame)
        if "Acceleration" in s:
            return AccelerationCommand(a_x=s["Acceleration"], enable=bool(s["Enable"]))
        convert = self._steering.to_road_wheel
        return SteeringCommand(
            delta=convert(s["SteeringWheelAngle"]), delta_rate=convert(s["SteeringWheelRate"]),
            enable=bool(s["Enable"]), clear=bool(s["Clear"]),
        )  # fmt: skip

    def safe_stop(self, frames: Iterable[Frame]) -> StopProfile:
        """Read a safe stop.

        Parameters
        ----------
        frames : iterable of Frame
            The frames of one plan, in order.

        Returns
        -------
        plan : StopProfile
            Steering and braking over distance.

        Raises
        ------
        InputError
            If the content is not that of a plan.
        """
        points = [self.decode(frame) for frame in frames]
        heading = np.unwrap([s["Heading"] for s in points], period=_HEADING_RANGE)
        return StopProfile(
            spacing=points[0]["Spacing"] if points else 0.0, heading=tuple(heading.tolist()),
            delta=tuple(self._steering.to_road_wheel(s["SteeringWheelAngle"]) for s in points),
            a_x=tuple(s["Acceleration"] for s in points),
        )  # fmt: skip

    def _frame(self, name: str, counter: int, content: Mapping[str, float]) -> Frame:
        message, limits = self._messages[name], self._limits[name]
        signals: dict[str, float] = {"Crc": 0, "Counter": 0}
        for key, value in content.items():
            low, high = limits[key]
            signals[key] = min(max(value, low), high)
        data = message.encode(signals, strict=False)
        return Frame(message.frame_id, protect(data, message.frame_id, counter))

"""Settings of the rig: bus, steering, radio and ports, from a TOML file."""

import math
import tomllib
from dataclasses import dataclass, field, fields
from pathlib import Path as FilePath
from typing import Any, Self

import numpy as np

from cca_core._checks import check_array, check_real, shown
from cca_core._files import read_bytes
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.rig.wrap import WRAPPERS


class SteeringMap:
    """Steering-wheel angle over road-wheel angle, the same to both sides.

    Parameters
    ----------
    ratio : float
        Steering-wheel angle divided by road-wheel angle [-], positive.
    points : array_like, shape (n, 2), optional
        Road-wheel angle and steering-wheel angle [rad] of a measured map instead, increasing and positive.

    Raises
    ------
    InputError
        If the ratio is not positive or the points do not increase.
    """

    def __init__(self, ratio: float = 15.0, points: Any = None) -> None:
        if points is None:
            points = [(1.0, check_real("ratio", ratio, gt=0.0))]
        pairs = np.vstack(((0.0, 0.0), check_array("points", points, (None, 2))))
        if len(pairs) < 2 or not (np.diff(pairs, axis=0) > 0.0).all():
            raise InputError("points must be positive and increase in both columns")
        self._road, self._wheel = pairs.T.tolist()

    def to_steering_wheel(self, delta: float) -> float:
        """Convert a road-wheel angle.

        Parameters
        ----------
        delta : float
            Road-wheel angle [rad], left positive.

        Returns
        -------
        angle : float
            Steering-wheel angle [rad], left positive.
        """
        return _odd(delta, self._road, self._wheel)

    def to_road_wheel(self, angle: float) -> float:
        """Convert a steering-wheel angle.

        Parameters
        ----------
        angle : float
            Steering-wheel angle [rad], left positive.

        Returns
        -------
        delta : float
            Road-wheel angle [rad], left positive.
        """
        return _odd(angle, self._wheel, self._road)


def _odd(x: float, xs: list[float], ys: list[float]) -> float:
    """Interpolate an odd function; beyond its last point it continues with the last slope."""
    size = abs(x)
    i = 1
    while i < len(xs) - 1 and xs[i] < size:
        i += 1
    slope = (ys[i] - ys[i - 1]) / (xs[i] - xs[i - 1])
    return math.copysign(ys[i - 1] + slope * (size - xs[i - 1]), x)


def _default_bus() -> dict[str, Any]:
    return {
        "interface": "udp_multicast", "channel": "239.74.163.2", "port": 43113, "hop_limit": 0, "fd": False
    }  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class RigSettings:
    """Interfaces of the rig.

    Parameters
    ----------
    bus : dict
        Arguments of ``can.Bus``, such as ``interface``, ``channel`` and ``bitrate``. The default is a bus in
        software, ``udp_multicast`` on this machine.
    steering_ratio : float
        Steering-wheel angle divided by road-wheel angle [-].
    steering_map : tuple of tuple of float
        Road-wheel angle and steering-wheel angle [rad] of a measured map; replaces the ratio.
    radio_to_vehicle, radio_to_plant : str
        Address and port at which the vehicle, and the plant for all other vehicles, receive messages. A
        multicast group lets the monitor listen too; an on-board unit is given the address of the machine.
    radio_wrapper : str
        Wrapper around sent messages, one of `WRAPPERS`.
    sensor_address : str
        Address and port at which the vehicle receives the detections of its sensor.
    telemetry_address : str
        Address and port to which the vehicle reports what it does, for the monitor.
    plant_control, vehicle_control : str
        Address and port at which a process takes lines of `ControlPort`; empty for none.
    monitor_port : int
        Port of the monitor's page on this machine [-].

    Raises
    ------
    InputError
        If a value is out of range or an address cannot be read.
    """

    bus: dict[str, Any] = field(default_factory=_default_bus)
    steering_ratio: float = 15.0
    steering_map: tuple[tuple[float, float], ...] = ()
    radio_to_vehicle: str = "239.74.163.3:26789"
    radio_to_plant: str = "239.74.163.3:26790"
    radio_wrapper: str = "unsecured"
    sensor_address: str = "127.0.0.1:26791"
    telemetry_address: str = "239.74.163.3:26792"
    plant_control: str = ""
    vehicle_control: str = ""
    monitor_port: int = 8765

    __repr__ = short_repr

    def __post_init__(self) -> None:
        bus: object = self.bus
        if not isinstance(bus, dict) or not all(isinstance(key, str) for key in bus):
            raise InputError(f"bus must be a table, was {shown(self.bus)}")
        SteeringMap(self.steering_ratio, self.steering_map or None)
        for name in ("radio_to_vehicle", "radio_to_plant", "sensor_address", "telemetry_address"):
            parse_address(name, getattr(self, name))
        for name in ("plant_control", "vehicle_control"):
            if getattr(self, name) != "":
                parse_address(name, getattr(self, name))
        if self.radio_wrapper not in WRAPPERS:
            raise InputError(
                f"radio_wrapper must be one of {', '.join(WRAPPERS)}, was {self.radio_wrapper!r}"
            )
        check_real("monitor_port", self.monitor_port, ge=0, le=65535)

    @property
    def steering(self) -> SteeringMap:
        """Conversion between steering-wheel and road-wheel angles."""
        return SteeringMap(self.steering_ratio, self.steering_map or None)

    def shifted(self, number: int) -> Self:
        """Return the settings of another rig in software on the same machine.

        Parameters
        ----------
        number : int
            Number that is added ten times to every port [-].

        Returns
        -------
        settings : RigSettings
            The same, with other ports.
        """

        def moved(address: str) -> str:
            if not address:
                return ""
            host, port = parse_address("address", address)
            return f"{host}:{port + 10 * number}"

        bus = dict(self.bus)
        if "port" in bus:
            bus["port"] += 10 * number
        return type(self)(
            bus=bus, steering_ratio=self.steering_ratio, steering_map=self.steering_map,
            radio_to_vehicle=moved(self.radio_to_vehicle), radio_to_plant=moved(self.radio_to_plant),
            radio_wrapper=self.radio_wrapper, sensor_address=moved(self.sensor_address),
            telemetry_address=moved(self.telemetry_address), plant_control=moved(self.plant_control),
            vehicle_control=moved(self.vehicle_control), monitor_port=self.monitor_port + 10 * number,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSettings:
    """Cycle of the vehicle computer.

    Parameters
    ----------
    period : float
        Time between two commands while no state arrives [s].
    safe_stop_cycles : int
        Cycles between two plans of a safe stop [-], if the planner does not decide more often.
    detection_timeout : float
        Age from which on detections of the sensor are not used [s].
    ego_id : str
        Temporary identity in the ego's own messages.
    clears : bool
        Whether a safe stop of the kit is cleared without a person.
    """

    period: float = 0.02
    safe_stop_cycles: int = 5
    detection_timeout: float = 0.1
    ego_id: str = "ffffffff"
    clears: bool = True

    __repr__ = short_repr


def read_rig_settings(file: str | FilePath) -> RigSettings:
    """Read the settings of a rig.

    Parameters
    ----------
    file : str or pathlib.Path
        TOML file. Its keys are the fields of `RigSettings`; ``bus`` is a table.

    Returns
    -------
    settings : RigSettings
        The default counts for what is missing.

    Raises
    ------
    InputError
        If the file cannot be read, a key is unknown or a value is wrong.
    """
    try:
        data = tomllib.loads(read_bytes(file, max_bytes=1_000_000).decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"file {str(file)!r} must be TOML: {error}") from None
    known = {each.name for each in fields(RigSettings)}
    unknown = sorted(data.keys() - known)
    if unknown:
        raise InputError(
            f"file {str(file)!r} must have the keys {', '.join(sorted(known))}, had {unknown[0]}"
        )
    if "steering_map" in data:
        data["steering_map"] = tuple(map(tuple, check_array("steering_map", data["steering_map"], (None, 2))))
    return RigSettings(**data)


def parse_address(name: str, text: object) -> tuple[str, int]:
    """Return host and port of ``host:port``."""
    host, colon, port = text.rpartition(":") if isinstance(text, str) else ("", "", "")
    if not (host and colon and port.isascii() and port.isdigit() and 0 < int(port) < 65536):
        raise InputError(f"{name} must be host:port, was {shown(text)}")
    return host, int(port)

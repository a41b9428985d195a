"""Monitor: joins bus, radio and telemetry read-only, and serves one live page on this machine."""

import json
import math
import threading
import time
from collections import Counter, deque
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any

import numpy as np

from cca_core.errors import InputError
from cca_core.rig.bus import BusLink
from cca_core.rig.messages import Codec
from cca_core.rig.protection import CheckStatus, ProtectedReceiver
from cca_core.rig.receivers import StateReceiver
from cca_core.rig.settings import RigSettings
from cca_core.rig.udp import UdpLink
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.v2x import unwrap_message

_PERIOD = 0.1  # of the events that the page receives [s]


class Monitor:
    """What bus, radio and telemetry show.

    Parameters
    ----------
    scenario : Scenario
        Its road is drawn.
    settings : RigSettings
        Interfaces.

    Raises
    ------
    InputError
        If an interface cannot be opened.
    """

    def __init__(self, scenario: Scenario, settings: RigSettings) -> None:
        self._bus, self._codec = BusLink(settings.bus), Codec(settings.steering)
        self._links = {
            "to_vehicle": UdpLink(_joinable(settings.radio_to_vehicle)),
            "to_plant": UdpLink(_joinable(settings.radio_to_plant)),
            "telemetry": UdpLink(settings.telemetry_address),
        }
        self._checks = {i: ProtectedReceiver(i) for i in self._codec.ids.values()}
        self._state = StateReceiver(self._codec)
        self._seen: deque[tuple[float, str]] = deque(maxlen=20_000)
        self._telemetry: dict[str, Any] = {}
        self._lock = threading.Lock()
        self.road = _road(scenario)

    def poll(self, t: float) -> None:
        """Take what has arrived.

        Parameters
        ----------
        t : float
            Time now [s].
        """
        with self._lock:
            for frame in self._bus.drain():
                name = self._codec.name_of(frame.id)
                self._state.take(frame, t)
                self._seen.append((t, name or "unknown frame"))
                if name and self._checks[frame.id].check(frame.data) is CheckStatus.WRONG_CRC:
                    self._seen.append((t, "wrong CRC"))
            for direction in ("to_vehicle", "to_plant"):
                for data in self._links[direction].drain():
                    self._seen.append((t, f"radio {direction}: {_kind(data)}"))
            for data in self._links["telemetry"].drain():
                try:
                    content = json.loads(data)
                except ValueError:
                    content = None
                if isinstance(content, dict):
                    self._telemetry = content | {"received": t}

    def snapshot(self, t: float) -> dict[str, Any]:
        """Describe the last second.

        Parameters
        ----------
        t : float
            Time now [s].

        Returns
        -------
        snapshot : dict
            Rates of frames and messages by name [1/s], the last telemetry, and its age [s]; the state of the
            kit and the motion of the ego on the bus, None if there was none in the last second.
        """
        with self._lock:
            rates = Counter(name for at, name in self._seen if t - at <= 1.0)
            age = t - self._telemetry["received"] if self._telemetry else None
            found = {"rates": dict(sorted(rates.items())), "vehicle": self._telemetry, "age": age}
            return found | self._on_bus(t)

    def _on_bus(self, t: float) -> dict[str, Any]:
        """Kit and ego as the bus reports them, whether or not the vehicle computer lives."""
        state, status = self._state.state, self._state.status
        if state is None or status is None or self._state.age(t) > 1.0:
            return {"kit": None, "ego": None}
        motion = state.x, state.y, state.psi, state.v_x, state.delta, state.a_x
        return {"kit": status.state.name, "ego": [round(value, 4) for value in motion]}

    def close(self) -> None:
        """Leave bus, radio and telemetry."""
        self._bus.close()
        for link in self._links.values():
            link.close()


def serve(scenario: Scenario, settings: RigSettings, *, is_stopped: Callable[[], bool]) -> None:
    """Serve the page until asked to stop.

    Parameters
    ----------
    scenario : Scenario
        Its road is drawn.
    settings : RigSettings
        Interfaces, and the port of the page. It is reached from another machine by ``ssh -L``.
    is_stopped : callable
        Whether to end now.

    Raises
    ------
    InputError
        If an interface or the port cannot be opened.
    """
    monitor = Monitor(scenario, settings)
    page = files("cca_core.rig").joinpath("monitor.html").read_bytes()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path == "/":
                self._answer("text/html; charset=utf-8", page)
            elif self.path == "/road":
                self._answer("application/json", json.dumps(monitor.road).encode())
            elif self.path == "/state":
                self._answer("application/json", json.dumps(monitor.snapshot(time.monotonic())).encode())
            elif self.path == "/events":
                self._stream()
            else:
                self.send_error(404)

        def _answer(self, kind: str, content: bytes) -> None:
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        def _stream(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/event-stream")
            self.end_headers()
            try:
                while not is_stopped():
                    text = json.dumps(monitor.snapshot(time.monotonic()))
                    self.wfile.write(f"data: {text}\n\n".encode())
                    self.wfile.flush()
                    time.sleep(_PERIOD)
            except OSError:  # the page was closed
                return

        def log_message(self, *_: object) -> None:
            """Write nothing to the terminal."""

    try:
        server = ThreadingHTTPServer(("127.0.0.1", settings.monitor_port), Handler)
    except OSError as error:
        monitor.close()
        raise InputError(f"monitor_port must be free, was {settings.monitor_port}: {error}") from None
    server.daemon_threads = True
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    while not is_stopped():
        monitor.poll(time.monotonic())
        time.sleep(0.02)
    server.shutdown()
    server.server_close()
    thread.join()
    monitor.close()


def _joinable(address: str) -> str | None:
    """Return a multicast group; an address of one receiver cannot be joined."""
    first = address.split(".", 1)[0]
    return address if first.isdigit() and 224 <= int(first) <= 239 else None


def _kind(data: bytes) -> str:
    try:
        return unwrap_message(data).name
    except InputError:
        return "unreadable"


def _road(scenario: Scenario) -> dict[str, Any]:
    """Describe lanes and edges as lines [m]."""
    road = scenario.road
    offsets = sorted({each for lane in road.lanes for each in (lane.left, lane.right)})
    path = road.path
    stations = np.linspace(path.start, path.end, max(2, math.ceil(path.length / 4.0)))
    lines = [np.round(path.to_cartesian(stations, np.full(len(stations), d)), 2).tolist() for d in offsets]
    car = scenario.vehicle
    return {"name": scenario.name, "lines": lines, "ego": [car.length, car.width, car.box_offset]}

"""Message link for the cases of `faults`: 10 Hz message bytes of true vehicles into a `Tracker`."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from cca_core import LocalFrame, RemoteVehicle, VehicleParams, VehicleState
from cca_core.v2x import Bsm, Tracker, TrackerHealth, encode_bsm

EPOCH = 1200.0  # senders' time when the drive begins [s]
ROAD_HEIGHT = 200.0  # of the ego's road [m]
EGO_ID = "000000ee"  # temporary id in the ego's own messages
LATENCY = 0.02  # [s]


class Radio:
    """Messages of all vehicles, ten times a second, into a tracker.

    `clock` is the lead of the receiver's clock over the senders' [s]. `sender` returns the temporary id of a
    vehicle at a time, or None if its message is lost; `fields` returns message fields that differ from the
    truth. With `echo` the ego receives its own message, too.
    """

    def __init__(
        self,
        *,
        clock: float = 0.0,
        sender: Callable[[RemoteVehicle, float], str | None] = lambda vehicle, t: vehicle.id,
        fields: Callable[[RemoteVehicle, float], dict[str, Any]] = lambda vehicle, t: {},
        echo: bool = False,
    ) -> None:
        self.frame = LocalFrame(40.0, -83.0)
        self.clock, self.sender, self.fields, self.echo = clock, sender, fields, echo
        self.count, self.due = 0, 0.0
        self.tracker = Tracker(self.frame, own_ids=(EGO_ID,), height=ROAD_HEIGHT)

    def health(self, t: float) -> TrackerHealth:
        """Return what the tracker reports about its messages."""
        return self.tracker.health(EPOCH + t + self.clock)

    def known(self, t: float, state: VehicleState, true: Sequence[RemoteVehicle]) -> Sequence[RemoteVehicle]:
        """Send what is due and return all tracks."""
        now = EPOCH + t + self.clock
        if t >= self.due - 1e-9:
            self.due += 0.1
            self.count += 1
            for i, vehicle in enumerate(true):
                name = self.sender(vehicle, t)
                if name is not None:
                    sent = EPOCH + t - 0.013 * i
                    self.tracker.update(
                        self.message(vehicle, sent, name, self.count + 17 * i, t), now + LATENCY
                    )
            if self.echo:
                data = self.message(_as_remote(state), EPOCH + t, EGO_ID, self.count, t)
                self.tracker.update(data, now + LATENCY)
        return self.tracker.vehicles(now, state)

    def message(self, vehicle: RemoteVehicle, sent: float, name: str, count: int, t: float) -> bytes:
        """Bytes of one message."""
        lat, lon = self.frame.to_geodetic((vehicle.x, vehicle.y))
        content = {
            "msg_count": count % 128,
            "id": name,
            "sec_mark": round(sent % 60.0 * 1000.0) % 60000 / 1000.0,
            "latitude_deg": float(lat),
            "longitude_deg": float(lon),
            "elevation": ROAD_HEIGHT,
            "speed": abs(vehicle.v_x),
            "psi": math.remainder(vehicle.psi, 2.0 * math.pi),
            "a_x": vehicle.a_x,
            "r": vehicle.r,
            "length": vehicle.length,
            "width": vehicle.width,
            "transmission": "reverse" if vehicle.v_x < 0.0 else "forward",
        }
        return encode_bsm(Bsm(**{**content, **self.fields(vehicle, t)}))


def _as_remote(state: VehicleState) -> RemoteVehicle:
    """The ego, a BMW 320i, as another vehicle receives it."""
    car = VehicleParams.bmw_320i()
    return RemoteVehicle(
        id=EGO_ID,
        x=state.x,
        y=state.y,
        psi=state.psi,
        v_x=state.v_x,
        a_x=state.a_x,
        length=car.length,
        width=car.width,
    )

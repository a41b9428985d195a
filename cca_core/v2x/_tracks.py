"""The senders' tracks, and a table of where they are for quick comparisons."""

import math

import numpy as np

from cca_core.geometry import wrap_angle
from cca_core.v2x.motion import STALE_AFTER, Fix, move_on, position_bounds
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.vehicle import RemoteVehicle, VehicleState

_NOWHERE = 1e12  # [m]
_AROUND = 6.0  # silence after which the message count may have gone around [s]


class Track:
    """What is known of one sender."""

    __slots__ = (
        "begun", "doubt", "events", "fix", "id", "length", "msg_count", "ref", "row", "timed", "width",
    )  # fmt: skip

    def __init__(
        self,
        id: str,
        fix: Fix,
        length: float,
        width: float,
        events: frozenset[str],
        msg_count: int,
        timed: bool,
    ) -> None:
        self.id, self.fix, self.length, self.width, self.events = id, fix, length, width, events
        self.msg_count, self.timed = msg_count, timed
        self.begun = fix.t  # time of its first message [s]
        self.ref = (fix.x, fix.y)  # where it is by all messages [m]
        self.doubt: Track | None = None  # its last message that was not believed
        self.row = -1

    def resembles(self, other: "Track") -> bool:
        """Whether both may be one body."""
        return (
            abs(self.length - other.length) < 0.2
            and abs(self.width - other.width) < 0.2
            and abs(wrap_angle(self.fix.psi - other.fix.psi)) < 0.3
        )

    def out_of_order(self, count: int, measured: float, timed: bool, t: float) -> str:
        """Why a message is not the next; empty if it is."""
        last = self.fix.t
        ahead = (count - self.msg_count) % 128
        if timed and self.timed:
            if measured > last:
                return ""
            return "duplicate" if measured == last and ahead == 0 else "out_of_order"
        if t - last > _AROUND:
            return ""
        if ahead == 0:
            return "duplicate"
        return "out_of_order" if ahead >= 64 or (timed and measured <= last) else ""

    def vehicle(self, t: float, shared: float) -> RemoteVehicle:
        """Where it is at a time; `shared` is a standard deviation that is added [m]."""
        fix = self.fix
        _, x, y, psi, v, a, r = move_on(fix, t)
        age = max(t - fix.t, 0.0)
        along, across = position_bounds(fix.v, age)
        return RemoteVehicle(
            id=self.id, x=x, y=y, psi=psi, v_x=v, a_x=a, r=r, age=age, length=self.length, width=self.width,
            sigma_along=min(math.hypot(0.5 * along, shared), 1e3),
            sigma_across=min(math.hypot(0.5 * across, shared), 1e3),
            events=self.events,
        )  # fmt: skip


def is_over(vehicle: RemoteVehicle, ego: VehicleState | None, settings: TrackerSettings) -> bool:
    """Whether a stale vehicle may be forgotten: its bounds do not reach the ego's stopping distance."""
    if vehicle.age > settings.forget_after:
        return True
    if ego is None:
        return False
    stopping = ego.v_x * settings.reaction + 0.5 * ego.v_x * ego.v_x / settings.braking
    extent = 0.5 * math.hypot(vehicle.length, vehicle.width)
    bound = 2.0 * math.hypot(vehicle.sigma_along, vehicle.sigma_across)
    distance = math.hypot(vehicle.x - ego.x, vehicle.y - ego.y)
    return distance - bound - extent > max(stopping, settings.least_reach)


class Tracks:
    """At most a given number of tracks."""

    def __init__(self, most: int) -> None:
        self.by_id: dict[str, Track] = {}
        self._free = list(range(most))[::-1]
        self._track: list[Track | None] = [None] * most
        self._xy = np.full((2, most), _NOWHERE)
        # along and across each body, dead-reckoned straight on, as a linear form of x, y, t, 1
        self._form = np.zeros((2, most, 4))
        self._form[..., 3] = _NOWHERE
        self._half = np.zeros((2, most))

    @property
    def is_full(self) -> bool:
        """Whether no further track can be added."""
        return not self._free

    def add(self, track: Track) -> None:
        """Keep a new track."""
        track.row = self._free.pop()
        self._track[track.row] = track
        self.by_id[track.id] = track
        self._write(track)

    def remove(self, track: Track) -> None:
        """Forget a track."""
        del self.by_id[track.id]
        self._track[track.row] = None
        self._xy[:, track.row] = _NOWHERE
        self._form[:, track.row] = 0.0, 0.0, 0.0, _NOWHERE
        self._free.append(track.row)

    def advance(self, track: Track, fresh: Track) -> None:
        """Replace a track by its next state, under the id of that."""
        fresh.row, fresh.begun, fresh.doubt = track.row, track.begun, None
        if fresh.id != track.id:
            del self.by_id[track.id]
        self.by_id[fresh.id] = fresh
        self._track[fresh.row] = fresh
        self._write(fresh)

    def _write(self, track: Track) -> None:
        t, x, y, psi, v, _, _ = track.fix
        cos, sin, row = math.cos(psi), math.sin(psi), track.row
        self._xy[:, row] = x, y
        self._form[0, row] = cos, sin, -v, v * t - x * cos - y * sin
        self._form[1, row] = -sin, cos, 0.0, x * sin - y * cos
        self._half[:, row] = 0.5 * track.length, 0.5 * track.width

    def holder(self, fix: Fix, begun: float, itself: Track | None) -> Track | None:
        """Track, begun earlier and not stale, in whose body a position lies."""
        within = np.abs(self._form @ np.array((fix.x, fix.y, fix.t, 1.0))) <= self._half
        for row in np.flatnonzero(within[0] & within[1]).tolist():
            track = self._track[row]
            if track is None or track is itself:
                continue
            if track.begun < begun and fix.t - track.fix.t <= STALE_AFTER:
                return track
        return None

    def farthest(self, place: tuple[float, float] | None) -> Track | None:
        """Track farthest from a place."""
        if place is None:
            return None
        x, y = self._xy
        away = np.where(x < _NOWHERE, np.hypot(x - place[0], y - place[1]), -1.0)
        return self._track[int(np.argmax(away))]

"""The senders' tracks, and a table of where they are for quick comparisons."""

import math

import numpy as np

from cca_core.geometry import wrap_angle
from cca_core.v2x.motion import STALE_AFTER, Fix, dead_reckon, position_bounds, predicted_displacement
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.vehicle import RemoteVehicle, VehicleState

_NOWHERE = 1e12  # [m]
_SHORTEST, _NARROWEST = 1.5, 0.8  # room that a body takes, however small it says to be [m]
_AROUND = 6.0  # silence after which the message count may have gone around [s]


class Track:
    """What is known of one sender: motion by its last message, place by the last that was believed."""

    __slots__ = (
        "accuracy", "begun", "doubt", "driven", "events", "fix", "id", "length", "msg_count", "origin",
        "placed", "ref", "row", "said", "speed", "timed", "width",
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
        accuracy: float,
    ) -> None:
        self.id, self.fix, self.length, self.width, self.events = id, fix, length, width, events
        self.msg_count, self.timed, self.accuracy = msg_count, timed, accuracy
        self.begun = fix.t  # time of its first message [s]
        self.said = self.origin = self.ref = (fix.x, fix.y)  # place told last, first, and by all messages [m]
        self.placed, self.speed, self.driven = fix.t, fix.v, 0.0  # of the last place believed; driven since
        self.doubt: Track | None = None  # its last message whose place was not believed
        self.row = -1

    def coast(self, fresh: "Track") -> None:
        """Go on as a message says, from where the sender was: its place is not believed, its motion is."""
        new, old = fresh.fix, self.fix
        x, y, way = predicted_displacement(old, new)
        self.driven += way
        self.ref = self.ref[0] + x - old.x, self.ref[1] + y - old.y
        self.fix = new._replace(x=x, y=y)
        self.events, self.msg_count, self.timed = fresh.events, fresh.msg_count, fresh.timed

    def matches(self, other: "Track") -> bool:
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

    def vehicle(self, t: float, name: str, shared: float, agreed: float) -> RemoteVehicle:
        """Where it is at a time, under a name.

        `shared` is a standard deviation that is added [m]; a doubted place that was told for `agreed`
        seconds lies within the bounds too.
        """
        fix, shared = self.fix, math.hypot(shared, self.accuracy)
        _, x, y, psi, v, a, r = dead_reckon(fix, t)
        age = max(t - self.placed, 0.0)
        if self.placed == fix.t:
            along, across = position_bounds(fix.v, age)
        else:
            along, across = position_bounds(self.speed, age, self.driven + abs(fix.v) * max(t - fix.t, 0.0))
        doubt = self.doubt
        if doubt is not None and doubt.fix.t - doubt.begun >= agreed:
            other, cos, sin = dead_reckon(doubt.fix, t), math.cos(psi), math.sin(psi)
            far_x, far_y = other.x - x, other.y - y
            more = position_bounds(doubt.fix.v, max(t - doubt.fix.t, 0.0))
            along = max(along, abs(far_x * cos + far_y * sin) + more[0])
            across = max(across, abs(far_y * cos - far_x * sin) + more[1])
        return RemoteVehicle(
            id=name, x=x, y=y, psi=psi, v_x=v, a_x=a, r=r, age=age, length=self.length, width=self.width,
            sigma_along=min(math.hypot(0.5 * along, shared), 1e3),
            sigma_across=min(math.hypot(0.5 * across, shared), 1e3),
            events=self.events,
        )  # fmt: skip


def is_expired(
    vehicle: RemoteVehicle, silent: float, ego: VehicleState | None, speed: float, settings: TrackerSettings
) -> bool:
    """Whether a vehicle silent for some time [s] stays out of the way of an ego at a speed."""
    if silent > settings.delete_after:
        return True
    if ego is None:
        return False
    stopping = speed * settings.reaction_time + 0.5 * speed * speed / settings.braking
    extent = 0.5 * math.hypot(vehicle.length, vehicle.width)
    bound = 2.0 * math.hypot(vehicle.sigma_along, vehicle.sigma_across)
    x, y = vehicle.x - ego.x, vehicle.y - ego.y
    away = math.hypot(x, y)
    v_x = vehicle.v_x * math.cos(vehicle.psi) - speed * math.cos(ego.psi)
    v_y = vehicle.v_x * math.sin(vehicle.psi) - speed * math.sin(ego.psi)
    nearer = max(-(x * v_x + y * v_y) / max(away, 1.0), 0.0) * settings.approach_horizon
    return away - bound - extent - nearer > max(stopping, settings.min_stopping_distance)


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
        self._begun = np.full(most, math.inf)

    @property
    def is_full(self) -> bool:
        """Whether no further track can be added."""
        return not self._free

    def add(self, track: Track) -> None:
        """Keep a new track."""
        track.row = self._free.pop()
        self._track[track.row] = track
        self.by_id[track.id] = track
        self.write(track)

    def remove(self, track: Track) -> None:
        """Forget a track."""
        del self.by_id[track.id]
        self._track[track.row] = None
        self._xy[:, track.row] = _NOWHERE
        self._form[:, track.row] = 0.0, 0.0, 0.0, _NOWHERE
        self._free.append(track.row)

    def advance(self, track: Track, fresh: Track) -> None:
        """Replace a track by its next state, under the id of that."""
        fresh.row, fresh.begun, fresh.origin, fresh.doubt = track.row, track.begun, track.origin, None
        if fresh.id != track.id:
            del self.by_id[track.id]
        self.by_id[fresh.id] = fresh
        self._track[fresh.row] = fresh
        self.write(fresh)

    def write(self, track: Track) -> None:
        """Enter into the table what has changed of a track."""
        t, x, y, psi, v, _, _ = track.fix
        cos, sin, row = math.cos(psi), math.sin(psi), track.row
        self._xy[:, row] = x, y
        self._form[0, row] = cos, sin, -v, v * t - x * cos - y * sin
        self._form[1, row] = -sin, cos, 0.0, x * sin - y * cos
        self._half[:, row] = 0.5 * max(track.length, _SHORTEST), 0.5 * max(track.width, _NARROWEST)
        self._begun[row] = track.begun

    def find_overlapping(self, fix: Fix, begun: float, itself: Track | None) -> Track | None:
        """Track, begun earlier and not stale, in whose body a position lies."""
        within = np.abs(self._form @ np.array((fix.x, fix.y, fix.t, 1.0))) <= self._half
        for row in np.flatnonzero(within[0] & within[1]).tolist():
            track = self._track[row]
            if track is None or track is itself:
                continue
            if track.begun < begun and fix.t - track.fix.t <= STALE_AFTER:
                return track
        return None

    def find_evictable(
        self, place: tuple[float, float], fix: Fix, within: float, established: float
    ) -> Track | None:
        """Farthest track that may make room for a nearer newcomer.

        One that has been heard for `established` seconds may only if it is farther than `within` from
        `place`.
        """
        x, y = self._xy
        away = np.where(x < _NOWHERE, np.hypot(x - place[0], y - place[1]), -1.0)
        away[(away <= within) & (fix.t - self._begun >= established)] = -1.0
        row = int(np.argmax(away))
        return self._track[row] if away[row] > math.dist(fix[1:3], place) else None

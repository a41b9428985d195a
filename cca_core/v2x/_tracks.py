"""Tracks of senders, and a table of their positions for fast comparison."""

import math

import numpy as np

from cca_core.geometry import wrap_angle
from cca_core.v2x._own_messages import EgoLikeness
from cca_core.v2x._reported_motion import ReportedMotion
from cca_core.v2x.motion import Fix, dead_reckon, position_bounds, predicted_displacement
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.vehicle import MAX_SPEED, STALE_AGE, RemoteVehicle, VehicleState

MAX_REVERSING = 20.0
"""Largest speed in reverse [m/s]."""

_NOWHERE = 1e12  # coordinate of an unused row [m]
_MAX_BODIES = 3  # bodies under one id


class Track:
    """State of one sender: motion of its last message, position of the last accepted one."""

    __slots__ = (
        "accuracy", "base", "driven", "ego_likeness", "events", "first_reported", "fix", "height", "id",
        "length", "motion", "msg_count", "ref", "rejected", "reported", "rivals", "row", "speed", "t_first",
        "t_position", "time_error", "timed", "width",
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
        base: float,
        time_error: float,
        accuracy: float,
        height: float | None,
        motion: ReportedMotion,
    ) -> None:
        self.id, self.fix, self.length, self.width, self.events = id, fix, length, width, events
        self.msg_count, self.timed, self.accuracy = msg_count, timed, accuracy
        self.base, self.time_error = base, time_error  # correction of the clock, and what is unknown [s]
        self.height, self.motion = height, motion
        self.t_first = fix.t  # time of its first message [s]
        # positions [m]: last accepted as reported, first reported, estimate by all messages
        self.reported = self.first_reported = self.ref = (fix.x, fix.y)
        # time and speed of the last accepted position, distance driven since
        self.t_position, self.speed, self.driven = fix.t, fix.v, 0.0
        self.rejected: Track | None = None  # last message with a rejected position
        # last messages of bodies elsewhere under the same id, with the number of messages that agree
        self.rivals: list[tuple[Track, int]] = []
        self.ego_likeness = EgoLikeness()
        self.row = -1

    def coast(self, message: "Track") -> None:
        """Continue with the reported motion of a message whose position was rejected."""
        new, old = message.fix, self.fix
        x, y, distance = predicted_displacement(old, new)
        self.driven += distance
        self.ref = self.ref[0] + x - old.x, self.ref[1] + y - old.y
        self.fix = new._replace(x=x, y=y)
        self.events, self.msg_count, self.timed = message.events, message.msg_count, message.timed
        self.base, self.time_error = message.base, message.time_error

    def has_size_of(self, other: "Track") -> bool:
        """Return whether the sizes of both may be those of one vehicle."""
        return abs(self.length - other.length) < 0.2 and abs(self.width - other.width) < 0.2

    def matches(self, other: "Track") -> bool:
        """Return whether size and heading of both may be those of one vehicle."""
        return self.has_size_of(other) and abs(wrap_angle(self.fix.psi - other.fix.psi)) < 0.3

    def out_of_order(self, count: int, measured: float, timed: bool, t: float) -> str:
        """Return why a message is not the next one; empty if it is."""
        last = self.fix.t
        ahead = (count - self.msg_count) % 128
        if timed and self.timed:
            # some devices repeat the time stamp of a position in their next messages
            if measured > last or (measured == last and 0 < ahead < 64):
                return ""
            return "duplicate" if measured == last and ahead == 0 else "out_of_order"
        if t - last > 6.0:  # [s], half a turn of the message count at 10 Hz: its order means nothing
            return ""
        if ahead == 0:
            return "duplicate"
        return "out_of_order" if ahead >= 64 or (timed and measured <= last) else ""

    def vehicle(self, t: float, name: str, settings: TrackerSettings, base: float) -> RemoteVehicle:
        """Return the vehicle dead-reckoned to a time [s] of a corrected clock, under a name."""
        fix, shared = self.fix, math.hypot(settings.sigma_position, self.accuracy)
        _, x, y, psi, v, a, r = dead_reckon(fix, t)
        v = min(max(v, -MAX_REVERSING), MAX_SPEED)  # a valid record, whatever acceleration is reported
        age, model = max(t - self.t_position, 0.0), settings.position_errors
        late = self.time_error + abs(base - self.base)  # a correction may be wrong as well
        if self.t_position == fix.t:
            along, across = position_bounds(fix.v, age, time_error=late, model=model)
        else:
            driven = self.driven + abs(fix.v) * max(t - fix.t, 0.0)
            along, across = position_bounds(self.speed, age, driven, time_error=late, model=model)
        rejected = self.rejected
        if rejected is not None and rejected.fix.t - rejected.t_first >= settings.readmit_after:
            # a rejected position that was reported for long may be true: the bounds include it
            other, cos, sin = dead_reckon(rejected.fix, t), math.cos(psi), math.sin(psi)
            far_x, far_y = other.x - x, other.y - y
            gap = max(t - rejected.fix.t, 0.0)
            more = position_bounds(rejected.fix.v, gap, time_error=rejected.time_error, model=model)
            along = max(along, abs(far_x * cos + far_y * sin) + more[0])
            across = max(across, abs(far_y * cos - far_x * sin) + more[1])
        if t - fix.t > STALE_AGE:  # the bounds need to know the reported speed, see `reachable_interval`
            a = (v - fix.v) / STALE_AGE
        elif v == 0.0:  # stopped if it braked as reported
            a = fix.a
        return RemoteVehicle(
            id=name, x=x, y=y, psi=psi, v_x=v, a_x=a, r=r, age=age, length=self.length, width=self.width,
            sigma_along=min(math.hypot(0.5 * along, shared), 1e3),
            sigma_across=min(math.hypot(0.5 * across, shared), 1e3),
            events=self.events, z=self.height, sigma_z=settings.sigma_height,
        )  # fmt: skip


def is_expired(
    vehicle: RemoteVehicle, gap: float, ego: VehicleState | None, speed: float, settings: TrackerSettings
) -> bool:
    """Return whether a vehicle with a message gap [s] cannot matter to an ego at a speed."""
    if gap > settings.delete_after:
        return True
    if ego is None:
        return False
    stopping = speed * settings.reaction_time + 0.5 * speed * speed / settings.braking
    extent = 0.5 * math.hypot(vehicle.length, vehicle.width)
    bound = 2.0 * math.hypot(vehicle.sigma_along, vehicle.sigma_across)
    x, y = vehicle.x - ego.x, vehicle.y - ego.y
    distance = math.hypot(x, y)
    v_x = vehicle.v_x * math.cos(vehicle.psi) - speed * math.cos(ego.psi)
    v_y = vehicle.v_x * math.sin(vehicle.psi) - speed * math.sin(ego.psi)
    closing = max(-(x * v_x + y * v_y) / max(distance, 1.0), 0.0) * settings.approach_horizon
    return distance - bound - extent - closing > max(stopping, settings.min_stopping_distance)


def _keys(id: str) -> list[str]:
    """Ids of the bodies under one id."""
    return [id, *(f"{id}#{i}" for i in range(2, _MAX_BODIES + 1))]


class Tracks:
    """Tracks of at most `max_tracks` senders."""

    def __init__(self, settings: TrackerSettings) -> None:
        size = settings.max_tracks
        self.by_id: dict[str, Track] = {}
        self._plausibility = settings.plausibility
        self._free = list(range(size))[::-1]
        self._track: list[Track | None] = [None] * size
        self._xy = np.full((2, size), _NOWHERE)
        # along and across each body, dead-reckoned straight on, as a linear form of x, y, t, 1
        self._form = np.zeros((2, size, 4))
        self._form[..., 3] = _NOWHERE
        self._half = np.zeros((2, size))
        self._t_first = np.full(size, math.inf)
        self._separated: set[str] = set()  # ids with several bodies

    @property
    def is_full(self) -> bool:
        """Whether no further track can be added."""
        return not self._free

    def add(self, track: Track) -> None:
        """Add a track."""
        track.row = self._free.pop()
        self._track[track.row] = track
        self.by_id[track.id] = track
        self.write(track)

    def bodies(self, id: str) -> list[Track]:
        """Return the tracks of a sender: more than one if several bodies use its id."""
        if id not in self._separated:
            return [self.by_id[id]] if id in self.by_id else []
        found = [self.by_id[key] for key in _keys(id) if key in self.by_id]
        if [track.id for track in found] in ([], [id]):
            self._separated.discard(id)
        return found

    def free_key(self, id: str) -> str | None:
        """Return the id of a further body under an id; None if there are enough."""
        key = next((key for key in _keys(id) if key not in self.by_id), None)
        if key is not None:
            self._separated.add(id)
        return key

    def remove(self, track: Track) -> None:
        """Delete a track."""
        del self.by_id[track.id]
        self._track[track.row] = None
        self._xy[:, track.row] = _NOWHERE
        self._form[:, track.row] = 0.0, 0.0, 0.0, _NOWHERE
        self._free.append(track.row)

    def advance(self, track: Track, new: Track) -> None:
        """Replace a track by its next state, under the id of that."""
        new.row, new.t_first, new.first_reported = track.row, track.t_first, track.first_reported
        new.rejected, new.rivals, new.ego_likeness = None, track.rivals, track.ego_likeness
        if new.id != track.id:
            del self.by_id[track.id]
        self.by_id[new.id] = new
        self._track[new.row] = new
        self.write(new)

    def write(self, track: Track) -> None:
        """Update the row of a track."""
        t, x, y, psi, v, _, _ = track.fix
        cos, sin, row = math.cos(psi), math.sin(psi), track.row
        self._xy[:, row] = x, y
        self._form[0, row] = cos, sin, -v, v * t - x * cos - y * sin
        self._form[1, row] = -sin, cos, 0.0, x * sin - y * cos
        limits = self._plausibility
        length = min(max(track.length, limits.min_overlap_length), limits.max_overlap_length)
        width = min(max(track.width, limits.min_overlap_width), limits.max_overlap_width)
        self._half[:, row] = 0.5 * length, 0.5 * width
        self._t_first[row] = track.t_first

    def find_overlapping(self, fix: Fix, t_first: float, itself: Track | None) -> Track | None:
        """Return an older track, not stale, whose body contains a position."""
        within = np.abs(self._form @ np.array((fix.x, fix.y, fix.t, 1.0))) <= self._half
        for row in np.flatnonzero(within[0] & within[1]).tolist():
            track = self._track[row]
            if track is None or track is itself:
                continue
            if track.t_first < t_first and fix.t - track.fix.t <= STALE_AGE:
                return track
        return None

    def silent(self, t: float, gap: float) -> list[Track]:
        """Return the tracks with a longer message gap [s], and those of the ego itself."""
        tracks = self.by_id.values()
        return [track for track in tracks if t - track.fix.t > gap or track.ego_likeness.is_certain]

    def find_evictable(self, ego: tuple[float, float], fix: Fix, settings: TrackerSettings) -> Track | None:
        """Return the farthest tentative or distant track if it is farther from the ego than a new sender."""
        x, y = self._xy
        distance = np.where(x < _NOWHERE, np.hypot(x - ego[0], y - ego[1]), -1.0)
        confirmed = fix.t - self._t_first >= settings.confirm_after
        distance[(distance <= settings.retention_range) & confirmed] = -1.0
        row = int(np.argmax(distance))
        return self._track[row] if distance[row] > math.dist(fix[1:3], ego) else None

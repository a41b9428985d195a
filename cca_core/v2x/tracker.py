"""Tracker: messages in, dead-reckoned vehicles out, with one track for each sender."""

import math
from collections import Counter, deque
from collections.abc import Mapping

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.path.local_frame import LocalFrame
from cca_core.v2x._projection import projector
from cca_core.v2x._tracks import Track, Tracks, is_expired
from cca_core.v2x.bsm import Bsm, decode_frame
from cca_core.v2x.motion import Fix
from cca_core.v2x.plausibility import POSITION_CHECKS, implausible_motion, implausible_state
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.v2x.update_result import ACCEPTED_KINDS, UpdateResult
from cca_core.v2x.wrappers import unwrap_message
from cca_core.vehicle import (
    MAX_COORDINATE,
    MAX_SPEED,
    STALE_AGE,
    STANDSTILL_SPEED,
    RemoteVehicle,
    VehicleState,
)

__all__ = ["Tracker"]


class Tracker:
    """Tracks of all received senders.

    A track is tentative, confirmed after 0.5 s, stale after a message gap of 1 s, and then deleted.

    Parameters
    ----------
    frame : LocalFrame
        Frame of the vehicles.
    settings : TrackerSettings, optional
        When tracks are confirmed, evicted, readmitted and deleted.

    Attributes
    ----------
    settings : TrackerSettings
        The same.
    counts : Counter
        Number of each `UpdateResult.kind`.

    Examples
    --------
    >>> from cca_core.v2x import Bsm
    >>> tracker = Tracker(LocalFrame(45.0, 14.0))
    >>> at = {"latitude_deg": 45.001, "longitude_deg": 14.0, "sec_mark": 7.0}
    >>> bsm = Bsm(msg_count=0, id="00c0ffee", speed=0.0, **at)
    >>> tracker.update(bsm, 7.1).kind, round(tracker.vehicles(7.1)[0].y, 1)
    ('new', 111.1)
    """

    def __init__(self, frame: LocalFrame, settings: TrackerSettings | None = None) -> None:
        self.settings = settings or TrackerSettings()
        self.counts: Counter[str] = Counter()
        self._project = projector(frame)
        self._tracks = Tracks(self.settings)
        self._rejected: deque[UpdateResult] = deque(maxlen=100)
        self._t_full = -math.inf  # when a sender was last rejected for want of capacity
        self._ego: tuple[float, float] | None = None
        self._top_speed = 0.0, 0.0  # recent one of the ego, and its time

    def __len__(self) -> int:
        return len(self._tracks.by_id)

    @property
    def dropped(self) -> tuple[UpdateResult, ...]:
        """Results of the last 100 rejected messages, oldest first."""
        return tuple(self._rejected)

    def is_saturated(self, t: float) -> bool:
        """Return whether senders within `retention_range` were rejected recently for want of capacity.

        The absence of a vehicle then proves nothing: pass `awareness_range=0` to the planner.

        Parameters
        ----------
        t : float
            Now [s].

        Returns
        -------
        saturated : bool
            Whether that happened in the last second.
        """
        return t - self._t_full <= 1.0

    def update(self, data: bytes | bytearray | str | Bsm, t_received: float) -> UpdateResult:
        """Process a message.

        Parameters
        ----------
        data : bytes, str or Bsm
            Message as received, in the wrappers that `unwrap_message` removes, or decoded. No content raises.
            Messages of other kinds are counted as ``"other_message"``.
        t_received : float
            Time of reception on the senders' clock [s]; minutes begin at multiples of 60.

        Returns
        -------
        result : UpdateResult
            Accepted or rejected, and why.

        Raises
        ------
        InputError
            If `t_received` is not a finite number.
        """
        t = check_real("t_received", t_received)
        try:
            result = self._process_data(data, t)
        except (InputError, TypeError, ValueError, OverflowError):
            result = UpdateResult(accepted=False, kind="unreadable", id="", t=t, message="")
        self.counts[result.kind] += 1
        if not result.accepted and result.kind != "other_message":
            self._rejected.append(result)
        return result

    def _process_data(self, data: bytes | bytearray | str | Bsm, t: float) -> UpdateResult:
        """Decode and process a message."""
        if isinstance(data, Bsm):
            bsm = data
        else:
            frame = unwrap_message(data)
            if frame.name != "BSM":
                return UpdateResult(accepted=False, kind="other_message", id="", t=t, message=frame.name)
            bsm = decode_frame(frame)
        kind = self._process(bsm, t)
        return UpdateResult(
            accepted=kind in ACCEPTED_KINDS, kind=kind, id=str(bsm.id), t=t, signed=bsm.signed
        )

    def vehicles(
        self, t: float, ego: VehicleState | None = None, names: Mapping[str, str] | None = None
    ) -> tuple[RemoteVehicle, ...]:
        """Return all vehicles dead-reckoned to now, and delete stale tracks that cannot matter.

        Parameters
        ----------
        t : float
            Now, on the senders' clock [s].
        ego : VehicleState, optional
            Position and speed of the ego. A stale track is deleted once its uncertainty bound is beyond the
            stopping distance of the ego at its recent top speed. A full tracker keeps the confirmed and the
            closest tracks.
        names : mapping of str to str, optional
            Ids of the vehicles by temporary identity; others keep their temporary identity.

        Returns
        -------
        vehicles : tuple of RemoteVehicle
            Vehicles at `t`, with age and uncertainty, stale ones included.

        Raises
        ------
        InputError
            If `t` is not a finite number.
        """
        t = check_real("t", t)
        if ego is not None:
            self._ego = ego.x, ego.y
            decayed = self._top_speed[0] - self.settings.speed_decay * max(t - self._top_speed[1], 0.0)
            self._top_speed = max(ego.v_x, decayed), t
        vehicles = []
        for track in tuple(self._tracks.by_id.values()):
            name = track.id if names is None else names.get(track.id, track.id)
            vehicle = track.vehicle(t, name, self.settings)
            gap = t - track.fix.t
            if gap > STALE_AGE and is_expired(vehicle, gap, ego, self._top_speed[0], self.settings):
                self._tracks.remove(track)
            else:
                vehicles.append(vehicle)
        return tuple(vehicles)

    def _process(self, bsm: Bsm, t: float) -> str:
        """Process a decoded message; return the kind of the result."""
        track = self._tracks.by_id.get(bsm.id)
        mark, timed, measured = bsm.sec_mark, False, t - self.settings.untimed_age
        if mark is not None and mark < 60.0:  # a leap second has no time on the clock
            timed, measured = True, mark + 60.0 * round((t - mark) / 60.0)
        if track is not None:
            if order := track.out_of_order(bsm.msg_count, measured, timed, t):
                return order
            measured = measured if timed else max(measured, track.fix.t + 1e-3)
        fix = self._fix(bsm, measured, track)
        if fix is None:
            return "unusable"
        length, width = bsm.length or self.settings.length, bsm.width or self.settings.width
        if not math.isfinite(length + width):
            return "unusable"
        if failed := implausible_state(self.settings.plausibility, fix, length, width, t):
            return failed
        if bsm.psi is None and track is None:
            length = width = min(max(length, width), 5.0)  # [m], a square covers any unknown heading
        reported: object = getattr(bsm.accuracy, "semi_major", None)
        reported = reported if isinstance(reported, (int, float)) and reported > 0.0 else 0.0
        accuracy = min(float(reported), self.settings.max_reported_accuracy)
        message = Track(bsm.id, fix, length, width, bsm.events, bsm.msg_count, timed, accuracy)
        if track is not None:
            return self._update(track, message)
        return self._begin(message)

    def _fix(self, bsm: Bsm, measured: float, track: Track | None) -> Fix | None:
        """Return the motion that a message reports in the local frame; None if it is unusable."""
        lat, lon, speed, psi = bsm.latitude_deg, bsm.longitude_deg, bsm.speed, bsm.psi
        if lat is None or lon is None or speed is None:
            return None
        if psi is None:
            if track is None and speed > STANDSTILL_SPEED:
                return None
            psi = track.fix.psi if track is not None else 0.0
        x, y = self._project(lat, lon)
        v = -speed if bsm.transmission == "reverse" else speed
        a, r = bsm.a_x or 0.0, bsm.r or 0.0
        finite = math.isfinite(psi + a + r + measured)
        usable = finite and abs(x) + abs(y) <= MAX_COORDINATE and -20.0 <= v <= MAX_SPEED  # reverse gear
        return Fix(measured, x, y, psi, v, a, r) if usable else None

    def _update(self, track: Track, message: Track) -> str:
        """Update a track with its sender's next message, or coast if its position is rejected."""
        failed = self._compare(track, message)
        if not failed and self._overlaps_track(message, track):
            failed = "overlap"
        elif (
            failed
            and self._is_consistent(track.rejected, message)
            and not self._overlaps_track(message, track)
        ):
            message.ref = message.fix.x, message.fix.y
            self._tracks.advance(track, message)
            return "readmitted"
        if not failed:
            self._tracks.advance(track, message)
            return "updated"
        if failed != "overlap":
            track.rejected = message
        if failed in POSITION_CHECKS:
            track.coast(message)
            self._tracks.write(track)
        return failed

    def _is_consistent(self, rejected: Track | None, message: Track) -> bool:
        """Return whether a sender with rejected positions has meanwhile driven as it reports."""
        settings, position = self.settings, message.fix[1:3]
        tolerance = 0.5 * settings.plausibility.position_tolerance
        if (
            rejected is None
            or self._compare(rejected, message)
            or math.dist(position, message.ref) > tolerance
        ):
            message.ref = message.fix.x, message.fix.y
            return False
        message.t_first, message.first_reported = rejected.t_first, rejected.first_reported
        driven = math.dist(position, message.first_reported)
        return (
            message.fix.t - message.t_first >= settings.readmit_after and driven >= settings.readmit_distance
        )

    def _compare(self, track: Track, message: Track) -> str:
        """Return the name of the check that a message fails against a track; else update its reference."""
        if message.fix.t <= track.fix.t:
            return "displacement"
        failed, ref = implausible_motion(
            self.settings.plausibility, track.fix, track.ref, track.reported, track.driven, message.fix
        )
        if not failed:
            message.ref = ref
        return failed

    def _overlaps_track(self, message: Track, track: Track) -> bool:
        """Return whether a message lies in the body of a vehicle with an older track."""
        if not self.settings.plausibility.overlap:
            return False
        return self._tracks.find_overlapping(message.fix, track.t_first, track) is not None

    def _begin(self, message: Track) -> str:
        """Begin a track, or associate the message with a track under another id."""
        fix, tracks = message.fix, self._tracks
        former = tracks.find_overlapping(fix, math.inf, None)
        if former is not None and fix.t - former.fix.t > self.settings.reassociate_after:
            if former.matches(message) and not self._compare(former, message):
                tracks.advance(former, message)
                return "reassociated"
        if former is not None and self.settings.plausibility.overlap:
            return "overlap"
        if tracks.is_full and not self._evict_for(fix):
            return "full"
        tracks.add(message)
        return "new"

    def _evict_for(self, fix: Fix) -> bool:
        """Evict a track that matters less than a new sender, if there is one."""
        rejected, evictable = fix, None
        if self._ego is not None:
            evictable = self._tracks.find_evictable(self._ego, fix, self.settings)
        if evictable is not None:
            rejected = evictable.fix
            self._tracks.remove(evictable)
        if self._ego is None or math.dist(rejected[1:3], self._ego) <= self.settings.retention_range:
            self._t_full = fix.t
        return evictable is not None

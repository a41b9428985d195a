"""Messages in, vehicles out: one track for each sender, dead-reckoned to the time asked."""

import math
from collections import Counter, deque
from collections.abc import Mapping

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.path.local_frame import LocalFrame
from cca_core.v2x._projection import projector
from cca_core.v2x._tracks import Track, Tracks, is_expired
from cca_core.v2x.bsm import Bsm, decode_bsm
from cca_core.v2x.motion import STALE_AFTER, Fix
from cca_core.v2x.plausibility import implausible_motion, implausible_state
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.v2x.update_result import UpdateResult
from cca_core.vehicle import MAX_COORDINATE, MAX_SPEED, STANDSTILL_SPEED, RemoteVehicle, VehicleState

__all__ = ["Tracker"]

_REMEMBERED = 100  # drops that can be looked at
_UNTIMED_AGE = 0.1  # assumed of a message without time [s]
_BACKWARDS = -20.0
_WIDEST = 5.0  # [m]
_CALMING = 0.5  # rate at which it is forgotten how fast the ego was [m/s^2]
_DRIVEN = 5.0  # way on which a doubted sender shows that its place moves as it tells [m]
_OF_PLACE = frozenset({"frozen", "teleport", "displacement", "overlap"})  # its motion may be true
_ACCEPTED = frozenset({"new", "updated", "returned", "took_over"})


class Tracker:
    """Tracks of all senders that are heard.

    Parameters
    ----------
    frame : LocalFrame
        Plane in which the vehicles are wanted.
    settings : TrackerSettings, optional
        How senders are believed, kept and forgotten.

    Attributes
    ----------
    counts : Counter
        How often each `Outcome.what` occurred.
    """

    def __init__(self, frame: LocalFrame, settings: TrackerSettings | None = None) -> None:
        self.settings = settings or TrackerSettings()
        self.counts: Counter[str] = Counter()
        self._place = projector(frame)
        self._tracks = Tracks(self.settings.max_tracks)
        self._dropped: deque[UpdateResult] = deque(maxlen=_REMEMBERED)
        self._turned_away = -math.inf
        self._ego: tuple[float, float] | None = None
        self._speed = 0.0, 0.0  # that the ego may have again, and when that was said

    def __len__(self) -> int:
        return len(self._tracks.by_id)

    @property
    def dropped(self) -> tuple[UpdateResult, ...]:
        """The last 100 messages that were dropped, oldest first."""
        return tuple(self._dropped)

    def is_saturated(self, t: float) -> bool:
        """Tell whether senders within `retention_range` were turned away of late: silence then says nothing.

        Parameters
        ----------
        t : float
            Now [s].

        Returns
        -------
        saturated : bool
            Whether that happened in the last second.
        """
        return t - self._turned_away <= 1.0

    def update(self, data: bytes | bytearray | Bsm, t_received: float) -> UpdateResult:
        """Take in a message.

        Parameters
        ----------
        data : bytes or Bsm
            As received, or decoded. Nothing in it raises.
        t_received : float
            When it was received, on the senders' clock [s]; minutes begin at multiples of 60.

        Returns
        -------
        outcome : Outcome
            Accepted or dropped, and why.

        Raises
        ------
        InputError
            If `t_received` is not a finite number.
        """
        t = check_real("t_received", t_received)
        try:
            bsm = data if isinstance(data, Bsm) else decode_bsm(data)
            what = self._process(bsm, t)
            outcome = UpdateResult(accepted=what in _ACCEPTED, kind=what, id=str(bsm.id), t=t)
        except (InputError, TypeError, ValueError, OverflowError):
            outcome = UpdateResult(accepted=False, kind="unreadable", id="", t=t)
        self.counts[outcome.kind] += 1
        if not outcome.accepted:
            self._dropped.append(outcome)
        return outcome

    def vehicles(
        self, t: float, ego: VehicleState | None = None, names: Mapping[str, str] | None = None
    ) -> tuple[RemoteVehicle, ...]:
        """Tell where all senders are; forget those that do not matter any more.

        Parameters
        ----------
        t : float
            Now, on the senders' clock [s].
        ego : VehicleState, optional
            Own place and speed. A silent track is forgotten once it is, with its bounds, out of reach of
            the stopping distance that the ego has, or had when it was last fast; and where there are too many
            senders, those heard for long and the nearest are kept.
        names : mapping of str to str, optional
            Ids under which senders are told, by their temporary identities; all others keep their own.

        Returns
        -------
        vehicles : tuple of RemoteVehicle
            Dead-reckoned to `t`, with age and bounds; stale ones too.

        Raises
        ------
        InputError
            If `t` is not a finite number.
        """
        t = check_real("t", t)
        if ego is not None:
            self._ego = ego.x, ego.y
            slower = self._speed[0] - _CALMING * max(t - self._speed[1], 0.0)
            self._speed = max(ego.v_x, slower), t
        known, settings = [], self.settings
        for track in tuple(self._tracks.by_id.values()):
            name = track.id if names is None else names.get(track.id, track.id)
            vehicle = track.vehicle(t, name, settings.sigma_position, settings.readmit_after)
            silent = t - track.fix.t
            if silent > STALE_AFTER and is_expired(vehicle, silent, ego, self._speed[0], settings):
                self._tracks.remove(track)
            else:
                known.append(vehicle)
        return tuple(known)

    def _process(self, bsm: Bsm, t: float) -> str:
        """Take in a decoded message; say what became of it."""
        track = self._tracks.by_id.get(bsm.id)
        mark, timed, measured = bsm.sec_mark, False, t - _UNTIMED_AGE
        if mark is not None and mark < 60.0:  # a leap second has no place on the clock
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
            length = width = min(max(length, width), _WIDEST)  # it may point anywhere
        told: object = getattr(bsm.accuracy, "semi_major", None)
        told = told if isinstance(told, (int, float)) and told > 0.0 else 0.0
        accuracy = min(float(told), self.settings.max_reported_accuracy)
        fresh = Track(bsm.id, fix, length, width, bsm.events, bsm.msg_count, timed, accuracy)
        if track is not None:
            return self._follow(track, fresh)
        return self._begin(fresh)

    def _fix(self, bsm: Bsm, measured: float, track: Track | None) -> Fix | None:
        lat, lon, speed, psi = bsm.latitude_deg, bsm.longitude_deg, bsm.speed, bsm.psi
        if lat is None or lon is None or speed is None:
            return None
        if psi is None:
            if track is None and speed > STANDSTILL_SPEED:
                return None
            psi = track.fix.psi if track is not None else 0.0
        x, y = self._place(lat, lon)
        v = -speed if bsm.transmission == "reverse" else speed
        a, r = bsm.a_x or 0.0, bsm.r or 0.0
        finite = math.isfinite(psi + a + r + measured)
        usable = finite and abs(x) + abs(y) <= MAX_COORDINATE and _BACKWARDS <= v <= MAX_SPEED
        return Fix(measured, x, y, psi, v, a, r) if usable else None

    def _follow(self, track: Track, fresh: Track) -> str:
        """Move a track on to its sender's next message, or only as far as that is believed."""
        failed = self._compare(track, fresh)
        if not failed and self._overlaps_track(fresh, track):
            failed = "overlap"
        elif failed and self._is_consistent(track.doubt, fresh) and not self._overlaps_track(fresh, track):
            fresh.ref = fresh.fix.x, fresh.fix.y
            self._tracks.advance(track, fresh)
            return "returned"
        if not failed:
            self._tracks.advance(track, fresh)
            return "updated"
        if failed != "overlap":
            track.doubt = fresh
        if failed in _OF_PLACE:
            track.coast(fresh)
            self._tracks.write(track)
        return failed

    def _is_consistent(self, doubt: Track | None, fresh: Track) -> bool:
        """Whether a sender whose place was doubted has meanwhile driven as it tells."""
        place, room = fresh.fix[1:3], 0.5 * self.settings.plausibility.position_tolerance
        if doubt is None or self._compare(doubt, fresh) or math.dist(place, fresh.ref) > room:
            fresh.ref = fresh.fix.x, fresh.fix.y
            return False
        fresh.begun, fresh.origin = doubt.begun, doubt.origin
        told = fresh.fix.t - fresh.begun
        return told >= self.settings.readmit_after and math.dist(place, fresh.origin) >= _DRIVEN

    def _compare(self, track: Track, fresh: Track) -> str:
        """Name of the check that a message fails after those of `track`; its reference place moves on."""
        if fresh.fix.t <= track.fix.t:
            return "displacement"
        failed, ref = implausible_motion(
            self.settings.plausibility, track.fix, track.ref, track.said, track.driven, fresh.fix
        )
        if not failed:
            fresh.ref = ref
        return failed

    def _overlaps_track(self, fresh: Track, track: Track) -> bool:
        """Whether a message lies in the body of a vehicle heard of before its sender."""
        if not self.settings.plausibility.overlap:
            return False
        return self._tracks.find_overlapping(fresh.fix, track.begun, track) is not None

    def _begin(self, fresh: Track) -> str:
        """Begin a track, or let a lost one go on under a new id."""
        fix, tracks = fresh.fix, self._tracks
        former = tracks.find_overlapping(fix, math.inf, None)
        if former is not None and fix.t - former.fix.t > self.settings.reassociate_after:
            if former.matches(fresh) and not self._compare(former, fresh):
                tracks.advance(former, fresh)
                return "took_over"
        if former is not None and self.settings.plausibility.overlap:
            return "overlap"
        if tracks.is_full and not self._evict_for(fix):
            return "full"
        tracks.add(fresh)
        return "new"

    def _evict_for(self, fix: Fix) -> bool:
        """Forget a sender that matters less than a new one, if there is any."""
        settings, loser, spare = self.settings, fix, None
        if self._ego is not None:
            spare = self._tracks.find_evictable(
                self._ego, fix, settings.retention_range, settings.confirm_after
            )
        if spare is not None:
            loser = spare.fix
            self._tracks.remove(spare)
        if self._ego is None or math.dist(loser[1:3], self._ego) <= settings.retention_range:
            self._turned_away = fix.t
        return spare is not None

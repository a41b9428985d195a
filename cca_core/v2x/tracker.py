"""Messages in, vehicles out: one track for each sender, dead-reckoned to the time asked."""

import math
from collections import Counter, deque

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.path.local_frame import LocalFrame
from cca_core.v2x._place import projector
from cca_core.v2x._tracks import Track, Tracks, is_over
from cca_core.v2x.bsm import Bsm, decode_bsm
from cca_core.v2x.motion import STALE_AFTER, Fix
from cca_core.v2x.outcome import Outcome
from cca_core.v2x.plausibility import implausible_motion, implausible_state
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.vehicle import FARTHEST, FASTEST, RemoteVehicle, VehicleState

__all__ = ["Tracker"]

_REMEMBERED = 100  # drops that can be looked at
_UNTIMED_AGE = 0.1  # assumed of a message without time [s]
_STANDING = 0.5  # [m/s]
_BACKWARDS = -20.0
_WIDEST = 5.0  # [m]


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
        self._tracks = Tracks(self.settings.most_senders)
        self._dropped: deque[Outcome] = deque(maxlen=_REMEMBERED)
        self._turned_away = -math.inf
        self._ego: tuple[float, float] | None = None

    def __len__(self) -> int:
        return len(self._tracks.by_id)

    @property
    def dropped(self) -> tuple[Outcome, ...]:
        """The last 100 messages that were dropped, oldest first."""
        return tuple(self._dropped)

    def is_saturated(self, t: float) -> bool:
        """Tell whether more senders were heard of late than are kept: silence then says even less.

        Parameters
        ----------
        t : float
            Now [s].

        Returns
        -------
        saturated : bool
            Whether one was turned away in the last second.
        """
        return t - self._turned_away <= 1.0

    def update(self, data: bytes | bytearray | Bsm, t_received: float) -> Outcome:
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
            what = self._take(bsm, t)
            outcome = Outcome(accepted=what in _ACCEPTED, what=what, id=str(bsm.id), t=t)
        except (InputError, TypeError, ValueError, OverflowError):
            outcome = Outcome(accepted=False, what="unreadable", id="", t=t)
        self.counts[outcome.what] += 1
        if not outcome.accepted:
            self._dropped.append(outcome)
        return outcome

    def vehicles(self, t: float, ego: VehicleState | None = None) -> tuple[RemoteVehicle, ...]:
        """Tell where all senders are; forget those that do not matter any more.

        Parameters
        ----------
        t : float
            Now, on the senders' clock [s].
        ego : VehicleState, optional
            Own place and speed. A stale track is forgotten once it is, with its bounds, out of reach of the
            ego's stopping distance, and where there are too many senders the nearest are kept.

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
        known = []
        for track in tuple(self._tracks.by_id.values()):
            vehicle = track.vehicle(t, self.settings.sigma_position)
            if vehicle.age > STALE_AFTER and is_over(vehicle, ego, self.settings):
                self._tracks.remove(track)
            else:
                known.append(vehicle)
        return tuple(known)

    def _take(self, bsm: Bsm, t: float) -> str:
        """Take in a decoded message; say what became of it."""
        track = self._tracks.by_id.get(bsm.id)
        timed = bsm.sec_mark is not None and bsm.sec_mark < 60.0  # a leap second has no place on the clock
        if timed:
            mark: float = bsm.sec_mark  # type: ignore[assignment]  # not None
            measured = mark + 60.0 * round((t - mark) / 60.0)
        else:
            measured = t - _UNTIMED_AGE
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
        fresh = Track(bsm.id, fix, length, width, bsm.events, bsm.msg_count, timed)
        if track is not None:
            return self._follow(track, fresh)
        return self._begin(fresh)

    def _fix(self, bsm: Bsm, measured: float, track: Track | None) -> Fix | None:
        lat, lon, speed, psi = bsm.latitude_deg, bsm.longitude_deg, bsm.speed, bsm.psi
        if lat is None or lon is None or speed is None:
            return None
        if psi is None:
            if track is None and speed > _STANDING:
                return None
            psi = track.fix.psi if track is not None else 0.0
        x, y = self._place(lat, lon)
        v = -speed if bsm.transmission == "reverse" else speed
        a, r = bsm.a_x or 0.0, bsm.r or 0.0
        finite = math.isfinite(psi + a + r + measured)
        usable = finite and abs(x) + abs(y) <= FARTHEST and _BACKWARDS <= v <= FASTEST
        return Fix(measured, x, y, psi, v, a, r) if usable else None

    def _follow(self, track: Track, fresh: Track) -> str:
        """Move a track on to its sender's next message."""
        what = "updated"
        failed = self._compare(track, fresh)
        if failed == "frozen":
            track.events = fresh.events  # the position is old, the warning is not
        if failed and track.doubt is not None and not self._compare(track.doubt, fresh):
            fresh.begun = track.doubt.begun
            agrees = math.dist(fresh.fix[1:3], fresh.ref) <= 0.5 * self.settings.plausibility.room
            if agrees and fresh.fix.t - fresh.begun >= self.settings.readmit_after:
                what, failed = "returned", ""
                fresh.ref = fresh.fix.x, fresh.fix.y
        elif failed:
            fresh.begun, fresh.ref = fresh.fix.t, (fresh.fix.x, fresh.fix.y)
        if not failed and self._is_inside(fresh, track):
            failed = "inside"
        if failed:
            if failed != "inside":
                track.doubt = fresh
            return failed
        self._tracks.advance(track, fresh)
        return what

    def _compare(self, track: Track, fresh: Track) -> str:
        """Name of the check that a message fails after those of `track`; its reference place moves on."""
        if fresh.fix.t <= track.fix.t:
            return "displacement"
        failed, x, y = implausible_motion(self.settings.plausibility, track.fix, *track.ref, fresh.fix)
        if not failed:
            fresh.ref = x, y
        return failed

    def _is_inside(self, fresh: Track, track: Track | None) -> bool:
        """Whether a message lies in the body of a vehicle heard of before its sender."""
        if not self.settings.plausibility.inside:
            return False
        begun = fresh.fix.t if track is None else track.begun
        return self._tracks.holder(fresh.fix, begun, track) is not None

    def _begin(self, fresh: Track) -> str:
        """Begin a track, or let a lost one go on under a new id."""
        fix, tracks = fresh.fix, self._tracks
        former = tracks.holder(fix, fix.t, None)
        if former is not None and fix.t - former.fix.t > self.settings.lost_after:
            if former.resembles(fresh) and not self._compare(former, fresh):
                tracks.advance(former, fresh)
                return "took_over"
        if former is not None and self.settings.plausibility.inside:
            return "inside"
        if tracks.is_full:
            self._turned_away = fix.t
            farthest = tracks.farthest(self._ego)
            if farthest is None or self._ego is None:
                return "full"
            if math.dist(farthest.fix[1:3], self._ego) <= math.dist(fix[1:3], self._ego):
                return "full"
            tracks.remove(farthest)
        tracks.add(fresh)
        return "new"


_ACCEPTED = frozenset({"new", "updated", "returned", "took_over"})

"""Intake of messages: order, plausibility, and the track to which each belongs."""

import math
from collections import OrderedDict
from collections.abc import Container
from dataclasses import replace

from cca_core.path.local_frame import LocalFrame
from cca_core.v2x._association import explains, may_be_same_body, position_at
from cca_core.v2x._clock import SenderClocks
from cca_core.v2x._plain import unusable_value
from cca_core.v2x._projection import projector
from cca_core.v2x._reported_motion import (
    MAX_UNREPORTED_REVERSING,
    PositionHistory,
    ReportedMotion,
    reported_motion,
)
from cca_core.v2x._tracks import MAX_REVERSING, Track, Tracks
from cca_core.v2x.bsm import Bsm
from cca_core.v2x.motion import Fix
from cca_core.v2x.plausibility import (
    POSITION_CHECKS,
    implausible_motion,
    implausible_state,
)
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.vehicle import MAX_COORDINATE, MAX_SPEED

__all__ = ["Intake"]

_MIN_RIVAL_MESSAGES, _MIN_RIVAL_TIME = 4, 0.25  # of a second body under one id [-, s]
_MAX_RIVALS = 3
_MIN_PERIOD = 0.08  # between two messages of one sender; closer ones may come from two bodies [s]
_RIVAL_NOISE = 0.5  # between successive messages of a close second body [m]


class Intake:
    """Processing of decoded messages into tracks."""

    def __init__(self, frame: LocalFrame, settings: TrackerSettings, height: float | None) -> None:
        self.settings, self.tracks = settings, Tracks(settings)
        self.clocks = SenderClocks(settings.plausibility, settings.untimed_age)
        self.age = 0.0  # of the last message when it was received [s]
        self.t_full = -math.inf  # when a sender was last rejected for want of capacity
        self.ego: tuple[float, float] | None = None
        self._project, self._height = projector(frame), height
        # values found from two positions are too noisy for these checks, and cannot contradict a position
        self._lenient = replace(settings.plausibility, acceleration=False, yaw=False, frozen=False)
        self._positions: OrderedDict[str, PositionHistory] = OrderedDict()

    def process(self, bsm: Bsm, t_received: float, own_ids: Container[str]) -> str:
        """Process a decoded message; return the kind of the result."""
        if bsm.id in own_ids:
            return "own"
        clocks, mark = self.clocks, bsm.sec_mark
        timed = False
        if mark is not None and 0.0 <= mark < 60.0:  # a leap second has no time on the clock
            timed = True
            clocks.add_mark(bsm.id, mark, t_received)
        t = t_received - clocks.correction
        measured = t - self.settings.untimed_age
        if timed and mark is not None:
            measured = mark + 60.0 * round((t - mark) / 60.0)
        if bsm.latitude_deg is None or bsm.longitude_deg is None or unusable_value(bsm):
            return "unusable"
        position = self._project(bsm.latitude_deg, bsm.longitude_deg)
        if not abs(position[0]) + abs(position[1]) <= MAX_COORDINATE:
            return "unusable"
        if timed and mark is not None:
            measured -= clocks.ahead(bsm.id, mark, t_received)
        self.age = t - measured
        track = self._nearest_body(bsm.id, measured, position)
        order = ""
        if track is not None:
            order = track.out_of_order(bsm.msg_count, measured, timed, t)
            measured = measured if timed else max(measured, track.fix.t + 1e-3)
        if order == "duplicate" and track is not None and math.dist(position, track.reported) < 0.01:
            return order
        message = self._message(bsm, measured, position, timed, track, order, t - measured)
        if message is None:
            return order or "unusable"
        failed = implausible_state(self.settings.plausibility, message.fix, message.length, message.width, t)
        if order and track is not None:
            # an earlier position that the track did not pass is that of another body
            separated = not failed and timed and self._consider_rival(track, message) == "separated"
            return "separated" if separated else order
        if failed:
            return failed
        return self._begin(message) if track is None else self._update(track, message)

    def _nearest_body(self, id: str, t: float, position: tuple[float, float]) -> Track | None:
        """Return the track of a sender, of several bodies under its id the one closest to a position."""
        bodies = self.tracks.bodies(id)
        if len(bodies) < 2:
            return bodies[0] if bodies else None
        return min(bodies, key=lambda track: math.dist(position, position_at(track.fix, t)))

    def _message(
        self,
        bsm: Bsm,
        measured: float,
        position: tuple[float, float],
        timed: bool,
        track: Track | None,
        order: str,
        age: float,
    ) -> Track | None:
        """Return what a message reports as a track of its own; None if it is unusable."""
        motion = self._motion(bsm, measured, position, track, order)
        length, width = bsm.length or self.settings.length, bsm.width or self.settings.width
        if motion is None or not math.isfinite(length + width):
            return None
        psi, a, r = motion.psi, bsm.a_x or 0.0, bsm.r or 0.0
        if psi is None:
            length = width = min(max(length, width), 5.0)  # [m], a square covers any unknown heading
            psi = 0.0
        if not (math.isfinite(psi + a + r + measured) and -MAX_REVERSING <= motion.v <= MAX_SPEED):
            return None
        reported: object = getattr(bsm.accuracy, "semi_major", None)
        reported = reported if isinstance(reported, (int, float)) and reported > 0.0 else 0.0
        accuracy = math.hypot(min(float(reported), self.settings.max_reported_accuracy), motion.sigma)
        height: float | None = None
        if self._height is not None and bsm.elevation is not None and math.isfinite(bsm.elevation):
            height = float(bsm.elevation) - self._height
        fix = Fix(measured, *position, psi, motion.v, a, r)
        return Track(
            bsm.id if track is None else track.id, fix, length, width, bsm.events, bsm.msg_count, timed,
            self.clocks.correction, self.clocks.error(bsm.id, age) if timed else 0.0, accuracy, height,
            motion,
        )  # fmt: skip

    def _motion(
        self, bsm: Bsm, t: float, position: tuple[float, float], track: Track | None, order: str
    ) -> ReportedMotion | None:
        """Return the motion of a message, from two positions what it does not report."""
        speed, psi, gear = bsm.speed, bsm.psi, bsm.transmission
        if speed is not None and psi is not None:
            gear_known = gear == "forward" or gear == "reverse"
            if gear_known or speed > MAX_UNREPORTED_REVERSING:
                return ReportedMotion(psi, -speed if gear == "reverse" else speed, 0.0, gear_known)
        displacement = 0.0, 0.0, 0.0
        if not order:
            positions = self._positions.get(bsm.id)
            if positions is None:
                if len(self._positions) >= 2 * self.settings.max_tracks:
                    self._positions.popitem(last=False)
                positions = self._positions[bsm.id] = PositionHistory()
            displacement = positions.displacement(t, *position)
        last = None
        if track is not None:
            last = (None if track.motion.psi is None else track.fix.psi), track.fix.v
        return reported_motion(bsm, last, displacement)

    def _update(self, track: Track, message: Track) -> str:
        """Update a track with its sender's next message, or coast if its position is rejected."""
        failed, limits = self._compare(track, message), self.settings.plausibility
        if not failed and limits.displacement and track.timed and message.timed:
            interval = message.fix.t - track.fix.t
            if 0.0 < interval < _MIN_PERIOD and not may_be_same_body(track, message, limits):
                failed = "displacement"
        if not failed and self._overlaps_track(message, track):
            failed = "overlap"
        elif (
            failed
            and self._is_consistent(track.rejected, message)
            and not self._overlaps_track(message, track)
        ):
            message.ref = message.fix.x, message.fix.y
            self.tracks.advance(track, message)
            return "readmitted"
        if not failed:
            self.tracks.advance(track, message)
            return "updated"
        rival = self._consider_rival(track, message) if failed not in ("frozen", "overlap") else ""
        if rival:
            return failed if rival == "rival" else rival
        if failed != "overlap":
            track.rejected = message
        if failed in POSITION_CHECKS:
            track.coast(message)
            self.tracks.write(track)
        return failed

    def _consider_rival(self, track: Track, message: Track) -> str:
        """Return "separated" if a message becomes the track of a second body, "rival" if it may soon."""
        # a sender that jumps is at one place at a time; of two senders, both are heard in turn
        if may_be_same_body(track, message, self.settings.plausibility):
            return ""
        # noise of one sender may look like a close body, but does not stay in one place
        distance = math.dist(message.fix[1:3], position_at(track.fix, message.fix.t))
        tolerance = (
            _RIVAL_NOISE if distance <= 2.0 * self.settings.plausibility.position_tolerance else math.inf
        )
        n = 1
        kept = [r for r in track.rivals if message.fix.t - r[0].fix.t <= 1.0]
        for rival, count in kept:
            off = math.dist(message.fix[1:3], position_at(rival.fix, message.fix.t))
            if message.fix.t > rival.fix.t and off <= tolerance and not self._compare(rival, message):
                message.t_first, message.first_reported = rival.t_first, rival.first_reported
                n, kept = count + 1, [r for r in kept if r[0] is not rival]
                break
        track.rivals = [*kept, (message, n)][-_MAX_RIVALS:]
        if n < 2 or track.t_position <= message.t_first:
            return ""
        if n < _MIN_RIVAL_MESSAGES or message.fix.t - message.t_first < _MIN_RIVAL_TIME:
            return "rival"
        if self._overlaps_track(message, track) or (self.tracks.is_full and not self._evict_for(message.fix)):
            return "rival"
        key = self.tracks.free_key(track.id.partition("#")[0])
        if key is None:
            return "rival"
        track.rivals = kept
        message.id, message.ref = key, (message.fix.x, message.fix.y)
        self.tracks.add(message)
        return "separated"

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
        last, elapsed = track.fix, 0.0
        if message.fix.t < last.t:
            return "displacement"
        if message.fix.t == last.t:  # ten messages per second
            elapsed = 0.1 * min((message.msg_count - track.msg_count) % 128, 10)
        if not message.motion.gear_known and last.v * message.fix.v < 0.0:  # the direction was not known
            last = last._replace(v=-last.v)
        found = message.motion.sigma > 0.0 or track.motion.sigma > 0.0
        checks = self._lenient if found else self.settings.plausibility
        failed, ref = implausible_motion(
            checks, last, track.ref, track.reported, track.driven, message.fix, elapsed
        )
        if not failed:
            message.ref = ref
        return failed

    def _overlaps_track(self, message: Track, track: Track) -> bool:
        """Return whether a message lies in the body of a vehicle with an older track."""
        if not self.settings.plausibility.overlap:
            return False
        return self.tracks.find_overlapping(message.fix, track.t_first, track) is not None

    def _begin(self, message: Track) -> str:
        """Begin a track, or associate the message with a track under another id."""
        fix, tracks, settings = message.fix, self.tracks, self.settings
        former = tracks.find_overlapping(fix, math.inf, None)
        explained = [
            track
            for track in tracks.silent(fix.t, settings.reassociate_after)
            if explains(message, track, settings.plausibility) or (track is former and track.matches(message))
        ]
        if former is not None:
            if former in explained:
                explained = [former]
            elif settings.plausibility.overlap:
                return "overlap"
        explained = [track for track in explained if not self._compare(track, message)]
        if len(explained) == 1:
            tracks.advance(explained[0], message)
            return "reassociated"
        message.ref = fix.x, fix.y
        if former is not None and settings.plausibility.overlap:
            return "overlap"
        if tracks.is_full and not self._evict_for(fix):
            return "full"
        tracks.add(message)
        return "new"

    def _evict_for(self, fix: Fix) -> bool:
        """Evict a track that matters less than a new sender, if there is one."""
        rejected, evictable = fix, None
        if self.ego is not None:
            evictable = self.tracks.find_evictable(self.ego, fix, self.settings)
        if evictable is not None:
            rejected = evictable.fix
            self.tracks.remove(evictable)
        if self.ego is None or math.dist(rejected[1:3], self.ego) <= self.settings.retention_range:
            self.t_full = fix.t
        return evictable is not None

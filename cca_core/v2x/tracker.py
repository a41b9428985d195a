"""Tracker: messages in, dead-reckoned vehicles out, with one track for each sender."""

from collections import Counter, deque
from collections.abc import Iterable, Mapping

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.path.local_frame import LocalFrame
from cca_core.v2x._intake import Intake
from cca_core.v2x._own_messages import EgoMotion
from cca_core.v2x._plain import plain_bsm, unusable_value
from cca_core.v2x._tracks import is_expired
from cca_core.v2x.bsm import Bsm, decode_frame
from cca_core.v2x.health import MessageRates, TrackerHealth, health_of
from cca_core.v2x.tracker_settings import TrackerSettings
from cca_core.v2x.update_result import ACCEPTED_KINDS, UNCOUNTED_KINDS, UpdateResult
from cca_core.v2x.wrappers import unwrap_message
from cca_core.vehicle import STALE_AGE, RemoteVehicle, VehicleState

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
    own_ids : iterable of str
        Temporary identities of the ego: its own messages are ignored.
    height : float, optional
        Height above the ellipsoid at z = 0 of the frame [m]. Without it the heights of vehicles are unknown.

    Attributes
    ----------
    settings : TrackerSettings
        The same.
    own_ids : set of str
        The same; add an identity when the ego changes its own.
    counts : Counter
        Number of each `UpdateResult.kind`.

    Raises
    ------
    InputError
        If `height` is not a finite number.

    Examples
    --------
    >>> from cca_core.v2x import Bsm
    >>> tracker = Tracker(LocalFrame(45.0, 14.0))
    >>> at = {"latitude_deg": 45.001, "longitude_deg": 14.0, "sec_mark": 7.0}
    >>> bsm = Bsm(msg_count=0, id="00c0ffee", speed=0.0, **at)
    >>> tracker.update(bsm, 7.1).kind, round(tracker.vehicles(7.1)[0].y, 1)
    ('new', 111.1)
    """

    def __init__(
        self,
        frame: LocalFrame,
        settings: TrackerSettings | None = None,
        *,
        own_ids: Iterable[str] = (),
        height: float | None = None,
    ) -> None:
        self.settings = settings or TrackerSettings()
        self.own_ids = set(own_ids)
        self.counts: Counter[str] = Counter()
        self._intake = Intake(frame, self.settings, None if height is None else check_real("height", height))
        self._rates = MessageRates()
        self._rejected: deque[UpdateResult] = deque(maxlen=100)
        self._ego_motion = EgoMotion()
        self._top_speed = 0.0, 0.0  # recent one of the ego, and its time

    def __len__(self) -> int:
        return len(self._intake.tracks.by_id)

    def __repr__(self) -> str:
        return f"Tracker({len(self)} tracks, {self.counts.total()} messages)"

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

        Raises
        ------
        InputError
            If `t` is no real number.
        """
        t = check_real("t", t, allow_inf=True)
        return t - self._intake.clocks.correction - self._intake.t_full <= 1.0

    def health(self, t: float) -> TrackerHealth:
        """Return what was received, accepted and rejected in the last second, and whether to trust the radio.

        The radio cannot be trusted if messages arrive and none is accepted, if it is saturated, if half of
        the senders or more disagree about the time, or if all messages of a sender are too old. The absence
        of a vehicle then proves nothing: pass `TrackerHealth.awareness_range` to the planner.

        Parameters
        ----------
        t : float
            Now, on the receiver's clock [s].

        Returns
        -------
        health : TrackerHealth
            Rates of messages, offset of the clock, and the reason for distrust.

        Raises
        ------
        InputError
            If `t` is not a finite number.
        """
        t, clocks = check_real("t", t), self._intake.clocks
        clock = clocks.offset, clocks.correction, clocks.n_senders, clocks.n_agreeing
        late = clocks.late_sender(t) if self.settings.plausibility.replay else None
        return health_of(self._rates.last_second(t), t, self.is_saturated(t), clock, late)

    def update(self, data: bytes | bytearray | str | Bsm, t_received: float) -> UpdateResult:
        """Process a message.

        Parameters
        ----------
        data : bytes, str or Bsm
            Message as received, in the wrappers that `unwrap_message` removes, or decoded. No content raises.
            Messages of other kinds are counted as ``"other_message"``.
        t_received : float
            Time of reception on the receiver's clock [s]. Minutes should begin at multiples of 60: an offset
            from the senders' clocks is found from the messages and corrected.

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
        self._intake.clocks.tick(t)
        try:
            result = self._process_data(data, t)
        except (InputError, TypeError, ValueError, OverflowError) as error:
            result = UpdateResult(
                accepted=False, kind="unreadable", id="", t=t, message="", detail=str(error)
            )  # fmt: skip
        self.counts[result.kind] += 1
        self._rates.add(result.kind, t)
        if not result.accepted and result.kind not in UNCOUNTED_KINDS:
            self._rejected.append(result)
        return result

    def _process_data(self, data: bytes | bytearray | str | Bsm, t: float) -> UpdateResult:
        """Decode and process a message."""
        if isinstance(data, Bsm):
            bsm = plain_bsm(data)
        else:
            frame = unwrap_message(data)
            if frame.name != "BSM":
                return UpdateResult(accepted=False, kind="other_message", id="", t=t, message=frame.name)
            bsm = decode_frame(frame)
        kind = self._intake.process(bsm, t, self.own_ids)
        return UpdateResult(
            accepted=kind in ACCEPTED_KINDS, kind=kind, id=str(bsm.id), t=t, signed=bsm.signed,
            detail=self._detail(kind, bsm),
        )  # fmt: skip

    def _detail(self, kind: str, bsm: Bsm) -> str:
        """Return what is wrong with a message, if its kind does not say it."""
        if kind == "unusable":
            moves = bsm.speed is not None and bsm.psi is not None
            return unusable_value(bsm) or (
                "position, speed or size is not that of a road vehicle" if moves
                else "speed or heading is missing, and not known from positions yet"
            )  # fmt: skip
        if kind not in ("future", "replay"):
            return ""
        age = self._intake.age
        return f"measured {abs(age):.2f} s {'before' if age > 0.0 else 'after'} its reception"

    def vehicles(
        self, t: float, ego: VehicleState | None = None, names: Mapping[str, str] | None = None
    ) -> tuple[RemoteVehicle, ...]:
        """Return all vehicles dead-reckoned to now, and delete stale tracks that cannot matter.

        Parameters
        ----------
        t : float
            Now, on the receiver's clock [s].
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
        intake = self._intake
        t = check_real("t", t) - intake.clocks.correction
        if ego is not None:
            intake.ego = ego.x, ego.y
            decayed = self._top_speed[0] - self.settings.speed_decay * max(t - self._top_speed[1], 0.0)
            self._top_speed = max(ego.v_x, decayed), t
            self._ego_motion.add(t, ego)
        vehicles = []
        for track in tuple(intake.tracks.by_id.values()):
            vehicle = track.vehicle(t, _name(track.id, names), self.settings, intake.clocks.correction)
            gap, own = t - track.fix.t, False
            if ego is not None:
                own = track.ego_likeness.compare(track.fix, ego, vehicle, self._ego_motion)
            if gap > STALE_AGE and (
                (own and track.ego_likeness.is_certain)
                or is_expired(vehicle, gap, ego, self._top_speed[0], self.settings)
            ):
                intake.tracks.remove(track)
            elif not own or gap > STALE_AGE:
                vehicles.append(vehicle)
        return tuple(vehicles)


def _name(id: str, names: Mapping[str, str] | None) -> str:
    """Return the id of a vehicle: of a further body under one temporary identity that name with a number."""
    if names is None or id in names:
        return id if names is None else names[id]
    base, sign, number = id.partition("#")
    return names.get(base, base) + sign + number

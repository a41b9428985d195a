"""Settings of a tracker."""

from dataclasses import dataclass, field, fields

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError
from cca_core.v2x.motion import PositionErrorModel
from cca_core.v2x.plausibility import PlausibilitySettings

__all__ = ["TrackerSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerSettings:
    """When a tracker confirms, evicts, readmits and deletes tracks.

    Parameters
    ----------
    plausibility : PlausibilitySettings
        Plausibility checks of messages.
    position_errors : PositionErrorModel
        Uncertainty of dead-reckoned positions.
    max_tracks : int
        Tracks at the same time, 1 to 1000.
    retention_range : float
        Distance from the ego within which confirmed tracks are never evicted [m].
    confirm_after : float
        Age of a track from which on it is confirmed [s]; a closer sender can evict a tentative one.
    reassociate_after : float
        Message gap after which a new id at the predicted position continues a track [s].
    readmit_after, readmit_distance : float
        A sender whose messages are rejected is readmitted after its messages have agreed with each other for
        this time [s] and distance [m]: a stationary one proves nothing.
    braking, reaction_time, min_stopping_distance : float
        Stopping distance of the ego, v `reaction_time` + v^2 / (2 `braking`), at least
        `min_stopping_distance` [m/s^2, s, m]; a stale track that cannot be closer is deleted.
    speed_decay : float
        The ego counts as fast as it was, less this rate [m/s^2]: it may accelerate again.
    approach_horizon : float
        Time for which an approaching stale track is assumed to continue [s]: the length of a maneuver.
    delete_after : float
        Age at which every stale track is deleted [s].
    untimed_age : float
        Age assumed of a message without time stamp, and of the youngest messages if the receiver's clock is
        off [s].
    sigma_position : float
        Standard deviation of a constant error of all positions [m], which comparing a sender with itself
        cannot show; added to both of a vehicle's.
    max_reported_accuracy : float
        A sender's reported standard deviation (`PositionalAccuracy.semi_major`) is added up to this limit
        [m]. 0 ignores it, since devices report meters where they err by decimeters.
    sigma_height : float
        Standard deviation of a reported height [m]; messages do not report it.
    length, width : float
        Body of a sender that does not report it [m].

    Raises
    ------
    InputError
        If a value is outside its range.
    """

    plausibility: PlausibilitySettings = field(default_factory=PlausibilitySettings)
    position_errors: PositionErrorModel = field(default_factory=PositionErrorModel)
    max_tracks: int = 200
    retention_range: float = 300.0
    confirm_after: float = 0.5
    reassociate_after: float = 0.25
    readmit_after: float = 1.0
    readmit_distance: float = 5.0
    braking: float = 4.0
    reaction_time: float = 1.0
    min_stopping_distance: float = 20.0
    speed_decay: float = 0.5
    approach_horizon: float = 15.0
    delete_after: float = 30.0
    untimed_age: float = 0.1
    sigma_position: float = 0.0
    max_reported_accuracy: float = 0.0
    sigma_height: float = 1.0
    length: float = 5.0
    width: float = 2.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for name, kind in (("plausibility", PlausibilitySettings), ("position_errors", PositionErrorModel)):
            if not isinstance(getattr(self, name), kind):
                raise InputError(f"{name} must be {kind.__name__}, was {getattr(self, name)!r}")
        from_zero = (
            "sigma_position", "max_reported_accuracy", "sigma_height", "reaction_time",
            "min_stopping_distance", "approach_horizon", "speed_decay", "untimed_age", "readmit_distance",
        )  # fmt: skip
        for limit in fields(self)[2:]:
            value = getattr(self, limit.name)
            if limit.name in from_zero:
                check_real(limit.name, value, ge=0.0, le=100.0)
            else:
                check_real(limit.name, value, gt=0.0, le=1000.0)
        if not isinstance(self.max_tracks, int):
            raise InputError(f"max_tracks must be an integer, was {self.max_tracks!r}")

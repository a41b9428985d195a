"""How a tracker keeps and forgets senders."""

from dataclasses import dataclass, field, fields

from cca_core._checks import check_real
from cca_core.errors import InputError
from cca_core.v2x.plausibility import PlausibilitySettings

__all__ = ["TrackerSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerSettings:
    """How a tracker keeps and forgets senders.

    Parameters
    ----------
    plausibility : PlausibilitySettings
        Which messages are believed.
    max_tracks : int
        Senders kept at the same time, 1 to 1000.
    retention_range : float
        Distance from the ego within which all senders are wanted, and one that is known makes no room for
        another [m].
    confirm_after : float
        Time after which a sender is known in that sense [s]; until then a nearer one replaces it.
    reassociate_after : float
        Silence after which a new id at its place takes a track over [s].
    readmit_after : float
        Time after which a sender whose messages are dropped, but agree with each other while it drives, is
        believed again [s].
    braking, reaction_time, min_stopping_distance : float
        Stopping distance of the ego is v `reaction` + v^2 / (2 `braking`), at least `min_stopping_distance`
        [m/s^2, s, m]; a stale track that cannot be nearer is forgotten.
    approach_horizon : float
        Time for which a stale track that comes nearer is taken to go on doing so [s]: as long as a pass.
    delete_after : float
        Age at which a track is forgotten in any case [s].
    sigma_position : float
        Standard deviation of positions that does not show when a sender is compared with itself [m]; added
        to both of a vehicle's.
    max_reported_accuracy : float
        The standard deviation that a sender tells of its position (`Accuracy.semi_major`) counts up to this
        [m] and is added likewise; 0 leaves it out, since devices tell meters where they err by decimeters.
    length, width : float
        Body of a sender that does not tell it [m].

    Raises
    ------
    InputError
        If a value is outside its range.
    """

    plausibility: PlausibilitySettings = field(default_factory=PlausibilitySettings)
    max_tracks: int = 200
    retention_range: float = 300.0
    confirm_after: float = 0.5
    reassociate_after: float = 0.25
    readmit_after: float = 1.0
    braking: float = 4.0
    reaction_time: float = 1.0
    min_stopping_distance: float = 20.0
    approach_horizon: float = 15.0
    delete_after: float = 30.0
    sigma_position: float = 0.0
    max_reported_accuracy: float = 0.0
    length: float = 5.0
    width: float = 2.0

    def __post_init__(self) -> None:
        if not isinstance(self.plausibility, PlausibilitySettings):
            raise InputError(f"plausibility must be PlausibilitySettings, was {self.plausibility!r}")
        for limit in fields(self)[1:]:
            value = getattr(self, limit.name)
            if limit.name in (
                "sigma_position",
                "max_reported_accuracy",
                "reaction_time",
                "min_stopping_distance",
                "approach_horizon",
            ):
                check_real(limit.name, value, ge=0.0, le=100.0)
            else:
                check_real(limit.name, value, gt=0.0, le=1000.0)
        if not isinstance(self.max_tracks, int):
            raise InputError(f"max_tracks must be an integer, was {self.max_tracks!r}")

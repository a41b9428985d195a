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
    most_senders : int
        Senders kept at the same time, 1 to 1000.
    keep_within : float
        Distance from the ego within which all senders are wanted, and one that is known makes no room for
        another [m].
    established_after : float
        Time after which a sender is known in that sense [s]; until then a nearer one replaces it.
    lost_after : float
        Silence after which a new id at its place takes a track over [s].
    readmit_after : float
        Time after which a sender whose messages are dropped, but agree with each other while it drives, is
        believed again [s].
    braking, reaction, least_reach : float
        Stopping distance of the ego is v `reaction` + v^2 / (2 `braking`), at least `least_reach`
        [m/s^2, s, m]; a stale track that cannot be nearer is forgotten.
    outlook : float
        Time for which a stale track that comes nearer is taken to go on doing so [s]: as long as a pass.
    forget_after : float
        Age at which a track is forgotten in any case [s].
    sigma_position : float
        Standard deviation of positions that does not show when a sender is compared with itself [m]; added
        to both of a vehicle's.
    most_accuracy : float
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
    most_senders: int = 200
    keep_within: float = 300.0
    established_after: float = 0.5
    lost_after: float = 0.25
    readmit_after: float = 1.0
    braking: float = 4.0
    reaction: float = 1.0
    least_reach: float = 20.0
    outlook: float = 15.0
    forget_after: float = 30.0
    sigma_position: float = 0.0
    most_accuracy: float = 0.0
    length: float = 5.0
    width: float = 2.0

    def __post_init__(self) -> None:
        if not isinstance(self.plausibility, PlausibilitySettings):
            raise InputError(f"plausibility must be PlausibilitySettings, was {self.plausibility!r}")
        for limit in fields(self)[1:]:
            value = getattr(self, limit.name)
            if limit.name in ("sigma_position", "most_accuracy", "reaction", "least_reach", "outlook"):
                check_real(limit.name, value, least=0.0, most=100.0)
            else:
                check_real(limit.name, value, above=0.0, most=1000.0)
        if not isinstance(self.most_senders, int):
            raise InputError(f"most_senders must be an integer, was {self.most_senders!r}")

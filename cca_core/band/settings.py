"""Settings of the search for a band."""

from dataclasses import dataclass, fields

from cca_core._checks import check_real
from cca_core._repr import short_repr
from cca_core.errors import InputError

_MAX_FREE_SIDES = 16  # more would take minutes


@dataclass(frozen=True, slots=True, kw_only=True)
class BandSettings:
    """Effort and tolerances of `relax_band`; the defaults are those of all published results.

    Parameters
    ----------
    max_tightenings : int
        Rounds of constraint tightening [-].
    max_solves : int
        Banded solves after which a band is not tightened any more [-]; a drivable band takes 1 to 30. A round
        takes at most 60, so no band with given sides takes more than this and 60.
    min_progress : float
        A round counts as progress if it reduces the violation to this fraction of the best so far [-].
    max_stalls : int
        Consecutive rounds without progress after which the search stops [-].
    clearance_margin : float
        Distance by which bounds are moved beyond the shortfall [m], so that the search ends in few rounds.
    curvature_margin : float
        Fraction of the curvature limit that is aimed below it [-].
    max_end_shortfall : float
        Shortfall of clearance at a pinned end above which the search ends at once [m]: no deformation
        changes it.
    max_free_sides : int
        Obstacles of which both sides are tried, nearest first [-]; each doubles the assignments. At most 16.
    max_certified_sides : int
        Side assignments that are relaxed to the end, cheapest first [-].
    side_change_fraction : float
        New sides replace those of the previous band only if their energy is below this fraction [-].

    Raises
    ------
    InputError
        If a value is outside its range: counts from 1, fractions from 0 to 1, distances not negative.

    Examples
    --------
    >>> BandSettings(max_free_sides=2).max_tightenings
    16
    """

    max_tightenings: int = 16
    max_solves: int = 400
    min_progress: float = 0.8
    max_stalls: int = 4
    clearance_margin: float = 3e-3
    curvature_margin: float = 2e-3
    max_end_shortfall: float = 0.2
    max_free_sides: int = 6
    max_certified_sides: int = 8
    side_change_fraction: float = 0.7

    __repr__ = short_repr

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "int" or field.type is int:
                if not isinstance(value, int) or value < 1:
                    raise InputError(f"{field.name} must be an integer of at least 1, was {value!r}")
            else:
                check_real(field.name, value, ge=0.0, le=1.0)
        if self.max_free_sides > _MAX_FREE_SIDES:
            raise InputError(f"max_free_sides must be at most {_MAX_FREE_SIDES}, was {self.max_free_sides}")

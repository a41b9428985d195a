"""Side assignment: the arguments `side` and `previous` of `relax_band`."""

from types import NoneType

import numpy as np

from cca_core._checks import Mask
from cca_core.band.band import Band
from cca_core.errors import InputError
from cca_core.kernel.band_workspace import BLOCKING_LEFT, BLOCKING_RIGHT, CHEAPEST_SIDES, GIVEN_SIDES


def parse_sides(side: object, m: int, bands: int) -> tuple[int, Mask | None]:
    """Check `side`; return the rule, and passes_left if it is given, shape (m, bands)."""
    if side is None:
        return CHEAPEST_SIDES, None
    if isinstance(side, str) and side in ("left", "right"):
        return BLOCKING_LEFT if side == "left" else BLOCKING_RIGHT, None
    if not isinstance(side, (list, tuple)) or len(side) != m or not set(side) <= {"left", "right"}:
        raise InputError(
            f"side must be 'left', 'right' or a list of {m}, one for each obstacle, was {side!r}"
        )
    passes_left = np.empty((m, bands), dtype=np.bool_)
    passes_left.T[...] = [each == "left" for each in side]
    return GIVEN_SIDES, passes_left


def former_sides(previous: Band | None, m: int, bands: int) -> Mask | None:
    """Check `previous`; return its passes_left, shape (m, bands), if it has these obstacles."""
    if not isinstance(previous, (Band, NoneType)):
        raise InputError(f"previous must be a Band, was {type(previous).__name__}")
    if previous is None:
        return None
    former = previous.passes_left.reshape(len(previous.passes_left), -1)
    return former if former.shape == (m, bands) else None

"""Positions of a file as they are read, before they are checked."""

import math
from datetime import UTC, datetime

from cca_core._checks import parse_real
from cca_core.errors import InputError

Text = str | float | None

_TIME_UNITS = (
    (1e9, 1e17),
    (1e6, 1e14),
    (1e3, 1e11),
)  # units in a second, and from which value on: years since 1970


class Fixes:
    """Rows of a file: two coordinates, elevation, time and the number of the line or point."""

    def __init__(self, unit: str = "point", *, in_meters: bool = False) -> None:
        self.unit, self.in_meters = unit, in_meters
        self.rows: list[tuple[Text, Text, Text, Text, int]] = []
        self.parts: list[int] = []

    def begin_part(self) -> None:
        """Let a new part start at the next row."""
        self.parts.append(len(self.rows))

    def add(
        self, first: Text, second: Text, z: Text = None, t: Text = None, number: int | None = None
    ) -> None:
        """Add a row: latitude and longitude [deg], or x and y [m]; ``None`` or no number: not given."""
        self.rows.append((first, second, z, t, len(self.rows) if number is None else number))

    def numbers(
        self, file_name: str, *, skip_invalid: bool
    ) -> tuple[list[tuple[float, ...]], list[int], int]:
        """Return the rows with a position, the first row of each part, and the number of skipped rows."""
        found: list[tuple[float, ...]] = []
        starts, borders = [], iter([*self.parts, -1])
        border, skipped = next(borders), 0
        at_zero = self._at_zero()
        for i, (first, second, z, t, number) in enumerate(self.rows):
            while i == border:
                starts.append(len(found))
                border = next(borders)
            pair = to_number(first), to_number(second)
            if math.isfinite(pair[0] + pair[1]) and (pair != (0.0, 0.0) or at_zero):
                found.append((*pair, to_number(z), to_time(t)))
            elif skip_invalid:
                skipped += 1
            else:
                names = "x and y" if self.in_meters else "latitude and longitude"
                raise InputError(
                    f"{names} must be numbers, and not both 0, were {str(first)[:40]!r}, "
                    f"{str(second)[:40]!r} in {self.unit} {number} of {file_name!r}"
                )
        return found, starts, skipped

    def _at_zero(self) -> bool:
        """Return whether latitude and longitude 0 may be a position; receivers without a fix report it."""
        return self.in_meters or all(
            abs(to_number(value)) <= 1.0
            for row in self.rows
            for value in row[:2]
            if not math.isnan(to_number(value))
        )


def to_number(value: Text) -> float:
    """Return a number; NaN if the text is none."""
    if isinstance(value, str):
        value = parse_real(value.strip())
    return math.nan if value is None else value


def to_time(value: Text) -> float:
    """Return a time [s]; an ISO 8601 date counts from 1970 in UTC, and so does a number of ms, us or ns."""
    number = to_number(value)
    if math.isnan(number) and isinstance(value, str) and 8 <= len(value) <= 40:
        try:
            moment = datetime.fromisoformat(value.strip())
            return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
        except (ValueError, OverflowError):
            return math.nan
    return next((number / unit for unit, limit in _TIME_UNITS if number > limit), number)

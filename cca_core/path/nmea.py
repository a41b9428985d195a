"""Positions of NMEA 0183 logs: sentences RMC and GGA."""

import math
from datetime import UTC, datetime
from functools import reduce

from cca_core.errors import InputError
from cca_core.path.fixes import Fixes, to_number

_DAY = 86400.0  # [s]


def read_nmea(data: bytes, name: str) -> Fixes:
    """Return one position of each time; RMC has the date, GGA the elevation."""
    fixes, epoch = Fixes("line"), _Epoch()
    for number, line in enumerate(data.decode("latin-1").splitlines(), start=1):
        begin = line.find("$")
        sentence, _, checksum = line[begin + 1 :].strip().partition("*")
        fields = sentence.split(",")
        kind = fields[0][-3:]
        if begin < 0 or kind not in ("RMC", "GGA") or len(fields) < 10:
            continue
        if checksum and f"{reduce(int.__xor__, sentence.encode('latin-1')):02X}" != checksum[:2].upper():
            fixes.add(None, None, number=number)  # damaged
            continue
        if fields[1] != epoch.time:
            epoch.close(fixes)
            epoch = _Epoch(fields[1], number, epoch.midnight, epoch.t)
        epoch.take(kind, fields)
    epoch.close(fixes)
    if not fixes.rows:
        raise InputError(f"file {name!r} must have NMEA sentences RMC or GGA, had none")
    return fixes


class _Epoch:
    """Values in the sentences of one time."""

    def __init__(
        self, time: str | None = None, number: int = 0, midnight: float = 0.0, before: float = -math.inf
    ) -> None:
        self.time, self._number, self.midnight = time, number, midnight
        self._position: tuple[float, float] | None = None
        self._z = math.nan
        self._is_void = False
        clock = to_number(time)
        clock = clock if 0.0 <= clock < 240000.0 else math.nan
        hours, minutes = clock // 10000.0, clock // 100.0 % 100.0
        self._of_day = hours * 3600.0 + minutes * 60.0 + clock % 100.0
        if self.t < before - 0.5 * _DAY:  # past midnight; only RMC has the date
            self.midnight += _DAY

    @property
    def t(self) -> float:
        """Time since 1970 [s], or since the first midnight if no date is given."""
        return self.midnight + self._of_day

    def take(self, kind: str, fields: list[str]) -> None:
        """Take a sentence."""
        if kind == "RMC":
            self._is_void |= fields[2].upper() != "A"
            pair = fields[3:7]
            day = fields[9]
            if len(day) == 6 and day.isascii() and day.isdigit():
                year = int(day[4:]) + (2000 if int(day[4:]) < 80 else 1900)
                try:
                    date = datetime(year, int(day[2:4]), int(day[:2]), tzinfo=UTC)
                except ValueError:
                    return
                self.midnight = date.timestamp()
        else:
            self._is_void |= fields[6].strip() in ("", "0")
            pair = fields[2:6]
            self._z = to_number(fields[9])
        lat, lon = _degrees(pair[0], pair[1], "NS"), _degrees(pair[2], pair[3], "EW")
        if self._position is None and math.isfinite(lat + lon):
            self._position = lat, lon

    def close(self, fixes: Fixes) -> None:
        """Add the position, or a row without one."""
        if self.time is not None:
            lat, lon = (None, None) if self._is_void or self._position is None else self._position
            fixes.add(lat, lon, self._z, self.t, self._number)


def _degrees(value: str, side: str, sides: str) -> float:
    """Return an angle [deg] written as degrees and minutes without a point between, and its side."""
    angle, side = to_number(value), side.strip().upper()
    if not angle >= 0.0 or side not in sides or not side:
        return math.nan
    degrees = angle // 100.0 + angle % 100.0 / 60.0
    return degrees if side == sides[0] else -degrees

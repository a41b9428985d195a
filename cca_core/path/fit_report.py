"""What a fit did with its waypoints."""

from dataclasses import dataclass

from cca_core._checks import Array, Index


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitReport:
    """Distance of a fitted path from its waypoints.

    Parameters
    ----------
    tolerance : float
        Tolerance of the fit, given or chosen [m].
    noise : float or None
        Estimated standard deviation of the waypoints in x and y [m]; None if the tolerance was given.
    max_deviation : float
        Largest distance between a waypoint and the path [m].
    s_max_deviation : float
        Station of that waypoint [m].
    missed : ndarray of int, shape (n_missed,)
        Rows of the waypoints farther away than the tolerance.
    missed_by : ndarray, shape (n_missed,)
        Their distance from the path [m].
    outliers : ndarray of int, shape (n_outliers,)
        Rows that the fit ignored because they are far away from both neighbors' course; they are among the
        missed ones.
    """

    tolerance: float
    noise: float | None
    max_deviation: float
    s_max_deviation: float
    missed: Index
    missed_by: Array
    outliers: Index

    @property
    def farthest(self) -> str:
        """Text of the largest deviation and where it is."""
        return f"max deviation {self.max_deviation:.2f} m at s={self.s_max_deviation:.1f}"

    @property
    def tolerance_text(self) -> str:
        """Tolerance with the digits of the largest deviation, or more if it is small."""
        return f"{self.tolerance:.2f} m" if self.tolerance >= 0.1 else f"{self.tolerance:.2g} m"

    def __repr__(self) -> str:
        parts = [f"tolerance {self.tolerance_text}"]
        if self.noise is not None:
            parts.append(f"noise {self.noise:.2g} m")
        parts.append(self.farthest)
        if len(self.missed):
            found = zip(self.missed[:6].tolist(), self.missed_by[:6].tolist(), strict=True)
            rows = ", ".join(f"{row} by {distance:.1f} m" for row, distance in found)
            more = ", ..." if len(self.missed) > 6 else ""
            parts.append(f"{len(self.missed)} missed: {rows}{more}")
        return f"FitReport({'; '.join(parts)})"

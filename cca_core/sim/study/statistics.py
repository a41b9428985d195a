"""Rates of events with their confidence intervals, and the table of a study."""

import csv
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from cca_core._checks import Mask, check_real
from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.sim.scenarios.scenario import EGO_TYPES


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """Fraction of runs with an event.

    Parameters
    ----------
    n_events, n : int
        Number of runs with the event, and of all runs.
    ci_low, ci_high : float
        Two-sided interval of its probability (Clopper and Pearson) [-].
    upper_bound : float
        One-sided upper bound of its probability at the same confidence [-].
    confidence : float
        Minimum probability that the interval holds [-].
    """

    n_events: int
    n: int
    ci_low: float
    ci_high: float
    upper_bound: float
    confidence: float

    @property
    def value(self) -> float:
        """The fraction itself [-]; 0 without runs."""
        return self.n_events / self.n if self.n else 0.0

    def __str__(self) -> str:
        return f"{self.n_events} of {self.n}, {_percent(self.ci_low)} to {_percent(self.ci_high)} %"

    def __repr__(self) -> str:
        return f"Rate({self} at {_percent(self.confidence)} % confidence)"


def _percent(probability: float) -> str:
    percent = 100.0 * probability
    if 99.5 <= percent < 100.0:  # never rounded to 100
        return f"{percent:.4g}"
    return f"{percent:.2g}" if percent < 9.95 else f"{percent:.0f}"


def estimate_rate(n_events: int, n: int, *, confidence: float = 0.95) -> Rate:
    """Estimate the rate of an event in `n` independent runs; without runs the interval is 0 to 1."""
    if not 0 <= n_events <= n:
        raise InputError(f"n_events must be from 0 to n, was {n_events} of {n}")
    confidence = check_real("confidence", confidence, gt=0.0, le=1.0 - 1e-12)
    low, high, bound = 0.0, 1.0, 1.0
    if n:
        from scipy.stats import binomtest  # slow to import

        low, high = binomtest(n_events, n).proportion_ci(confidence, method="exact")
        _, bound = binomtest(n_events, n, alternative="less").proportion_ci(confidence, method="exact")
    return Rate(
        n_events=n_events, n=n, ci_low=float(low), ci_high=float(high), upper_bound=float(bound),
        confidence=confidence,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StudyTable:
    """Runs of a study, one row each, in the order of their numbers.

    Parameters
    ----------
    scenario : str
        Scenario of all runs.
    rows : tuple of dict
        Sampled parameters and results; all rows have the same keys. No value depends on the clock, the
        machine's load or the executor.
    """

    scenario: str
    rows: tuple[dict[str, Any], ...]

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        first = f"StudyTable({self.scenario}, {len(self)} runs"
        egos = [ego_type for ego_type in EGO_TYPES if f"{ego_type}_collided_with" in self.names]
        if not egos or "avoiding_action" not in self.names:
            return f"{first})"
        rates = "".join(f"\n  {ego_type:<7} {self.rate(ego_type)}" for ego_type in egos)
        overlapping = f"\n  {describe_overlapping(self)}" if self.overlapping.any() else ""
        return (
            f"{first}, {np.sum(self.avoidable)} avoidable; collisions among these at 95 % confidence:{rates}"
            f"{overlapping})"
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self.rows[0]) if self.rows else ()

    def column(self, name: str) -> np.ndarray:
        """Return one column.

        Parameters
        ----------
        name : str
            One of `names`.

        Returns
        -------
        values : ndarray of bool, int, float or str, shape (n,)
            In SI units; an unknown number is NaN.

        Raises
        ------
        InputError
            If there is no such column.
        """
        if name not in self.names:
            raise InputError(f"name must be one of {', '.join(self.names)}, was {name!r}")
        values = [row[name] for row in self.rows]
        return np.array([np.nan if value is None else value for value in values])

    @property
    def avoidable(self) -> Mask:
        """Whether braking or evading from the first hazard message on avoids any collision, by run."""
        return np.array([row["avoiding_action"] != "" for row in self.rows], dtype=bool)

    @property
    def overlapping(self) -> Mask:
        """Whether road users drive into each other, with any ego type, by run; such a run means little."""
        names = [f"{ego_type}_overlap" for ego_type in EGO_TYPES]
        return np.array([any(row.get(name) for name in names) for row in self.rows], dtype=bool)

    def collided(self, ego_type: str) -> Mask:
        """Return which runs ended in a collision.

        Parameters
        ----------
        ego_type : {"v2v", "driver", "sensor"}
            Type of the ego.

        Returns
        -------
        collided : ndarray of bool, shape (n,)
            By run.

        Raises
        ------
        InputError
            If the type is unknown.
        """
        if ego_type not in EGO_TYPES:
            raise InputError(f"ego_type must be one of {', '.join(EGO_TYPES)}, was {ego_type!r}")
        return np.array([row[f"{ego_type}_collided_with"] != "" for row in self.rows], dtype=bool)

    def rate(self, ego_type: str, among: Mask | None = None, *, confidence: float = 0.95) -> Rate:
        """Estimate the rate of collisions.

        Parameters
        ----------
        ego_type : {"v2v", "driver", "sensor"}
            Type of the ego.
        among : ndarray of bool, shape (n,), optional
            Runs that count; the default is the `avoidable` ones.
        confidence : float
            Confidence of the interval [-], above 0 and below 1.

        Returns
        -------
        rate : Rate
            The fraction of collisions with its interval.

        Raises
        ------
        InputError
            If the type is unknown, or the confidence out of range.

        Examples
        --------
        >>> rows = ({"v2v_collided_with": "", "avoiding_action": "brake"},) * 2000
        >>> StudyTable(scenario="eebl", rows=rows).rate("v2v").upper_bound
        0.00149...
        """
        counted = self.avoidable if among is None else among
        collided = int(np.sum(self.collided(ego_type) & counted))
        return estimate_rate(collided, int(np.sum(counted)), confidence=confidence)

    def to_dataframe(self) -> Any:
        """Return all columns as a data frame of pandas.

        Returns
        -------
        frame : pandas.DataFrame
            One row for each run, one column for each of `names`, in SI units.

        Raises
        ------
        MissingExtraError
            If pandas is not installed.
        """
        return require_extra("pandas", None).DataFrame({name: self.column(name) for name in self.names})

    def write_csv(self, path: str | FilePath) -> None:
        """Write all columns to a CSV file; numbers read back exactly.

        Parameters
        ----------
        path : str or pathlib.Path
            File to write.
        """
        with FilePath(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.names)
            writer.writerows(row.values() for row in self.rows)


def describe_overlapping(table: StudyTable) -> str:
    """State in how many runs road users drive into each other."""
    return (
        f"road users drive into each other in {np.sum(table.overlapping)} of {len(table)} runs "
        "(columns that end in _overlap)"
    )

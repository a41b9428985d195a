"""How often something happened, with its confidence interval; and the table of a study."""

import csv
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from scipy.special import betaincinv

from cca_core._checks import Mask, check_real
from cca_core.errors import InputError
from cca_core.sim.scenarios.scenario import EGO_TYPES

__all__ = ["Rate", "StudyTable", "estimate_rate"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rate:
    """Share of runs in which something happened.

    Parameters
    ----------
    n_events, n : int
        In how many of how many runs.
    ci_low, ci_high : float
        Two-sided interval (Clopper, Pearson) of the probability [-].
    upper_bound : float
        One-sided upper bound of it at the same confidence [-].
    confidence : float
        Probability with which the interval holds [-], at least.
    """

    n_events: int
    n: int
    ci_low: float
    ci_high: float
    upper_bound: float
    confidence: float

    @property
    def value(self) -> float:
        """The share itself [-]; 0 if there were no runs."""
        return self.n_events / self.n if self.n else 0.0


def estimate_rate(hits: int, n: int, *, confidence: float = 0.95) -> Rate:
    """Give a share its exact interval.

    Parameters
    ----------
    hits, n : int
        In how many of how many independent runs something happened.
    confidence : float
        Wanted confidence [-].

    Returns
    -------
    rate : Rate
        With the interval of Clopper and Pearson; without runs it is from 0 to 1.

    Raises
    ------
    InputError
        If `hits` is negative or above `n`, or `confidence` not between 0 and 1.

    Examples
    --------
    >>> round(estimate_rate(0, 2000).bound, 5)
    0.0015
    """
    if not 0 <= hits <= n:
        raise InputError(f"hits must be from 0 to n, were {hits} of {n}")
    confidence = check_real("confidence", confidence, gt=0.0, le=1.0 - 1e-12)
    rest = 1.0 - confidence

    def upper(tail: float) -> float:
        return float(betaincinv(hits + 1, n - hits, 1.0 - tail)) if hits < n else 1.0

    low = float(betaincinv(hits, n - hits + 1, 0.5 * rest)) if hits else 0.0
    return Rate(
        n_events=hits,
        n=n,
        ci_low=low,
        ci_high=upper(0.5 * rest),
        upper_bound=upper(rest),
        confidence=confidence,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StudyTable:
    """Runs of a study, one row each, in the order of their numbers.

    Parameters
    ----------
    scenario : str
        What was varied.
    rows : tuple of dict
        What was drawn, and what came of it; all rows have the same keys. Nothing in it depends on the clock,
        the machine's load or the executor.
    """

    scenario: str
    rows: tuple[dict[str, Any], ...]

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self.rows[0]) if self.rows else ()

    def column(self, name: str) -> np.ndarray:
        """One column.

        Parameters
        ----------
        name : str
            Which.

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
        """Whether braking or swerving from the first hazard message on avoids any contact, by run."""
        return np.array([row["avoiding_action"] != "" for row in self.rows], dtype=bool)

    def collided(self, ego: str) -> Mask:
        """Tell which runs ended in a contact.

        Parameters
        ----------
        ego : {"v2v", "driver", "sensor"}
            Who drove.

        Returns
        -------
        hit : ndarray of bool, shape (n,)
            By run.

        Raises
        ------
        InputError
            If nobody of that name drove.
        """
        if ego not in EGO_TYPES:
            raise InputError(f"ego must be one of {', '.join(EGO_TYPES)}, was {ego!r}")
        return np.array([row[f"{ego}_collided_with"] != "" for row in self.rows], dtype=bool)

    def rate(self, ego: str, among: Mask | None = None, *, confidence: float = 0.95) -> Rate:
        """Share of runs that ended in a contact.

        Parameters
        ----------
        ego : {"v2v", "driver", "sensor"}
            Who drove.
        among : ndarray of bool, shape (n,), optional
            The runs that count; the default is the `avoidable` ones.
        confidence : float
            Of its interval [-].

        Returns
        -------
        rate : Rate
            The share with its interval.

        Raises
        ------
        InputError
            If nobody of that name drove.
        """
        counted = self.avoidable if among is None else among
        return estimate_rate(
            int(np.sum(self.collided(ego) & counted)), int(np.sum(counted)), confidence=confidence
        )

    def write_csv(self, path: str | FilePath) -> None:
        """Write all columns; numbers are written so that they read back exactly.

        Parameters
        ----------
        path : str or pathlib.Path
            File to write.
        """
        with FilePath(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(self.names)
            writer.writerows(row.values() for row in self.rows)

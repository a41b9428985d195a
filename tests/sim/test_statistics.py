"""Rates of events and their confidence intervals."""

import math

import pytest

from cca_core.errors import InputError
from cca_core.sim.study.statistics import estimate_rate


@pytest.mark.parametrize(("n_events", "n"), [(0, 5), (1, 7), (3, 30), (29, 30), (30, 30), (12, 400)])
@pytest.mark.parametrize("confidence", [0.9, 0.95])
def test_interval_has_exact_tails(n_events: int, n: int, confidence: float) -> None:
    """The bounds of Clopper and Pearson by their definition, as sums of binomial probabilities."""
    rate, rest = estimate_rate(n_events, n, confidence=confidence), 1.0 - confidence

    def cumulative(k: int, p: float) -> float:
        return sum(math.comb(n, i) * p**i * (1.0 - p) ** (n - i) for i in range(k + 1))

    if n_events < n:
        assert cumulative(n_events, rate.ci_high) == pytest.approx(0.5 * rest, rel=1e-6)
        assert cumulative(n_events, rate.upper_bound) == pytest.approx(rest, rel=1e-6)
    else:
        assert rate.ci_high == rate.upper_bound == 1.0
    if n_events:
        assert 1.0 - cumulative(n_events - 1, rate.ci_low) == pytest.approx(0.5 * rest, rel=1e-6)
    else:
        assert rate.ci_low == 0.0
    assert rate.ci_low <= rate.value <= rate.upper_bound <= rate.ci_high


def test_bound_without_events() -> None:
    assert estimate_rate(0, 2000).upper_bound == pytest.approx(1.0 - 0.05 ** (1 / 2000))
    assert estimate_rate(0, 2000).upper_bound < 0.002 < estimate_rate(1, 2000).upper_bound


def test_interval_without_runs_is_0_to_1() -> None:
    rate = estimate_rate(0, 0)
    assert (rate.value, rate.ci_low, rate.ci_high) == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(("n_events", "n", "c"), [(-1, 5, 0.9), (6, 5, 0.9), (1, 5, 1.0), (1, 5, 0.0)])
def test_invalid_argument_raises(n_events: int, n: int, c: float) -> None:
    with pytest.raises(InputError, match=r"n_events|confidence"):
        estimate_rate(n_events, n, confidence=c)

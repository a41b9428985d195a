"""Rates of events and their confidence intervals."""

import math
import sys
from importlib.machinery import ModuleSpec
from types import ModuleType

import pytest

from cca_core.errors import InputError, MissingExtraError
from cca_core.sim.study.statistics import StudyTable, estimate_rate


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


@pytest.mark.parametrize(
    ("n_events", "n", "text"),
    [
        (0, 8, "0 of 8, 0 to 37 %"),
        (0, 0, "0 of 0, 0 to 100 %"),
        (0, 2000, "0 of 2000, 0 to 0.18 %"),
        (2000, 2000, "2000 of 2000, 99.82 to 100 %"),
        (30, 400, "30 of 400, 5.1 to 11 %"),
    ],
)
def test_rate_prints_counts_and_interval(n_events: int, n: int, text: str) -> None:
    rate = estimate_rate(n_events, n)
    assert str(rate) == text
    assert repr(rate) == f"Rate({text} at 95 % confidence)"


def study_table() -> StudyTable:
    row = {"index": 0, "latency": None, "v2v_collided_with": "", "driver_collided_with": "red"}
    return StudyTable(scenario="eebl", rows=({**row, "avoiding_action": "brake"},) * 8)


def test_table_prints_rates_of_its_egos() -> None:
    assert repr(study_table()) == (
        "StudyTable(eebl, 8 runs, 8 avoidable; collisions among these at 95 % confidence:\n"
        "  v2v     0 of 8, 0 to 37 %\n"
        "  driver  8 of 8, 63 to 100 %)"
    )
    assert repr(StudyTable(scenario="ima", rows=())) == "StudyTable(ima, 0 runs)"


def test_table_becomes_a_data_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a stand-in of pandas, which is no dependency of the library."""
    stand_in = ModuleType("pandas")
    stand_in.DataFrame = dict  # type: ignore[attr-defined]
    stand_in.__spec__ = ModuleSpec("pandas", None)
    monkeypatch.setitem(sys.modules, "pandas", stand_in)
    frame = study_table().to_dataframe()
    assert list(frame) == list(study_table().names)
    assert frame["driver_collided_with"].tolist() == ["red"] * 8


def test_missing_pandas_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cca_core._optional.find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match="run: pip install pandas"):
        study_table().to_dataframe()

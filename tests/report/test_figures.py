import pytest

from cca_core.report import report_figures, tuning_figure
from cca_core.sim import Log
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")


def test_figure_names_are_unique_file_names(run: Run, hostile: Log) -> None:
    for group in ([run("curbside", "fast", "driver"), run("curbside", "fast", "v2v")], [hostile]):
        names = [figure.name for figure in report_figures(group)]
        assert len(set(names)) == len(names)
        assert all(name.isascii() and name.isidentifier() for name in names)


def test_tuning_figure_needs_both_tunings(run: Run) -> None:
    fast, smooth = run("maneuver", "1-fast", "v2v"), run("maneuver", "1-smooth", "v2v")
    assert tuning_figure([smooth, fast]).name == "fig15_two_tunings"
    assert tuning_figure([fast]) is None

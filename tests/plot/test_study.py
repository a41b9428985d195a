"""Figure of studies: collision rates over latency, loss or other samples."""

from typing import Any

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.plot import plot_study
from cca_core.sim import StudyTable

pytestmark = pytest.mark.requires("matplotlib")


def example_table() -> StudyTable:
    rng = np.random.default_rng(0)
    rows = []
    for i in range(400):
        latency, loss = rng.uniform(0.0, 0.5), rng.uniform(0.0, 0.8)
        collisions = {"v2v": loss > 0.7, "driver": i % 2 == 0, "sensor": False}
        results = {f"{ego}_collided_with": "red" if collided else "" for ego, collided in collisions.items()}
        rows.append({"index": i, "latency": latency, "loss": loss, "avoiding_action": "", **results})
    return StudyTable(scenario="ima", rows=tuple(rows))


def test_lines_are_rates_of_their_bins() -> None:
    table = example_table()
    latency, loss = plot_study([table], bins=4).axes
    assert (latency.get_xlabel(), loss.get_ylabel()) == ("latency [s]", "")
    lines = {c.get_label(): c.lines[0].get_ydata() for c in loss.containers}
    x = table.column("loss")
    edges = np.linspace(x.min(), x.max(), 5)
    last = x >= edges[3]
    assert lines["with V2V"][3] == pytest.approx(table.rate("v2v", last).value)
    assert lines["with V2V"][:3].tolist() == [0.0, 0.0, 0.0]
    assert 0.3 < lines["driver without V2V"].min() < lines["driver without V2V"].max() < 0.7
    assert lines["sensor without V2V"].tolist() == [0.0] * 4


def test_figure_shows_varying_samples() -> None:
    rows = example_table().rows
    held = tuple({**row, "latency": 0.1} for row in rows)
    own = tuple({"index": i, "latency": 0.1, "v_red": 10.0 + i, **row} for i, row in enumerate(held))
    figure = plot_study([StudyTable(scenario="ima", rows=held)] * 2, egos=("v2v",), log=True)
    figure.canvas.draw()
    assert [axis.get_xlabel() for axis in figure.axes] == ["messages lost [-]"] * 2
    labels = [axis.get_xlabel() for axis in plot_study([StudyTable(scenario="own", rows=own)]).axes]
    assert labels == ["messages lost [-]", "v_red"]


def test_study_without_varying_samples() -> None:
    held = tuple({**row, "latency": 0.1, "loss": 0.0} for row in example_table().rows)
    (axis,) = plot_study([StudyTable(scenario="ima", rows=held)]).axes
    assert axis.get_xlabel() == "index"


def test_tables_with_different_samples_share_a_figure() -> None:
    held = tuple({**row, "latency": 0.1} for row in example_table().rows)
    figure = plot_study([example_table(), StudyTable(scenario="ima", rows=held)])
    assert [axis.axison for axis in figure.axes] == [True, True, True, False]


@pytest.mark.parametrize("change", [{"tables": []}, {"bins": 0}, {"egos": ("cat",)}])
def test_invalid_argument_raises(change: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(change))):
        plot_study(**{"tables": [example_table()], **change})

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
    own = tuple({"index": i, "v_red": 10.0 + i, **row} for i, row in enumerate(held))
    figure = plot_study([StudyTable(scenario="ima", rows=held)] * 2, egos=("v2v",), log=True)
    figure.canvas.draw()
    assert [axis.get_xlabel() for axis in figure.axes] == ["messages lost [-]"] * 2
    assert shown([StudyTable(scenario="own", rows=own)]) == ["v_red", "messages lost [-]"]
    assert shown([StudyTable(scenario="ima", rows=own)]) == ["messages lost [-]", "v_red [m/s]"]


def shown(tables: list[StudyTable], **arguments: Any) -> list[str]:
    """Labels of the panels of a figure."""
    return [axis.get_xlabel() for axis in plot_study(tables, **arguments).axes if axis.axison]


def own_table(**changes: Any) -> StudyTable:
    """Runs of a function with samples of its own, in the order of a study."""
    rng = np.random.default_rng(1)
    rows = [
        {
            "index": row["index"], "seed": 7 * row["index"], "friction": 0.8, "mass": 1.0, "latency": 0.1,
            "loss": 0.0, "mean_burst_length": rng.uniform(1.0, 10.0), "position_noise": 0.0,
            "gap": rng.uniform(0.5, 1.5), "dec": rng.uniform(4.0, 8.0), "case": "None",
            "t_hazard": rng.uniform(), **row, **{"latency": 0.1, "loss": 0.0}, **changes,
        }
        for row in example_table().rows
    ]  # fmt: skip
    return StudyTable(scenario="pile_up", rows=tuple(rows))


def test_own_samples_come_first() -> None:
    assert shown([own_table()]) == ["gap", "dec"]
    assert shown([own_table(gap=1.0)]) == ["dec"]  # without loss a burst has no length
    assert shown([own_table(gap=1.0, loss=0.3)]) == ["dec", "mean burst of losses [-]"]


def test_chosen_parameters_are_shown() -> None:
    assert shown([own_table()], parameters=("dec",)) == ["dec"]
    assert shown([own_table(), own_table()], parameters=["dec", "friction"]) == [
        "dec", "friction [-]", "dec", "friction [-]",
    ]  # fmt: skip
    labels = {"gap": "time gap [s]", "dec": "deceleration [m/s²]", "mass": "mass [-]"}
    assert shown([own_table()], parameters={}) == shown([own_table()])
    figure = plot_study([own_table()], parameters=labels)
    assert [axis.get_xlabel() for axis in figure.axes if axis.axison] == list(labels.values())
    assert figure.get_figheight() > plot_study([own_table()]).get_figheight()  # two panels in a row


def test_fixed_parameter_has_a_legible_axis() -> None:
    (axis,) = plot_study([own_table()], parameters=("friction",)).axes
    low, high = axis.get_xlim()
    assert 0.05 < high - low < 0.3
    assert low < 0.8 < high


def test_title_names_scenario_and_runs() -> None:
    titles = [
        plot_study([table]).axes[0].get_title(loc="left") for table in (own_table(), example_table())
    ]  # fmt: skip
    assert titles == ["Scenario pile up, 400 runs", "Occluded traffic at an intersection, 400 runs"]


@pytest.mark.parametrize("parameters", ["gap", ("gap", "speed"), ("case",), ("gap", "gap"), (1,), {"gap": 1}])
def test_parameters_that_cannot_be_shown_raise(parameters: Any) -> None:
    with pytest.raises(InputError, match=r"^parameters must "):
        plot_study([own_table()], parameters=parameters)


def test_parameter_without_a_number_in_some_runs_raises() -> None:
    with pytest.raises(InputError, match=r"^parameters must .* numbers in all runs, t_hazard has not"):
        plot_study([own_table(t_hazard=None)], parameters=("t_hazard",))


def test_study_without_varying_samples() -> None:
    held = tuple({**row, "latency": 0.1, "loss": 0.0} for row in example_table().rows)
    (axis,) = plot_study([StudyTable(scenario="ima", rows=held)]).axes
    assert axis.get_xlabel() == "number of the run [-]"


def test_tables_with_different_samples_share_a_figure() -> None:
    held = tuple({**row, "latency": 0.1} for row in example_table().rows)
    figure = plot_study([example_table(), StudyTable(scenario="ima", rows=held)])
    assert [axis.axison for axis in figure.axes] == [True, True, True, False]


@pytest.mark.parametrize("change", [{"tables": []}, {"bins": 0}, {"egos": ("cat",)}])
def test_invalid_argument_raises(change: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=next(iter(change))):
        plot_study(**{"tables": [example_table()], **change})

"""Texts of the figures of a report: none cut off, on another text or on a vehicle; and colors."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import pytest
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from cca_core import Lane, Road, VehicleParams
from cca_core.follow import shipped_gains, stability_margins
from cca_core.plot import (
    DEFECTS,
    fig_12,
    fig_15,
    plot_braking,
    plot_crossing,
    plot_defect,
    plot_layout,
    plot_margins,
    plot_passing,
    plot_time_series,
    plot_traffic,
    plot_tunings,
)
from cca_core.plot.style import COLORS, COLUMN_WIDTH, ROLE_COLORS, TEXT, VEHICLE_COLORS, assign_colors
from cca_core.report import report_figures
from cca_core.sim import Log, paper_scenarios
from tests.support.paper_runs import Run
from tests.support.sweeps import sweep

pytestmark = pytest.mark.requires("matplotlib")

GROUPS = {
    "eebl": [("eebl", "A", "driver"), ("eebl", "sensor", "sensor"), ("eebl", "C", "v2v")],
    "ima": [("ima", "left-turn", "driver"), ("ima", "left-turn", "v2v")],
    "curbside": [("curbside", "fast", "driver"), ("curbside", "fast", "v2v")],
    "case_3": [("maneuver", "3", "sensor"), ("maneuver", "3", "v2v")],
}
TOUCHING = 1.5  # overlap of two texts that is not visible [px]


def visible_texts(figure: Figure) -> Iterator[tuple[str, Bbox]]:
    """Texts of a figure and their extents [px]."""
    figure.draw_without_rendering()
    hidden = {
        id(label) for axis in figure.axes for side in (axis.xaxis, axis.yaxis)
        for tick in side.get_major_ticks()
        for label in (tick.label1, tick.label2)
        if not side.get_view_interval()[0] - 1e-9 <= tick.get_loc() <= side.get_view_interval()[1] + 1e-9
    }  # fmt: skip
    for text in figure.findobj(Text):
        if text.get_visible() and text.get_text().strip() and id(text) not in hidden:
            yield text.get_text(), Text.get_window_extent(text)


def overlap(a: Bbox, b: Bbox) -> float:
    """Smaller side of the common part of two boxes [px]."""
    both = Bbox.intersection(a, b)
    return 0.0 if both is None else min(both.width, both.height)


def faults(figure: Figure) -> list[str]:
    """Texts that are cut off or overlap."""
    texts = list(visible_texts(figure))
    width, height = figure.bbox.size
    found = [
        f"cut off: {text}" for text, box in texts
        if min(box.x0, box.y0) < -1.0 or box.x1 > width + 1.0 or box.y1 > height + 1.0
    ]  # fmt: skip
    pairs = combinations(texts, 2)
    return found + [f"{a[0]} on {b[0]}" for a, b in pairs if overlap(a[1], b[1]) > TOUCHING]


def texts_on_bodies(figure: Figure) -> list[str]:
    """Texts of an axis that cover a body."""
    found = []
    for axis in figure.axes:
        bodies = [patch for patch in axis.patches if "@" in (patch.get_gid() or "")]
        for text in (each for each in axis.texts if each.get_text() and each.get_visible()):
            box = Text.get_window_extent(text)
            on = [body.get_gid() for body in bodies if overlap(body.get_window_extent(), box) > TOUCHING]
            found += [f"{text.get_text()} on {name}" for name in on]
    return found


@pytest.mark.parametrize("name", sweep("eebl", "case_3", "ima", "curbside", quick=2))
def test_no_text_is_cut_off_or_on_another(run: Run, name: str) -> None:
    for figure in report_figures([run(*each) for each in GROUPS[name]]):
        assert faults(figure.figure) == [], figure.name
        assert texts_on_bodies(figure.figure) == [], figure.name
        assert figure.figure.get_figwidth() == COLUMN_WIDTH


def test_no_text_of_the_tunings_is_cut_off_or_on_another(run: Run) -> None:
    assert faults(plot_tunings(run("maneuver", "1-fast", "v2v"), run("maneuver", "1-smooth", "v2v"))) == []


@pytest.mark.parametrize("scenario", paper_scenarios(), ids=lambda s: f"{s.name}-{s.case}-{s.ego_type}")
def test_no_text_of_a_layout_is_on_a_body(scenario: object) -> None:
    figure = plot_layout(scenario)
    assert faults(figure) == []
    (axis,) = figure.axes
    bodies = [patch.get_window_extent() for patch in axis.patches if len(patch.get_xy()) == 5][-4:]
    texts = [Text.get_window_extent(text) for text in axis.texts if text.get_text()]
    assert max(overlap(body, text) for body in bodies[-2:] for text in texts) < TOUCHING


def test_each_role_has_one_color() -> None:
    ids = {user.id for scenario in paper_scenarios() for user in scenario.road_users}
    assert ids <= ROLE_COLORS.keys()
    for scenario in paper_scenarios():
        names = [user.id for user in scenario.road_users]
        assert assign_colors(names) == {id_: ROLE_COLORS[id_] for id_ in names}
    assert len({COLORS.ego, *ROLE_COLORS.values()}) == 1 + len(ROLE_COLORS)


def test_other_ids_do_not_take_the_color_of_a_role() -> None:
    colors = assign_colors(["R1", "van", "bus", "bike"])
    assert len(set(colors.values())) == 4
    assert COLORS.ego not in VEHICLE_COLORS


def test_texts_are_legible_on_a_phone() -> None:
    # a figure is 368 px wide on a screen of 400 px
    assert min(TEXT.tiny, TEXT.legend, TEXT.axis) / 72.0 * 368.0 / COLUMN_WIDTH > 8.0


def test_long_ids_and_many_vehicles_stay_legible(hostile: Log) -> None:
    for figure in report_figures([hostile]):
        assert len(list(visible_texts(figure.figure))) > 5


LONG = "a-van-with-a-very-long-name-of-its-own"


def renamed(log: Log, ids: list[str]) -> Log:
    """A run whose road users have other ids."""
    users = tuple(replace(u, id=id_, actions=()) for u, id_ in zip(log.scenario.road_users, ids, strict=True))
    return replace(log, scenario=replace(log.scenario, road_users=users, fixed_gap=None))


def legend_faults(figure: Figure) -> list[str]:
    """Texts of legends that are cut off or on another text."""
    texts = {text.get_text() for legend in figure.findobj(Legend) for text in legend.get_texts()}
    return [fault for fault in faults(figure) if any(text in fault for text in texts)]


def test_legends_of_many_actions_are_not_cut_off(run: Run) -> None:
    log = run("maneuver", "2", "v2v")
    names = "KEEP", "FOLLOW", "BRAKE", "EVADE_LEFT", "EVADE_RIGHT"
    decisions = tuple((float(log.t[0]) + k, name, "because") for k, name in enumerate(names))
    assert faults(plot_time_series(replace(log, decisions=decisions))) == []


def test_legends_of_long_ids_are_not_cut_off(run: Run) -> None:
    log = run("maneuver", "2", "v2v")
    named = renamed(log, [f"{LONG}-{i}" for i in range(len(log.scenario.road_users))])
    assert legend_faults(plot_time_series(named)) == []
    assert legend_faults(plot_traffic(named)) == []
    assert legend_faults(plot_braking([named, named])) == []
    parked = run("curbside", "fast", "v2v")
    ids = [f"{LONG} {user.id}" for user in parked.scenario.road_users]
    assert legend_faults(plot_passing([renamed(parked, ids)] * 2, f"{LONG} red")) == []
    crossing = run("ima", "left-turn", "v2v")
    ids = [f"{LONG} {user.id}" for user in crossing.scenario.road_users]
    assert legend_faults(plot_crossing([renamed(crossing, ids)] * 2)) == []


def test_legend_of_words_without_spaces_keeps_its_begin(run: Run) -> None:
    log = run("eebl", "C", "v2v")
    figure = plot_braking([renamed(log, ["x" * 400, "y"])])
    assert legend_faults(figure) == []
    texts = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert any(text.startswith("xxxx") and text.endswith("\N{HORIZONTAL ELLIPSIS}") for text in texts)


def test_no_text_of_bands_and_gains_is_cut_off_or_on_another() -> None:
    car = VehicleParams.bmw_320i()
    gains = shipped_gains(car)
    margins = [stability_margins(car, gains, v) for v in gains.speeds]
    for figure in (fig_12(), fig_15(), plot_margins(margins), *map(plot_defect, DEFECTS)):
        assert faults(figure) == []
        assert figure.get_figwidth() == COLUMN_WIDTH


@pytest.mark.parametrize("offsets", [(), (3.5,), (3.5, -3.5), (3.5, -3.5, -7.0)])
def test_no_text_of_the_traffic_on_some_lanes_is_cut_off(run: Run, offsets: tuple[float, ...]) -> None:
    log = run("eebl", "C", "v2v")
    lanes = [Lane(d=0.0), *(Lane(d=d, direction=-1 if d > 0.0 else 1) for d in offsets)]
    road = Road(log.scenario.road.path, lanes)
    assert faults(plot_traffic(replace(log, scenario=replace(log.scenario, road=road)))) == []

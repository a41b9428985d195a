"""Which figures tell of a scenario, each with a name and a caption: counterparts of the paper's figures."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cca_core.plot.braking import plot_braking
from cca_core.plot.crossing import plot_crossing
from cca_core.plot.figures import plot_time_series, plot_tunings
from cca_core.plot.layout import plot_layout
from cca_core.plot.passing import plot_passing
from cca_core.plot.style import ego_label
from cca_core.plot.traffic import plot_traffic
from cca_core.plot.verdict import baseline_and_v2v, group_by_case, one_run_per_ego
from cca_core.sim import Log

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["ReportFigure", "report_figures", "tuning_figure"]

_LAYOUTS = {"eebl": "fig05", "ima": "fig08", "curbside": "fig10"}
_FRAMES = {
    "eebl": "fig06", "curbside": "fig11",
    "1-fast": "fig13_14", "1-smooth": "fig13_14", "2": "fig16_17", "3": "fig18_19",
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReportFigure:
    """A figure that belongs to a scenario.

    Parameters
    ----------
    name : str
        Name of its file, without ending; it begins with the paper's figures that it is the counterpart of.
    caption : str
        What is to be seen.
    figure : Figure
        The figure.
    detail : bool
        Whether it is for those who want to know more.
    """

    name: str
    caption: str
    figure: "Figure"
    detail: bool = False


def report_figures(group: Sequence[Log]) -> Iterator[ReportFigure]:
    """Draw what tells of one scenario.

    Parameters
    ----------
    group : sequence of Log
        Its runs, as `grouped` sorts them.

    Yields
    ------
    plate : Plate
        First the layout, then the comparison, then frames and time series of the runs without and with V2V.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    shown, pair = one_run_per_ego(group), baseline_and_v2v(group)
    scenario = pair[-1].scenario
    cased = len({log.scenario.case for log in group}) == 1 and scenario.case is not None
    slug = f"{scenario.name}_{scenario.case}" if cased else scenario.name
    slug = re.sub(r"\W", "_", slug, flags=re.ASCII).lower()
    yield ReportFigure(
        name="_".join(filter(None, (_LAYOUTS.get(scenario.name, ""), slug, "layout"))),
        caption="At the start. The dotted line is the ego's route; arrows are the way in a second.",
        figure=plot_layout(scenario),
    )
    if scenario.name == "eebl":
        yield ReportFigure(
            name="fig06_07_eebl_bumper_to_bumper", figure=plot_braking(shown),
            caption="Each band reaches from the rear to the front bumper of a vehicle; where two bands meet "
            "the vehicles touch. Below, speeds and decelerations. Counterpart of Figs 6 and 7.",
        )  # fmt: skip
    elif scenario.other_roads and scenario.road_users:
        yield ReportFigure(
            name=f"fig09_{slug}_from_above", figure=plot_crossing(pair),
            caption="Bodies each second, numbered by the time in seconds, and below the ego's way over time: "
            "it must not enter the red patch, where it would touch another. Counterpart of Fig 9.",
        )  # fmt: skip
    standing = next((user.id for user in scenario.road_users if user.v_x == 0.0 and user.route is None), None)
    if standing is not None:
        yield ReportFigure(
            name=f"fig11_12_{slug}_ways", figure=plot_passing(shown, standing),
            caption=f"How the ego comes to {standing}: bodies each half second, to scale, then the ego's "
            "ways with the width drawn larger. Counterpart of Figs 11 and 12.",
        )  # fmt: skip
    if not scenario.other_roads:
        frames = _FRAMES.get(scenario.case or "", _FRAMES.get(scenario.name, ""))
        for log in pair:
            yield ReportFigure(
                name="_".join(filter(None, (frames, slug, log.scenario.ego_type, "frames"))),
                caption=f"{_sentence(ego_label(log))}: path and traffic. Equal numbers belong to one "
                "moment. In the strips the solid line is where the ego was, the dotted where it will be.",
                figure=plot_traffic(log), detail=scenario.name != "maneuver" or not log.scenario.v2v,
            )  # fmt: skip
    for log in pair:
        yield ReportFigure(
            name=f"{slug}_{log.scenario.ego_type}_over_time", figure=plot_time_series(log), detail=True,
            caption=f"{_sentence(ego_label(log))}: the run over time; the background shows the action.",
        )  # fmt: skip


def tuning_figure(logs: Sequence[Log]) -> ReportFigure | None:
    """Draw the two tunings of case 1 on one axis, if both were run with V2V.

    Parameters
    ----------
    logs : sequence of Log
        Any runs.

    Returns
    -------
    plate : Plate or None
        Counterpart of Fig 15.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    found = {group[0].scenario.case: baseline_and_v2v(group)[-1] for group in group_by_case(logs)}
    fast, smooth = found.get("1-fast"), found.get("1-smooth")
    if fast is None or smooth is None or not (fast.scenario.v2v and smooth.scenario.v2v):
        return None
    return ReportFigure(
        name="fig15_two_tunings", figure=plot_tunings(fast, smooth),
        caption="Tuned fast, the car leaves its lane later and changes over in less distance, with more "
        "lateral acceleration; tuned smooth, it takes more road. Counterpart of Fig 15.",
    )  # fmt: skip


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:]

"""The figures of a scenario, each with a name and a caption: counterparts of the paper's figures."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from cca_core.plot import (
    plot_braking,
    plot_crossing,
    plot_layout,
    plot_passing,
    plot_time_series,
    plot_traffic,
    plot_tunings,
)
from cca_core.plot.labels import begin_sentence, ego_label
from cca_core.report.narrative import describe_run, summarize_outcome
from cca_core.report.selection import baseline_and_v2v, compared_runs, group_by_case
from cca_core.sim import Log, RoadUser, Scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReportFigure:
    """A figure that belongs to a scenario.

    Parameters
    ----------
    name : str
        Name of its file, without ending; it begins with the paper's figures that it is the counterpart of.
    caption : str
        What the figure shows.
    figure : Figure
        The figure.
    detail : bool
        Whether the report shows it among the details.
    """

    name: str
    caption: str
    figure: "Figure"
    detail: bool = False


def report_figures(group: Sequence[Log]) -> Iterator[ReportFigure]:
    """Draw the figures of one scenario.

    Parameters
    ----------
    group : sequence of Log
        Its runs, as `group_by_case` sorts them.

    Yields
    ------
    figure : ReportFigure
        First the layout, then the comparison, then frames and time series of the runs without and with V2V.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    pair = baseline_and_v2v(group)
    scenario = pair[-1].scenario
    has_case = len({log.scenario.case for log in group}) == 1 and scenario.case is not None
    slug = f"{scenario.name}_{scenario.case}" if has_case else scenario.name
    slug = re.sub(r"\W", "_", slug, flags=re.ASCII).lower()
    # the paper shows a layout of each scenario but maneuvering, and no comparison there
    n_layouts = 0 if scenario.name == "maneuver" else 1
    frames = scenario.paper_figures[n_layouts:2]
    yield ReportFigure(
        name=_file_name(scenario.paper_figures[:n_layouts], slug, "layout"),
        figure=plot_layout(_at_start(pair[-1])),
        caption="The start. The dotted line is the ego's route; arrows show the directions.",
    )  # fmt: skip
    yield from _comparison(compared_runs(group), pair, slug)
    for log in pair if not scenario.other_roads else ():
        yield ReportFigure(
            name=_file_name(frames, slug, log.scenario.ego_type, "frames"),
            caption=f"{begin_sentence(ego_label(log))}: path and traffic. Equal numbers belong to one "
            "time. In the strips the ego's path is solid behind it and dotted ahead of it.",
            figure=plot_traffic(log, caption=describe_run(log)),
            detail=scenario.name != "maneuver" or not log.scenario.v2v,
        )
    for log in pair:
        yield ReportFigure(
            name=f"{slug}_{log.scenario.ego_type}_over_time", figure=plot_time_series(log), detail=True,
            caption=f"{begin_sentence(ego_label(log))}: the run over time; the bar on top shows the action.",
        )  # fmt: skip


def _comparison(runs: Sequence[Log], pair: Sequence[Log], slug: str) -> Iterator[ReportFigure]:
    """Figures of several runs at once."""
    scenario = pair[-1].scenario
    numbers = scenario.paper_figures[1:]
    if scenario.name == "eebl":
        yield ReportFigure(
            name=_file_name(numbers, slug, "bumper_to_bumper"),
            figure=plot_braking(runs, outcomes=list(map(summarize_outcome, runs))),
            caption="Each band reaches from the rear to the front bumper of a vehicle. Where two bands meet, "
            "the vehicles collide. Below: speed and acceleration of the ego. Counterpart of Figs 6 and 7.",
        )
    elif scenario.other_roads and scenario.road_users:
        yield ReportFigure(
            name=_file_name(numbers, slug, "from_above"),
            figure=plot_crossing(pair, outcomes=list(map(summarize_outcome, pair))),
            caption="Bodies every two seconds, labeled with the time; below, the ego over time. "
            "In the red area the ego would collide. Counterpart of Fig 9.",
        )
    parked = next((user.id for user in scenario.road_users if _is_parked(runs, user)), None)
    if parked is not None:
        yield ReportFigure(
            name=_file_name(numbers, slug, "paths"),
            figure=plot_passing(runs, parked, outcomes=list(map(summarize_outcome, runs))),
            caption=f"How the ego passes {parked}: bodies each second, to scale, then the ego's "
            "paths with the width drawn larger. Counterpart of Figs 11 and 12.",
        )


def _at_start(log: Log) -> Scenario:
    """Scenario of a run with the road users that are on the road when it begins."""
    scenario = log.scenario
    if log.remotes is None:  # simulated: all are there from the start
        return scenario
    users = tuple(
        user
        for user, is_present in zip(scenario.road_users, log.present[0], strict=True)
        if is_present and user.route is None
    )
    return replace(scenario, road_users=users)


def _is_parked(logs: Sequence[Log], user: RoadUser) -> bool:
    """Return whether a road user stands on the ego's route in all runs."""
    if user.v_x != 0.0 or user.route is not None:
        return False
    for log in logs:
        ids = [each.id for each in log.scenario.road_users]
        if user.id not in ids:
            return False
        i = ids.index(user.id)
        if np.nanmax(np.abs(log.road_users[:, i, 3])) > 0.0:
            return False
    return True


def _file_name(numbers: Sequence[int], *parts: str) -> str:
    prefix = ["fig" + "_".join(f"{number:02d}" for number in numbers)] if numbers else []
    return "_".join([*prefix, *parts])


def tuning_figure(logs: Sequence[Log]) -> ReportFigure | None:
    """Draw the two tunings of case 1 on one axis, if both were run with V2V.

    Parameters
    ----------
    logs : sequence of Log
        Any runs.

    Returns
    -------
    figure : ReportFigure or None
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
        caption="With the fast tuning the ego leaves its lane later and changes lane over a shorter "
        "distance, with more lateral acceleration. Counterpart of Fig 15.",
    )  # fmt: skip

"""A report on a set of runs: outcomes, narratives, figures and animations on one page (extra ``plot``)."""

from cca_core.report.animation import animate
from cca_core.report.figures import ReportFigure, report_figures, tuning_figure
from cca_core.report.narrative import (
    describe_outcome,
    describe_participants,
    describe_run,
    headline,
    summarize_outcome,
    vehicles_waited_for,
)
from cca_core.report.page import write_report
from cca_core.report.selection import baseline_and_v2v, group_by_case, one_run_per_ego

__all__ = [
    "ReportFigure",
    "animate",
    "baseline_and_v2v",
    "describe_outcome",
    "describe_participants",
    "describe_run",
    "group_by_case",
    "headline",
    "one_run_per_ego",
    "report_figures",
    "summarize_outcome",
    "tuning_figure",
    "vehicles_waited_for",
    "write_report",
]

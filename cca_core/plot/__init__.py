"""Pictures of bands and of runs: scenarios, traffic, time, animations, a report (extra ``plot``)."""

from cca_core.plot.animation import animate
from cca_core.plot.bands import fig_12, fig_15
from cca_core.plot.braking import plot_braking
from cca_core.plot.commonroad import plot_commonroad
from cca_core.plot.comparison import plot_growth, plot_plans, plot_time_quality
from cca_core.plot.crossing import plot_crossing
from cca_core.plot.defects import DEFECTS, plot_defect
from cca_core.plot.figures import first_lane_change, lead_speed, plot_time_series, plot_tunings
from cca_core.plot.gains import plot_gain_region, plot_margins
from cca_core.plot.gallery import ReportFigure, report_figures, tuning_figure
from cca_core.plot.layout import plot_layout
from cca_core.plot.passing import plot_passing
from cca_core.plot.report import headline, write_report
from cca_core.plot.story import (
    KeyFrame,
    describe_outcome,
    describe_participants,
    describe_run,
    key_frames,
    vehicles_waited_for,
)
from cca_core.plot.study import plot_study
from cca_core.plot.style import title
from cca_core.plot.traffic import plot_traffic
from cca_core.plot.verdict import (
    Collision,
    baseline_and_v2v,
    first_collision,
    group_by_case,
    one_run_per_ego,
    summarize_outcome,
)

__all__ = [
    "DEFECTS",
    "Collision",
    "KeyFrame",
    "ReportFigure",
    "animate",
    "baseline_and_v2v",
    "describe_outcome",
    "describe_participants",
    "describe_run",
    "fig_12",
    "fig_15",
    "first_collision",
    "first_lane_change",
    "group_by_case",
    "headline",
    "key_frames",
    "lead_speed",
    "one_run_per_ego",
    "plot_braking",
    "plot_commonroad",
    "plot_crossing",
    "plot_defect",
    "plot_gain_region",
    "plot_growth",
    "plot_layout",
    "plot_margins",
    "plot_passing",
    "plot_plans",
    "plot_study",
    "plot_time_quality",
    "plot_time_series",
    "plot_traffic",
    "plot_tunings",
    "report_figures",
    "summarize_outcome",
    "title",
    "tuning_figure",
    "vehicles_waited_for",
    "write_report",
]  # fmt: skip

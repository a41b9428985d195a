"""Pictures of bands and of runs: traffic, tunings, time series, and a report (matplotlib, extra ``plot``)."""

from cca_core.plot.bands import fig_12, fig_15
from cca_core.plot.defects import DEFECTS, plot_defect
from cca_core.plot.figures import lane_change, leader_speed, plot_time_series, plot_tunings
from cca_core.plot.gains import plot_gain_region, plot_margins
from cca_core.plot.report import write_report
from cca_core.plot.story import Frame, awaited, cast, outcome, story, telling_frames
from cca_core.plot.traffic import plot_traffic

__all__ = [
    "DEFECTS", "Frame", "awaited", "cast", "fig_12", "fig_15", "lane_change", "leader_speed", "outcome",
    "plot_defect", "plot_gain_region", "plot_margins",
    "plot_time_series", "plot_traffic", "plot_tunings", "story", "telling_frames", "write_report",
]  # fmt: skip

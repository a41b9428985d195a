"""Pictures of runs: traffic, tunings, time series, and a report (matplotlib, extra ``plot``)."""

from cca_core.plot.figures import lane_change, leader_speed, plot_time_series, plot_tunings
from cca_core.plot.gains import plot_gain_region, plot_margins
from cca_core.plot.report import write_report
from cca_core.plot.story import Frame, awaited, cast, outcome, story, telling_frames
from cca_core.plot.traffic import plot_traffic

__all__ = [
    "Frame", "awaited", "cast", "lane_change", "leader_speed", "outcome", "plot_gain_region", "plot_margins",
    "plot_time_series", "plot_traffic", "plot_tunings", "story", "telling_frames", "write_report",
]  # fmt: skip

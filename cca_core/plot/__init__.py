"""Figures of bands, runs, gains, studies and planning methods (extra ``plot``); SVG needs no extra."""

from cca_core.plot.bands import fig_12, fig_15
from cca_core.plot.braking import plot_braking
from cca_core.plot.commonroad import plot_commonroad
from cca_core.plot.comparison import plot_plans, plot_scaling, plot_time_quality
from cca_core.plot.crossing import plot_crossing
from cca_core.plot.defects import DEFECTS, plot_defect
from cca_core.plot.gains import plot_gain_region, plot_margins
from cca_core.plot.labels import title
from cca_core.plot.layout import plot_layout
from cca_core.plot.passing import plot_passing
from cca_core.plot.study import plot_study
from cca_core.plot.svg import to_svg
from cca_core.plot.time_series import plot_time_series
from cca_core.plot.traffic import plot_traffic
from cca_core.plot.tunings import plot_tunings

__all__ = [
    "DEFECTS",
    "fig_12",
    "fig_15",
    "plot_braking",
    "plot_commonroad",
    "plot_crossing",
    "plot_defect",
    "plot_gain_region",
    "plot_layout",
    "plot_margins",
    "plot_passing",
    "plot_plans",
    "plot_scaling",
    "plot_study",
    "plot_time_quality",
    "plot_time_series",
    "plot_traffic",
    "plot_tunings",
    "title",
    "to_svg",
]

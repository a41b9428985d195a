"""Roads: local frame, waypoints, cleaning, smooth paths, lanes."""

from cca_core.path.clean import CleanedRoute, CleaningReport, clean_route
from cca_core.path.fit import fit_path
from cca_core.path.fit_report import FitReport
from cca_core.path.interpolate import interpolate_path, splice_path
from cca_core.path.join import join_roads
from cca_core.path.lane import Lane
from cca_core.path.local_frame import LocalFrame
from cca_core.path.path import Path
from cca_core.path.road import Road
from cca_core.path.waypoints import Waypoints, read_waypoints

__all__ = [
    "CleanedRoute",
    "CleaningReport",
    "FitReport",
    "Lane",
    "LocalFrame",
    "Path",
    "Road",
    "Waypoints",
    "clean_route",
    "fit_path",
    "interpolate_path",
    "join_roads",
    "read_waypoints",
    "splice_path",
]  # fmt: skip

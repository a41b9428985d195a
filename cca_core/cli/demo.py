"""``cca demo``: the paper's four scenarios, with and without V2V.

The first three scenarios have roads of their own. The road of the fourth, maneuvering in traffic, is the
longest part without tight curves of a route in GPS coordinates.
"""

import argparse
from dataclasses import replace
from importlib.util import find_spec

import numpy as np

from cca_core.cli.results import drive_all, print_table, write_results
from cca_core.errors import InputError
from cca_core.path import LocalFrame, Path, Waypoints, fit_path, read_waypoints
from cca_core.sim import demo_route, eebl, longest_stretch, paper_scenarios

__all__ = ["run"]

_NAMES = "eebl", "ima", "curbside", "maneuver"
_MIN_RADIUS = 200.0  # of the fourth scenario's road [m]
_MARGIN = 220.0  # road behind the ego's start, for the fast car of case 2 [m]


def run(given: argparse.Namespace) -> int:
    """Drive, write and print; return the exit code."""
    if given.only not in (None, *_NAMES):
        raise InputError(f"--only must be one of {', '.join(_NAMES)}, was {given.only!r}")
    road = _fit_road(demo_route() if given.route is None else read_waypoints(given.route), given.km)
    scenarios = paper_scenarios(road, start=road.start + _MARGIN)
    # between this run and the one with the sensor alone only the messages to the ego change
    only_ego = replace(eebl("sensor"), case="B-hard", ego_type="v2v")
    chosen = [scenario for scenario in (*scenarios, only_ego) if given.only in (None, scenario.name)]
    runs = [("single_track", scenario) for scenario in chosen]
    if find_spec("vehiclemodels"):
        runs += [
            ("multi_body", scenario)
            for scenario in chosen
            if scenario.ego_type != "sensor" and scenario is not only_ego
        ]
    logs = drive_all(runs, given.seed)
    print_table(logs)
    write_results(logs, given.out)
    return 0


def _fit_road(waypoints: Waypoints, km: float) -> Path:
    """Fit a path to GPS coordinates; return its longest part without tight curves."""
    if not len(waypoints.lat):
        raise InputError("--route must have latitude and longitude, had x and y")
    xy = LocalFrame(waypoints.lat[0], waypoints.lon[0]).to_local(waypoints.lat, waypoints.lon)
    distance = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))))
    xy = xy[distance <= 1000.0 * km]
    path = fit_path(xy, tolerance=0.3)
    start, end = longest_stretch(path, radius=_MIN_RADIUS)
    print(
        f"{waypoints.duplicates} duplicates dropped, {len(xy)} points on {path.length / 1000.0:.1f} km used"
    )
    print(f"longest stretch with radius over {_MIN_RADIUS:.0f} m: from {start:.0f} m to {end:.0f} m")
    return path.cut(start, end)

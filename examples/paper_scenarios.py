"""Simulate the paper's four scenarios, with and without V2V, and report the results.

The first three scenarios have roads of their own. The road of the fourth, maneuvering in traffic, is the
longest part without tight curves of a route in GPS coordinates. Writes summary.json, the figures and
report.html.
"""

import argparse
import json
import sys
from importlib.util import find_spec
from pathlib import Path as FilePath

import numpy as np
from tqdm import tqdm

from cca_core import InputError, LocalFrame, Path, fit_path
from cca_core.path import Waypoints, read_waypoints
from cca_core.plot import title
from cca_core.report import group_by_case, headline, summarize_outcome, write_report
from cca_core.sim import Log, Scenario, demo_route, longest_stretch, paper_scenarios, simulate

MIN_RADIUS = 200.0  # of the fourth scenario's road [m]
MARGIN = 220.0  # road behind the ego's start, for the fast car of case 2 [m]


def main() -> int:
    """Run all scenarios; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=FilePath, default=FilePath("out"), help="folder for the results")
    parser.add_argument("--route", type=FilePath, help="GPX or CSV file; default: 2.5 km of Interstate 80")
    parser.add_argument("--km", type=float, default=20.0, help="length of the route to use [km]")
    parser.add_argument("--seed", type=int, default=1, help="seed of the messages")
    args = parser.parse_args()
    try:
        road = fit_road(demo_route() if args.route is None else read_waypoints(args.route), args.km)
        scenarios = paper_scenarios(road, start=road.start + MARGIN)
    except InputError as error:
        print(f"This route cannot be used: {error}", file=sys.stderr)
        return 2
    logs = simulate_all(scenarios, args.seed)
    args.out.mkdir(parents=True, exist_ok=True)
    summary = {"runs": [log.summary() for log in logs]}
    (args.out / "summary.json").write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    with tqdm(total=len(group_by_case(logs)), unit="scenario", desc="drawing", disable=None) as bar:
        write_report(logs, args.out / "report.html", figures=args.out, progress=lambda: bar.update())
    print_table(logs)
    print(f"Open {args.out / 'report.html'}")
    return 0


def fit_road(waypoints: Waypoints, km: float) -> Path:
    """Fit a path to GPS coordinates; return its longest part without tight curves."""
    xy = LocalFrame(waypoints.lat[0], waypoints.lon[0]).to_local(waypoints.lat, waypoints.lon)
    distance = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))))
    xy = xy[distance <= 1000.0 * km]
    path = fit_path(xy, tolerance=0.3)
    start, end = longest_stretch(path, radius=MIN_RADIUS)
    print(
        f"{waypoints.duplicates} duplicates dropped, {len(xy)} points on {path.length / 1000.0:.1f} km used"
    )
    print(f"longest stretch with radius over {MIN_RADIUS:.0f} m: from {start:.0f} m to {end:.0f} m")
    return path.cut(start, end)


def simulate_all(scenarios: list[Scenario], seed: int) -> list[Log]:
    """Simulate each scenario, with V2V or a driver on the multi-body plant too, with a progress bar."""
    runs = [("single_track", s) for s in scenarios]
    if find_spec("vehiclemodels"):
        runs += [("multi_body", s) for s in scenarios if s.ego_type != "sensor"]
    seconds = sum(scenario.duration for _, scenario in runs)
    style = "{desc} {percentage:3.0f}%|{bar}| {n:.0f} of {total:.0f} s [{elapsed}]"
    logs = []
    with tqdm(total=seconds, desc="driving", bar_format=style, disable=None) as bar:
        for plant, scenario in runs:
            begin = bar.n
            logs.append(
                simulate(
                    scenario, plant=plant, seed=seed,
                    progress=lambda t, begin=begin: bar.update(begin + t - bar.n),
                )
            )  # fmt: skip
            bar.update(begin + scenario.duration - bar.n)
    return logs


def print_table(logs: list[Log]) -> None:
    """Print a table of the runs, and the effect of V2V."""
    groups = group_by_case(logs)
    print(f"{'run':66} {'plant':13} {'min. gap':>9} {'peak a_y':>10} {'speed-up':>8}  outcome")
    for log in (log for group in groups for log in group):
        key = log.summary()
        gap = "-" if key["min_gap_m"] is None else f"{max(key['min_gap_m'], 0.0):.2f} m"
        print(
            f"{title(log):66} {log.plant:13} {gap:>9} {abs(log.a_y).max():>5.2f} m/s2 "
            f"{key['realtime_factor']:>7.0f}x  {summarize_outcome(log)}"
        )
    print(headline(groups))


if __name__ == "__main__":
    sys.exit(main())

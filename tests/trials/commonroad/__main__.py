"""Print what is solved of the files of a folder: ``python -m tests.trials.commonroad FOLDER``."""

import argparse
import math
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from cca_core import EvasionSettings, InputError
from cca_core.adapters import read_commonroad_map
from cca_core.errors import InfeasibleError
from cca_core.follow import SpeedSettings
from cca_core.planner import CertificateSettings
from cca_core.sim import CommonRoadRun, drive_commonroad
from tests.trials import commonroad
from tests.trials.commonroad.brute_force import min_gap, solve

# late braking, gaps of 0.1 m, and other vehicles that keep their motion: not for a road
CLOSE = SpeedSettings(b_comfort=4.0, standstill_gap=0.2, time_gap=0.01, approach_rate=3.0, jerk=12.0)
TRUSTING = replace(EvasionSettings.paper(), certificate=CertificateSettings(touch=0.1, margin=0.0))
OUTCOMES = "both", "brute force alone", "the library alone", "neither", "not driven"


def row(file: Path) -> tuple[str, str, str, str, str]:
    """Return scenario, results of brute force and library, result with small gaps, and a reason."""
    try:
        scenario = read_commonroad_map(file)
        run = drive_commonroad(scenario)
    except (InputError, InfeasibleError) as error:
        return file.stem, "-", "-", "-", str(error)
    profile = solve(run)
    solved = "none"
    if profile is not None:
        solved = f"{profile.t[-1]:.1f} s, gap {min_gap(run, profile):.1f} m"
    if run.summary()["reached"]:
        return file.stem, solved, f"{run.t_goal:.1f} s", "", ""
    close = "" if profile is None else outcome(drive_commonroad(scenario, speed=CLOSE, evasion=TRUSTING))
    return file.stem, solved, outcome(run), close, reason(run)


def outcome(run: CommonRoadRun) -> str:
    """Return when a run reached its goal, or why it did not."""
    if run.summary()["reached"]:
        return f"{run.t_goal:.1f} s"
    return f"{struck_by(run)} collides" if run.gaps.min(initial=math.inf) <= 0.0 else "not reached"


def struck_by(run: CommonRoadRun) -> str:
    """Return the first vehicle that the ego collides with, and where it is then."""
    k, i = (int(found[0]) for found in np.nonzero(run.gaps <= 0.0))
    other = run.scenario.obstacles[i].at(float(run.t[k]))
    x, y, psi = run.ego[k, :3].tolist()
    assert other is not None
    ahead = (other.x - x) * math.cos(psi) + (other.y - y) * math.sin(psi)
    half = 0.5 * (run.vehicle.length + other.length) - 0.5
    where = "ahead" if ahead > half else "behind" if ahead < -half else "beside"
    return f"{other.id} ({where}, {other.v_x:.1f} m/s, ego {run.ego[k, 3]:.1f} m/s)"


def reason(run: CommonRoadRun) -> str:
    """Return the longest action of a run with its reason."""
    starts = [t for t, _, _ in run.decisions]
    lasted = np.diff([*starts, float(run.t[-1])])
    text = run.decisions[int(np.argmax(lasted))][2]
    return f"cruise {run.cruise_speed:.1f} m/s; {text}"


def kind(cells: tuple[str, ...]) -> str:
    """Return who solves a scenario."""
    if cells[1] == "-":
        return "not driven"
    by_force, by_library = cells[1] != "none", cells[2].endswith(" s")
    return {
        (True, True): "both",
        (True, False): "brute force alone",
        (False, True): "the library alone",
        (False, False): "neither",
    }[by_force, by_library]


def main() -> None:
    """Drive the files that the command line names."""
    parser = argparse.ArgumentParser(prog="python -m tests.trials.commonroad", description=commonroad.__doc__)
    parser.add_argument("files", nargs="+", type=Path, help="files, or folders of files")
    given = parser.parse_args()
    files = [f for g in given.files for f in (sorted(g.rglob("*.xml")) if g.is_dir() else [g])]
    warnings.simplefilter("ignore")  # of curves that are too tight, which the reasons name
    print("scenario | brute force | library | library, close | its longest action")
    kinds = []
    for file in files:
        cells = row(file)
        print(" | ".join(cells), flush=True)
        kinds.append(kind(cells))
    print(", ".join(f"{name}: {kinds.count(name)}" for name in OUTCOMES))


main()

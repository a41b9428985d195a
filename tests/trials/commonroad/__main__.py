"""Print what is solved of the files of a folder: ``python -m tests.trials.commonroad FOLDER``."""

import argparse
from pathlib import Path

from cca_core import InputError
from cca_core.errors import InfeasibleError
from cca_core.sim import drive_commonroad, read_commonroad
from tests.trials import commonroad
from tests.trials.commonroad.brute_force import solve


def row(file: Path) -> tuple[str, str, str, str]:
    """Return scenario, result of the brute force, result of the library, and its reason."""
    try:
        scenario = read_commonroad(file)
        run = drive_commonroad(scenario)
    except (InputError, InfeasibleError) as error:
        return file.stem, "-", "-", f"not driven: {error}"
    summary = run.summary()
    profile = solve(run)
    solved = "none" if profile is None else f"{profile.t[-1]:.1f} s"
    if summary["reached"]:
        return file.stem, solved, f"{summary['t_goal_s']:.1f} s", ""
    outcome = "collision" if summary["collided_with"] else "not reached"
    text = f"cruise {run.cruise_speed:.1f} m/s"
    if summary["collided_with"]:
        text += f", {', '.join(summary['collided_with'])}"
    reasons = [reason for _, _, reason in run.decisions]
    return file.stem, solved, outcome, f"{text}; {reasons[-1]}"


def main() -> None:
    """Drive the files that the command line names."""
    parser = argparse.ArgumentParser(prog="python -m tests.trials.commonroad", description=commonroad.__doc__)
    parser.add_argument("files", nargs="+", type=Path, help="files, or folders of files")
    given = parser.parse_args()
    files = [f for g in given.files for f in (sorted(g.rglob("*.xml")) if g.is_dir() else [g])]
    print("scenario | brute force | library | of the library")
    counts = {"both": 0, "brute force alone": 0, "library alone": 0, "neither": 0, "not driven": 0}
    for file in files:
        cells = row(file)
        print(" | ".join(cells), flush=True)
        if cells[1] == "-":
            key = "not driven"
        elif cells[1] == "none":
            key = "library alone" if cells[2].endswith(" s") else "neither"
        else:
            key = "both" if cells[2].endswith(" s") else "brute force alone"
        counts[key] += 1
    print(", ".join(f"{key}: {n}" for key, n in counts.items()))


main()

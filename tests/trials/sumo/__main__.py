"""Print the table of figures: ``python -m tests.trials.sumo --seeds 0:8 [--radio] [--baseline]``."""

import argparse
import tempfile
from pathlib import Path

from tests.trials import sumo
from tests.trials.sumo.episode import baseline, episode
from tests.trials.sumo.metrics import COLUMNS, table_row
from tests.trials.sumo.nets import SCENARIOS


def main() -> None:
    """Run the scenarios and seeds that the command line names."""
    parser = argparse.ArgumentParser(prog="python -m tests.trials.sumo", description=sumo.__doc__)
    parser.add_argument("--scenario", default=",".join(SCENARIOS), help="names, separated by commas")
    parser.add_argument("--seeds", default="0:2", help="first:last, without the last")
    parser.add_argument("--duration", type=float, default=75.0, help="of an episode [s]")
    parser.add_argument("--radio", action="store_true", help="the ego knows other vehicles by messages only")
    parser.add_argument("--baseline", action="store_true", help="drive SUMO's own driver as well")
    given = parser.parse_args()
    seeds = range(*map(int, given.seeds.split(":")))
    print(" | ".join(COLUMNS))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for scenario in given.scenario.split(","):
            driven = [episode(scenario, seed, folder, given.duration, given.radio) for seed in seeds]
            compared = seeds if given.baseline else ()
            speeds = [baseline(scenario, seed, folder, given.duration) for seed in compared]
            print(table_row(scenario, driven, SCENARIOS[scenario].cruise_speed, speeds), flush=True)


main()

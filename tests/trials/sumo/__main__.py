"""Print the table of figures: ``python -m tests.trials.sumo --seeds 0:8 [--radio] [--baseline] ...``."""

import argparse
import tempfile
from pathlib import Path

from tests.trials import sumo
from tests.trials.sumo.episode import DESIRED, baseline, episode
from tests.trials.sumo.metrics import COLUMNS, table_row


def main() -> None:
    """Run the scenarios and seeds that the command line names."""
    parser = argparse.ArgumentParser(prog="python -m tests.trials.sumo", description=sumo.__doc__)
    parser.add_argument("--scenario", default=",".join(DESIRED), help="names, separated by commas")
    parser.add_argument("--seeds", default="0:2", help="first:last, without the last")
    parser.add_argument("--duration", type=float, default=75.0, help="of an episode on one edge [s]")
    parser.add_argument("--radio", action="store_true", help="the ego knows other vehicles by messages only")
    parser.add_argument("--baseline", action="store_true", help="drive SUMO's own driver as well")
    parser.add_argument("--keep-lane", action="store_true", help="change lanes only to pass")
    given = parser.parse_args()
    seeds = range(*map(int, given.seeds.split(":")))
    print(" | ".join(COLUMNS))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for scenario in given.scenario.split(","):
            longest = 4.0 * given.duration if scenario == "network" else given.duration
            driven = [
                episode(scenario, seed, folder, longest, by_radio=given.radio, keep_lane=given.keep_lane)
                for seed in seeds
            ]
            compared = seeds if given.baseline else ()
            speeds = [baseline(scenario, seed, folder, longest) for seed in compared]
            print(table_row(scenario, driven, DESIRED[scenario], speeds), flush=True)


main()

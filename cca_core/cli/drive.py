"""``cca drive``: one run of a scenario that a file describes."""

import argparse
import sys
from dataclasses import replace
from importlib.resources import files
from pathlib import Path as FilePath

from cca_core.cli.results import drive_all, print_table, write_results
from cca_core.cli.scenario_file import read_scenario
from cca_core.report import describe_run
from cca_core.sim import EGO_TYPES

__all__ = ["run"]


def run(given: argparse.Namespace) -> int:
    """Drive, write and print; return the exit code."""
    if given.template:
        sys.stdout.write((files(__package__) / "template.toml").read_text(encoding="utf-8"))
        return 0
    scenario, plant = read_scenario(given.scenario)
    types = EGO_TYPES if given.ego == "all" else (given.ego or scenario.ego_type,)
    runs = [(given.plant or plant, replace(scenario, ego_type=ego_type)) for ego_type in types]
    logs = drive_all(runs, given.seed)
    print_table(logs)
    for log in logs:
        print(f"{log.scenario.ego_type}: {describe_run(log)}")
    write_results(logs, given.out or FilePath("out") / given.scenario.stem)
    return 0

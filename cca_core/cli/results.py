"""Files and tables of runs."""

import json
import re
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path as FilePath

from cca_core.cli.progress import ProgressBar
from cca_core.errors import MissingExtraError
from cca_core.plot.labels import title
from cca_core.report import group_by_case, headline, summarize_outcome, write_report
from cca_core.sim import Log, Scenario, save_log, simulate

__all__ = ["draw_report", "drive_all", "print_table", "write_results"]


def drive_all(runs: Sequence[tuple[str, Scenario]], seed: int | None) -> list[Log]:
    """Simulate pairs of a plant and a scenario."""
    logs: list[Log] = []
    begin = 0.0
    with ProgressBar("driving", sum(scenario.duration for _, scenario in runs), "s") as bar:
        for plant, scenario in runs:
            advance = partial(_advance, bar, begin)
            logs.append(simulate(scenario, plant=plant, seed=seed, progress=advance))
            begin += scenario.duration
            bar.advance(begin)
    return logs


def _advance(bar: ProgressBar, begin: float, t: float) -> None:
    bar.advance(begin + t)


def write_results(logs: Sequence[Log], folder: FilePath) -> None:
    """Write logs, key figures and the report into a folder, the report only if it can be drawn."""
    folder.mkdir(parents=True, exist_ok=True)
    summary = {"runs": [log.summary() for log in logs]}
    (folder / "summary.json").write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    for i, log in enumerate(logs):
        save_log(log, folder / f"{_file_name(i, log)}.npz")
    try:
        draw_report(logs, folder / "report.html", folder)
    except MissingExtraError as error:
        sys.stderr.write(f"no report: {error}; then: cca report {folder}\n")
    else:
        print(f"Open {folder / 'report.html'}")


def draw_report(logs: Sequence[Log], file: FilePath, figures: FilePath | None) -> None:
    """Write the report of logs."""
    with ProgressBar("drawing", len(group_by_case(logs)), "scenarios") as bar:
        write_report(logs, file, figures=figures, progress=lambda: bar.advance(bar.done + 1))


def _file_name(i: int, log: Log) -> str:
    """Return the name of a log's file; the number keeps the order of the runs."""
    parts = f"{i + 1:02d}", log.scenario.name, log.scenario.case or "", log.scenario.ego_type, log.plant
    return re.sub(r"[^\w-]+", "_", "_".join(filter(None, parts)), flags=re.ASCII).lower()


def print_table(logs: Sequence[Log]) -> None:
    """Print a line for each run, and the effect of V2V."""
    groups = group_by_case(logs)
    width = max(len(title(log)) for log in logs)
    print(f"{'run':{width}} {'plant':12} {'min. gap':>8} {'peak a_y':>10} {'speed-up':>8}  outcome")
    for log in (log for group in groups for log in group):
        key = log.summary()
        gap = "-" if key["min_gap_m"] is None else f"{max(key['min_gap_m'], 0.0):.2f} m"
        factor = "-" if key["realtime_factor"] is None else f"{key['realtime_factor']:.0f}x"
        print(
            f"{title(log):{width}} {log.plant or 'recorded':12} {gap:>8} {abs(log.a_y).max():>5.2f} m/s² "
            f"{factor:>8}  {summarize_outcome(log)}"
        )
    print(headline(groups))

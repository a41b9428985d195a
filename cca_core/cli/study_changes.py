"""What differs between a study and the runs in its file, and what its result does not say."""

import sqlite3
import tomllib
from pathlib import Path as FilePath

from cca_core.cli.study_file import FileScenario
from cca_core.sim import Study
from cca_core.sim.study import changes
from cca_core.sim.study.changes import LIBRARY

__all__ = ["describe_changes", "explain_no_avoidable"]

_NAMES = {
    "definition": LIBRARY, "parameters.scenario.text": "the scenario file",
    "parameters.scenario.roads": "the files that the scenario names",
    "parameters.scenario.ranges": "the ranges of the scenario's values",
}  # fmt: skip


def describe_changes(study: Study, file: FilePath) -> str:
    """Return what changed since the runs in a file, empty if nothing did or the file is no study."""
    return changes.describe_changes(_stored(file), study.fingerprint, _NAMES)


def _stored(file: FilePath) -> str:
    """Return what the runs in a file depend on; empty if it holds no runs."""
    try:
        connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True, timeout=0.0)
        try:
            connection.execute("pragma trusted_schema = off")
            kinds = connection.execute("select type from sqlite_master where name = 'meta'").fetchall()
            if kinds != [("table",)]:  # a view could be computed without end
                return ""
            (text,) = connection.execute("select fingerprint from meta limit 1").fetchone()
        finally:
            connection.close()
        return str(text)
    except (sqlite3.Error, TypeError, ValueError):
        return ""


def explain_no_avoidable(study: Study) -> str:
    """Return why it may be that no collision of a study counts as avoidable."""
    scenario = study.parameters.scenario
    hazard_id = tomllib.loads(scenario.text).get("hazard_id") if isinstance(scenario, FileScenario) else None
    if hazard_id is not None:
        return f"from the first message of hazard_id = {hazard_id!r} on, no action avoids a collision"
    if isinstance(scenario, FileScenario):
        return (
            "hazard_id in the scenario file names the road user whose first message warns; without it only a "
            "message with the hard-braking event does"
        )
    return "from the first message of the scenario's hazard_id on, no action avoids a collision"

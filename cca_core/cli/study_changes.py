"""What differs between a study and the runs in its file, and what its result does not say."""

import json
import sqlite3
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any

from cca_core._files import parse_json
from cca_core.cli.study_file import FileScenario
from cca_core.errors import InputError
from cca_core.sim import Study

__all__ = ["describe_changes", "explain_no_avoidable"]

_LIBRARY = "the version or the sources of cca_core"
_NAMES = {
    "source": _LIBRARY, "definition": _LIBRARY, "parameters.scenario.text": "the scenario file",
    "parameters.scenario.roads": "the files that the scenario names",
    "parameters.scenario.ranges": "the ranges of the scenario's values",
}  # fmt: skip
_MAX_TEXT = 60  # of a value that is shown


def describe_changes(study: Study, file: FilePath) -> str:
    """Return what changed since the runs in a file, empty if nothing did or the file is no study."""
    before, now = _flat(_stored(file)), _flat(parse_json(study.fingerprint, "study"))
    if not before:
        return ""
    differing = [key for key in (*now, *(before.keys() - now.keys())) if before.get(key) != now.get(key)]
    return ", ".join(dict.fromkeys(_change(key, before, now) for key in differing))


def _change(key: str, before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Return the name of a value, with both values where they are short."""
    if key in _NAMES:
        return _NAMES[key]
    if key not in before or key not in now:  # another version has other values
        return _LIBRARY
    name = key.removeprefix("parameters.")
    values = [json.dumps(content[key]) for content in (before, now)]
    if max(map(len, values)) > _MAX_TEXT:
        return name
    return f"{name} (was {values[0]}, is {values[1]})"


def _flat(content: object, name: str = "") -> dict[str, Any]:
    """Return the values of inner tables under names with dots."""
    if not isinstance(content, dict):
        return {name: content} if name else {}
    return {key: value for pair in _inner(content, name) for key, value in pair.items()}


def _inner(content: dict[str, Any], name: str) -> Iterator[dict[str, Any]]:
    for key, value in content.items():
        yield _flat(value, f"{name}.{key}" if name else key)


def _stored(file: FilePath) -> object:
    """Return what the runs in a file depend on; None if it holds no runs."""
    try:
        connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True, timeout=0.0)
        try:
            connection.execute("pragma trusted_schema = off")
            kinds = connection.execute("select type from sqlite_master where name = 'meta'").fetchall()
            if kinds != [("table",)]:  # a view could be computed without end
                return None
            (text,) = connection.execute("select fingerprint from meta limit 1").fetchone()
        finally:
            connection.close()
        return parse_json(text, "study")
    except (sqlite3.Error, InputError, TypeError, ValueError):
        return None


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

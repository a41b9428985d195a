"""Studies described in TOML: a scenario of the library or of a file, with ranges of its values."""

import hashlib
import re
import tomllib
from dataclasses import dataclass, fields, replace
from pathlib import Path as FilePath
from typing import Any

from cca_core._checks import check_real, shown
from cca_core.cli.scenario_file import scenario_of
from cca_core.cli.tables import Table, named, parse_toml, read_text, read_toml
from cca_core.errors import InputError
from cca_core.sim import PLANTS, ParameterRanges, Sample, Scenario, Study
from cca_core.sim.study.sampling import STUDY_SCENARIOS

__all__ = ["FileScenario", "read_study"]

_TOP = "scenario", "runs", "avoidable", "seed", "plant", "ranges"
_SHARED = tuple(field.name for field in fields(ParameterRanges))[1:]
_KEY = re.compile(r"(\w+)((?:\[\d+\])*)")
_MAX_RANGE = 1e4  # of a radio in studies [m]
_MAX_REACTION_TIME = 1.6  # in studies [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class FileScenario:
    """The scenario in a file with ranges of its values; called with a sample it makes that of one run."""

    name: str
    file: str
    text: str
    roads: str  # digest of the files that it names
    ranges: tuple[tuple[str, float, float], ...]

    def __call__(self, sample: Sample) -> Scenario:
        """Return the scenario of one run."""
        return self.at({key: sample.uniform(key, low, high) for key, low, high in self.ranges})

    def at(self, values: dict[str, float]) -> Scenario:
        """Return the scenario with these values."""
        content = tomllib.loads(self.text)
        for key, value in values.items():
            _put(content, key, value)
        return replace(scenario_of(Table(content, ""), FilePath(self.file))[0], ego_type="v2v")


def read_study(file: FilePath) -> Study:
    """Return the study in a file."""
    top = read_toml(file)
    if "road" in top.content:
        raise InputError(f'{file.name} is a scenario: name it in a study file, as scenario = "{file.name}"')
    top.check_keys(_TOP)
    ranges = top.table("ranges")
    bounds = {key: _bounds(ranges, key) for key in ranges.content}
    shared = {key: pair for key, pair in bounds.items() if key in _SHARED}
    scenario: Any = top.text("scenario")
    if scenario.endswith(".toml"):
        own = tuple((key, *pair) for key, pair in bounds.items() if key not in shared)
        scenario = _file_scenario(file.parent / scenario, own)
        shared = _fixed(scenario.at({key: low for key, low, _ in own})) | shared
    else:
        ranges.check_keys(_SHARED)
    counts = {key: top.whole(key, 0) for key in ("runs", "avoidable") if key in top.content}
    checked: dict[str, Any] = dict(shared)
    if isinstance(scenario, str):
        scenario = top.choice("scenario", STUDY_SCENARIOS)
    with named("ranges"):
        parameters = ParameterRanges(scenario=scenario, **checked)
    return Study(
        parameters=parameters, seed=top.whole("seed", 1),
        plant=top.choice("plant", PLANTS, next(iter(PLANTS))), **(counts or {"runs": 100}),
    )  # fmt: skip


def _bounds(table: Table, key: str) -> tuple[float, float]:
    """Return the bounds of a value."""
    pair = table.content[key]
    if not isinstance(pair, list) or len(pair) != 2:
        raise InputError(f"{table.position(key)} must be two numbers, was {shown(pair)}")
    low, high = (check_real(table.position(key), each) for each in pair)
    if low > high:
        raise InputError(f"{table.position(key)} must be in increasing order, was {shown(pair)}")
    return low, high


def _file_scenario(file: FilePath, ranges: tuple[tuple[str, float, float], ...]) -> FileScenario:
    """Return a scenario that is valid at both ends of its ranges."""
    text = read_text(file)
    content = parse_toml(text, file)
    made = FileScenario(name=file.stem, file=str(file), text=text, roads="", ranges=ranges)
    for end in (1, 2):
        made.at({each[0]: float(each[end]) for each in ranges})
    digest = hashlib.sha256()
    for name in _files(content):
        digest.update((file.parent / name).read_bytes())
    return replace(made, roads=digest.hexdigest())


def _files(content: Any) -> list[str]:
    """Return the files that a scenario names."""
    if isinstance(content, dict):
        own = [content["file"]] if isinstance(content.get("file"), str) else []
        return own + [name for each in content.values() for name in _files(each)]
    return [name for each in content for name in _files(each)] if isinstance(content, list) else []


def _fixed(scenario: Scenario) -> dict[str, tuple[float, float]]:
    """Return the values of a scenario that a study samples, as ranges without width."""
    channel = scenario.channel
    values: dict[str, float] = {
        "friction": scenario.vehicle.mu, "mass": 1.0, "position_noise": scenario.sender.position_noise,
        "reaction_time": min(scenario.reaction_time, _MAX_REACTION_TIME),
    }  # fmt: skip
    if channel is not None:
        values |= {
            "latency": channel.latency, "jitter": channel.jitter, "loss": channel.loss_probability,
            "radio_range": min(channel.range, _MAX_RANGE),
        }  # fmt: skip
    return {name: (value, value) for name, value in values.items()}


def _put(content: dict[str, Any], key: str, value: float) -> None:
    """Set the value of a key such as ``road_users[0].v_x``; tables that are not there are made."""
    where: Any = content
    steps: list[str | int] = []
    for part in key.split("."):
        match = _KEY.fullmatch(part)
        if match is None:
            raise InputError(f"ranges.{key!r} must be a key of the scenario, such as road_users[0].v_x")
        steps += [match[1], *map(int, re.findall(r"\d+", match[2]))]
    for step, following in zip(steps, [*steps[1:], None], strict=True):
        is_there = step < len(where) if isinstance(where, list) and isinstance(step, int) else None
        if is_there is None and isinstance(where, dict) and isinstance(step, str):
            is_there = following is None or where.setdefault(step, {}) is not None
        if not is_there:
            raise InputError(f"ranges.{key!r} must be a key of the scenario, {step!r} in it is none")
        if following is None:
            where[step] = value
        else:
            where = where[step]

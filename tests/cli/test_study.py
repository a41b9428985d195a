"""`cca study`."""

import csv
import json
import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from cca_core.cli import main
from cca_core.cli.study_changes import describe_changes, explain_no_avoidable
from cca_core.cli.study_file import FileScenario, read_study
from cca_core.errors import InputError
from cca_core.sim import ParameterRanges, Study
from cca_core.sim.study.parameters import sample_scenario
from cca_core.sim.study.store import Store

OWN = """
duration = 6.0
road = {file = "way.csv"}
ego = {cruise_speed = 18.0, reaction_time = 0.9, vehicle = {mu = 0.8}}
road_users = [{id = "R1", s = 80.0, v_x = 12.0, actions = [{type = "brake", t = 2.0, deceleration = 6.0}]}]
radio = {latency = 0.2, range = 500.0}
"""
STUDY = """
scenario = "own.toml"
runs = 3
seed = 4
[ranges]
loss = [0.0, 0.5]
"ego.cruise_speed" = [15.0, 20.0]
"road_users[0].actions[0].deceleration" = [4.0, 8.0]
"evasion.clearance" = [0.8, 1.2]
"""


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "way.csv").write_text("x,y\n" + "".join(f"{x},0\n" for x in range(0, 801, 20)))
    (tmp_path / "own.toml").write_text(OWN)
    file = tmp_path / "many.toml"
    file.write_text(STUDY)
    return file


def test_ranges_of_a_file_are_sampled(study: Path) -> None:
    made = read_study(study)
    assert (made.runs, made.seed, made.parameters.name) == (3, 4, "own")
    assert made.parameters.latency == (0.2, 0.2)
    assert made.parameters.friction == (0.8, 0.8)
    assert made.parameters.reaction_time == (0.9, 0.9)
    assert made.parameters.mass == (1.0, 1.0)
    values = set()
    for i in range(20):
        scenario, _, samples = sample_scenario(made.parameters, made.seed, i)
        assert 15.0 <= scenario.cruise_speed == samples["ego.cruise_speed"] <= 20.0
        assert 0.8 <= scenario.evasion.clearance <= 1.2
        braking = scenario.road_users[0].actions[0]
        assert braking.deceleration <= 8.0  # type: ignore[union-attr]
        assert scenario.channel is not None
        assert scenario.channel.range == 500.0
        values.add(scenario.cruise_speed)
    assert len(values) == 20


def test_study_depends_on_the_files_it_names(study: Path) -> None:
    before = read_study(study).fingerprint
    assert read_study(study).fingerprint == before
    for name, text in {"own.toml": OWN.replace("12.0", "11.0"), "way.csv": "x,y\n0,0\n900,0\n"}.items():
        old = (study.parent / name).read_text()
        (study.parent / name).write_text(text)
        assert read_study(study).fingerprint != before
        (study.parent / name).write_text(old)


def test_scenario_of_a_file_can_be_pickled(study: Path) -> None:
    scenario = read_study(study).parameters.scenario
    assert isinstance(scenario, FileScenario)
    assert pickle.loads(pickle.dumps(scenario)) == scenario


@pytest.mark.requires("matplotlib")
def test_study_of_a_file_is_run_and_resumed(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", str(study), "--jobs", "1"]) == 0
    first = capsys.readouterr().out
    assert first.startswith("own: 3 runs, a collision was avoidable in ")
    rows = list(csv.DictReader((study.parent / "out" / "many.csv").read_text().splitlines()))
    assert len(rows) == 3
    assert (study.parent / "out" / "many.png").is_file()
    assert main(["study", str(study), "--jobs", "1"]) == 0  # all runs are there
    assert capsys.readouterr().out == first
    study.write_text(STUDY.replace("0.5]", "0.4]"))
    assert main(["study", str(study), "--jobs", "1"]) == 2
    error = capsys.readouterr().err
    assert "changed in: loss (was [0.0, 0.5], is [0.0, 0.4]); --out names" in error
    (study.parent / "own.toml").write_text(OWN.replace("s = 80.0", "s = 700.0"))
    assert main(["study", str(study), "--jobs", "1", "--out", "new", "--runs", "1"]) == 0
    assert "no collision was avoidable: hazard_id in the scenario file" in capsys.readouterr().out


def test_changes_of_a_study_are_named(study: Path, tmp_path: Path) -> None:
    made = read_study(study)
    file = tmp_path / "many.db"
    assert describe_changes(made, file) == ""  # there is none
    with Store(file, made.fingerprint):
        assert describe_changes(made, file) == ""  # another process has it
    assert describe_changes(made, file) == ""
    assert describe_changes(replace(made, seed=5, runs=9), file) == "seed (was 4, is 5)"
    (study.parent / "own.toml").write_text(OWN.replace("6.0", "7.0"))
    assert describe_changes(read_study(study), file) == "the scenario file"
    (study.parent / "own.toml").write_text(OWN)
    (study.parent / "way.csv").write_text("x,y\n0,0\n50,0\n900,0\n")
    assert describe_changes(read_study(study), file) == "the files that the scenario names"
    content = json.loads(made.fingerprint) | {"source": "older", "retired": 1}
    other = tmp_path / "older.db"
    with Store(other, json.dumps(content)):
        pass
    assert describe_changes(replace(made, plant="multi_body"), other) == (
        'plant (was "single_track", is "multi_body"), the version or the sources of cca_core'
    )


def test_file_that_is_no_study_has_no_changes(study: Path, tmp_path: Path) -> None:
    for content in (b"", b"no database", b"SQLite format 3\0" + bytes(90)):
        file = tmp_path / "odd.db"
        file.write_bytes(content)
        assert describe_changes(read_study(study), file) == ""


def test_reason_of_no_avoidable_run_names_hazard_id(study: Path) -> None:
    assert "hazard_id in the scenario file" in explain_no_avoidable(read_study(study))
    (study.parent / "own.toml").write_text('hazard_id = "R1"\n' + OWN)
    assert "hazard_id = 'R1'" in explain_no_avoidable(read_study(study))
    library = Study(parameters=ParameterRanges(scenario="eebl"), runs=1)
    assert "hazard_id" in explain_no_avoidable(library)


@pytest.mark.requires("matplotlib")
def test_study_of_the_library_by_name(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "eebl", "--runs", "1", "--seed", "5", "--jobs", "1", "--out", "x"]) == 0
    assert capsys.readouterr().out.startswith("eebl: 1 run,")
    assert sorted(file.name for file in Path("x").iterdir()) == [
        "study_eebl.csv", "study_eebl.db", "study_eebl.png"
    ]  # fmt: skip


HEAD = 'scenario = "own.toml"\n[ranges]\n'
WRONG = [
    ("runs = 3\n", "scenario must be given"),
    ('scenario = "eeble"\n', "scenario must be one of eebl, ima, curbside, maneuver, was 'eeble'"),
    ('scenario = "no.toml"\n', "file '"),
    ('scenario = "eebl"\nrun = 3\n', "run is unknown; did you mean runs?"),
    ('scenario = "eebl"\nruns = 0\n', "runs or avoidable must be at least 1"),
    ('scenario = "eebl"\nruns = 3\navoidable = 3\n', "one of runs and avoidable must be given"),
    ('scenario = "eebl"\n[ranges]\nlatncy = [0.0, 1.0]\n', "ranges.latncy is unknown; did you mean latency?"),
    ('scenario = "eebl"\n[ranges]\nfriction = [0.1, 1.0]\n', "ranges.friction must be two numbers from 0.3"),
    ('scenario = "eebl"\n[ranges]\nfriction = 0.5\n', "ranges.friction must be two numbers, was 0.5"),
    ('scenario = "eebl"\n[ranges]\nfriction = [0.9, 0.5]\n', "ranges.friction must be in increasing order"),
    ('scenario = "eebl"\n[ranges]\nfriction = ["a", 1]\n', "ranges.friction must be a real number, was 'a'"),
    (HEAD + '"ego.cruise_sped" = [1.0, 2.0]\n', "ego.cruise_sped is unknown; did you mean cruise_speed?"),
    (HEAD + '"ego.cruise_speed" = [-1.0, 2.0]\n', "ego.cruise_speed must be greater than 0, was -1"),
    (HEAD + '"ego.cruise_speed.x" = [1.0, 2.0]\n', "ranges.'ego.cruise_speed.x' must be a key"),
    (HEAD + '"road_users[1].v_x" = [1.0, 2.0]\n', "ranges.'road_users[1].v_x' must be a key of the scenario"),
    (HEAD + '"road_users.v_x" = [1.0, 2.0]\n', "ranges.'road_users.v_x' must be a key of the scenario"),
    (HEAD + '"a b" = [1.0, 2.0]\n', "ranges.'a b' must be a key of the scenario"),
    ("[road]\n[ego]\nv_x = 20.0\n", "many.toml is a scenario: name it in a study file"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "begin"), WRONG, ids=range(len(WRONG)))
def test_error_names_the_key(text: str, begin: str, study: Path) -> None:
    study.write_text(text)
    with pytest.raises(InputError) as error:
        read_study(study)
    assert str(error.value).startswith(begin)

"""Studies of a user's scenario and plant."""

import json
import math
import subprocess
import sys
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cca_core import InputError, Lane, Road, VehicleParams, VehicleState
from cca_core.path import interpolate_path
from cca_core.sim import (
    EGO_TYPES,
    BrakeAction,
    ParameterRanges,
    RoadUser,
    Sample,
    Scenario,
    SingleTrackPlant,
    Study,
    StudyTable,
    run_study,
)
from cca_core.sim.study.changes import LIBRARY, describe_changes
from cca_core.sim.study.parameters import sample_scenario
from cca_core.sim.study.run import simulate_run
from cca_core.sim.study.store import Store

CAR = VehicleParams.bmw_320i()
# the mass is not that of the car whose gains steer it
pytestmark = pytest.mark.filterwarnings("ignore:no steering gains were designed:UserWarning")
WIDTH = 3.5


def lane_of(d: float) -> Lane:
    return Lane(d=d, width=WIDTH)


def queue_end(sample: Sample) -> Scenario:
    """A car ahead brakes."""
    v_x = sample.uniform("v_x", 15.0, 20.0)
    deceleration = sample.uniform("deceleration", 3.0, 6.0)
    ahead = RoadUser(
        id="ahead", s=60.0, d=0.0, v_x=v_x, reaction_time=sample.reaction_time,
        actions=(BrakeAction(t=1.0, deceleration=deceleration),),
    )  # fmt: skip
    road = Road(interpolate_path([[0.0, 0.0], [900.0, 0.0]]), [lane_of(0.0)])
    return Scenario(
        name="queue end", case=None, road=road, vehicle=replace(CAR, m=1500.0, I_z=2500.0), start=20.0,
        v_x=v_x, cruise_speed=v_x, road_users=(ahead,), duration=6.0,
    )  # fmt: skip


def empty_road(sample: Sample) -> Scenario:
    return replace(queue_end(sample), road_users=())


def nothing(sample: Sample) -> Any:
    return sample.case


def deaf(sample: Sample) -> Scenario:
    return replace(queue_end(sample), ego_type="sensor")


def twice(sample: Sample) -> Scenario:
    sample.uniform("loss", 0.0, 1.0)
    return queue_end(sample)


class StiffPlant(SingleTrackPlant):
    """A plant of a user, with slow brakes."""

    def __init__(self, vehicle: VehicleParams, state: VehicleState) -> None:
        super().__init__(vehicle, state, drive_lag=0.3)


class SameProcess(Executor):
    """Executor that runs each task at once in this process."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def pile_up(sample: Sample) -> Scenario:
    """A car drives through another one in half of the runs, far ahead of the ego."""
    made = queue_end(sample)
    parked = replace(made.road_users[0], id="parked", s=700.0, v_x=0.0, actions=())
    fast = replace(parked, id="fast", s=640.0, v_x=20.0 if sample.uniform("half", 0.0, 1.0) < 0.5 else 2.0)
    return replace(made, road_users=(*made.road_users, parked, fast))


OWN = ParameterRanges(scenario=queue_end, loss=(0.0, 0.2))


def test_own_scenario_is_sampled() -> None:
    scenario, nominal, samples = sample_scenario(OWN, 1, 3)
    assert (samples["v_x"], samples["index"]) == (scenario.v_x, 3)
    assert scenario.road_users[0].reaction_time != math.inf
    assert scenario.seed == samples["seed"]
    assert scenario.channel is not None
    assert scenario.channel.loss_probability == samples["loss"]
    assert (nominal.m, nominal.mu) == (1500.0, samples["friction"])
    assert scenario.vehicle.m == pytest.approx(1500.0 * float(samples["mass"]))
    again = sample_scenario(OWN, 1, 3)
    assert again[2] == samples
    assert sample_scenario(OWN, 1, 4)[2] != samples


def test_own_study_has_all_columns_and_is_resumed(tmp_path: Path) -> None:
    study = Study(parameters=OWN, runs=2)
    run_study(study, tmp_path / "a.db", executor=SameProcess())
    table = run_study(replace(study, runs=4), tmp_path / "a.db", executor=SameProcess())
    whole = run_study(replace(study, runs=4), tmp_path / "b.db", executor=SameProcess())
    assert table.rows == whole.rows
    assert table.scenario == "queue_end"
    assert {"v_x", "deceleration", "latency", "avoiding_action", "v2v_gap"} <= set(table.names)
    assert (table.column("t_hazard") > 1.0).any()
    assert table.rate("v2v", np.ones(4, dtype=bool)).n_events == 0


def test_own_study_runs_in_processes(tmp_path: Path) -> None:
    script = tmp_path / "own.py"
    script.write_text("""
from cca_core import Road, VehicleParams
from cca_core.path import interpolate_path
from cca_core.sim import ParameterRanges, RoadUser, Sample, Scenario, Study, run_study

ROAD = 900.0

def alone(sample: Sample) -> Scenario:
    v_x = sample.uniform("v_x", 15.0, 20.0)
    user = RoadUser(id="ahead", s=100.0, d=0.0, v_x=v_x)
    return Scenario(
        name="alone", case=None, road=Road(interpolate_path([[0.0, 0.0], [ROAD, 0.0]])),
        vehicle=VehicleParams.bmw_320i(), start=20.0, v_x=v_x, cruise_speed=v_x, road_users=(user,),
        duration=1.0,
    )

if __name__ == "__main__":
    table = run_study(Study(parameters=ParameterRanges(scenario=alone), runs=2), "own.db", in_flight=2)
    print(len(table), table.scenario)
""")
    for _ in range(2):  # the second time nothing is left to do
        done = subprocess.run(
            [sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr[-2000:]
        assert done.stdout == "2 alone\n"
    changed = script.read_text().replace("ROAD = 900.0", "ROAD = 800.0")
    script.write_text(changed)
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert "own.db' belongs to another one, which differs in: the source of the scenario" in done.stderr
    assert '(was "ROAD = 900.0", is "ROAD = 800.0"); give another file name, or delete' in done.stderr


def test_own_plant_in_a_study() -> None:
    own = simulate_run(OWN, 1, 0, StiffPlant)
    library = simulate_run(OWN, 1, 0)
    assert own["v_x"] == library["v_x"]
    assert own["v2v_gap"] != library["v2v_gap"]


def test_fingerprint_follows_what_the_scenario_is_made_of() -> None:
    study = Study(parameters=OWN, runs=3)
    text = study.fingerprint
    assert "def queue_end" in text
    assert "def lane_of" in text  # used by it
    assert "WIDTH = 3.5" in text  # used by that
    assert "def twice" not in text
    assert "class StiffPlant" in replace(study, plant=StiffPlant).fingerprint


def test_study_counts_runs_with_road_users_in_each_other(recwarn: pytest.WarningsRecorder) -> None:
    rows = tuple(simulate_run(ParameterRanges(scenario=pile_up), 1, i) for i in range(4))
    table = StudyTable(scenario="pile_up", rows=rows)
    overlapping = table.column("half") < 0.5
    assert 0 < overlapping.sum() < 4
    assert (table.overlapping == overlapping).all()
    for ego_type in EGO_TYPES:
        texts = table.column(f"{ego_type}_overlap")
        assert ((texts != "") == overlapping).all()
        assert set(texts[overlapping]) == {"fast drives into parked at 2.8 s"}
    n = overlapping.sum()
    assert f"\n  road users drive into each other in {n} of 4 runs (columns that end in _ov" in repr(table)
    assert len(recwarn) == 0
    rest = StudyTable(scenario="pile_up", rows=tuple(row for row in rows if row["half"] >= 0.5))
    assert not rest.overlapping.any()
    assert "road users" not in repr(rest)


def test_scenario_without_road_users_has_no_gap() -> None:
    row = simulate_run(ParameterRanges(scenario=empty_road), 1, 0)
    assert row["v2v_gap"] is None
    assert row["avoiding_action"] == ""


@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        (nothing, "scenario must return a Scenario of ego type v2v, returned"),
        (deaf, "scenario must return a Scenario of ego type v2v, returned"),
        (twice, "name must be new, was 'loss'"),
    ],
)
def test_scenario_that_cannot_be_used_raises(scenario: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        sample_scenario(ParameterRanges(scenario=scenario), 1, 0)


@pytest.mark.parametrize("scenario", [lambda sample: None, Sample.__init__, 3.0, None])
def test_scenario_that_no_process_finds_raises(scenario: Any) -> None:
    with pytest.raises(InputError, match=r"scenario must be .* function or class at the top level"):
        ParameterRanges(scenario=scenario)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"seed": 2}, "seed (was 1, is 2)"),
        ({"plant": StiffPlant}, "the plant"),
        ({"parameters": replace(OWN, loss=(0.0, 0.1))}, "loss (was [0.0, 0.2], is [0.0, 0.1])"),
        ({"parameters": replace(OWN, scenario=empty_road)}, "the source of the scenario"),
        ({"parameters": replace(OWN, scenario="ima")}, "the scenario"),
    ],
)
def test_file_of_another_study_names_what_changed(change: dict[str, Any], words: str, tmp_path: Path) -> None:
    study, file = Study(parameters=OWN, runs=1), tmp_path / "a.db"
    with Store(file, study.fingerprint):
        pass
    with pytest.raises(InputError) as caught:
        run_study(replace(study, **change), file, executor=SameProcess())
    text = str(caught.value)
    assert f"a.db' belongs to another one, which differs in: {words}" in text
    assert text.endswith("; give another file name, or delete this one to begin anew")
    assert len(text) < 600


def test_changed_line_of_a_source_is_shown() -> None:
    before = Study(parameters=OWN, runs=1).fingerprint
    now = before.replace("t=1.0, deceleration", "t=2.0, deceleration")
    assert describe_changes(before, now) == (
        'the source of the scenario (was "actions=(BrakeAction(t=1.0, deceleration=deceleration),),", '
        'is "actions=(BrakeAction(t=2.0, deceleration=deceleration),),")'
    )
    other = json.dumps(json.loads(before) | {"source": "older", "retired": 1})
    assert describe_changes(before, other) == "the version or the sources of cca_core"
    assert describe_changes(before, before) == ""
    assert describe_changes("[" * 100000, before) == ""


def test_names_of_the_caller_come_first() -> None:
    """The class that reads scenario files belongs to the library, not to the user's scenario."""
    before, now = (json.dumps({"definition": f"class A:\n    {name} = 1\n"}) for name in "ab")
    assert describe_changes(before, now, {"definition": LIBRARY}) == LIBRARY
    assert describe_changes(before, now, {"seed": "the seed"}).startswith("the source of the scenario (was ")


@pytest.mark.parametrize("other", ["def f():\n    b = 2\n    a = 1\n", "def f():\n  a = 1\n  b = 2\n"])
def test_source_of_the_same_lines_shows_none(other: str) -> None:
    before = json.dumps({"definition": "def f():\n    a = 1\n    b = 2\n"})
    assert describe_changes(before, json.dumps({"definition": other})) == "the source of the scenario"


def test_plant_object_in_a_study_raises() -> None:
    plant = SingleTrackPlant(CAR, VehicleState(x=0.0, y=0.0, psi=0.0, v_x=1.0))
    with pytest.raises(InputError, match=r"plant must be .* function or class at the top level"):
        Study(parameters=OWN, runs=1, plant=plant)  # type: ignore[arg-type]

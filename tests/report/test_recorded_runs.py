"""Figures, animations and reports of runs of a user's own loop."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cca_core import EvasionSettings, InputError, Lane, Planner, RemoteVehicle, Road, VehicleParams
from cca_core import VehicleState as State
from cca_core.cli import main
from cca_core.path import interpolate_path
from cca_core.plot import (
    plot_braking,
    plot_crossing,
    plot_layout,
    plot_passing,
    plot_time_series,
    plot_traffic,
)
from cca_core.report import (
    animate,
    describe_outcome,
    describe_participants,
    describe_run,
    group_by_case,
    report_figures,
    summarize_outcome,
    write_report,
)
from cca_core.report.overview import words_used
from cca_core.sim import Log, Recorder, SingleTrackPlant, save_log
from tests.support.sweeps import sweep

pytestmark = pytest.mark.requires("matplotlib")

CAR = VehicleParams.bmw_320i()
DT = 0.05  # [s]


def recorded(name: str, t_0: float = 0.0, *, steered: bool = True) -> Log:
    """Past a parked van that appears late, with a fast car that leaves; unsteered into the van."""
    road = Road(interpolate_path([[0.0, 0.0], [800.0, 0.0]]), [Lane(d=0.0), Lane(d=3.5)])
    planner = Planner(CAR, road, cruise_speed=15.0, evasion=EvasionSettings(awareness_range=500.0))
    recorder = Recorder(planner, name=name)
    plant = SingleTrackPlant(CAR, State(x=20.0, y=0.0, psi=0.0, v_x=15.0))
    for k in range(200):
        t, state, remotes = t_0 + DT * k, plant.state, []
        if k >= 10:
            remotes.append(RemoteVehicle(id="van", x=130.0, y=-0.4, psi=0.0, v_x=0.0, length=6.0))
        if k < 80:
            remotes.append(RemoteVehicle(id="car", x=60.0 + k, y=0.0, psi=0.0, v_x=20.0))
        if k >= 120:
            remotes.append(RemoteVehicle(id="late", x=240.0, y=k - 200.0, psi=1.57, v_x=20.0))
        command = planner.step(t, state, remotes)
        recorder.add(t, state, remotes, command)
        plant.step(command.delta if steered else 0.0, command.a_x if steered else 0.0, DT)
    return recorder.log()


@pytest.fixture(scope="module")
def passed() -> Log:
    return recorded("past a van")


@pytest.fixture(scope="module")
def collided() -> Log:
    return recorded("past a van", t_0=1000.0, steered=False)


FIGURES: dict[str, Callable[[Log], object]] = {
    "braking": lambda log: plot_braking([log]),
    "crossing": lambda log: plot_crossing([log]),
    "layout": lambda log: plot_layout(log.scenario),
    "passing": lambda log: plot_passing([log], "van"),
    "time series": plot_time_series,
    "traffic": plot_traffic,
    "traffic at times": lambda log: plot_traffic(log, times=log.t[[0, len(log.t) // 2, -1]].tolist()),
    "report": lambda log: list(report_figures([log])),
    "animation": lambda log: animate([log]),
}


@pytest.mark.parametrize("name", FIGURES)
def test_recorded_run_has_each_figure(passed: Log, collided: Log, name: str) -> None:
    for log in (passed, collided):
        assert FIGURES[name](log)


@pytest.mark.parametrize(
    "steps", sweep([0.3, 0.01, 2.0, 0.1], [1.5] * 6, [0.02]), ids=["irregular", "slow", "two"]
)
def test_slow_and_irregular_loop_has_each_figure(steps: list[float]) -> None:
    road = Road(interpolate_path([[0.0, 0.0], [500.0, 0.0]]), [Lane(d=0.0), Lane(d=3.5)])
    planner = Planner(CAR, road, cruise_speed=10.0)
    recorder = Recorder(planner, name="a/b <c>", case="1")
    van = RemoteVehicle(id="van", x=110.0, y=-1.0, psi=0.0, v_x=0.0)
    for k, t in enumerate(np.cumsum([1.7e9, *steps]).tolist()):
        state = State(x=20.0 + 10.0 * (t - 1.7e9), y=0.0, psi=0.0, v_x=10.0)
        remotes = [van] if k else []
        recorder.add(t, state, remotes, planner.step(t, state, remotes))
    for draw in FIGURES.values():
        assert draw(recorder.log())


def test_texts_of_a_run_name_the_vehicles_that_took_part(passed: Log) -> None:
    assert "van" in describe_outcome(passed)
    assert summarize_outcome(passed).startswith("passes van")
    # the gap is 35.5 m
    text = describe_participants(passed).replace(" 36 m ahead", " 35 m ahead")
    assert text == (
        "The ego's cruise speed is 15 m/s; car drives at 20 m/s in the ego lane, 35 m ahead; "
        "van appears at 0.5 s; late appears at 6.0 s."
    )
    assert "assing van on the left" in describe_run(passed)


def test_collision_in_the_middle_of_a_run_is_described(collided: Log) -> None:
    wanted = r"At 100[0-9]\.\d s it collides with van, at a relative speed of 15\.0 m/s"
    assert re.search(wanted, describe_run(collided))
    assert summarize_outcome(collided) == "collides with van at 15.0 m/s"


def test_animation_hides_absent_vehicles_and_begins_at_0(passed: Log, collided: Log) -> None:
    text = animate([passed])
    known = re.search(r'"known":\["([01-]+)","([01-]+)","([01-]+)"\]', text)
    assert known is not None
    car, van, late = known.groups()
    assert (car[0], car[-1], van[0], van[-1], late[0], late[-1]) == ("1", "-", "-", "1", "-", "1")
    assert "NaN" not in text
    assert '"start":1000.0' in animate([collided])
    assert 'max="9.950"' in animate([collided])


def test_report_shows_every_recorded_run(passed: Log, collided: Log, tmp_path: Path) -> None:
    assert [len(group) for group in group_by_case([passed, collided])] == [1, 1]
    write_report([passed, collided], tmp_path / "own.html", title="My <runs>", figures=tmp_path)
    text = (tmp_path / "own.html").read_text(encoding="utf-8")
    assert "<title>My &lt;runs&gt;</title>" in text
    assert "what V2V changed" not in text
    assert re.findall(r"<h2>(.*?)</h2>", text) == ["Past a van", "Past a van (2)"]
    assert ">recorded</td>" in text
    assert ">unknown</td>" in text
    assert len(list(tmp_path.glob("*.png"))) == text.count("<img ")


def test_report_compares_recorded_runs_with_and_without_v2v(passed: Log, tmp_path: Path) -> None:
    alone = replace(passed, scenario=replace(passed.scenario, ego_type="sensor"))
    write_report([passed, alone], tmp_path / "own.html")
    text = (tmp_path / "own.html").read_text(encoding="utf-8")
    assert "what V2V changed" in text
    assert text.count("<h2>") == 1


def test_report_claims_no_sensor_delay_of_a_recorded_run(passed: Log) -> None:
    alone = replace(passed, scenario=replace(passed.scenario, ego_type="sensor"))
    text = words_used([[alone]])
    assert "Sensor: a program that drives, and knows what its sensor sees. " in text
    assert "V2V:" in text
    assert "With V2V" not in text


def test_command_reports_recorded_runs(
    passed: Log, collided: Log, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [tmp_path / "1.npz", tmp_path / "2.npz"]
    for log, file in zip((passed, collided), files, strict=True):
        save_log(log, file)
    assert main(["report", *map(str, files), "--out", str(tmp_path / "own.html")]) == 0
    assert capsys.readouterr().out.count("with V2V recorded ") == 2
    assert (tmp_path / "own.html").read_text(encoding="utf-8").count("<h2>") == 2


@pytest.mark.parametrize("runs", [[], [3.0]])
def test_report_of_no_runs_raises(runs: list[Log], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="runs must be a sequence of at least one Log"):
        write_report(runs, tmp_path / "own.html")


def test_gap_of_an_absent_vehicle_is_infinite(passed: Log) -> None:
    assert np.isinf(passed.gaps()[0, 1])
    assert np.isfinite(passed.gaps()[-1, 1])

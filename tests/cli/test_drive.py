"""`cca drive`."""

import json
from pathlib import Path

import numpy as np
import pytest

from cca_core.cli import main
from cca_core.sim import load_log

BRAKING = """
duration = 9.0
seed = 3
[road]
pieces = [{length = 600.0}]
[ego]
cruise_speed = 18.0
[[road_users]]
id = "R1"
s = 90.0
v_x = 12.0
actions = [{type = "brake", t = 3.0, deceleration = 4.0}]
"""


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "braking.toml"
    file.write_text(BRAKING)
    return file


@pytest.mark.requires("matplotlib")
def test_run_is_logged_summarized_and_reported(scenario: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["drive", str(scenario)]) == 0
    out = scenario.parent / "out" / "braking"
    log = load_log(out / "01_braking_v2v_single_track.npz")
    assert (log.scenario.duration, log.seed) == (9.0, 3)
    assert log.time_of("stopped", "R1") == pytest.approx(6.0, abs=0.1)
    assert log.collided_with == ""
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert [run["collided"] for run in summary["runs"]] == [False]
    assert (out / "report.html").is_file()
    assert "v2v: " in capsys.readouterr().out


@pytest.mark.requires("matplotlib")
def test_words_replace_values_of_the_file(scenario: Path) -> None:
    assert main(["drive", str(scenario), "--ego", "all", "--seed", "8", "--out", "there"]) == 0
    logs = [load_log(file) for file in sorted(Path("there").glob("*.npz"))]
    assert [log.scenario.ego_type for log in logs] == ["v2v", "driver", "sensor"]
    assert [log.seed for log in logs] == [8, 8, 8]


@pytest.mark.requires("matplotlib")
def test_run_repeats_bit_for_bit(scenario: Path) -> None:
    for name in ("a", "b"):
        assert main(["drive", str(scenario), "--out", name]) == 0
    first, second = (load_log(next(Path(name).glob("*.npz"))) for name in ("a", "b"))
    assert np.array_equal(first.ego, second.ego)


@pytest.mark.requires("matplotlib")
def test_template_drives_and_passes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["drive", "--template"]) == 0
    (tmp_path / "scenario.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    assert main(["drive", "scenario.toml"]) == 0
    assert "passes truck" in capsys.readouterr().out


def test_invalid_scenario_has_code_2(scenario: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario.write_text(BRAKING.replace("s = 90.0", "s = 90.0\nwidth = -3"))
    assert main(["drive", str(scenario)]) == 2
    assert capsys.readouterr().err == "cca drive: road_users[0].width must be at least 0.01, was -3\n"
    assert not (scenario.parent / "out").exists()


def test_neither_file_nor_template_has_code_2() -> None:
    with pytest.raises(SystemExit) as ended:
        main(["drive"])
    assert ended.value.code == 2

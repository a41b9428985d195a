"""The command line as a whole: help, exit codes, imports."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import cca_core
from cca_core.cli import main
from cca_core.v2x import Bsm, encode_bsm

COMMANDS = ("demo", "fit", "decode", "drive", "study", "report")
BLOCK_MATPLOTLIB = """
import sys


class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("matplotlib", "tqdm", "vehiclemodels"):
            raise ModuleNotFoundError(name, name=name)


sys.meta_path.insert(0, Blocker())
import importlib.util

find_spec = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: (
    None if name.partition(".")[0] in ("matplotlib", "tqdm", "vehiclemodels") else find_spec(name, package)
)
from cca_core.cli import main

sys.exit(main(sys.argv[1:]))
"""


def run(*arguments: str, code: str = "", cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    program = ["-c", code] if code else ["-m", "cca_core"]
    return subprocess.run(
        [sys.executable, *program, *arguments], capture_output=True, text=True, timeout=300, cwd=cwd
    )


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_fits_a_screen(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit) as ended:
        main([*([command] if command else []), "--help"])
    assert ended.value.code == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 80


def test_help_names_every_command() -> None:
    assert re.findall(r"^    (\w+) ", run("-h").stdout, re.MULTILINE) == list(COMMANDS)


@pytest.mark.parametrize("arguments", [["--help"], ["fit", "--help"], []])
def test_help_imports_neither_scipy_nor_matplotlib(arguments: list[str]) -> None:
    code = f"""
import sys
from cca_core.cli import main

try:
    main({arguments!r})
except SystemExit:
    loaded = {{name.partition(".")[0] for name in sys.modules}}
    sys.exit(bool(loaded & {{"scipy", "matplotlib", "tqdm"}}) or "cca_core.sim" in sys.modules)
"""
    assert run(code=code).returncode == 0


def test_module_is_the_command() -> None:
    result = run("--help")
    assert result.stdout.startswith("usage: cca ")
    assert result.returncode == 0


@pytest.mark.parametrize("arguments", [[], ["draw"], ["fit"], ["fit", "a.gpx", "--tolerance", "wide"]])
def test_words_that_cannot_be_parsed_have_code_2(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2


@pytest.mark.parametrize(
    "arguments",
    [
        ["fit", "no.gpx"],
        ["decode", "no.pcap"],
        ["report", "no.npz"],
        ["drive", "no.toml"],
        ["demo", "--route", "no.gpx"],
    ],
    ids=" ".join,
)
def test_missing_file_is_one_line_and_code_2(
    arguments: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"cca {arguments[0]}: ")
    assert arguments[-1] in error
    assert error.count("\n") == 1


def test_no_command_shows_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main([])
    error = capsys.readouterr().err
    assert "commands:" in error
    assert "cca COMMAND --help" in error


@pytest.mark.parametrize("name", ["no.npz", "text.npz", "empty"])
def test_log_that_is_none_is_named_as_given(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.npz").write_text("no log")
    (tmp_path / "empty").mkdir()
    assert main(["report", name]) == 2
    error = capsys.readouterr().err
    assert repr(name) in error
    assert "Path(" not in error


def test_folder_that_cannot_be_written_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    route = tmp_path / "route.csv"
    route.write_text("x,y\n0,0\n50,0\n100,0\n")
    assert main(["fit", str(route), "--plot", str(tmp_path / "no" / "a.svg")]) == 2
    assert "a.svg' cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", ["decode log.hex", "decode log.hex --csv", "decode --help", "--version", "drive --template"]
)
def test_reader_that_ends_early_ends_quietly(words: str, tmp_path: Path) -> None:
    data = encode_bsm(Bsm(msg_count=0, id="00c0ffee", latitude_deg=41.3, longitude_deg=-105.6))
    (tmp_path / "log.hex").write_text(f"{data.hex()}\n" * 2000)
    with subprocess.Popen(
        [sys.executable, "-m", "cca_core", *words.split()], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        cwd=tmp_path, text=True,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""
        code = process.wait(120)
    assert code == 141 or (words.endswith("--help") and code == 0)  # argparse drops the error


def test_full_disk_is_one_line(tmp_path: Path) -> None:
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("needs /dev/full")
    with full.open("w") as stream:
        result = subprocess.run(
            [sys.executable, "-m", "cca_core", "--version"], stdout=stream, stderr=subprocess.PIPE, text=True
        )
    assert result.returncode == 2
    assert result.stderr == "cca: the output cannot be written: No space left on device\n"


def test_demo_without_matplotlib_names_the_extra(tmp_path: Path) -> None:
    result = run("demo", "--only", "eebl", "--out", "out", code=BLOCK_MATPLOTLIB, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "pip install 'cca-planner[plot]'" in result.stderr
    assert len(list((tmp_path / "out").glob("*.npz"))) == 4
    report = run("report", "out", code=BLOCK_MATPLOTLIB, cwd=tmp_path)
    assert report.returncode == 2
    assert "pip install 'cca-planner[plot]'" in report.stderr


@pytest.mark.requires("matplotlib")
def test_logs_of_demo_are_reported_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert main(["demo", "--only", "eebl", "--out", str(out)]) == 0
    table, error = capsys.readouterr()
    assert "driving" not in error  # no progress without a terminal
    assert (out / "report.html").is_file()
    logs = sorted(map(str, out.glob("*single_track.npz")))
    assert main(["report", *logs, "--out", str(tmp_path / "again" / "page.html")]) == 0
    assert "The ego collides in" in table
    assert "The ego collides in" in capsys.readouterr().out
    assert (tmp_path / "again" / "page.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_unknown_scenario_of_demo_lists_names(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--only", "eeble"]) == 2
    output = capsys.readouterr()
    assert "eebl, ima, curbside, maneuver" in output.err
    assert output.out == ""


def test_version_is_that_of_the_library() -> None:
    assert run("--version").stdout == f"cca {cca_core.__version__}\n"


def test_warning_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "tight.toml"
    file.write_text(
        "duration = 0.1\nroad = {pieces = [{length = 50.0}, {length = 9.0, radius = 3.0}]}\n"
        "ego = {cruise_speed = 9.0}\n"
    )
    main(["drive", str(file), "--out", str(tmp_path / "out")])
    warnings = [line for line in capsys.readouterr().err.splitlines() if line.startswith("warning: ")]
    assert len(warnings) == 1
    assert warnings[0].startswith("warning: the path has a curve of radius")

"""`cca fit`."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from cca_core import LocalFrame
from cca_core.cli import main
from tests.support.moved_maps import moved_file
from tests.support.opendrive_files import crossing
from tests.support.sumo_files import write_net


def facts(text: str) -> dict[str, str]:
    pairs = (line.split(":", 1) for line in text.splitlines())
    return {name: value.strip() for name, value in pairs}


def write_table(file: Path, xy: np.ndarray) -> None:
    file.write_text("x,y\n" + "".join(f"{x:.4f},{y:.4f}\n" for x, y in xy))


@pytest.fixture
def circle(tmp_path: Path) -> Path:
    angle = np.linspace(0.0, math.pi, 60)
    file = tmp_path / "circle.csv"
    write_table(file, 80.0 * np.column_stack((np.sin(angle), 1.0 - np.cos(angle))))
    return file


def test_facts_of_half_a_circle(circle: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(circle)]) == 0
    found = facts(capsys.readouterr().out)
    assert found["route"] == "circle.csv: 60 points in 1 part, 0 rows without a position"
    assert float(found["length"].split()[0]) == pytest.approx(80.0 * math.pi, abs=0.5)
    assert float(found["rms error"].split()[0]) < 0.05
    radius = re.match(r"radius (\d+) m to the left", found["tightest curve"])
    assert radius is not None
    assert float(radius[1]) == pytest.approx(80.0, abs=4.0)
    assert "picture" not in found


def test_rms_error_is_that_of_the_noise(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    s = np.arange(0.0, 4000.0, 10.0)
    noise = 0.5 * np.random.default_rng(1).standard_normal(len(s))
    file = tmp_path / "line.csv"
    write_table(file, np.column_stack((s, noise)))
    assert main(["fit", str(file), "--tolerance", "3"]) == 0
    found = facts(capsys.readouterr().out)
    assert float(found["rms error"].split()[0]) == pytest.approx(0.5, abs=0.05)
    assert found["tightest curve"] == "none, the road is straight"
    assert found["tolerance"] == "3.00 m"


def test_accuracy_follows_from_the_noise(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    angle = np.arange(0.0, 3.0, 0.02)
    xy = 300.0 * np.column_stack((np.sin(angle), 1.0 - np.cos(angle)))
    file = tmp_path / "drive.csv"
    write_table(file, xy + 2.0 * np.random.default_rng(1).standard_normal(xy.shape))
    assert main(["fit", str(file)]) == 0
    found = facts(capsys.readouterr().out)
    assert re.fullmatch(r"in curves up to [4-7]\.\d m off, by the noise", found["accuracy"])
    assert main(["fit", str(file), "--tolerance", "1"]) == 0
    assert "a curve is tighter than cars turn" in facts(capsys.readouterr().out)["warning"]


def test_picture_has_the_name_of_the_route(
    circle: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["fit", str(circle), "--plot"]) == 0
    picture = (tmp_path / "circle.svg").read_text(encoding="utf-8")
    assert picture.startswith("<svg")
    points = re.search(r"; (\d+) waypoints, the largest error in orange", picture)
    assert points is not None
    assert picture.count("h0") == int(points[1]) + 1  # and that of the largest error
    assert main(["fit", str(circle), "--plot", "other.svg"]) == 0
    assert (tmp_path / "other.svg").is_file()
    assert main(["fit", str(circle), "--plot", "other.png"]) == 2
    assert "--plot must end with .svg, was 'other.png'" in capsys.readouterr().err


def test_parts_and_joints_are_stated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    frame = LocalFrame(45.0, 14.0)
    segments = ""
    for begin in (0.0, 450.0):
        lat, lon = frame.to_geodetic(np.column_stack((begin + np.arange(0.0, 401.0, 20.0), np.zeros(21))))
        points = "".join(
            f'<trkpt lat="{a}" lon="{b}"/>' for a, b in zip(lat.tolist(), lon.tolist(), strict=True)
        )
        segments += f"<trkseg>{points}</trkseg>"
    file = tmp_path / "route.gpx"
    file.write_text(f"<gpx><trk>{segments}</trk></gpx>")
    assert main(["fit", str(file)]) == 0
    found = facts(capsys.readouterr().out)
    assert "2 parts, which were joined over gaps of up to 50 m" in found["warning"]
    assert float(found["length"].split()[0]) == pytest.approx(850.0, abs=1.0)
    assert main(["fit", str(file), "--part", "1"]) == 0
    assert float(facts(capsys.readouterr().out)["length"].split()[0]) == pytest.approx(400.0, abs=1.0)
    assert main(["fit", str(file), "--part", "2"]) == 2
    assert "part must be 0 to 1" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["", "x,y\n1,2\n", "x,y\n1,2\n1,2\n", "lat,lon\n1,x\n", "\0\1"])
def test_file_without_route_has_code_2(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "route.csv"
    file.write_text(text)
    assert main(["fit", str(file)]) == 2
    assert capsys.readouterr().err.startswith("cca fit: ")


def test_road_of_a_map_of_opendrive(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = crossing(tmp_path)
    assert main(["fit", str(file), "--along", "1,5,2", "--plot", str(tmp_path / "a.svg")]) == 0
    found = facts(capsys.readouterr().out)
    length = float(found["length"].split()[0])
    assert length == pytest.approx(180.0 + 10.0 * math.pi, abs=6.0)
    assert (tmp_path / "a.svg").is_file()
    assert main(["fit", str(file)]) == 2
    error = capsys.readouterr().err
    assert "--along must list the ids of roads or edges in driving order; the map has 1, 2, 3, 5, 6" in error
    assert main(["fit", str(file), "--along", "1,4"]) == 2
    assert "--along must be ids of the map, had '4'" in capsys.readouterr().err
    assert main(["fit", str(file), "--along", "1", "--lane", "9"]) == 2
    assert f"{file.name}: lane_id must be one of [-1, 1] of road '1', was 9" in capsys.readouterr().err
    assert main(["fit", str(file), "--along", "1", "--part", "0"]) == 2
    assert "--part and --tolerance must be given with a track alone" in capsys.readouterr().err


def test_road_of_a_net_of_sumo(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(write_net(tmp_path)), "--along", "in,on", "--lane", "0"]) == 0
    found = facts(capsys.readouterr().out)
    assert found["length"] == "400.0 m"
    assert found["lanes"] == "3, from -1.8 m to 8.8 m"
    assert found["speed limits"] == "20.0 m/s, 25.0 m/s"


def test_track_of_utm_has_the_facts_of_that_near_zero(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = []
    for x, y in ((0, 0), (691000, 5335000)):
        file = tmp_path / "route.csv"
        file.write_text("x,y\n" + "".join(f"{x + 20 * k},{y + k * k}\n" for k in range(20)))
        assert main(["fit", str(file)]) == 0
        found.append(facts(capsys.readouterr().out))
    assert found[1].pop("origin") == "x = 691000 m, y = 5335000 m of the file are x = y = 0"
    assert found[1] == found[0]


def test_map_of_utm_states_its_origin(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = moved_file(crossing(tmp_path), ("691234.5", "5334567.25"))
    assert main(["fit", str(file), "--along", "1,5,2"]) == 0
    found = facts(capsys.readouterr().out)
    assert found["origin"] == "x = 691000 m, y = 5335000 m of the file are x = y = 0"
    assert found["speed limits"] == "36.0 m/s (36 where the map has none: set speed_limit)"


def test_words_for_maps_need_a_map(circle: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(circle), "--along", "1"]) == 2
    assert "--along and --lane must be given with a map" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["town.xml", "town.osm"])
def test_map_of_another_kind_names_its_reader(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fit", str(tmp_path / name)]) == 2
    error = capsys.readouterr().err
    assert ".net.xml" in error
    assert "read_commonroad" in error

"""Roads made of files in one call."""

import warnings
from pathlib import Path as FilePath

import numpy as np
import pytest

from cca_core import InputError, Lane, LocalFrame, Road
from cca_core.path import read_waypoints


def track(latitudes: list[np.ndarray]) -> str:
    """GPX file of straight segments to the north."""
    segments = ["".join(f'<trkpt lat="{lat}" lon="11.0"/>' for lat in part) for part in latitudes]
    return "<gpx><trk>" + "".join(f"<trkseg>{rows}</trkseg>" for rows in segments) + "</trk></gpx>"


NORTH = 48.0 + 1e-4 * np.arange(20)  # 11.1 m apart


def put(folder: FilePath, name: str, text: str) -> FilePath:
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def test_road_of_a_track(tmp_path: FilePath) -> None:
    lanes = [Lane(d=0.0), Lane(d=3.5, direction=-1)]
    file = put(tmp_path, "a.gpx", track([NORTH]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        road = Road.from_file(file, lanes, 20.0, [100.0], tolerance=0.5)
    assert road.path.length == pytest.approx(19 * 11.12, rel=1e-3)
    assert (road.lanes, road.speed_limit, road.stop_lines) == (tuple(lanes), 20.0, (100.0,))
    assert isinstance(road.frame, LocalFrame)
    assert (road.frame.lat0, road.frame.lon0) == (48.0, 11.0)
    shifted = Road.from_file(file, origin=(47.999, 11.0))
    np.testing.assert_allclose(shifted.path.position(shifted.path.start), [0.0, 111.2], atol=0.1)


def test_near_parts_are_joined_with_a_warning(tmp_path: FilePath) -> None:
    file = put(tmp_path, "a.gpx", track([NORTH[:10], NORTH[12:]]))
    with pytest.warns(UserWarning, match=r"'a\.gpx' has 2 parts, which were joined over gaps of up to 33 m"):
        road = Road.from_file(file)
    assert road.path.length == pytest.approx(19 * 11.12, rel=1e-3)
    with pytest.raises(InputError, match="point 10 must be at most 20 m apart, were 33 m; give part="):
        Road.from_file(file, max_gap=20.0)


def test_parts_far_apart_are_refused(tmp_path: FilePath) -> None:
    file = put(tmp_path, "a.gpx", track([NORTH, NORTH + 0.0038, NORTH[:1] + 0.01]))
    with pytest.raises(
        InputError, match=r"has 3 parts; those before and after point 20 .* were 211 m; give part="
    ):
        Road.from_file(file)
    road = Road.from_file(file, part=1)
    assert road.path.length == pytest.approx(19 * 11.12, rel=1e-3)
    np.testing.assert_allclose(road.path.position(road.path.start), [0.0, 0.0038 * 111.2e3], atol=0.5)
    with pytest.raises(InputError, match=r"part 2 of file 'a\.gpx' must have at least two points"):
        Road.from_file(file, part=2)
    for part in (3, -1, "x"):
        with pytest.raises(InputError, match="part must be 0 to 2"):
            Road.from_file(file, part=part)  # type: ignore[arg-type]


def test_part_beyond_the_plane_of_the_first_is_read(tmp_path: FilePath) -> None:
    """A file with tracks of two continents: only the part asked for is projected."""
    south = NORTH - 70.0
    file = put(tmp_path, "a.gpx", track([NORTH, south]))
    road = Road.from_file(file, part=1)
    assert road.frame is not None
    assert road.frame.lat0 == pytest.approx(south[0])
    assert road.path.length == pytest.approx(Road.from_file(file, part=0).path.length, rel=0.02)
    with pytest.raises(InputError, match="within 1000 km"):
        Road.from_file(file)


def test_road_of_a_table_in_meters(tmp_path: FilePath) -> None:
    rows = "".join(f"{10 * i};{0.0}\n" for i in range(20))
    road = Road.from_file(put(tmp_path, "a.csv", "x;y\n" + rows))
    assert road.path.length == pytest.approx(190.0)
    assert road.frame is None


def test_refused_file_and_arguments(tmp_path: FilePath) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        Road.from_file(tmp_path / "none.gpx")
    file = put(tmp_path, "a.gpx", track([NORTH]))
    for arguments in ({"max_gap": 0.0}, {"origin": (1.0,)}, {"origin": (95.0, 0.0)}, {"tolerance": -1.0}):
        with pytest.raises(InputError, match=next(iter(arguments)).replace("origin", "origin|lat0")):
            Road.from_file(file, **arguments)  # type: ignore[arg-type]


def test_road_of_the_recorded_drive(data_dir: FilePath) -> None:
    file = data_dir / "gps" / "around-visnjan-with-car.gpx"
    road = Road.from_file(file, tolerance=2.0)
    xy = read_waypoints(file).to_local()
    assert road.path.length == pytest.approx(np.hypot(*np.diff(xy, axis=0).T).sum(), rel=0.02)

"""Waypoints from files, well-formed and not."""

from pathlib import Path as FilePath

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.path import LocalFrame, fit_path, read_waypoints

GPX = '<?xml version="1.0"?><gpx xmlns="http://www.topografix.com/GPX/1/1">{}</gpx>'


def put(folder: FilePath, name: str, text: str | bytes) -> FilePath:
    file = folder / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return file


def points(tag: str, pairs: list[tuple[float, float]]) -> str:
    return "".join(f'<{tag} lat="{lat}" lon="{lon}"><ele>3</ele></{tag}>' for lat, lon in pairs)


A, B, C = (45.1, 13.2), (45.2, 13.3), (45.3, 13.4)


def test_csv_duplicates_are_merged(tmp_path: FilePath) -> None:
    file = put(tmp_path, "a.csv", "ROUTE,LATITUDE,LONGITUDE\nI,1,2\nI,1,2\nI,3,4\nI,3,4\nI,3,4\nI,1,2\n")
    found = read_waypoints(file)
    np.testing.assert_array_equal(found.lat, [1.0, 3.0, 1.0])  # a return is not a duplicate
    np.testing.assert_array_equal(found.lon, [2.0, 4.0, 2.0])
    assert found.duplicates == 3


@pytest.mark.parametrize(
    "header", ["lat,lon", "Lat , LONG", "lon_x,latitude,lng", "latitude_deg,longitude_deg", "\ufefflat,lon"]
)
def test_csv_headers_are_recognized(tmp_path: FilePath, header: str) -> None:
    blank = "x," if header.startswith("lon_x") else ""
    found = read_waypoints(str(put(tmp_path, "a.CSV", f"{header}\r\n{blank}1,2\r\n\r\n{blank}3,4\r\n")))
    np.testing.assert_array_equal(found.lat, [1.0, 3.0])
    np.testing.assert_array_equal(found.lon, [2.0, 4.0])


def test_csv_columns_may_have_any_order(tmp_path: FilePath) -> None:
    found = read_waypoints(put(tmp_path, "a.csv", "lon,name,lat\n100,x,1\n101,y,2\n"))
    np.testing.assert_array_equal(found.lat, [1.0, 2.0])
    np.testing.assert_array_equal(found.lon, [100.0, 101.0])


def test_gpx_track_is_preferred(tmp_path: FilePath) -> None:
    body = points("wpt", [C, C]) + f"<rte>{points('rtept', [B, C])}</rte>"
    track = f"<trk><trkseg>{points('trkpt', [A, A, B])}</trkseg><trkseg>{points('trkpt', [C])}</trkseg></trk>"
    found = read_waypoints(put(tmp_path, "a.gpx", GPX.format(body + track)))
    np.testing.assert_array_equal(found.lat, [A[0], B[0], C[0]])
    assert found.duplicates == 1
    np.testing.assert_array_equal(read_waypoints(put(tmp_path, "b.gpx", GPX.format(body))).lat, [B[0], C[0]])


def test_gpx_needs_no_namespace(tmp_path: FilePath) -> None:
    found = read_waypoints(put(tmp_path, "a.gpx", f"<gpx>{points('trkpt', [A, B])}</gpx>"))
    np.testing.assert_array_equal(found.lon, [A[1], B[1]])


def test_waypoints_are_read_only(tmp_path: FilePath) -> None:
    found = read_waypoints(put(tmp_path, "a.csv", "lat,lon\n1,2\n3,4\n"))
    with pytest.raises(ValueError, match="read-only"):
        found.lat[0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        found.lon[0] = 0.0


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.txt", "lat,lon\n1,2\n3,4\n", r"file must end in \.gpx or \.csv, was 'a\.txt'"),
        ("a.csv", "", r"'a\.csv' must have a header"),
        ("a.csv", "1,2\n3,4\n", r"'a\.csv' must have a header with a latitude and a longitude column"),
        ("a.csv", "lat,height\n1,2\n3,4\n", r"'a\.csv' must have a header"),
        ("a.csv", "lat,lon\n", r"'a\.csv' must have at least two points, had 0"),
        ("a.csv", "lat,lon\n1,2\n", r"'a\.csv' must have at least two points, had 1"),
        ("a.csv", "lat,lon\n1,2\n1,2\n1,2\n", r"'a\.csv' must have at least two different points"),
        ("a.csv", "lat,lon\n1,2\n3\n", r"line 3 of 'a\.csv' has too few columns"),
        ("a.csv", "lat,lon\n1,2\nx,4\n", r"must be numbers, were 'x', '4' in line 3 of 'a\.csv'"),
        ("a.csv", "lat,lon\n1,2\n3,\n", r"must be numbers, were '3', '' in line 3"),
        ("a.csv", "lat,lon\n1,2\n91,4\n", r"latitude must be within \+-90 deg, was 91 in point 1 of 'a\.csv'"),
        ("a.csv", "lat,lon\n1,2\n3,-180.5\n", r"longitude must be within \+-180 deg, was -180\.5 in point 1"),
        ("a.csv", "lat,lon\n-111.04,41.2\n-111.05,41.3\n", r"latitude must be within .* was -111\.04 in point 0"),
        ("a.csv", "lat,lon\n1,2\nnan,4\n", r"latitude must be within .* was nan in point 1"),
        ("a.csv", "lat,lon\n1,2\n3,inf\n", r"longitude must be within .* was inf in point 1"),
        ("a.csv", b"lat,lon\n\xff\xfe,2\n3,4\n", r"'a\.csv' is broken"),
        ("a.gpx", "", r"'a\.gpx' is broken"),
        ("a.gpx", "<gpx><trk>", r"'a\.gpx' is broken"),
        ("a.gpx", "lat,lon\n1,2\n", r"'a\.gpx' is broken"),
        ("a.gpx", b'<?xml version="1.0" encoding="utf-8"?><gpx>\xff</gpx>', r"'a\.gpx' is broken"),
        ("a.gpx", '<?xml version="1.0" encoding="shift_jis"?><gpx/>', r"'a\.gpx' is broken"),
        ("a.gpx", '<?xml version="1.0" encoding="no-such"?><gpx/>', r"'a\.gpx' is broken"),
        ("a.gpx", GPX.format(""), r"'a\.gpx' must have at least two points, had 0"),
        ("a.gpx", GPX.format(points("trkpt", [A])), r"must have at least two points, had 1"),
        ("a.gpx", GPX.format('<trkpt lat="45.1"/>' + points("trkpt", [B])), r"must be numbers, .*point 0"),
        ("a.gpx", GPX.format(points("trkpt", [A, (95.0, 13.0)])), r"latitude .* was 95 in point 1"),
    ],
)  # fmt: skip
def test_broken_file_raises_with_reason(tmp_path: FilePath, name: str, text: str | bytes, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_waypoints(put(tmp_path, name, text))


def test_unreadable_file_raises(tmp_path: FilePath) -> None:
    with pytest.raises(InputError, match=r"nowhere\.csv' cannot be read: No such file"):
        read_waypoints(tmp_path / "nowhere.csv")
    (tmp_path / "folder.gpx").mkdir()
    with pytest.raises(InputError, match=r"folder\.gpx' cannot be read"):
        read_waypoints(tmp_path / "folder.gpx")


@pytest.mark.parametrize("file", [None, 5, ["a.csv"]])
def test_invalid_file_name_raises(file: object) -> None:
    with pytest.raises(InputError, match=r"^file must"):
        read_waypoints(file)  # type: ignore[arg-type]


def worst_residual(xy: np.ndarray, path: object) -> float:
    s = np.linspace(path.start, path.end, int(path.length * 2))  # type: ignore[attr-defined]
    from scipy.spatial import cKDTree

    near = s[cKDTree(path.position(s)).query(xy)[1]]  # type: ignore[attr-defined]
    _, d = path.project(xy, s_guess=near)  # type: ignore[attr-defined]
    return float(np.abs(d).max())


def test_recorded_drive_is_read(data_dir: FilePath) -> None:
    found = read_waypoints(data_dir / "gps" / "around-visnjan-with-car.gpx")
    assert len(found.lat) + found.duplicates == 104
    xy = LocalFrame(found.lat[0], found.lon[0]).to_local(found.lat, found.lon)
    assert np.hypot(*np.diff(xy, axis=0).T).sum() == pytest.approx(2.7e3, rel=0.05)
    path = fit_path(xy, tolerance=0.5)
    assert worst_residual(xy, path) <= 0.5 + 1e-6


def test_recorded_motorway_is_read(data_dir: FilePath) -> None:
    found = read_waypoints(data_dir / "gps" / "I_80_Eastbound_Vertices.csv")
    assert found.duplicates == 344
    assert len(found.lat) == 10415 - 344
    lat, lon = found.lat[:400], found.lon[:400]
    xy = LocalFrame(lat[0], lon[0]).to_local(lat, lon)
    path = fit_path(xy, tolerance=0.3)
    assert worst_residual(xy, path) <= 0.3 + 1e-6
    chord = np.hypot(*np.diff(xy, axis=0).T).sum()
    assert chord * 0.999 <= path.length <= chord * 1.01

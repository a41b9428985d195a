"""Waypoints from files, well-formed and not."""

import json
from datetime import UTC, datetime
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


def test_gpx_parts_elevations_and_times_are_kept(tmp_path: FilePath) -> None:
    def rows(begin: int) -> str:
        return "".join(
            f'<trkpt lat="{45 + 0.001 * i}" lon="13"><ele>{i}</ele>'
            f"<time>2024-05-0{1 + begin}T10:00:{i:02d}.5Z</time>"
            "<extensions><time>never</time><ele>900</ele></extensions></trkpt>"
            for i in range(begin, begin + 3)
        )

    body = (
        f"<trk><trkseg>{rows(0)}</trkseg><trkseg/><trkseg>{rows(3)}</trkseg></trk>"
        f"<trk>{points('trkpt', [C])}</trk>"
    )
    found = read_waypoints(put(tmp_path, "a.gpx", GPX.format(body)))
    assert found.parts.tolist() == [0, 3, 6]
    np.testing.assert_array_equal(found.z, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 3.0])
    begin = datetime(2024, 5, 1, 10, tzinfo=UTC).timestamp()
    np.testing.assert_array_equal(found.t[:4] - begin, [0.5, 1.5, 2.5, 3 * 86400.0 + 3.5])
    assert np.isnan(found.t[6])
    assert repr(found) == "Waypoints(7 points, 3 parts, 0 duplicates and 0 skipped rows)"


def test_gpx_routes_are_parts(tmp_path: FilePath) -> None:
    body = f"<rte>{points('rtept', [A, B])}</rte><rte>{points('rtept', [B, C])}</rte>"
    found = read_waypoints(put(tmp_path, "a.gpx", GPX.format(body)))
    assert (found.parts.tolist(), found.duplicates) == ([0, 2], 1)


@pytest.mark.parametrize(
    "header",
    [
        "lat_deg;lon_deg", "Latitude [deg];Longitude [deg]", "gps_lat\tgps_lon", "position.lat,position.lng",
        "%field.latitude,field.longitude", "/gps/fix/latitude;/gps/fix/longitude", "# lat, lon",
        ".latitude,.longitude", "sep=;\nLAT;LON", '"lat";"lon"', "exported by a logger\nlat,lon",
    ],
)  # fmt: skip
def test_headers_and_delimiters_of_loggers(tmp_path: FilePath, header: str) -> None:
    delimiter = next(mark for mark in "\t;," if mark in header.splitlines()[-1])
    text = f"{header}\n48.5{delimiter}11.5\n48.6{delimiter}11.6\n"
    found = read_waypoints(put(tmp_path, "a.csv", text))
    np.testing.assert_array_equal((found.lat, found.lon), ([48.5, 48.6], [11.5, 11.6]))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_text_encodings_are_recognized(tmp_path: FilePath, encoding: str) -> None:
    text = "Straße;lat;lon\nGrün;48,5;11,5\nGrün;48,6;11,6\n"
    np.testing.assert_array_equal(
        read_waypoints(put(tmp_path, "a.csv", text.encode(encoding))).lat, [48.5, 48.6]
    )


def test_ros_fixes_are_read(tmp_path: FilePath) -> None:
    header = (
        "%time,field.header.seq,field.status.status,field.latitude,field.longitude,field.altitude,"
        "field.position_covariance0"
    )
    rows = [
        "1700000000500000000,1,0,48.1,11.5,520.5,1",
        "1700000001500000000,2,-1,48.3,11.5,520,1",
        "1700000002500000000,3,0,48.2,11.5,nan,1",
    ]
    found = read_waypoints(put(tmp_path, "a.csv", "\n".join([header, *rows])))
    np.testing.assert_array_equal(found.lat, [48.1, 48.2])
    np.testing.assert_allclose(found.t, [1700000000.5, 1700000002.5])
    assert found.z[0] == 520.5
    assert np.isnan(found.z[1])
    assert found.skipped == 1


@pytest.mark.parametrize(
    "header",
    ["x,y,z", "x_m,y_m", "X [m];Y [m]", "east,north", "easting;northing", "t,pose.position.x,pose.position.y,"
     "pose.orientation.x,pose.orientation.y"],
)  # fmt: skip
def test_table_in_meters_is_read(tmp_path: FilePath, header: str) -> None:
    delimiter = ";" if ";" in header else ","
    columns = header.split(delimiter)
    rows = [["7"] * columns.index(columns[-1]) for _ in range(3)]
    for i, row in enumerate(rows):
        begin = 1 if header.startswith("t,") else 0
        row[begin : begin + 2] = [str(10.5 * i), str(-2.5 * i)]
    text = "\n".join([header, *(delimiter.join(row) for row in rows)])
    found = read_waypoints(put(tmp_path, "a.csv", text))
    np.testing.assert_array_equal(found.xy, [[0.0, 0.0], [10.5, -2.5], [21.0, -5.0]])
    assert (len(found.lat), len(found.lon)) == (0, 0)
    np.testing.assert_array_equal(found.to_local((10.5, -2.5))[0], [-10.5, 2.5])


def test_projected_coordinates_need_an_origin(tmp_path: FilePath) -> None:
    found = read_waypoints(put(tmp_path, "a.csv", "easting,northing\n691000,5334000\n691010,5334000\n"))
    with pytest.raises(InputError, match=r"give origin=\(691000, 5\.334e\+06\)"):
        found.to_local()
    np.testing.assert_array_equal(found.to_local((691000.0, 5334000.0)), [[0.0, 0.0], [10.0, 0.0]])


@pytest.mark.parametrize(
    "row",
    [
        ",", "48.3,", ",11.5", "nan,nan", "NaN,11.5", "null,null", "N/A,N/A", "-,-", "48.3", "x,11.5", "0,0",
        "0.0,-0.0", "inf,11",
    ],
)  # fmt: skip
def test_row_without_a_fix_is_skipped_and_counted(tmp_path: FilePath, row: str) -> None:
    file = put(tmp_path, "a.csv", f"lat,lon\n48.0,11.5\n48.1,11.5\n{row}\n48.2,11.5\n")
    found = read_waypoints(file)
    np.testing.assert_array_equal(found.lat, [48.0, 48.1, 48.2])
    assert found.skipped == 1
    with pytest.raises(InputError, match=r"must be numbers, .* in line 4 of 'a\.csv'"):
        read_waypoints(file, skip_invalid=False)


def test_equator_and_meridian_are_a_position(tmp_path: FilePath) -> None:
    found = read_waypoints(put(tmp_path, "a.csv", "lat,lon\n-0.001,0\n0,0\n0.001,0\n"))
    assert (len(found.lat), found.skipped) == (3, 0)


def test_geojson_lines_are_parts(tmp_path: FilePath) -> None:
    def feature(kind: str, coordinates: object, **properties: object) -> dict[str, object]:
        geometry = {"type": kind, "coordinates": coordinates}
        return {"type": "Feature", "properties": properties, "geometry": geometry}

    line = [[11.0, 48.0, 500.0], [11.1, 48.1]]
    two = [[[11.2, 48.2], [11.3, 48.3]], [[11.4, 48.4], [None, None], [11.5, 48.5]]]
    features = [
        feature("LineString", line, coordTimes=["2024-05-01T00:00:00Z", "2024-05-01T00:00:01Z"]),
        feature("Point", [1.0, 2.0]), feature("MultiLineString", two), feature("Polygon", [line]),
        {"type": "Feature", "geometry": None, "properties": None},
    ]  # fmt: skip
    text = json.dumps({"type": "FeatureCollection", "features": features})
    for name in ("a.geojson", "a.json"):
        found = read_waypoints(put(tmp_path, name, text))
        np.testing.assert_array_equal(found.lat, [48.0, 48.1, 48.2, 48.3, 48.4, 48.5])
        assert (found.parts.tolist(), found.skipped) == ([0, 2, 4], 1)
        assert found.z[0] == 500.0
        assert found.t[1] - found.t[0] == 1.0
    bare = json.dumps(
        {"type": "GeometryCollection", "geometries": [{"type": "LineString", "coordinates": line}]}
    )
    np.testing.assert_array_equal(read_waypoints(put(tmp_path, "b.json", bare)).lon, [11.0, 11.1])
    dots = json.dumps({"type": "FeatureCollection", "features": [feature("Point", p) for p in line]})
    np.testing.assert_array_equal(read_waypoints(put(tmp_path, "c.json", dots)).lon, [11.0, 11.1])


def test_kml_lines_and_tracks_are_parts(tmp_path: FilePath) -> None:
    line = (
        "<Placemark><LineString><coordinates>\n 11.0,48.0,500 11.1,48.1,501\n</coordinates></LineString>"
        "</Placemark>"
    )
    track = (
        "<Placemark><gx:Track><when>2024-05-01T00:00:00Z</when><when>2024-05-01T00:00:02Z</when>"
        "<gx:coord>11.2 48.2 502</gx:coord><gx:coord>11.3 48.3 503</gx:coord></gx:Track></Placemark>"
    )
    pin = "<Placemark><Point><coordinates>1,2</coordinates></Point></Placemark>"
    head = (
        '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Document>'
    )
    found = read_waypoints(put(tmp_path, "a.kml", f"{head}{pin}{line}{track}</Document></kml>"))
    np.testing.assert_array_equal(found.lat, [48.0, 48.1, 48.2, 48.3])
    np.testing.assert_array_equal(found.z, [500.0, 501.0, 502.0, 503.0])
    assert found.parts.tolist() == [0, 2]
    assert found.t[3] - found.t[2] == 2.0


def sentence(body: str) -> str:
    checksum = 0
    for letter in body.encode():
        checksum ^= letter
    return f"${body}*{checksum:02X}\r\n"


def test_nmea_epochs_are_read(tmp_path: FilePath) -> None:
    # from manuals of the standard
    known = "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n"
    lines = [
        sentence("GPGSV,3,1,11,03,03,111,00"),
        known, sentence("GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"),
        sentence("GNGGA,123520,4807.050,N,01131.010,E,0,00,,,M,,M,,"),  # no fix
        sentence("GNRMC,123521,V,,,,,,,230394,,"),
        sentence("GNRMC,123522.50,A,4807.060,S,01131.020,W,1,2,230394,,"),
        sentence("GPRMC,123523,A,4807.070,N,01131.030,E,1,2,230394,,").replace("4807", "4907"),  # damaged
        "garbage\r\n",
    ]  # fmt: skip
    for name in ("a.nmea", "a.log", "a.txt"):
        found = read_waypoints(put(tmp_path, name, "".join(lines if name == "a.nmea" else lines[1:])))
        np.testing.assert_allclose(found.lat, [48.0 + 7.038 / 60.0, -48.0 - 7.06 / 60.0], rtol=1e-14)
        np.testing.assert_allclose(found.lon, [11.0 + 31.0 / 60.0, -11.0 - 31.02 / 60.0], rtol=1e-14)
        assert found.z[0] == 545.4
        begin = datetime(1994, 3, 23, 12, 35, 19, tzinfo=UTC).timestamp()
        np.testing.assert_allclose(found.t - begin, [0.0, 3.5])
        assert found.skipped == 3


def test_nmea_without_dates_passes_midnight(tmp_path: FilePath) -> None:
    times = ("235958", "235959", "000000", "000001")
    lines = [sentence(f"GPGGA,{t},480{i}.0,N,01131.0,E,1,08,0.9,5,M,4,M,,") for i, t in enumerate(times)]
    found = read_waypoints(put(tmp_path, "a.nmea", "".join(lines)))
    np.testing.assert_array_equal(np.diff(found.t), 1.0)


BROKEN = [
    ("a.dat", "lat,lon\n1,2\n3,4\n", r"file must end in \.gpx, .* was 'a\.dat'"),
    ("a.csv", "", r"'a\.csv' must have a header"),
    ("a.csv", "1,2\n3,4\n", r"'a\.csv' must have a header with a latitude and a longitude column"),
    ("a.csv", "lat,height\n1,2\n3,4\n", r"'a\.csv' must have a header"),
    ("a.csv", "lat_rad,lon_rad\n1,2\n3,4\n", r"'a\.csv' must have a header"),
    ("a.csv", "lat,lon\n", r"'a\.csv' must have at least two points, had 0"),
    ("a.csv", "lat,lon\n1,2\n", r"'a\.csv' must have at least two points, had 1"),
    ("a.csv", "lat,lon\n1,2\n1,2\n1,2\n", r"'a\.csv' must have at least two different points"),
    ("a.csv", "lat,lon\n1,2\n3\n", r"two points, had 1; 1 without a position"),
    ("a.csv", "lat,lon\n1,2\n1_0,\u0663\n", r"two points, had 1; 1 without a position"),
    ("a.csv", b"lat,lon\n\xff\xfe,2\n3,4\n", r"two points, had 1; 1 without a position"),
    ("a.csv", "lat,lon\n1,2\n91,4\n", r"latitude must be within \+-90 deg, was 91 in point 1 of 'a\.csv'"),
    ("a.csv", "lat,lon\n1,2\n3,-180.5\n", r"longitude must be within \+-180 deg, was -180\.5 in point 1"),
    ("a.csv", "lat,lon\n-111.04,41.2\n-111.05,41.3\n", r"latitude must be within .* was -111\.04 in point 0"),
    ("a.csv", "x,y\n11.51,48.1\n11.52,48.2\n", r"must extend over 1 m or more; are they degrees"),
    ("a.csv", f"x,y\n1,{'9' * 30}\n2,3\n", r"y must be within \+-2e\+07 m"),
    ("a.csv", f'lat,lon\n1,"{"2" * 200_000}"\n3,4\n', r"'a\.csv' is broken in line"),
    ("a.gpx", "", r"'a\.gpx' is broken"),
    ("a.gpx", "<gpx><trk>", r"'a\.gpx' is broken"),
    ("a.gpx", "lat,lon\n1,2\n", r"'a\.gpx' is broken"),
    ("a.gpx", b'<?xml version="1.0" encoding="utf-8"?><gpx>\xff</gpx>', r"'a\.gpx' is broken"),
    ("a.gpx", '<?xml version="1.0" encoding="shift_jis"?><gpx/>', r"'a\.gpx' is broken"),
    ("a.gpx", '<?xml version="1.0" encoding="no-such"?><gpx/>', r"'a\.gpx' is broken"),
    ("a.gpx", '<!DOCTYPE gpx [<!ENTITY a "1">]><gpx>&a;</gpx>', "DOCTYPE must not occur"),
    ("a.kml", "<!DOCTYPE kml><kml/>", "DOCTYPE must not occur"),
    ("a.gpx", "<a>" * 101 + "</a>" * 101, "nested at most 100 deep"),
    ("a.gpx", GPX.format(""), r"'a\.gpx' must have at least two points, had 0"),
    ("a.gpx", GPX.format(points("trkpt", [A])), r"must have at least two points, had 1"),
    ("a.gpx", GPX.format('<trkpt lat="45.1"/>' + points("trkpt", [B])), r"two points, had 1; 1 without"),
    ("a.gpx", GPX.format(points("trkpt", [A, (95.0, 13.0)])), r"latitude .* was 95 in point 1"),
    ("a.json", "[" * 101 + "]" * 101, "nested at most 100 deep"),
    ("a.json", "{", "must be JSON, was not"),
    ("a.json", '{"type": "Point", "coordinates": [' + "1" * 5000 + "]}", "must be JSON, was not"),
    ("a.json", "[1, 2]", "must hold GeoJSON objects, had a list"),
    ("a.json", '{"features": [1]}', "must hold GeoJSON objects, had a int"),
    ("a.json", '{"type": "LineString", "coordinates": {"a": 1}}', "two points, had 0; 1 without"),
    (
        "a.json",
        '{"type": "LineString", "coordinates": [[1e400, 2], [true, "x"], 5]}',
        "two points, had 0; 3 without",
    ),
    ("a.nmea", "lat,lon\n1,2\n", r"must have NMEA sentences RMC or GGA"),
]


@pytest.mark.parametrize(("name", "text", "words"), BROKEN, ids=range(len(BROKEN)))
def test_broken_file_raises_with_reason(tmp_path: FilePath, name: str, text: str | bytes, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_waypoints(put(tmp_path, name, text))


@pytest.mark.parametrize("name", ["a.gpx", "a.kml", "a.csv", "a.json", "a.nmea"])
def test_large_file_is_refused(tmp_path: FilePath, name: str) -> None:
    with (tmp_path / name).open("wb") as stream:
        stream.truncate(50_000_001)
    with pytest.raises(InputError, match="at most 50 MB"):
        read_waypoints(tmp_path / name)


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


@pytest.mark.parametrize("kind", ['["LineString"]', '{"a": 1}', "1", "null"])
def test_geojson_type_of_other_kind_is_no_line(tmp_path: FilePath, kind: str) -> None:
    file = put(tmp_path, "a.geojson", f'{{"type": {kind}, "coordinates": [[0, 0], [0, 1]]}}')
    with pytest.raises(InputError):
        read_waypoints(file)

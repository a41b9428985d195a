"""East-north-up coordinates, against pymap3d."""

import math

import numpy as np
import pymap3d
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cca_core.errors import InputError
from cca_core.path import LocalFrame

ORIGINS = [(45.27, 13.72), (41.2476, -111.0467), (0.0, 0.0), (-33.9, 151.2), (69.6, 179.95), (89.99, 20.0)]


@pytest.mark.parametrize(("lat0", "lon0"), ORIGINS)
def test_frame_equals_pymap3d_over_50_km(lat0: float, lon0: float) -> None:
    rng = np.random.default_rng(1)
    r, azimuth = rng.uniform(0.0, 50e3, 500), rng.uniform(0.0, 360.0, 500)
    lat, lon, _ = pymap3d.enu2geodetic(
        r * np.sin(np.radians(azimuth)), r * np.cos(np.radians(azimuth)), np.zeros(500), lat0, lon0, 0.0
    )
    east, north, _ = pymap3d.geodetic2enu(lat, lon, np.zeros(500), lat0, lon0, 0.0)
    xy = LocalFrame(lat0, lon0).to_local(lat, lon)
    np.testing.assert_allclose(xy, np.column_stack((east, north)), rtol=0.0, atol=1e-5)


@given(st.floats(-89.0, 89.0), st.floats(-180.0, 180.0), st.floats(0.0, 50e3), st.floats(0.0, 2.0 * math.pi))
@example(0.0, 180.0, 5e4, 1.0)
@example(60.0, -180.0, 5e4, 4.0)
def test_round_trip_from_meters(lat0: float, lon0: float, r: float, azimuth: float) -> None:
    frame = LocalFrame(lat0, lon0)
    xy = np.array([r * math.cos(azimuth), r * math.sin(azimuth)])
    lat, lon = frame.to_geodetic(xy)
    np.testing.assert_allclose(frame.to_local(lat, lon), xy, rtol=0.0, atol=1e-6)


@given(st.floats(-80.0, 80.0), st.floats(-179.0, 179.0), st.floats(-0.45, 0.45), st.floats(-0.45, 0.45))
def test_round_trip_from_degrees(lat0: float, lon0: float, north: float, east: float) -> None:
    lat, lon = LocalFrame(lat0, lon0).to_geodetic(LocalFrame(lat0, lon0).to_local(lat0 + north, lon0 + east))
    assert float(lat) == pytest.approx(lat0 + north, abs=1e-9)
    assert float(lon) == pytest.approx(lon0 + east, abs=1e-9)


def test_east_is_x_and_north_is_y() -> None:
    frame = LocalFrame(45.0, 14.0)
    np.testing.assert_array_equal(frame.to_local(45.0, 14.0), [0.0, 0.0])
    east, north = frame.to_local([45.0, 45.001], [14.001, 14.0])
    # radii of curvature at 45 deg: N = 6388838.290 m, M = 6367381.816 m (WGS 84)
    assert east[0] == pytest.approx(6388838.290 * math.cos(math.radians(45.0)) * math.radians(1e-3), abs=1e-4)
    assert north[1] == pytest.approx(6367381.816 * math.radians(1e-3), abs=1e-4)
    assert abs(east[1]) < 1e-2
    assert abs(north[0]) < 1e-9


def test_shapes_are_preserved() -> None:
    frame = LocalFrame(45.0, 14.0)
    assert frame.to_local(45.0, 14.0).shape == (2,)
    assert frame.to_local([[45.0], [45.1]], [[14.0], [14.0]]).shape == (2, 1, 2)
    assert frame.to_local([], []).shape == (0, 2)
    lat, lon = frame.to_geodetic(np.zeros((3, 1, 2)))
    assert lat.shape == lon.shape == (3, 1)


@pytest.mark.parametrize(
    ("lat0", "lon0", "name"),
    [(91.0, 0.0, "lat0"), (-111.05, 41.2, "lat0"), (0.0, 181.0, "lon0"), (math.nan, 0.0, "lat0"),
     (0.0, math.inf, "lon0"), (None, 0.0, "lat0"), (0.0, "east", "lon0")],
)  # fmt: skip
def test_invalid_origin_raises(lat0: object, lon0: object, name: str) -> None:
    with pytest.raises(InputError, match=rf"^{name} must be"):
        LocalFrame(lat0, lon0)  # type: ignore[arg-type]


def test_swapped_coordinates_out_of_range_raise() -> None:
    with pytest.raises(InputError, match=r"^lat must be within \+-90 deg, was 111\.05; .*mixed up\?"):
        LocalFrame(41.2, -111.0).to_local([-111.05], [41.2])


@pytest.mark.parametrize(("lat0", "lon0"), [(45.27, 13.72), (-33.9, 18.4), (10.0, 40.0), (41.2, -87.6)])
def test_swapped_coordinates_in_range_raise(lat0: float, lon0: float) -> None:
    with pytest.raises(InputError, match=r"lat, lon .*mixed up\?"):
        LocalFrame(lat0, lon0).to_local([lon0, lon0 + 0.001], [lat0, lat0])


def test_far_side_of_earth_is_rejected() -> None:
    with pytest.raises(InputError, match="km away"):
        LocalFrame(45.0, 14.0).to_local(-45.0, -166.0)


@pytest.mark.parametrize(
    ("lat", "lon", "words"),
    [
        ([45.0, math.nan], [14.0, 14.0], r"^lat must be finite"),
        ([45.0], [math.inf], r"^lon must be finite"),
        ([45.0], [180.5], r"^lon must be within \+-180"),
        ([95.0], [14.0], r"^lat must be within \+-90"),
        ([45.0, 45.1], [14.0], r"^lon must have the shape of lat"),
        (["north"], [14.0], r"^lat must be"),
        ([45.0], [None], r"^lon must be"),
        ([[45.0], [45.0, 46.0]], [14.0], r"^lat must be"),
    ],
)
def test_invalid_positions_raise(lat: object, lon: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        LocalFrame(45.0, 14.0).to_local(lat, lon)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "xy",
    [
        5.0,
        [1.0, 2.0, 3.0],
        [[math.nan, 0.0]],
        [0.0, math.inf],
        [0.0, 1.1e6],
        [["a", "b"]],
        [[1.0], [1.0, 2.0]],
    ],
)
def test_invalid_points_raise(xy: object) -> None:
    with pytest.raises(InputError, match=r"^xy must"):
        LocalFrame(45.0, 14.0).to_geodetic(xy)  # type: ignore[arg-type]

"""Vehicle records: ranges, presets, defects."""

import dataclasses
import math

import numpy as np
import pytest

from cca_core.errors import InputError
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

PRESETS = [VehicleParams.bmw_320i, VehicleParams.ford_escort, VehicleParams.vw_vanagon]
BMW = VehicleParams.bmw_320i()
ALL_FIELDS = [field.name for field in dataclasses.fields(VehicleParams)]
POSITIVE = [name for name in ALL_FIELDS if name not in ("box_offset", "steering_lag")]
STATE_FIELDS = [field.name for field in dataclasses.fields(VehicleState)]


@pytest.mark.parametrize("name", ALL_FIELDS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, None, "", "2100", [1.0]])
def test_params_that_are_not_finite_raise(name: str, value: object) -> None:
    with pytest.raises(InputError, match=rf"^{name} must be"):
        dataclasses.replace(BMW, **{name: value})


@pytest.mark.parametrize("name", POSITIVE)
@pytest.mark.parametrize("value", [0.0, -1e-9, -1500.0])
def test_params_that_are_not_positive_raise(name: str, value: float) -> None:
    with pytest.raises(InputError, match=rf"^{name} must be greater than 0, was"):
        dataclasses.replace(BMW, **{name: value})


def test_zero_wheelbase_raises() -> None:
    with pytest.raises(InputError, match=r"^l_f must be greater than 0"):
        dataclasses.replace(BMW, l_f=0.0, l_r=0.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [("box_offset", 5.1), ("box_offset", -5.1), ("steering_lag", -0.1),
     ("m", 2.1), ("I_z", 3.9), ("C_f", 110.0), ("C_r", 130.0)],  # in tonnes, kilonewtons
)  # fmt: skip
def test_params_out_of_range_raise(name: str, value: float) -> None:
    with pytest.raises(InputError, match=rf"^{name} must be at"):
        dataclasses.replace(BMW, **{name: value})


def test_params_at_limits_are_accepted() -> None:
    assert dataclasses.replace(BMW, steering_lag=0.0).steering_lag == 0.0
    assert dataclasses.replace(BMW, box_offset=-5.0).box_offset == -5.0


def test_params_are_frozen_and_keyword_only() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        BMW.m = 1.0  # type: ignore[misc]
    with pytest.raises(TypeError):
        VehicleParams(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)  # type: ignore[misc]


# theory.md, Follow: the source's C = 21.92 Fz makes it exactly neutral, the table's rounding hides that
@pytest.mark.parametrize("preset", PRESETS)
def test_presets_are_neutral_steer(preset: type) -> None:
    """In degrees per g the understeer gradient is m g (l_r / C_f - l_f / C_r) / L: within table rounding."""
    car = preset()
    per_g = math.degrees(car.understeer_gradient * 9.81)
    assert abs(per_g) < 0.01
    assert car.wheelbase == car.l_f + car.l_r


def test_understeer_gradient_closed_form() -> None:
    car = dataclasses.replace(BMW, m=1500.0, l_f=1.2, l_r=1.6, C_f=80e3, C_r=120e3)
    assert car.wheelbase == pytest.approx(2.8, abs=1e-15)
    assert car.understeer_gradient == pytest.approx(1500.0 / 2.8 * (1.6 / 80e3 - 1.2 / 120e3), rel=1e-14)
    assert car.understeer_gradient > 0.0
    assert dataclasses.replace(car, C_f=120e3, C_r=80e3).understeer_gradient < 0.0


@pytest.mark.parametrize(
    ("preset", "expected"),
    [
        (VehicleParams.ford_escort, (1225.9, 1538.9, 0.884, 1.509, 166.2e3, 97.4e3)),
        (VehicleParams.bmw_320i, (1093.3, 1791.6, 1.156, 1.423, 129.7e3, 105.4e3)),
        (VehicleParams.vw_vanagon, (1478.9, 2473.1, 1.151, 1.321, 170.0e3, 148.1e3)),
    ],
)
def test_presets_equal_published_values(preset: type, expected: tuple) -> None:
    car = preset()
    assert (car.m, car.I_z, car.l_f, car.l_r, car.C_f, car.C_r) == expected


@pytest.mark.parametrize("name", STATE_FIELDS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_state_that_is_not_finite_raises(name: str, value: float) -> None:
    good = {"x": 1.0, "y": 2.0, "psi": 0.1, "v_x": 10.0}
    with pytest.raises(InputError, match=rf"^{name} must be finite"):
        VehicleState(**{**good, name: value})


def test_state_error_names_first_of_two_infinities() -> None:
    with pytest.raises(InputError, match=r"^x must be finite, was inf"):
        VehicleState(x=math.inf, y=-math.inf, psi=0.0, v_x=0.0)


@pytest.mark.parametrize("name", STATE_FIELDS)
@pytest.mark.parametrize("value", [None, "fast"])
def test_state_that_is_no_number_raises(name: str, value: object) -> None:
    good = {"x": 1.0, "y": 2.0, "psi": 0.1, "v_x": 10.0}
    if name == "t" and value is None:  # no time of measurement
        return
    with pytest.raises(InputError, match=rf"^{name} must be"):
        VehicleState(**{**good, name: value})


def test_state_with_negative_speed_beyond_noise_raises() -> None:
    with pytest.raises(InputError, match=r"^v_x must be at least -0\.5 m/s.*was -0\.6"):
        VehicleState(x=0.0, y=0.0, psi=0.0, v_x=-0.6)
    assert VehicleState(x=0.0, y=0.0, psi=0.0, v_x=-0.5).v_x == -0.5


def remote(**changes: object) -> RemoteVehicle:
    return RemoteVehicle(**{"id": "A", "x": 0.0, "y": 0.0, "psi": 0.0, "v_x": 20.0, **changes})


def test_valid_record_has_no_invalid_reason() -> None:
    assert remote().invalid_reason is None
    assert remote(v_x=0, psi=7, length=400.0, width=20.0, age=0.0).invalid_reason is None
    assert remote(v_x=np.float64(12.5), x=np.float64(3.0)).invalid_reason is None
    assert remote(v_x=-20.0).invalid_reason is None
    assert remote(z=math.nan, sigma_z=math.nan).invalid_reason is None  # an unknown height blocks


@pytest.mark.parametrize(
    "name", ["x", "y", "psi", "v_x", "a_x", "r", "length", "width", "age", "sigma_along", "sigma_across"]
)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, None, "12", 1j, 10**400])
def test_invalid_reason_names_field(name: str, value: object) -> None:
    reason = remote(**{name: value}).invalid_reason
    assert reason is not None
    assert reason.startswith(f"{name} must be a finite number")


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"length": 0.0}, "length and width"),
        ({"length": 400.1}, "length and width"),
        ({"width": -1.8}, "length and width"),
        ({"width": 20.1}, "length and width"),
        ({"v_x": 100.1}, "v_x"),
        ({"v_x": -20.1}, "v_x"),
        ({"age": -0.01}, "age and sigmas"),
        ({"sigma_along": -0.1}, "sigma"),
        ({"sigma_across": -0.1}, "sigma"),
        ({"sigma_along": 1.1e3}, "sigma"),
        ({"age": 3601.0}, "age and sigmas"),
        ({"x": -1.1e6}, "position"),
        ({"y": 1.1e6}, "position"),
        ({"a_x": 101.0}, "a_x"),
        ({"r": -101.0}, "a_x and r"),
        ({"id": 7}, "id"),
        ({"events": ["hard_braking"]}, "events"),
    ],
)
def test_invalid_reason_text(changes: dict, word: str) -> None:
    reason = remote(**changes).invalid_reason
    assert reason is not None
    assert word in reason


def test_numpy_numbers_are_valid() -> None:
    assert remote(v_x=np.int64(20)).invalid_reason is None
    assert remote(length=np.float32(4.5)).invalid_reason is None


def test_body_at_pose_is_centered_at_box_offset() -> None:
    car = dataclasses.replace(BMW, box_offset=0.4)
    body = car.body_at([1.0, 2.0], [3.0, 4.0], [0.0, 0.5 * math.pi])
    np.testing.assert_allclose(body.x, [1.4, 2.0], atol=1e-12)
    np.testing.assert_allclose(body.y, [3.0, 4.4], atol=1e-12)
    assert (car.front, car.rear) == (0.4 + 0.5 * car.length, 0.4 - 0.5 * car.length)
    for x, y, psi, center in zip(
        body.x - [0.4, 0.0], body.y - [0.0, 0.4], body.psi, zip(body.x, body.y, strict=True), strict=True
    ):
        assert car.center_at(x, y, psi) == pytest.approx(center, abs=1e-12)

"""Uncertainty bounds of dead-reckoned positions against recorded messages."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from cca_core import LocalFrame, RemoteVehicle
from cca_core.predict import predict_ctra
from cca_core.v2x import Fix, PositionErrorModel, Tracker, dead_reckon, decode_bsm, position_bounds
from tests.support.v2x_messages import T0


@given(
    st.floats(-20.0, 60.0), st.floats(-10.0, 10.0), st.floats(-1.0, 1.0), st.floats(-4.0, 4.0),
    st.floats(0.0, 1.0),
)  # fmt: skip
def test_dead_reckoning_equals_ctra(v: float, a: float, r: float, psi: float, age: float) -> None:
    fix = dead_reckon(Fix(5.0, 1.0, 2.0, psi, v, a, r), 5.0 + age)
    remote = RemoteVehicle(id="", x=1.0, y=2.0, psi=psi, v_x=v, a_x=a, r=r)
    assert fix[1:4] == pytest.approx([float(c) for c in predict_ctra(remote, age)], abs=1e-8)


@given(st.floats(-20.0, 100.0), st.floats(0.0, 3000.0), st.floats(0.0, 100.0))
def test_bounds_grow_with_age(v: float, age: float, more: float) -> None:
    new, old = position_bounds(v, age), position_bounds(v, age + more)
    assert all(0.0 < a <= b < math.inf for a, b in zip(new, old, strict=True))


def test_error_model_widens_bounds() -> None:
    wide = PositionErrorModel(along=1.1, across=0.135, assumed_acceleration=10.0)
    for age in (0.0, 0.5, 1.5):
        default, wider = position_bounds(20.0, age), position_bounds(20.0, age, model=wide)
        assert wider[0] - default[0] == pytest.approx(1.0 + max(age - 1.0, 0.0) ** 2)
        assert wider[1] - default[1] == pytest.approx(0.1)


@dataclass
class Prediction:
    """Error of a recorded position against an earlier prediction."""

    row: int
    target: int
    horizon: float
    age: float
    v: float
    along: float
    across: float
    bound_along: float
    bound_across: float

    @property
    def is_within(self) -> bool:
        return abs(self.along) <= self.bound_along and abs(self.across) <= self.bound_across


@pytest.fixture(scope="module")
def predictions(data_dir: FilePath) -> list[Prediction]:
    """After each message: the first position reported at least a horizon (and at most 0.5 s) later."""
    with (data_dir / "bsm" / "wyoming_rx_decoded.csv").open() as file:
        messages = [decode_bsm(bytes.fromhex(row["uper_hex"])) for row in csv.DictReader(file)]
    frame = LocalFrame(messages[0].latitude_deg, messages[0].longitude_deg)
    xy = frame.to_local([m.latitude_deg for m in messages], [m.longitude_deg for m in messages])
    found = []
    for begin, end in ((0, 138), (138, 243)):  # two drives
        marks = np.array([m.sec_mark for m in messages[begin:end]])
        t = T0 + marks + 60.0 * np.cumsum(np.diff(marks, prepend=marks[0]) < -30.0)
        tracker = Tracker(frame)
        for i in range(end - begin):
            result = tracker.update(messages[begin + i], float(t[i]) + 0.05)
            assert result.accepted or result.kind == "frozen"
            for horizon in (0.1, 0.5, 1.0):
                j = int(np.searchsorted(t, t[i] + horizon - 0.005))
                if j == len(t) or t[j] > t[i] + horizon + 0.5:
                    continue
                (vehicle,) = tracker.vehicles(float(t[j]))
                off = complex(*(xy[begin + j] - (vehicle.x, vehicle.y))) * np.exp(-1j * vehicle.psi)
                found.append(
                    Prediction(
                        begin + i, begin + j, horizon, vehicle.age, vehicle.v_x, off.real, off.imag,
                        2.0 * vehicle.sigma_along, 2.0 * vehicle.sigma_across,
                    )
                )  # fmt: skip
    return found


HALF = 121  # of 243 messages


def rounded_up(value: float, digits: int = 2) -> float:
    """Round up to significant digits."""
    unit = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    return math.ceil(value / unit - 1e-9) * unit


def test_bounds_equal_largest_errors_of_first_half(predictions: list[Prediction]) -> None:
    """The rule of the default constants; it does not use the second half."""
    first = [p for p in predictions if p.target < HALF]
    age, v, along, across = np.array([(p.age, p.v, abs(p.along), abs(p.across)) for p in first]).T
    assert len(first) > 300
    limit, rate = rounded_up(max(along / v)), rounded_up(max(along / (v * age)))
    # the line of least mean that no error across exceeds
    line = linprog(
        [len(age), age.sum()], A_ub=-np.column_stack((np.ones_like(age), age)), b_ub=-across, method="highs"
    )
    new, growth = (rounded_up(float(value)) for value in line.x)
    for moment in (0.0, 0.05, 0.1, 0.2, 1.0):
        for speed in (0.0, 12.0, 30.0):
            expected = 0.1 + speed * min(rate * moment, limit), new + growth * moment
            assert position_bounds(speed, moment) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("horizon", [0.1, 0.5, 1.0])
def test_bounds_hold_on_the_second_half(predictions: list[Prediction], horizon: float) -> None:
    selected = [p for p in predictions if p.horizon == horizon and p.row >= HALF]
    assert len(selected) > 70
    assert 0.93 <= np.mean([p.is_within for p in selected]) <= 0.99
    errors = np.sort([abs(p.along) for p in selected])
    constant = errors[math.ceil(0.95 * len(errors)) - 1]
    assert np.mean([p.bound_along for p in selected]) <= 1.5 * constant


def test_safety_distance_covers_recorded_errors(predictions: list[Prediction]) -> None:
    """7 m, up to the age at which a track is stale."""
    errors = np.abs([p.along for p in predictions])
    assert np.mean(errors <= 7.0) >= 0.99
    assert errors.max() < 8.0

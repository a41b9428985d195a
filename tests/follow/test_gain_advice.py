"""Gains for own vehicles: what an error of the design names works, and oversteer is stated."""

import math
import pickle
import re
import warnings
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cca_core.follow import NoGainsError, StabilityRegion, design_gains, has_shipped_gains, shipped_gains
from cca_core.vehicle import VehicleParams

VAN = VehicleParams(m=2500, I_z=5500, l_f=1.6, l_r=1.9, C_f=90000, C_r=110000, length=5.9, width=2.0)
OVERSTEER = VehicleParams(m=1500, I_z=2500, l_f=1.4, l_r=1.2, C_f=110e3, C_r=90e3, length=4.5, width=1.8)
SWAPPED = VehicleParams(m=2500, I_z=4000, l_f=2.0, l_r=1.0, C_f=160e3, C_r=40e3, length=4.5, width=1.8)
DEFAULT_SPEEDS = shipped_gains(VAN).speeds
SPEEDS = (2.0, 4.0, 8.0, 13.0, 20.0, 30.0, 40.0)
ADVICE = re.compile(r"region=(StabilityRegion\(.*\)) works (?:at all speeds|up to ([\d.]+) m/s)$")


@st.composite
def vehicles(draw: st.DrawFn, balance: tuple[float, float] = (1.0, 1.5)) -> VehicleParams:
    """Cars, vans and trucks of 1 to 3.5 t; understeering, unless `balance` C_r l_r / C_f l_f is below 1."""
    mass, wheelbase = draw(st.floats(1000.0, 3500.0)), draw(st.floats(2.3, 4.6))
    l_f = wheelbase * draw(st.floats(0.38, 0.56))
    l_r = wheelbase - l_f
    front = draw(st.floats(5.0, 15.0)) * mass * 9.81 * l_r / wheelbase  # stiffness per load [1/rad]
    return VehicleParams(
        m=mass, I_z=draw(st.floats(0.8, 1.3)) * mass * l_f * l_r, l_f=l_f, l_r=l_r, C_f=front,
        C_r=draw(st.floats(*balance)) * front * l_f / l_r, length=wheelbase + 1.8, width=2.0,
        steering_lag=draw(st.floats(0.0, 0.2)),
    )  # fmt: skip


@st.composite
def regions(draw: st.DrawFn) -> StabilityRegion:
    grip, lightest = draw(st.floats(0.3, 1.0)), draw(st.floats(0.8, 1.1))
    return StabilityRegion(
        decay=draw(st.floats(0.2, 3.0)), damping=draw(st.floats(0.2, 1.0)),
        mass=(lightest, lightest + draw(st.floats(0.0, 0.6))), friction=(grip, 1.0),
        delay=draw(st.floats(0.0, 0.3)),
    )  # fmt: skip


def advice_of(
    vehicle: VehicleParams, speeds: tuple[float, ...], region: StabilityRegion | None
) -> NoGainsError | None:
    """Return the error of a design; None if it succeeds."""
    try:
        design_gains(vehicle, speeds, region=region)
    except NoGainsError as error:
        return error
    return None


def follow(error: NoGainsError, vehicle: VehicleParams, speeds: tuple[float, ...]) -> StabilityRegion:
    """Type what the message says, and return its region."""
    found = ADVICE.search(str(error))
    assert found is not None, str(error)
    region = eval(found[1], {"StabilityRegion": StabilityRegion})
    assert region == error.region
    highest = math.inf if found[2] is None else float(found[2])
    assert highest == error.max_speed
    design_gains(vehicle, tuple(v for v in speeds if v <= highest) or (highest,), region=region)
    return region


def test_error_for_van_ends_with_region_that_works() -> None:
    error = advice_of(VAN, (30.0, 40.0), None)
    assert error is not None
    assert str(error).startswith("no gains at 30 m/s with a preview of 33 m keep decay 0.8 1/s")
    region = follow(error, VAN, (30.0, 40.0))
    assert error.max_speed == math.inf
    assert (region.decay, region.damping) == (0.47, 0.24)
    with pytest.raises(NoGainsError, match=r"no gains at 40 m/s"):
        design_gains(VAN, (30.0, 40.0), region=replace(region, decay=0.49, damping=0.25))


@given(
    vehicles(), st.none() | regions(), st.sets(st.sampled_from(SPEEDS), min_size=1, max_size=3).map(sorted)
)
@settings(max_examples=6)
def test_advice_for_any_vehicle_works(
    vehicle: VehicleParams, region: StabilityRegion | None, speeds: list[float]
) -> None:
    grid = tuple(speeds)
    error = advice_of(vehicle, grid, region)
    if error is None:
        return
    asked = region or StabilityRegion()
    if error.region is None:  # with its dead time the loop is not even damped at walking pace
        assert region is not None
        assert str(error).endswith(" m/s")
        return
    advised = follow(error, vehicle, grid)
    assert (advised.mass, advised.friction, advised.delay) == (asked.mass, asked.friction, asked.delay)
    assert advised.decay <= asked.decay
    assert advised.damping <= asked.damping


@pytest.mark.slow
@given(vehicles(balance=(0.6, 1.5)), st.none() | regions())
@pytest.mark.filterwarnings("ignore:the vehicle oversteers:UserWarning")
@settings(max_examples=30)
def test_advice_works_on_default_speeds(vehicle: VehicleParams, region: StabilityRegion | None) -> None:
    error = advice_of(vehicle, DEFAULT_SPEEDS, region)
    if error is not None and error.region is not None:
        follow(error, vehicle, DEFAULT_SPEEDS)


@given(vehicles(), st.sets(st.sampled_from(SPEEDS), min_size=1, max_size=3).map(sorted))
@settings(max_examples=6)
def test_advice_for_default_region_is_nearest(vehicle: VehicleParams, speeds: list[float]) -> None:
    """Understeering vehicles need no lower speed, and no region with both values 5 % higher works."""
    error = advice_of(vehicle, tuple(speeds), None)
    if error is None:
        return
    assert error.max_speed == math.inf
    advised = follow(error, vehicle, tuple(speeds))
    decay, damping = 1.05 * advised.decay + 0.01, 1.05 * advised.damping + 0.01
    closer = replace(advised, decay=min(decay, 0.8), damping=min(damping, 0.4))
    assert advice_of(vehicle, tuple(speeds), closer) is not None


@given(vehicles(balance=(0.2, 0.98)), st.sampled_from([(10.0, 40.0), (40.0,), (2.0, 20.0, 30.0)]))
@pytest.mark.filterwarnings("ignore:the vehicle oversteers:UserWarning")
@settings(max_examples=6)
def test_advice_for_oversteering_vehicle_works(vehicle: VehicleParams, speeds: tuple[float, ...]) -> None:
    error = advice_of(vehicle, speeds, None)
    if error is not None:
        follow(error, vehicle, speeds)


@given(vehicles(balance=(0.4, 1.4)))
@settings(max_examples=10)
def test_oversteer_is_stated_with_critical_speed(vehicle: VehicleParams) -> None:
    """Either way: as a warning of a design that succeeds, or in the error of one that fails."""
    moment = vehicle.C_f * vehicle.l_f - vehicle.C_r * vehicle.l_r
    stiff = 0.6 * vehicle.C_f * vehicle.C_r * vehicle.wheelbase**2
    critical = math.sqrt(stiff / (1.3 * vehicle.m * moment)) if moment > 0.0 else math.inf
    for speeds in ((4.0,), (40.0,)):
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            error = advice_of(vehicle, speeds, None)
        text = str(error) if error is not None else " ".join(str(each.message) for each in warned)
        assert ("oversteers" in text) == (critical < 100.0)
        if critical < 100.0:
            assert f"critical speed, {critical:.1f} m/s at 1.3 times the mass and 0.6 times" in text


def test_oversteering_car_gets_gains_and_warning() -> None:
    with pytest.warns(
        UserWarning, match=r"^the vehicle oversteers .* 21\.2 m/s .* only the steering"
    ) as caught:
        design_gains(OVERSTEER, [5.0, 10.0])
    assert len(caught) == 1
    assert caught[0].filename == __file__


@pytest.mark.filterwarnings("ignore:the vehicle oversteers:UserWarning")
@pytest.mark.parametrize("speeds", [(40.0,), (5.0, 30.0, 40.0), (12.5, 14.2, 40.0)])
def test_speed_beyond_every_region_names_highest(speeds: tuple[float, ...]) -> None:
    error = advice_of(SWAPPED, speeds, StabilityRegion(delay=0.3))
    assert error is not None
    assert "oversteers" in str(error)
    assert "no region with decay and damping of at least 0.1 works at " in str(error)
    region = follow(error, SWAPPED, speeds)
    assert 2.0 <= error.max_speed < 40.0
    assert advice_of(SWAPPED, (error.max_speed + 1.0,), region) is not None


def test_hopeless_delay_names_no_region() -> None:
    error = advice_of(VAN, (2.0, 20.0), StabilityRegion(delay=20.0))
    assert error is not None
    assert (error.region, error.max_speed) == (None, math.inf)
    assert str(error).endswith("no region with decay and damping of at least 0.1 works at 2 m/s")


def test_error_is_pickled_with_its_region() -> None:
    error = advice_of(VAN, (40.0,), None)
    assert error is not None
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.region, again.max_speed) == (str(error), error.region, error.max_speed)
    assert again.result.v_x == 40.0


def test_shipped_gains_suit_presets_alone() -> None:
    for preset in (VehicleParams.bmw_320i(), VehicleParams.ford_escort(), VehicleParams.vw_vanagon()):
        assert has_shipped_gains(replace(preset, length=5.0, mu=0.3, steering_lag=0.05))
        assert not has_shipped_gains(replace(preset, steering_lag=0.2))
        assert not has_shipped_gains(replace(preset, m=preset.m + 1.0))
    assert not has_shipped_gains(VAN)

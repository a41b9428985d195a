"""Fusion of messages and detections that differ or are missing."""

from dataclasses import replace

import numpy as np
import pytest

from cca_core import RemoteVehicle, VehicleState
from cca_core.path import Lane, LocalFrame, Road, interpolate_path
from cca_core.sim import RoadUser, Scenario
from cca_core.sim.scenarios.eebl import CAR
from cca_core.sim.world.perception import Perception
from cca_core.sim.world.radio import sender_id
from cca_core.v2x import Bsm, PositionalAccuracy, encode_bsm

PATH = interpolate_path([[0.0, 0.0], [400.0, 0.0]])
SCENARIO = Scenario(
    name="test", case=None, road=Road(PATH, [Lane(d=0.0)]), vehicle=CAR, start=0.0, v_x=10.0,
    cruise_speed=10.0, road_users=(RoadUser(id="red", s=40.0, d=0.0, v_x=10.0),),
)  # fmt: skip
EGO = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=10.0)
BRAKES = frozenset({"hard_braking"})


def report(t: float, x: float, y: float = 0.0, accuracy: float | None = None) -> bytes:
    lat, lon = LocalFrame(*SCENARIO.origin).to_geodetic((x, y))
    return encode_bsm(
        Bsm(
            msg_count=round(10.0 * t) % 128, id=sender_id(0), sec_mark=t % 60.0, latitude_deg=float(lat),
            longitude_deg=float(lon), speed=10.0, psi=0.0, a_x=0.0, r=0.0, width=1.8, length=4.5,
            events=BRAKES, accuracy=PositionalAccuracy(semi_major=accuracy, semi_minor=accuracy),
        )
    )  # fmt: skip


def known(visible: bool, until: float, *, ego: str = "v2v") -> list[tuple[float, str, float, bool]]:
    """Age, source, position and whether its event is known, in each cycle of 3 s; red sends up to a time."""
    perception = Perception(replace(SCENARIO, ego_type=ego))
    found = []
    for k in range(150):
        t = 0.02 * k
        x = 40.0 + 10.0 * t
        messages = [report(t, x)] if k % 5 == 0 and t <= until else []
        # red is stationary from 1 s on, which no message reports
        row = (min(x, 50.0), 0.0, 0.0, 10.0 if t < 1.0 else 0.0, 0.0, 0.0)
        reports = perception.remotes(t, [row], [visible], messages, EGO)
        assert len(reports) <= 1
        found += [(r.age, r.source, r.x, r.events == BRAKES) for r in reports]
    return found


def test_fresh_messages_take_precedence() -> None:
    young = known(True, 3.0)
    assert len(young) == 150
    assert {source for _, source, _, _ in young} == {"v2v"}
    assert max(age for age, *_ in young) <= 0.1 + 1e-9
    assert young == known(False, 3.0)


def test_visible_vehicle_never_becomes_stale() -> None:
    ages, sources, x, found = zip(*known(True, 1.0), strict=True)
    assert len(ages) == 150
    assert max(ages) <= 0.4 + 1e-9
    assert x[-1] == pytest.approx(50.0)
    assert np.abs(np.diff(x)).max() < 6.0  # from the dead-reckoned to the detected position
    deleted = sources.index("sensor")  # the track is deleted
    assert deleted > 90
    assert found == (True,) * deleted + (False,) * (150 - deleted)


def test_occluded_silent_vehicle_becomes_stale() -> None:
    ages, _, x, _ = zip(*known(False, 1.0), strict=True)
    assert ages[-1] > 0.9
    assert x[-1] > 55.0  # no message reports the stop
    assert len(ages) < 150  # and then its track is deleted


def test_unconnected_vehicle_comes_from_sensor() -> None:
    found = known(True, -1.0)
    assert len(found) == 150 - 20
    assert {source for _, source, _, _ in found} == {"sensor"}
    assert not any(found for *_, found in found)


def test_messages_are_ignored_without_v2v() -> None:
    assert known(True, 3.0, ego="sensor") == known(True, -1.0, ego="sensor")
    assert known(False, 3.0, ego="sensor") == []


@pytest.mark.parametrize("visible", [True, False])
def test_sensor_position_replaces_uncertain_report(visible: bool) -> None:
    perception = Perception(SCENARIO)
    for k in range(50):
        t = 0.02 * k
        x = 40.0 + 10.0 * t
        messages = [report(t, x, 0.8, 0.5)] if k % 5 == 0 else []
        (red,) = perception.remotes(t, [(x, 0.0, 0.0, 10.0, 0.0, 0.0)], [visible], messages, EGO)
    assert (red.x, red.y) == pytest.approx((x, 0.0 if visible else 0.8), abs=0.02)
    assert (red.source, red.events) == ("v2v", BRAKES)
    assert red.age < 0.1
    assert red.sigma_across == (0.0 if visible else pytest.approx(0.5, abs=0.01))


def reports_until_occluded(y: float, accuracy: float, until: float) -> list[RemoteVehicle]:
    """Perception each 0.1 s of a vehicle at y = 0 that reports another y and is visible for 1 s."""
    perception, found = Perception(SCENARIO), []
    for k in range(round(until / 0.02)):
        t = 0.02 * k
        x = 40.0 + 10.0 * t
        messages = [report(t, x, y, accuracy)] if k % 5 == 0 else []
        (red,) = perception.remotes(t, [(x, 0.0, 0.0, 10.0, 0.0, 0.0)], [t < 1.0], messages, EGO)
        found += [red] if k % 5 == 0 else []
    return found


def test_sender_bias_is_corrected_and_decays() -> None:
    found = reports_until_occluded(0.8, 0.5, 120.0)
    assert max(abs(red.y) for red in found[5:30]) < 0.05
    assert found[20].sigma_across < 0.15
    across = [red.sigma_across for red in found[15:]]
    assert np.diff(across).min() > -1e-3
    assert across[-1] == pytest.approx(0.5, abs=0.01)
    assert found[10 + 300].y == pytest.approx(0.8 * (1.0 - np.exp(-1.0)), abs=0.05)
    assert found[-1].y == pytest.approx(0.8, abs=0.05)
    assert {red.source for red in found} == {"v2v"}


def test_correction_never_reduces_uncertainty_below_report() -> None:
    """The bounds hold for any error; a vehicle that was never visible keeps its report."""
    found = reports_until_occluded(0.0, 0.3, 10.0)
    assert all(red.sigma_across <= 0.31 for red in found)
    perception = Perception(SCENARIO)
    row = (40.0, 0.0, 0.0, 10.0, 0.0, 0.0)
    (red,) = perception.remotes(0.0, [row], [False], [report(0.0, 40.0, 0.8, 0.5)], EGO)
    assert red.y == pytest.approx(0.8, abs=0.02)
    assert red.sigma_across == pytest.approx(0.5, abs=0.01)


def test_implausible_bias_is_not_applied() -> None:
    perception = Perception(SCENARIO)
    for k in range(150):
        t = 0.02 * k
        x = 40.0 + 10.0 * t
        error = 0.0 if t > 1.0 else 12.0
        messages = [report(t, x, error, 0.3)] if k % 5 == 0 else []
        (red,) = perception.remotes(t, [(x, 0.0, 0.0, 10.0, 0.0, 0.0)], [t < 1.0], messages, EGO)
    assert abs(red.y) < 0.1
    assert red.sigma_across == pytest.approx(0.3, abs=0.02)


def test_bias_is_deleted_with_its_track() -> None:
    perception = Perception(SCENARIO)
    for k in range(50):
        t = 0.02 * k
        messages = [report(t, 40.0, 0.8, 0.5)] if k % 5 == 0 else []
        perception.remotes(t, [(40.0, 0.0, 0.0, 10.0, 0.0, 0.0)], [True], messages, EGO)
    row = (200.0, 0.0, 0.0, 10.0, 0.0, 0.0)
    for k in range(2000):
        perception.remotes(1.0 + 0.02 * k, [row], [False], [], EGO)
    (red,) = perception.remotes(50.0, [row], [False], [report(50.0, 200.0, 0.8, 0.5)], EGO)
    assert red.y == pytest.approx(0.8, abs=0.02)

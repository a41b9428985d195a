"""What a cycle must not do, as it takes long: collect garbage, import modules."""

import gc
import subprocess
import sys
from collections.abc import Iterator

import pytest

from tests.support.planner_drives import car, ego_state, make_planner

FIRST_STEPS = """
import sys
from cca_core import EvasionSettings, Lane, Path, Planner, RemoteVehicle, Road, VehicleParams, VehicleState

path = Path([0.0, 900.0], [[[0.0, 0.0, 900.0, 0.0], [0.0, 0.0, 0.0, 0.0]]])
planner = Planner(
    VehicleParams.bmw_320i(), Road(path, (Lane(d=0.0), Lane(d=3.5))), cruise_speed=20.0,
    evasion=EvasionSettings(awareness_range=500.0),
)
blocking = RemoteVehicle(id="R", x=120.0, y=0.0, psi=0.0, v_x=5.0)
before = set(sys.modules)
for k in range(5):
    state = VehicleState(x=20.0 + 2.0 * k, y=0.0, psi=0.0, v_x=20.0)
    band = planner.step(0.1 * k, state, [blocking]).band
print(band is not None, *sorted(set(sys.modules) - before))
"""


@pytest.fixture
def collections() -> Iterator[list[str]]:
    """Phases of garbage collections, which begin whenever they may."""
    seen: list[str] = []

    def note(phase: str, _: dict[str, int]) -> None:
        seen.append(phase)

    before = gc.get_threshold()
    gc.callbacks.append(note)
    gc.set_threshold(1)
    yield seen
    gc.set_threshold(*before)
    gc.callbacks.remove(note)


@pytest.mark.parametrize("x", [20.0, 9e9], ids=["on the route", "off the route"])
def test_step_postpones_garbage_collection(collections: list[str], x: float) -> None:
    planner, ego, others = make_planner(), ego_state(x), [car(80.0, 0.0, 5.0), car(-40.0, 3.5, 15.0)]
    for k in range(3):
        before = len(collections)
        planner.step(0.1 * k, ego, others)
        during = len(collections) - before
        assert during == 0
        assert gc.isenabled()
    assert [[each] for each in range(9)]
    assert collections


def test_step_leaves_disabled_collection_disabled() -> None:
    gc.disable()
    try:
        make_planner().step(0.0, ego_state(), [])
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_first_steps_import_nothing() -> None:
    found = subprocess.run([sys.executable, "-c", FIRST_STEPS], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["True"]

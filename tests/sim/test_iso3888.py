"""Double lane changes of ISO 3888: gates, and runs of a single track through them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cca_core import InputError, VehicleParams, VehicleState
from cca_core.geometry import box_gap, boxes
from cca_core.path import Path
from cca_core.sim import DoubleLaneChange, GateRun, drive_through, iso3888_1, iso3888_2, plan_gate_path
from cca_core.sim.handling.iso3888 import Offset

CAR = VehicleParams.bmw_320i()
OFFSETS: tuple[Offset, ...] = ("center to center", "edge to center", "edge to edge")
CASES = [*((iso3888_1(CAR.width, offset=offset), 80.0 / 3.6) for offset in OFFSETS),
         (iso3888_2(CAR.width), 55.0 / 3.6)]  # fmt: skip
NAMES = [f"part 1, {offset}" for offset in OFFSETS] + ["part 2"]


@pytest.mark.parametrize("offset", OFFSETS)
def test_gates_of_part_1(offset: Offset) -> None:
    """15 m, 30 m to the next, 25 m, 25 m to the next, 30 m: 125 m for a car of 2 m."""
    gates = iso3888_1(2.0, offset=offset).gates
    assert gates[:, :2].ravel().tolist() == [0.0, 15.0, 45.0, 70.0, 95.0, 125.0]
    np.testing.assert_allclose(gates[:, 3] - gates[:, 2], [2.45, 2.65, 2.85])
    assert gates[[0, 2], 2].tolist() == [0.0, 0.0]
    centers = 0.5 * (gates[:, 2] + gates[:, 3])
    apart = {
        "center to center": centers[1] - centers[0] - 3.5,
        "edge to center": gates[1, 2] - centers[0] - 3.5,
        "edge to edge": gates[1, 2] - gates[0, 3] - 1.0,
    }
    assert apart[offset] == pytest.approx(0.0, abs=1e-12)


def test_offsets_of_part_1_are_ordered() -> None:
    shift = {offset: iso3888_1(CAR.width, offset=offset).gates[1, 2] for offset in OFFSETS}
    assert shift["edge to edge"] < shift["center to center"] < shift["edge to center"]


@pytest.mark.parametrize(("width", "last"), [(1.61, 3.0), (2.0, 3.0), (2.3, 3.24)])
def test_gates_of_part_2(width: float, last: float) -> None:
    """12 m, 13.5 m to the next, 11 m, 12.5 m to the next, 12 m: 61 m; 1 m between the first two."""
    course = iso3888_2(width)
    gates = course.gates
    assert gates[:, :2].ravel().tolist() == [0.0, 12.0, 25.5, 36.5, 49.0, 61.0]
    np.testing.assert_allclose(gates[:, 3] - gates[:, 2], [1.1 * width + 0.25, width + 1.0, last])
    assert gates[1, 2] - gates[0, 3] == pytest.approx(1.0)
    assert gates[2, 2] == gates[0, 2] == 0.0
    assert course.release == 2.0
    assert iso3888_1(width).release == math.inf


def test_nodes_run_straight_through_first_gate() -> None:
    course = iso3888_2(CAR.width)
    nodes = course.nodes()
    np.testing.assert_allclose(nodes[:, 1], 0.5 * course.gates[0, 3])
    np.testing.assert_allclose(np.diff(nodes[:, 0]), 0.5)
    assert nodes[[0, -1], 0].tolist() == [-40.0, 121.0]


def test_obstacles_leave_gates_free() -> None:
    course = iso3888_1(CAR.width)
    for gate, block in zip(np.repeat(course.gates, 2, axis=0), course.obstacles(), strict=True):
        start, end, right, left = gate
        lane = boxes(0.5 * (start + end), 0.5 * (right + left), 0.0, end - start, left - right)
        assert box_gap(lane, block) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("course", "speed"), CASES, ids=NAMES)
@pytest.mark.requires("qpsolvers", "piqp")
def test_planned_path_is_driven_without_collision(course: DoubleLaneChange, speed: float) -> None:
    """80 km/h and 55 km/h, without a collision."""
    band = plan_gate_path(course, CAR, speed)
    assert band.ok
    assert band.clearance > 0.05
    path = band.path()
    s = np.arange(path.start, path.end, 0.1)
    kappa = path.curvature(s)
    assert np.abs(kappa).max() * speed**2 < 7.0 * 1.01
    assert np.abs(np.diff(kappa)).max() / 0.1 * speed**3 < 20.0 * 1.03
    passage = drive_through(course, band, speed)
    assert passage.passed
    assert passage.gap > 0.04
    assert passage.a_y < 7.5
    assert passage.sideslip < math.radians(3.0)
    assert passage.run.peak < 0.06
    held = course.release == math.inf
    assert passage.exit_speed == pytest.approx(speed, abs=0.1) if held else passage.exit_speed < speed - 1.0
    assert passage.poses[-1, 0] > course.gates[-1, 1] + CAR.length


@pytest.mark.requires("qpsolvers", "piqp")
def test_too_high_speed_is_infeasible() -> None:
    band = plan_gate_path(iso3888_2(CAR.width), CAR, 80.0 / 3.6)
    assert not band.ok


@pytest.mark.requires("qpsolvers", "piqp")
def test_collision_with_gate_is_detected() -> None:
    """Straight on, the car runs into the ground on the right of the second gate."""
    course, speed = iso3888_2(CAR.width), 15.0
    band = plan_gate_path(course, CAR, speed)

    def straight_on(state: VehicleState, path: Path) -> float:
        return 0.0

    passage: GateRun = drive_through(replace(course, release=math.inf), band, speed, steer=straight_on)
    y = passage.poses[0, 1]
    assert not passage.passed
    assert passage.gaps[0, 0] == pytest.approx(y - 0.5 * CAR.width, abs=1e-6)
    assert passage.gaps[1, 0] == pytest.approx(y - 0.5 * CAR.width - course.gates[1, 2], abs=1e-6)
    assert passage.gaps[2, 1] == pytest.approx(3.0 - y - 0.5 * CAR.width, abs=1e-6)


def test_invalid_argument_raises() -> None:
    with pytest.raises(InputError, match=r"^width must be greater than 0"):
        iso3888_1(0.0)
    with pytest.raises(InputError, match=r"^width must be greater than 0"):
        iso3888_2(-1.0)
    with pytest.raises(InputError, match=r"^offset must be one of"):
        iso3888_1(1.8, offset="middle")  # type: ignore[arg-type]
    for name in ("speed", "a_y", "jerk"):
        with pytest.raises(InputError, match=rf"^{name} must be greater than 0"):
            plan_gate_path(iso3888_2(1.8), CAR, **{"speed": 15.0, name: 0.0})

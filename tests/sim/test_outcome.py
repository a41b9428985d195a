import numpy as np
import pytest

from cca_core.geometry import box_gap, boxes
from cca_core.sim import first_collision, first_lane_change, lead_speed
from tests.support.paper_runs import simulated


def test_collision_point_is_on_both_outlines() -> None:
    log = simulated("ima", "left-turn", "driver")
    collision = first_collision(log)
    for body in log.bodies():
        x, y, psi = (field[-1, 0] for field in (body.x, body.y, body.psi))
        assert abs(box_gap(boxes(x, y, psi, 4.5, 1.8), boxes(*collision.xy, 0.0, 0.01, 0.01))) < 0.15
    assert collision.speed == pytest.approx(log.closing_speed())
    assert collision.t == log.t[-1]
    assert str(collision) == f"collision with red at {log.t[-1]:.1f} s, {collision.speed:.1f} m/s"


def test_first_collision_without_collision_is_none() -> None:
    assert first_collision(simulated("eebl", "C", "v2v")) is None


def test_lead_is_the_nearest_vehicle_ahead_in_the_lane() -> None:
    speeds = lead_speed(simulated("maneuver", "2", "v2v"))
    assert speeds[0] == 17.0  # R1; A comes from behind
    assert np.isnan(speeds[-1])


def test_fast_lane_change_is_shorter() -> None:
    fast, smooth = (
        end - start
        for start, end in (
            first_lane_change(simulated("maneuver", f"1-{each}", "v2v")) for each in ("fast", "smooth")
        )
    )
    assert 30.0 < fast < smooth < 80.0

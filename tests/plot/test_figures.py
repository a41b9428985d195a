import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cca_core import InputError
from cca_core.plot import (
    describe_outcome,
    describe_run,
    first_collision,
    first_lane_change,
    key_frames,
    lead_speed,
    plot_time_series,
    plot_traffic,
    plot_tunings,
    vehicles_waited_for,
)
from cca_core.sim import Log

pytestmark = pytest.mark.requires("matplotlib")


@pytest.fixture
def waiting(run: Callable[..., Log]) -> Log:
    return run("maneuver", "2", "v2v")


@pytest.fixture
def stuck(run: Callable[..., Log]) -> Log:
    return run("maneuver", "2", "sensor")


@pytest.fixture
def tunings(run: Callable[..., Log]) -> tuple[Log, Log]:
    return run("maneuver", "1-fast", "v2v"), run("maneuver", "1-smooth", "v2v")


def predicted_occupancy(axis: object) -> dict[str, np.ndarray]:
    return {patch.get_gid(): patch.get_xy()[:4] for patch in axis.patches if "@" in (patch.get_gid() or "")}


def test_each_strip_shows_who_is_near_at_its_place(waiting: Log) -> None:
    times = [5.0, 19.0, 27.0]
    overview, *strips = plot_traffic(waiting, times=times).axes
    assert len(strips) == len(times)
    for number, (t, strip) in enumerate(zip(times, strips, strict=True), start=1):
        row = int(np.argmin(np.abs(waiting.t - t)))
        low, high = strip.get_xlim()
        shown = predicted_occupancy(strip)
        assert f"ego@{number}" in shown
        texts = " ".join(text.get_text() for text in strip.texts)
        for user, (s, d) in zip(waiting.scenario.road_users, waiting.user_frenet[row], strict=True):
            ahead = s - waiting.ego_frenet[row, 0]
            assert (f"{user.id}@{number}" in shown) == (low < ahead < high)
            assert user.id in texts  # in words at the border if not as a box
            if low < ahead < high:
                box = shown[f"{user.id}@{number}"]
                np.testing.assert_allclose(box.mean(axis=0), (ahead, d), atol=0.02)
                np.testing.assert_allclose(np.ptp(box, axis=0), (user.length, user.width), atol=0.05)
    assert {f"ego@{number}" for number in (1, 2, 3)} <= predicted_occupancy(overview).keys()


def test_the_ego_is_drawn_at_its_body_and_not_at_its_center_of_gravity(waiting: Log) -> None:
    ahead = replace(waiting.scenario.vehicle, box_offset=1.0)
    log = replace(waiting, scenario=replace(waiting.scenario, vehicle=ahead))
    strip = plot_traffic(log, times=[2.0]).axes[1]
    np.testing.assert_allclose(predicted_occupancy(strip)["ego@1"].mean(axis=0), (1.0, 0.0), atol=0.02)


def test_frames_tell_the_story(waiting: Log) -> None:
    frames = key_frames(waiting)
    assert len(frames) <= 6
    times = [frame.t for frame in frames]
    assert times == sorted(times)
    texts = [frame.text for frame in frames]
    for wanted in ("EVADE_LEFT", "FOLLOW", "beside R1", "beside A", "beside R2"):
        assert any(text.startswith(wanted) for text in texts)
    assert len(key_frames(waiting, most=2)) == 2


def test_a_collision_is_always_a_frame(stuck: Log) -> None:
    users = stuck.road_users.copy()
    users[-1, 0, :2] = stuck.ego[-1, :2]
    log = replace(stuck, road_users=users)
    assert key_frames(log)[-1].text == "the run ends in a collision"
    assert describe_outcome(log) == "collides with R1"


def test_a_collision_is_a_frame_even_right_after_a_decision(run: Callable[..., Log]) -> None:
    log = run("curbside", "fast", "driver")
    assert first_collision(log) is not None
    late = replace(log, decisions=(*log.decisions, (float(log.t[-2]), "BRAKE", "red is in the way")))
    assert key_frames(late)[-1].text == "the run ends in a collision"


def test_frames_tell_what_others_begin(run: Callable[..., Log]) -> None:
    braking = {frame.text: frame.t for frame in key_frames(run("eebl", "A", "driver"))}
    assert braking["red brakes"] < braking["yellow brakes"]
    assert "yellow swerves" in {frame.text for frame in key_frames(run("curbside", "fast", "v2v"))}
    assert not any(frame.t == 0.0 for frame in key_frames(run("curbside", "fast", "v2v")))


def test_narrative_names_awaited_vehicles(waiting: Log, stuck: Log) -> None:
    assert vehicles_waited_for(waiting, 10.0, 25.0) == ["A"]
    assert "until A is through" in describe_run(waiting)
    assert describe_outcome(waiting) == "ends ahead of R1 and R2"
    assert describe_outcome(stuck) == "ends behind R1 and R2"
    assert "to the end" in describe_run(stuck)


def test_two_tunings_on_one_axis(tunings: tuple[Log, Log]) -> None:
    fast, smooth = tunings
    (axis,) = plot_tunings(fast, smooth).axes
    curves = [line for line in axis.lines if len(line.get_xdata()) == len(fast.t)]
    for log, curve in zip(tunings, curves, strict=True):
        np.testing.assert_array_equal(curve.get_xydata(), log.ego_frenet)
        assert f"{np.abs(log.a_y).max():.2f} m/s" in curve.get_label()
    lengths = [end - start for start, end in map(first_lane_change, tunings)]
    assert 30.0 < lengths[0] < lengths[1] < 80.0


def test_a_run_without_lane_change_has_no_tuning(tunings: tuple[Log, Log], stuck: Log) -> None:
    with pytest.raises(InputError, match="leaves its lane"):
        plot_tunings(tunings[0], stuck)


def test_time_series(waiting: Log) -> None:
    speed, steer, lateral, gap = plot_time_series(waiting).axes
    np.testing.assert_array_equal(speed.lines[0].get_ydata(), waiting.ego[:, 3])
    np.testing.assert_allclose(steer.lines[0].get_ydata(), np.degrees(waiting.ego[:, 6]))
    np.testing.assert_array_equal(lateral.lines[0].get_ydata(), waiting.a_y)
    lowest = min(np.nanmin(line.get_ydata()) for line in gap.lines[:3])
    assert lowest == pytest.approx(waiting.gaps().min())
    assert all("[" in axis.get_ylabel() for axis in (speed, steer, lateral, gap))


def test_the_leader_is_the_nearest_in_front_on_the_route(waiting: Log) -> None:
    speeds = lead_speed(waiting)
    assert speeds[0] == 17.0  # R1; A comes from behind
    assert np.isnan(speeds[-1])


def test_figures_without_other_vehicles(alone: Log) -> None:
    assert len(predicted_occupancy(plot_traffic(alone).axes[1])) == 1
    assert np.isnan(lead_speed(alone)).all()
    plot_time_series(alone)


@pytest.mark.parametrize("module", ["cca_core", "cca_core.plot"])
def test_matplotlib_is_imported_only_to_draw(module: str) -> None:
    code = f"import sys, {module}; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0

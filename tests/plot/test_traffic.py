from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cca_core.plot import plot_layout, plot_traffic
from cca_core.plot.key_frames import key_frames
from cca_core.report import describe_participants
from cca_core.sim import Log, first_collision

pytestmark = pytest.mark.requires("matplotlib")


@pytest.fixture
def waiting(run: Callable[..., Log]) -> Log:
    return run("maneuver", "2", "v2v")


@pytest.fixture
def stuck(run: Callable[..., Log]) -> Log:
    return run("maneuver", "2", "sensor")


def polygons(axis: object) -> dict[str, np.ndarray]:
    return {patch.get_gid(): patch.get_xy()[:4] for patch in axis.patches if "@" in (patch.get_gid() or "")}


def test_strip_shows_near_vehicles_at_their_positions(waiting: Log) -> None:
    times = [5.0, 19.0, 27.0]
    overview, *strips = plot_traffic(waiting, times=times).axes
    assert len(strips) == len(times)
    for number, (t, strip) in enumerate(zip(times, strips, strict=True), start=1):
        row = int(np.argmin(np.abs(waiting.t - t)))
        low, high = strip.get_xlim()
        shown = polygons(strip)
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
    assert {f"ego@{number}" for number in (1, 2, 3)} <= {text.get_gid() for text in overview.texts}


def test_distance_of_a_vehicle_out_of_view_is_its_gap(waiting: Log) -> None:
    row = int(np.argmax(waiting.gaps()[:, 2]))
    strip = plot_traffic(waiting, times=[float(waiting.t[row])]).axes[1]
    user = waiting.scenario.road_users[2]
    center = waiting.ego_frenet[row, 0] + waiting.scenario.vehicle.box_offset
    ahead = waiting.user_frenet[row, 2, 0] - center
    gap = abs(ahead) - 0.5 * (user.length + waiting.scenario.vehicle.length)
    texts = " ".join(text.get_text() for text in strip.texts)
    assert f"m/s, {gap:.0f} m {'ahead' if ahead > 0.0 else 'behind'}" in texts


def test_ego_is_shown_at_its_body_not_center_of_gravity(waiting: Log) -> None:
    ahead = replace(waiting.scenario.vehicle, box_offset=1.0)
    log = replace(waiting, scenario=replace(waiting.scenario, vehicle=ahead))
    strip = plot_traffic(log, times=[2.0]).axes[1]
    np.testing.assert_allclose(polygons(strip)["ego@1"].mean(axis=0), (1.0, 0.0), atol=0.02)


def test_key_frames_show_actions_and_encounters(waiting: Log) -> None:
    frames = key_frames(waiting)
    assert len(frames) <= 6
    times = [frame.t for frame in frames]
    assert times == sorted(times)
    texts = [frame.text for frame in frames]
    for wanted in ("EVADE_LEFT", "FOLLOW", "alongside R1", "alongside A", "alongside R2"):
        assert any(text.startswith(wanted) for text in texts)
    assert len(key_frames(waiting, max_frames=2)) == 2


def test_collision_is_the_last_key_frame(stuck: Log) -> None:
    users = stuck.road_users.copy()
    users[-1, 0, :2] = stuck.ego[-1, :2]
    log = replace(stuck, road_users=users)
    assert key_frames(log)[-1].text == "the run ends in a collision"


def test_collision_right_after_a_decision_is_a_key_frame(run: Callable[..., Log]) -> None:
    log = run("curbside", "fast", "driver")
    assert first_collision(log) is not None
    late = replace(log, decisions=(*log.decisions, (float(log.t[-2]), "BRAKE", "braking for red")))
    assert key_frames(late)[-1].text == "the run ends in a collision"


def test_key_frames_show_actions_of_others(run: Callable[..., Log]) -> None:
    braking = {frame.text: frame.t for frame in key_frames(run("eebl", "A", "driver"))}
    assert braking["red brakes"] < braking["yellow brakes"]
    assert "yellow moves laterally" in {frame.text for frame in key_frames(run("curbside", "fast", "v2v"))}
    assert not any(frame.t == 0.0 for frame in key_frames(run("curbside", "fast", "v2v")))


def test_caption_is_written_below_the_title(waiting: Log) -> None:
    figure = plot_traffic(waiting, times=[2.0], caption="Passing R1.")
    assert "Passing R1." in {text.get_text() for text in figure.texts}


def test_traffic_without_other_vehicles_shows_the_ego(alone: Log) -> None:
    assert len(polygons(plot_traffic(alone).axes[1])) == 1


@pytest.mark.parametrize(("id_", "text"), [("van", "van 20 m/s oncoming"), ("oncoming", "oncoming 20 m/s")])
def test_oncoming_vehicle_is_called_so_once(run: Callable[..., Log], id_: str, text: str) -> None:
    met = run("maneuver", "3", "v2v")
    users = [replace(u, id=id_ if u.direction < 0 else u.id, actions=()) for u in met.scenario.road_users]
    log = replace(met, scenario=replace(met.scenario, road_users=tuple(users), fixed_gap=None))
    (strip,) = plot_traffic(log, times=[0.0]).axes[1:]
    assert any(f"{text}, " in each.get_text() for each in strip.texts)
    (axis,) = plot_layout(log.scenario).axes
    assert any(f"{text.replace(' 20', ': 20')}, " in each.get_text() for each in axis.texts)
    described = describe_participants(log)
    assert described.count("oncoming") == 1
    assert ("ahead, oncoming" in described) == (id_ == "van")

from dataclasses import fields, replace

import numpy as np
import pytest

from cca_core import InputError
from cca_core.plot import plot_braking
from cca_core.plot.run_labels import run_labels
from cca_core.plot.style import COLORS
from cca_core.sim import Log, first_collision
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")


@pytest.fixture(scope="module")
def braking(run: Run) -> tuple[Log, Log]:
    return run("eebl", "A", "driver"), run("eebl", "C", "v2v")


def test_bands_reach_from_rear_to_front_bumper(braking: tuple[Log, Log]) -> None:
    for log, axis in zip(braking, plot_braking(braking).axes[:2], strict=True):
        bands = {band.get_label(): band.get_paths()[0].vertices for band in axis.collections}
        assert bands.keys() == {"ego", "yellow", "red"}
        for name, s, length in (
            ("ego", log.ego_frenet[:, 0] + log.scenario.vehicle.box_offset, 4.5),
            ("yellow", log.user_frenet[:, 0, 0], 4.5), ("red", log.user_frenet[:, 1, 0], 4.5),
        ):  # fmt: skip
            rear = s[0] - log.ego_frenet[0, 0] - 0.5 * length
            at_start = bands[name][bands[name][:, 0] == 0.0, 1]
            assert at_start.min() == pytest.approx(rear)
            assert at_start.max() == pytest.approx(rear + length)


def test_bands_meet_only_in_a_collision(braking: tuple[Log, Log]) -> None:
    collided, free = (log.user_frenet[:, 0, 0] - log.ego_frenet[:, 0] - 4.5 for log in braking)
    assert first_collision(braking[0]).id == "yellow"
    assert collided.min() < 0.05
    assert first_collision(braking[1]) is None
    assert free.min() > 0.5
    first, second = plot_braking(braking).axes[:2]
    assert any("m/s" in text.get_text() for text in first.texts)
    assert not second.texts


def test_speeds_and_accelerations_are_those_of_the_log(braking: tuple[Log, Log]) -> None:
    *_, speed, acceleration = plot_braking(braking).axes
    for i, log in enumerate(braking):
        np.testing.assert_array_equal(speed.lines[i].get_ydata(), log.ego[:, 3])
        np.testing.assert_array_equal(acceleration.lines[i].get_ydata(), log.ego[:, 7])
    assert "[m/s]" in speed.get_ylabel()
    assert "[m/s²]" in acceleration.get_ylabel()


def test_outcomes_are_in_the_titles(braking: tuple[Log, Log]) -> None:
    first, second = plot_braking(braking, outcomes=["collides", "stops"]).axes[:2]
    assert first.get_title(loc="left") == "Driver without V2V: collides"
    assert second.get_title(loc="left") == "With V2V: stops"


def renamed(log: Log, name: str, case: str | None = None) -> Log:
    return replace(log, scenario=replace(log.scenario, name=name, case=case))


def test_runs_of_one_ego_type_are_distinct(braking: tuple[Log, Log]) -> None:
    driver, v2v = braking
    logs = [driver, *(renamed(v2v, f"clock {offset:+.1f} s") for offset in (0.0, 0.2, -0.2))]
    *positions, speed, acceleration = plot_braking(logs).axes
    titles = [axis.get_title(loc="left").replace("\N{NO-BREAK SPACE}", " ") for axis in positions]
    assert titles == [
        "Driver without V2V", "Clock +0.0 s, with V2V", "Clock +0.2 s, with V2V", "Clock -0.2 s, with V2V",
    ]  # fmt: skip
    assert [line.get_label().lower() for line in speed.lines] == [title.lower() for title in titles]
    for axis in (speed, acceleration):
        styles = [(line.get_color(), line.get_linestyle()) for line in axis.lines[:4]]
        assert len(set(styles)) == 4
        assert len({line for _, line in styles[1:]}) == 3
        assert styles[1] == (COLORS.ego, "-")


def test_labels_show_only_what_differs(braking: tuple[Log, Log]) -> None:
    log = braking[1]
    assert run_labels([log]) == ["with V2V"]
    assert run_labels([log, log]) == ["run 1, with V2V", "run 2, with V2V"]
    cases = [renamed(log, "queue", "wet"), renamed(log, "queue", "dry")]
    assert run_labels(cases) == ["case wet, with V2V", "case dry, with V2V"]
    assert run_labels([log, replace(log, plant="multi_body")]) == [
        "single-track, with V2V", "multi-body, with V2V",
    ]  # fmt: skip


def test_label_names_vehicles_without_a_radio(braking: tuple[Log, Log]) -> None:
    log = braking[1]

    def silenced(*ids: str) -> Log:
        users = tuple(replace(u, connected=u.id not in ids) for u in log.scenario.road_users)
        return replace(log, scenario=replace(log.scenario, road_users=users))

    assert run_labels([silenced("red")]) == ["with V2V; red has no radio"]
    assert run_labels([silenced("red", "yellow")]) == ["with V2V; yellow and red have no radio"]


def test_braking_without_runs_raises() -> None:
    with pytest.raises(InputError, match="at least one run"):
        plot_braking([])


def test_braking_without_other_vehicles_has_three_axes(alone: Log) -> None:
    assert len(plot_braking([alone]).axes) == 3


def oncoming(log: Log) -> Log:
    """The run, with one more vehicle that comes from 600 m ahead with 20 m/s."""
    red = log.scenario.road_users[1]
    user = replace(red, id="oncoming", s=600.0, d=3.5, v_x=20.0, direction=-1, actions=())
    s, frenet = 600.0 - 20.0 * log.t, log.user_frenet
    frenet = np.concatenate((frenet, np.stack((s, np.full_like(s, 3.5)), axis=-1)[:, None]), axis=1)
    doubled = {
        name: np.concatenate((getattr(log, name), getattr(log, name)[:, -1:]), axis=1)
        for name in ("road_users", "user_motion", "visible", "tracked")
    }
    scenario = replace(log.scenario, road_users=(*log.scenario.road_users, user))
    return replace(log, scenario=scenario, user_frenet=frenet, **doubled)


def test_oncoming_vehicle_does_not_widen_the_view(braking: tuple[Log, Log]) -> None:
    alone, met = (plot_braking([log]).axes[0] for log in (braking[1], oncoming(braking[1])))
    assert met.get_ylim() == alone.get_ylim()
    assert "oncoming" in {band.get_label() for band in met.collections}


def test_only_a_run_that_ends_before_the_others_has_a_gray_strip(braking: tuple[Log, Log]) -> None:
    def named(logs: list[Log]) -> bool:
        figure = plot_braking(logs)
        names = [text.get_text() for legend in figure.legends for text in legend.texts]
        assert figure.axes[-1].get_xlim()[1] <= max(log.t[-1] for log in logs)
        return "after the run" in names

    assert not named([braking[1]])
    assert not named([moving(braking[1])])
    rows = slice(0, len(braking[1].t) // 2)
    assert named([moving(braking[1]), moving(cut(braking[1], rows))])


def cut(log: Log, rows: slice) -> Log:
    """Some cycles of a run."""
    per_cycle = {
        name: value[rows] for name, value in ((each.name, getattr(log, each.name)) for each in fields(log))
        if isinstance(value, np.ndarray) and len(value) == len(log.t)
    }  # fmt: skip
    return replace(log, **per_cycle)


def moving(log: Log) -> Log:
    """The run, with road users that do not come to rest."""
    users = log.road_users.copy()
    users[:, :, 3] += 5.0
    return replace(log, road_users=users)

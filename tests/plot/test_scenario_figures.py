from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cca_core import InputError
from cca_core.geometry import box_gap, boxes
from cca_core.plot import (
    baseline_and_v2v,
    describe_outcome,
    first_collision,
    group_by_case,
    one_run_per_ego,
    plot_braking,
    plot_crossing,
    plot_layout,
    plot_passing,
    report_figures,
    summarize_outcome,
    tuning_figure,
)
from cca_core.sim import Log

pytestmark = pytest.mark.requires("matplotlib")

Run = Callable[[str, str, str], Log]


@pytest.fixture(scope="module")
def braking(run: Run) -> tuple[Log, Log]:
    return run("eebl", "A", "driver"), run("eebl", "C", "v2v")


@pytest.fixture(scope="module")
def crossing(run: Run) -> tuple[Log, Log]:
    return run("ima", "left-turn", "driver"), run("ima", "left-turn", "v2v")


@pytest.fixture(scope="module")
def passing(run: Run) -> tuple[Log, Log]:
    return run("curbside", "fast", "driver"), run("curbside", "fast", "v2v")


def outline(axis: object, gid: str) -> np.ndarray:
    (patch,) = (patch for patch in axis.patches if patch.get_gid() == gid)
    return patch.get_xy()[:4]


def test_bands_reach_from_rear_to_front_bumper(braking: tuple[Log, Log]) -> None:
    axes = np.reshape(plot_braking(braking).axes, (3, 2))
    for log, axis in zip(braking, axes[0], strict=True):
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
    hit, free = (log.user_frenet[:, 0, 0] - log.ego_frenet[:, 0] - 4.5 for log in braking)
    assert first_collision(braking[0]).id == "yellow"
    assert hit.min() < 0.05
    assert first_collision(braking[1]) is None
    assert free.min() > 0.5
    first, second = plot_braking(braking).axes[:2]
    assert any("m/s" in text.get_text() for text in first.texts)
    assert not second.texts


def test_speeds_and_decelerations_are_those_of_the_log(braking: tuple[Log, Log]) -> None:
    axes = np.reshape(plot_braking(braking).axes, (3, 2))
    for log, (_, speed, brake) in zip(braking, axes.T, strict=True):
        np.testing.assert_array_equal(speed.lines[0].get_ydata(), log.ego[:, 3])
        np.testing.assert_array_equal(brake.lines[0].get_ydata(), -log.ego[:, 7])
        np.testing.assert_array_equal(speed.lines[2].get_ydata(), log.road_users[:, 1, 3])
    assert all("[" in axis.get_ylabel() for axis in axes[:, 0])


def test_crossing_shows_bodies_where_they_were(crossing: tuple[Log, Log]) -> None:
    figure = plot_crossing(crossing)
    for log, axis in zip(crossing, figure.axes[:2], strict=True):
        row = int(np.argmin(np.abs(log.t - 5.0)))
        np.testing.assert_allclose(outline(axis, "ego@5.0").mean(axis=0), log.ego[row, :2], atol=0.01)
    assert any("contact with red" in text.get_text() for text in figure.axes[0].texts)
    assert not any("contact" in text.get_text() for text in figure.axes[1].texts)


def test_the_way_enters_the_patch_only_in_a_collision(crossing: tuple[Log, Log]) -> None:
    for log, axis in zip(crossing, plot_crossing(crossing).axes[2:], strict=True):
        patch = axis.collections[0].get_paths()
        way = np.column_stack((log.t, log.ego_frenet[:, 0]))
        ego = next(line for line in axis.lines if line.get_label() == "ego")
        np.testing.assert_array_equal(ego.get_xdata(), way[:, 0])
        inside = any(path.contains_points(ego.get_xydata(), radius=1e-3).any() for path in patch)
        assert inside == (first_collision(log) is not None)


def test_passing_shows_the_ways_of_the_log(passing: tuple[Log, Log]) -> None:
    *strips, way, push = plot_passing(passing, "red").axes
    assert len(strips) == 2
    for log in passing:
        label = {"driver": "driver without V2V", "v2v": "with V2V"}[log.scenario.ego_type]
        line = next(line for line in way.lines if line.get_label() == label)
        s, d = line.get_xydata().T
        red = log.user_frenet[-1, 1, 0]
        np.testing.assert_allclose(np.interp(s + red, *log.ego_frenet.T), d, atol=1e-6)
        assert f"{label}: {np.abs(log.a_y).max():.1f} m/s²" in {each.get_label() for each in push.lines}
    assert strips[0].get_aspect() == 1.0
    assert strips[0].get_title(loc="left").endswith(summarize_outcome(passing[0]))


def test_layouts_have_everybody_in_place(run: Run) -> None:
    for name, case, ego in (("eebl", "C", "v2v"), ("ima", "left-turn", "v2v"), ("curbside", "fast", "v2v"),
                            ("maneuver", "3", "v2v")):  # fmt: skip
        scenario = run(name, case, ego).scenario
        (axis,) = plot_layout(scenario).axes
        texts = " ".join(text.get_text() for text in axis.texts)
        assert all(f"{user.id}:" in texts for user in scenario.road_users)
        assert "ego:" in texts


def test_layout_gaps_are_to_scale(run: Run) -> None:
    scenario = run("eebl", "C", "v2v").scenario
    (axis,) = plot_layout(scenario).axes
    bodies = sorted(patch.get_xy()[:4, 0].min() for patch in axis.patches if len(patch.get_xy()) == 5)
    wanted = [scenario.start, *sorted(user.s for user in scenario.road_users)]
    np.testing.assert_allclose(np.diff(bodies)[-2:], np.diff(wanted), atol=1e-6)


def test_contact_lies_on_both_outlines(crossing: tuple[Log, Log]) -> None:
    hit = first_collision(crossing[0])
    ego, others = crossing[0].bodies()
    for body, i in ((ego, 0), (others, 0)):
        x, y, psi = (field[-1, i] for field in (body.x, body.y, body.psi))
        assert abs(box_gap(boxes(x, y, psi, 4.5, 1.8), boxes(*hit.xy, 0.0, 0.01, 0.01))) < 0.15
    assert hit.speed == pytest.approx(crossing[0].closing_speed())
    assert hit.t == crossing[0].t[-1]


def test_verdicts_say_how_runs_ended(
    braking: tuple[Log, Log], passing: tuple[Log, Log], crossing: tuple[Log, Log], run: Run, alone: Log
) -> None:
    assert summarize_outcome(braking[0]) == f"hits yellow at {braking[0].closing_speed():.1f} m/s"
    gap = braking[1].gaps()[-1, 0]
    assert summarize_outcome(braking[1]) == f"stops {gap:.1f} m behind yellow"
    assert summarize_outcome(passing[1]) == f"passes red, {passing[1].gaps()[:, 1].min():.1f} m apart"
    assert f"least gap {crossing[1].gaps().min():.1f} m" in summarize_outcome(crossing[1])
    stuck = run("maneuver", "2", "sensor")
    assert (
        summarize_outcome(stuck)
        == f"ends {stuck.gaps()[-1, 0]:.1f} m behind R1, at {stuck.ego[-1, 3]:.1f} m/s"
    )
    assert summarize_outcome(alone) == describe_outcome(alone)


def test_groups_and_their_contrast(run: Run) -> None:
    logs = [
        run("eebl", "C", "v2v"), run("eebl", "B", "v2v"), run("eebl", "sensor", "sensor"),
        run("eebl", "D", "driver"), run("eebl", "A", "driver"), run("curbside", "slow", "v2v"),
        run("curbside", "fast", "v2v"),
    ]  # fmt: skip
    first, *others = group_by_case(logs)
    assert [log.scenario.ego_type for log in first] == ["driver", "driver", "sensor", "v2v", "v2v"]
    assert [log.scenario.case for log in one_run_per_ego(first)] == ["A", "sensor", "C"]
    assert [log.scenario.case for log in baseline_and_v2v(first)] == ["A", "C"]
    assert [[log.scenario.case for log in baseline_and_v2v(group)] for group in others] == [
        ["slow"],
        ["fast"],
    ]
    other_plant = replace(logs[0], plant="multi_body")
    assert one_run_per_ego([*first, other_plant])[-1] is logs[0]


def test_plates_have_names_of_files_and_captions(crossing: tuple[Log, Log], hostile: Log) -> None:
    for group in (list(crossing), [hostile]):
        names = [plate.name for plate in report_figures(group)]
        assert len(set(names)) == len(names)
        assert all(name.isascii() and name.isidentifier() for name in names)


def test_tunings_need_both(run: Run) -> None:
    fast, smooth = run("maneuver", "1-fast", "v2v"), run("maneuver", "1-smooth", "v2v")
    assert tuning_figure([smooth, fast]).name == "fig15_two_tunings"
    assert tuning_figure([fast]) is None


def test_misuse(braking: tuple[Log, Log], alone: Log) -> None:
    for draw in (plot_braking, plot_crossing, lambda logs: plot_passing(logs, "red")):
        with pytest.raises(InputError, match="at least one run"):
            draw([])
    with pytest.raises(InputError, match="yellow, red, was 'blue'"):
        plot_passing(braking, "blue")
    with pytest.raises(InputError, match="other road users"):
        plot_crossing([alone])


def test_figures_without_other_vehicles(alone: Log) -> None:
    assert len(plot_layout(alone.scenario).axes) == 1
    plot_braking([alone])
    assert [plate.figure for plate in report_figures([alone])]

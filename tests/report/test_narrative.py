from dataclasses import replace

import pytest

from cca_core.report import (
    describe_outcome,
    describe_participants,
    describe_run,
    group_by_case,
    headline,
    summarize_outcome,
    vehicles_waited_for,
)
from cca_core.report.overview import card
from cca_core.sim import Log
from cca_core.sim.outcome import overtaken
from tests.support.paper_runs import Run


def test_summary_of_a_collision_gives_its_speed(run: Run) -> None:
    log = run("eebl", "A", "driver")
    assert summarize_outcome(log) == f"collides with yellow at {log.closing_speed():.1f} m/s"


def test_summary_of_a_stop_gives_the_gap(run: Run) -> None:
    log = run("eebl", "C", "v2v")
    assert summarize_outcome(log) == f"stops {log.gaps()[-1, 0]:.1f} m behind yellow"


def test_summary_of_passing_gives_the_min_gap(run: Run) -> None:
    log = run("curbside", "fast", "v2v")
    assert summarize_outcome(log) == f"passes red, min gap to it {log.gaps()[:, 1].min():.1f} m"


def test_summary_of_passing_names_to_which_vehicles_the_gap_is(run: Run) -> None:
    log = run("maneuver", "2", "v2v")
    gaps = log.gaps()[:, overtaken(log)]
    assert f"passes R1 and R2, min gap to them {gaps.min():.1f} m" in summarize_outcome(log)


def test_gap_below_a_meter_has_centimeters_and_is_not_good(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    log = run("curbside", "fast", "v2v")

    def outcome() -> str:
        (text,) = [each for each in card(0, "a", [log]) if "<dd" in each]
        return text[text.index("<dd") :].replace("\N{NO-BREAK SPACE}", " ")

    assert outcome().startswith('<dd class="good">passes red, min gap to it')
    gaps = log.gaps()
    monkeypatch.setattr(Log, "gaps", lambda _: gaps - gaps[:, 1].min() + 0.013)
    assert outcome().startswith('<dd class="close">passes red, min gap to it 0.01 m')


def test_summary_of_a_crossing_gives_the_min_gap(run: Run) -> None:
    log = run("ima", "left-turn", "v2v")
    assert summarize_outcome(log).endswith(f"min gap {log.gaps().min():.1f} m")


def test_summary_of_following_gives_gap_and_speed(run: Run) -> None:
    log = run("maneuver", "2", "sensor")
    assert summarize_outcome(log) == f"ends {log.gaps()[-1, 0]:.1f} m behind R1, at {log.ego[-1, 3]:.1f} m/s"


def test_texts_state_that_a_road_user_drives_into_another(run: Run) -> None:
    log = run("eebl", "C", "v2v")
    crushed = replace(log, overlaps=((6.12, "yellow", "red", 4.0), (7.0, "green", "red", 1.0)))
    assert summarize_outcome(crushed) == f"{summarize_outcome(log)}; yellow drives into red at 6.1 s"
    assert describe_run(crushed) == (
        f"{describe_run(log)} yellow drives into red at 6.1 s: road users do not collide, so what follows "
        "means little; 1 more such pair."
    )


def test_summary_without_other_vehicles(alone: Log) -> None:
    assert summarize_outcome(alone) == describe_outcome(alone) == "ends with no vehicle ahead"


def test_narrative_names_awaited_vehicles(run: Run) -> None:
    waiting, stuck = run("maneuver", "2", "v2v"), run("maneuver", "2", "sensor")
    assert vehicles_waited_for(waiting, 10.0, 25.0) == ["A"]
    assert "until A has passed" in describe_run(waiting)
    assert describe_outcome(waiting) == "ends ahead of R1 and R2"
    assert describe_outcome(stuck) == "ends behind R1 and R2"
    assert "up to the end" in describe_run(stuck)


def test_narrative_ends_with_cause_of_last_decision(run: Run) -> None:
    log = run("maneuver", "2", "sensor")
    for (_, _, reason), (activity, cause) in zip(log.decisions, log.reasons, strict=True):
        assert reason.startswith(activity)
        assert reason.endswith(cause)
    activity, cause = log.reasons[-1]
    assert cause != ""
    begin, _, reason = log.decisions[-1]
    assert f"At {begin:.1f} s the ego starts {activity}, up to the end: {cause}. It ends" in describe_run(log)
    assert f"At {begin:.1f} s the ego starts {reason}, up to the end. It ends" in describe_run(
        replace(log, reasons=())
    )


def test_narrative_of_a_stop_is_a_sentence(run: Run) -> None:
    text = describe_run(run("curbside", "slow", "sensor"))
    assert "it stops behind red, up to the end" in text
    assert "starts stop" not in text


def test_outcome_names_the_collided_vehicle(run: Run) -> None:
    log = run("maneuver", "2", "sensor")
    users = log.road_users.copy()
    users[-1, 0, :2] = log.ego[-1, :2]
    assert describe_outcome(replace(log, road_users=users)) == "collides with R1"


def test_participants_are_described_with_lane_and_distance(run: Run) -> None:
    text = describe_participants(run("maneuver", "2", "v2v"))
    assert "R1 drives at 17 m/s in the ego lane" in text
    assert "A drives at 35 m/s in the left lane" in text


def test_participants_are_described_with_the_gap_to_the_ego(run: Run) -> None:
    log = run("eebl", "C", "v2v")
    assert f"in the ego lane, {log.gaps()[0, 0]:.0f} m ahead;" in describe_participants(log)
    shifted = log.user_frenet.copy()
    shifted[0, 0, 0] = log.ego_frenet[0, 0] + 1.0
    assert "in the ego lane, alongside;" in describe_participants(replace(log, user_frenet=shifted))
    log = run("ima", "left-turn", "v2v")
    gaps = log.gaps()[0]
    assert all(f"on another road, {gap:.0f} m away" in describe_participants(log) for gap in gaps[:1])


def test_headline_counts_collisions(run: Run) -> None:
    logs = [
        run("eebl", "A", "driver"), run("eebl", "C", "v2v"), run("ima", "left-turn", "driver"),
        run("ima", "left-turn", "v2v"), run("maneuver", "2", "sensor"), run("maneuver", "2", "v2v"),
    ]  # fmt: skip
    text = headline(group_by_case(logs))
    assert "in 2 of 2 scenarios if a person drives, in 0 of 1 if a program" in text
    assert "and in 0 of 3 with V2V" in text
    assert "case 2" in text


def test_headline_covers_only_simulated_runs(run: Run) -> None:
    assert "none of them both with and without" in headline([[run("eebl", "C", "v2v")]])

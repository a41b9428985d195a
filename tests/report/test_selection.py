from dataclasses import replace

from cca_core.report import baseline_and_v2v, group_by_case, one_run_per_ego
from cca_core.report.selection import compared_runs
from tests.support.paper_runs import Run


def test_compared_runs_change_one_thing_at_a_time(run: Run) -> None:
    names = ("C", "B", "sensor", "A")
    logs = [run("eebl", name, "") for name in names]
    assert [log.scenario.case for log in compared_runs(group_by_case(logs)[0])] == ["A", "sensor", "B", "C"]


def test_groups_and_their_runs_are_in_order(run: Run) -> None:
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

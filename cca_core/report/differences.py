"""What differs between runs that are compared."""

from collections.abc import Sequence
from itertools import pairwise

from cca_core.plot.labels import begin_sentence, join_names
from cca_core.plot.run_labels import run_labels
from cca_core.sim import Log, Scenario


def describe_differences(runs: Sequence[Log]) -> list[str]:
    """State what changes from each run to the next one, in a sentence each."""
    sentences = []
    for (before, was), (after, now) in pairwise(zip(runs, run_labels(runs), strict=True)):
        parts = _differences(before.scenario, after.scenario)
        if before.plant != after.plant:
            parts.append(f"the plant is {after.plant or 'recorded'} instead of {before.plant or 'recorded'}")
        only = "only this changes: " if len(parts) == 1 else ""
        text = "; ".join(parts) or "nothing changes"
        sentences.append(f"{begin_sentence(was)} \u2192 {now}: {only}{text}.")
    return sentences


def _differences(before: Scenario, after: Scenario) -> list[str]:
    parts = []
    if before.ego_type == "driver" != after.ego_type:
        parts.append(
            "a program drives instead of a person, and reacts to what it can see after "
            f"{after.sensor_delay:g} s instead of {before.reaction_time:g} s"
        )
    elif after.ego_type == "driver" != before.ego_type:
        parts.append("a person drives instead of a program")
    if before.v2v != after.v2v:
        parts.append(f"the ego {'receives' if after.v2v else 'does not receive'} messages")
    connected, now = ({user.id for user in each.road_users if user.connected} for each in (before, after))
    for ids, change in ((now - connected, "connected"), (connected - now, "not connected any more")):
        if ids:
            parts.append(f"{join_names(sorted(ids))} {'is' if len(ids) == 1 else 'are'} {change}")
    for name, was, value, unit in (
        ("brakes with at most", before.speed.b_max, after.speed.b_max, "m/s²"),
        ("has a cruise speed of", before.cruise_speed, after.cruise_speed, "m/s"),
    ):
        if was != value:
            parts.append(f"the ego {name} {value:g} {unit} instead of {was:g} {unit}")
    return parts

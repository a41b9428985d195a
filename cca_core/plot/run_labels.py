"""Names and line styles of runs that are compared: no two of them are the same."""

from collections import Counter
from collections.abc import Callable, Sequence

from cca_core.plot.labels import case_name, ego_label, scenario_name
from cca_core.plot.style import EGO_TYPE_STYLES, darken, lighten
from cca_core.sim import Log

_LINES = "-", "--", ":", "-."


def run_labels(logs: Sequence[Log]) -> list[str]:
    """Ego type of each run, after what tells runs of one ego type apart: scenario, case, plant or number."""
    egos = [ego_label(log) for log in logs]
    labels = [
        ", ".join([*_differences(log, [logs[k] for k, other in enumerate(egos) if other == ego]), ego])
        for log, ego in zip(logs, egos, strict=True)
    ]
    taken = Counter(labels)
    return [f"run {i}, {label}" if taken[label] > 1 else label for i, label in enumerate(labels, start=1)]


def run_styles(logs: Sequence[Log]) -> list[tuple[str, str]]:
    """Color and line of each run: those of its ego type, then shades of that color with other lines."""
    counts: Counter[tuple[str, str]] = Counter()
    styles = []
    for log in logs:
        color, line, _ = EGO_TYPE_STYLES[log.scenario.ego_type]
        if log.scenario.v2v and not all(user.connected for user in log.scenario.road_users):
            line = ":"
        k = counts[color, line]
        counts[color, line] += 1
        shade = (color, lighten(color), darken(color, 0.5))[k % 3]
        styles.append((shade, _LINES[(_LINES.index(line) + k) % len(_LINES)]))
    return styles


def _differences(log: Log, alike: Sequence[Log]) -> list[str]:
    """Names of what is not the same in all runs of an ego type."""
    names: tuple[Callable[[Log], str], ...] = (
        lambda each: scenario_name(each.scenario, cased=False),
        lambda each: case_name(each.scenario),
        lambda each: (each.plant or "recorded").replace("_", "-"),
    )
    return [name(log) for name in names if len(set(map(name, alike))) > 1 and name(log)]

"""The first screen of a report: what happens in each scenario, its vehicles, and the outcome of each ego."""

from collections.abc import Iterator, Sequence
from datetime import date

import numpy as np

from cca_core import __version__
from cca_core.plot.style import COLORS, assign_colors
from cca_core.report.animation import animate
from cca_core.report.html_text import html_text
from cca_core.report.narrative import summarize_outcome
from cca_core.report.scenario_texts import PAPER, describe_situation, paper_figures
from cca_core.report.selection import baseline_and_v2v, compares_v2v, one_run_per_ego
from cca_core.sim import Log
from cca_core.sim.outcome import first_collision

_SHORT_NAMES = {"driver": "Driver", "sensor": "Sensor", "v2v": "V2V"}


def card(i: int, name: str, group: Sequence[Log]) -> Iterator[str]:
    """One scenario: name, vehicles, situation, outcomes."""
    runs = one_run_per_ego(group)
    scenario = runs[-1].scenario
    figures = paper_figures(scenario)
    yield f'<a class="card" href="#scenario-{i}"><div><h3>{html_text(name)}'
    yield f" <small>{figures}</small></h3>{swatches(runs[-1])}\n"
    yield f"<p>{html_text(describe_situation(scenario))}</p></div>\n<dl>"
    for log in runs:
        ego_type = log.scenario.ego_type
        yield f'<div class="{ego_type}"><dt>{_SHORT_NAMES[ego_type]}</dt>'
        yield f'<dd class="{_kind(log)}">{html_text(summarize_outcome(log))}</dd></div>'
    yield "</dl></a>\n"


def _kind(log: Log) -> str:
    """Kind of the outcome of a run, which has a color."""
    if first_collision(log) is not None:
        return "collided"
    if log.gaps().min(initial=np.inf) < log.scenario.evasion.replan.min_clearance:
        return "close"
    return "good" if log.scenario.v2v else "fair"


def swatches(log: Log) -> str:
    """Color and id of each vehicle of a run, and the ego's cruise speed."""
    v_x = log.scenario.cruise_speed
    colors = {f"ego, {v_x:.0f} m/s ({3.6 * v_x:.0f} km/h)": COLORS.ego}
    colors |= assign_colors([user.id for user in log.scenario.road_users])
    parts = (
        f'<span><i style="background:{color}"></i>{html_text(name)}</span>' for name, color in colors.items()
    )
    return f'<p class="who">{" ".join(parts)}</p>'


def first_animation(groups: Sequence[Sequence[Log]], names: Sequence[str]) -> str:
    """Animation of two runs that show the effect of V2V best, at an intersection if there is one."""
    pairs = [baseline_and_v2v(group) for group in groups]

    def rank(i: int) -> tuple[bool, bool, bool]:
        collided = [first_collision(log) is not None for log in pairs[i]]
        helps = compares_v2v(pairs[i]) and collided == [True, False]
        return helps, helps and bool(pairs[i][-1].scenario.other_roads), compares_v2v(pairs[i])

    best = max(range(len(pairs)), key=rank)
    return f"<h3>{html_text(names[best])}</h3>\n{animate(pairs[best], standalone=False)}"


def words_used(groups: Sequence[Sequence[Log]]) -> str:
    """Explanations of the words of a report."""
    logs = [log for group in groups for log in group]
    scenarios = [log.scenario for log in logs]
    parts = [
        "Ego: the car that is studied, always blue. V2V: cars report their motion to each other by radio."
    ]
    drivers = sorted({s.reaction_time for s in scenarios if s.ego_type == "driver"})
    if drivers:
        seconds = " or ".join(f"{value:g}" for value in drivers)
        parts.append(f"Driver: a person, who brakes {seconds} s after they can see the hazard.")
    sensors = [log for log in logs if log.scenario.ego_type == "sensor"]
    delays = sorted({log.scenario.sensor_delay for log in sensors if log.remotes is None})
    if delays:
        seconds = " or ".join(f"{value:g}" for value in delays)
        parts.append(f"Sensor: a program that drives, and knows what its sensor saw {seconds} s ago.")
    elif sensors:  # recorded: the delay is unknown
        parts.append("Sensor: a program that drives, and knows what its sensor sees.")
    if any(s.v2v for s in scenarios):
        parts.append("With V2V: the same program, which also receives messages of hidden vehicles.")
    parts.append("Collision speeds are relative. Gaps are measured between the bodies.")
    return " ".join(parts)


def source_of(groups: Sequence[Sequence[Log]]) -> str:
    """Name the paper, the version, the seeds and the date."""
    logs = [log for group in groups for log in group]
    seeds = sorted({log.seed for log in logs if log.seed is not None})
    numbers = sorted({number for log in logs for number in log.scenario.paper_figures})
    parts = [f"The scenarios are those of {PAPER}, Figs {numbers[0]} to {numbers[-1]}."] if numbers else []
    parts.append("Every number on this page comes from the runs that are shown.")
    run = f"cca_core {__version__}"
    if seeds:
        run += f", {'seed' if len(seeds) == 1 else 'seeds'} {', '.join(map(str, seeds))}"
    return " ".join([*parts, f"{run}, {date.today().isoformat()}."])

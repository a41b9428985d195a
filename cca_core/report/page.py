"""One self-contained page about a set of runs: what V2V changed, then each scenario."""

import base64
import io
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path as FilePath

import numpy as np

from cca_core._checks import shown
from cca_core.errors import InputError
from cca_core.plot.crossing_times import crossing_times
from cca_core.plot.labels import begin_sentence, case_name, ego_label, scenario_name
from cca_core.plot.run_labels import run_labels
from cca_core.report.animation import animate
from cca_core.report.differences import describe_differences
from cca_core.report.figures import ReportFigure, report_figures, tuning_figure
from cca_core.report.files import fill, read_text
from cca_core.report.html_text import html_text
from cca_core.report.narrative import describe_participants, describe_run, headline, summarize_outcome
from cca_core.report.overview import card, first_animation, source_of, swatches, words_used
from cca_core.report.scenario_texts import describe_situation, paper_figures
from cca_core.report.selection import baseline_and_v2v, compared_runs, compares_v2v, group_by_case
from cca_core.sim import Log

_REASON_WORDS = (
    "Gap: distance between bumpers, less the error that the other vehicle's position may have; wants: the gap"
    " that the ego keeps. Closing at: difference of the speeds. A value in m/s² after braking or slowing: the"
    " deceleration of the ego. Limit: the value up to which the program accepts a quantity. Awareness range:"
    " distance up to which it knows all vehicles."
)


def write_report(
    runs: Sequence[Log],
    file: str | FilePath,
    *,
    title: str | None = None,
    figures: str | FilePath | None = None,
    progress: Callable[[], object] | None = None,
) -> None:
    """Write a page that states what V2V changed and shows what happened in each scenario.

    Parameters
    ----------
    runs : sequence of Log
        The runs, simulated or recorded (`Recorder`), in the order in which their scenarios are shown. A
        section shows the runs of one scenario, such as those with and without V2V (`group_by_case`).
    file : str or pathlib.Path
        HTML file to write; it needs no other file and no network.
    title : str, optional
        Title of the page.
    figures : str or pathlib.Path, optional
        Folder into which all figures are written as PNG too.
    progress : callable, optional
        Called after each scenario.

    Raises
    ------
    InputError
        If there is no run, or a run is not a `Log`.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not runs or not all(isinstance(log, Log) for log in runs):
        raise InputError(f"runs must be a sequence of at least one Log, was {shown(runs)}")
    folder = None if figures is None else FilePath(figures)
    groups = group_by_case(runs)
    names = _names(groups)
    if title is None:
        compares = any(compares_v2v(baseline_and_v2v(group)) for group in groups)
        title = f"Cooperative collision avoidance{': what V2V changed' if compares else ''}"
    sections = ""
    for i, group in enumerate(groups):
        sections += "".join(_section(i, *names[i], group, folder))
        if progress is not None:
            progress()
    tunings = tuning_figure(runs)
    if tunings is not None:
        sections += "<h2>Two tunings</h2>\n" + "".join(_pictures([tunings], folder))
    page = fill(
        "page.html",
        page_css=read_text("page.css"),
        player_css=read_text("player.css"),
        player_js=read_text("player.js"),
        title=html_text(title),
        headline=html_text(headline(groups)),
        cards="".join(part for i, group in enumerate(groups) for part in card(i, names[i][0], group)),
        show=first_animation(groups, [name for name, _ in names]),
        words=html_text(words_used(groups)),
        source=html_text(source_of(groups)),
        sections=sections,
    )
    FilePath(file).write_text(page, encoding="utf-8")


def _names(groups: Sequence[Sequence[Log]]) -> list[tuple[str, int]]:
    """Name of each group, with a number if it is taken, and the number."""
    names, taken = [], Counter[str]()
    for group in groups:
        is_one_case = len({log.scenario.case for log in group}) == 1
        name = begin_sentence(scenario_name(baseline_and_v2v(group)[-1].scenario, cased=is_one_case))
        taken[name] += 1
        number = taken[name]
        names.append((f"{name} ({number})" if number > 1 else name, number))
    return names


def _section(i: int, name: str, number: int, group: Sequence[Log], folder: FilePath | None) -> Iterator[str]:
    runs = compared_runs(group)
    egos = [html_text(begin_sentence(label)) for label in run_labels(runs)]
    scenario = runs[-1].scenario
    source = paper_figures(scenario)
    heading = f"{html_text(name)} <small>{source}</small>" if source else html_text(name)
    yield f'<section id="scenario-{i}"><h2>{heading}</h2>\n'
    yield f"<p>{html_text(describe_situation(scenario))}</p>{swatches(runs[-1])}\n"
    yield f"<p>{html_text(describe_participants(runs[-1]))}</p>\n"
    yield animate(runs, standalone=False)
    yield from (f'<p class="note">{html_text(text)}</p>\n' for text in describe_differences(runs))
    figures = list(report_figures(group))
    if number > 1:
        figures = [replace(figure, name=f"{figure.name}_{number}") for figure in figures]
    layout, *others = figures
    yield f'<div class="figures"><div>{_picture(layout, folder)}<h3>What happens</h3>\n<ul>\n'
    for log, ego in zip(runs, egos, strict=True):
        yield f"<li><b>{ego}.</b> {html_text(describe_run(log))}</li>\n"
    yield "</ul></div>\n"
    yield from (_picture(figure, folder) for figure in others if not figure.detail)
    yield "</div>\n"
    yield from _table(group)
    yield "<details><summary>More figures and every decision</summary>\n"
    yield from _pictures([figure for figure in others if figure.detail], folder)
    yield f'<p class="note">{_REASON_WORDS}</p>\n'
    for log, ego in zip(runs, egos, strict=True):
        yield f"<p><b>{ego}</b></p><ul>\n"
        yield from (
            f"<li>At {t:.1f} s <b>{name}</b>: {html_text(reason)}</li>\n" for t, name, reason in log.decisions
        )
        yield "</ul>\n"
    yield "</details></section>\n"


def _table(group: Sequence[Log]) -> Iterator[str]:
    names = (
        "Ego", "Plant", "Outcome", "Smallest gap to any vehicle", "Shortest time to collision",
        "Hardest braking", "Peak lateral acceleration", "Messages",
    )  # fmt: skip
    yield '<table class="facts">\n<thead><tr>'
    yield "".join(f"<th>{name}</th>" for name in names) + "</tr></thead>\n<tbody>\n"
    has_cases = len({log.scenario.case for log in group}) > 1
    for log in group:
        key = log.summary()
        ego = f"{ego_label(log)}; {case_name(log.scenario)}" if has_cases else ego_label(log)
        cells = (
            ego, (log.plant or "recorded").replace("_", "-"), summarize_outcome(log),
            _value(key["min_gap_m"], "m", 2), _time_to_collision(log, key["min_ttc_s"]),
            _value(key["max_decel_mps2"], "m/s²", 1), _value(key["max_abs_ay_mps2"], "m/s²", 1),
            str(len(log.received)) if log.remotes is None else "unknown",
        )  # fmt: skip
        kind = ' class="collided"' if key["collided"] else ""
        yield (
            f"<tr{kind}>"
            + "".join(
                f'<td data-name="{name}">{html_text(cell)}</td>'
                for name, cell in zip(names, cells, strict=True)
            )
            + "</tr>\n"
        )
    yield "</tbody>\n</table>\n"


def _time_to_collision(log: Log, along: float | None) -> str:
    """Least time to collision: with crossing vehicles if there are any, or else along the lane."""
    times = crossing_times(log)
    if times is None:
        return _value(along, "s", 1)
    ttc = float(times.ttc.min(initial=np.inf))
    if log.collision_row is not None:
        return "0.0 s, crossing"
    text = f"{_value(ttc if np.isfinite(ttc) else None, 's', 1)}, crossing"
    return text if times.pet is None else f"{text}; {times.pet:.1f} s between both in the conflict area"


def _value(value: float | None, unit: str, digits: int) -> str:
    return "none" if value is None else f"{max(value, 0.0):.{digits}f} {unit}"


def _pictures(figures: Sequence[ReportFigure], folder: FilePath | None) -> Iterator[str]:
    yield '<div class="figures">\n'
    yield from (_picture(figure, folder) for figure in figures)
    yield "</div>\n"


def _picture(figure: ReportFigure, folder: FilePath | None) -> str:
    stream = io.BytesIO()
    figure.figure.savefig(stream, format="png", dpi=150)
    if folder is not None:
        (folder / f"{figure.name}.png").write_bytes(stream.getvalue())
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    caption = html_text(figure.caption)
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{data}">'
        f"<figcaption>{caption}</figcaption></figure>\n"
    )

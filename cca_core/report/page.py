"""One self-contained page about a set of runs: what V2V changed, then each scenario."""

import base64
import io
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path as FilePath

from cca_core._checks import shown
from cca_core.errors import InputError
from cca_core.plot.labels import begin_sentence, case_name, ego_label, sanitize_text, scenario_name
from cca_core.report.animation import animate
from cca_core.report.figures import ReportFigure, report_figures, tuning_figure
from cca_core.report.files import fill, read_text
from cca_core.report.narrative import describe_participants, describe_run, headline, summarize_outcome
from cca_core.report.selection import baseline_and_v2v, compares_v2v, group_by_case, one_run_per_ego
from cca_core.sim import Log
from cca_core.sim.outcome import first_collision


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
        sections += f"<h2>Two tunings</h2>\n{_picture(tunings, folder)}"
    page = fill(
        "page.html",
        page_css=read_text("page.css"),
        player_css=read_text("player.css"),
        player_js=read_text("player.js"),
        title=_text(title),
        headline=_text(headline(groups)),
        cards="".join(part for i, group in enumerate(groups) for part in _card(i, names[i][0], group)),
        sections=sections,
    )
    FilePath(file).write_text(page, encoding="utf-8")


def _card(i: int, name: str, group: Sequence[Log]) -> Iterator[str]:
    yield f'<a class="card" href="#scenario-{i}"><h3>{_text(name)}</h3>\n<dl>'
    for log in one_run_per_ego(group):
        kind = "collided" if first_collision(log) is not None else "good" if log.scenario.v2v else "fair"
        yield f'<dt>{_ego(log)}</dt><dd class="{kind}">{_text(summarize_outcome(log))}</dd>'
    yield "</dl></a>\n"


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


def _ego(log: Log) -> str:
    return begin_sentence(ego_label(log))


def _section(i: int, name: str, number: int, group: Sequence[Log], folder: FilePath | None) -> Iterator[str]:
    pair = baseline_and_v2v(group)
    yield f'<section id="scenario-{i}"><h2>{_text(name)}</h2>\n'
    yield f"<p>{_text(describe_participants(pair[-1]))}</p>\n"
    figures = list(report_figures(group))
    if number > 1:
        figures = [replace(figure, name=f"{figure.name}_{number}") for figure in figures]
    first, *others = figures
    yield _picture(first, folder)
    yield animate(pair, standalone=False)
    yield "<ul>\n"
    yield from (f"<li><b>{_ego(log)}.</b> {_text(describe_run(log))}</li>\n" for log in pair)
    yield "</ul>\n"
    yield from _table(group)
    yield from (_picture(figure, folder) for figure in others if not figure.detail)
    yield "<details><summary>More figures and every decision</summary>\n"
    yield from (_picture(figure, folder) for figure in others if figure.detail)
    for log in pair:
        yield f"<p><b>{_ego(log)}</b></p><ul>\n"
        yield from (
            f"<li>{t:.1f} s <b>{name}</b>: {_text(reason)}</li>\n" for t, name, reason in log.decisions
        )
        yield "</ul>\n"
    yield "</details></section>\n"


def _table(group: Sequence[Log]) -> Iterator[str]:
    names = ("Ego", "Plant", "Outcome", "Min gap", "Min TTC", "Peak deceleration", "Peak a_y", "Messages")
    yield '<div class="scroll" tabindex="0" role="region" aria-label="Key figures"><table>\n<thead><tr>'
    yield "".join(f"<th>{name}</th>" for name in names) + "</tr></thead>\n<tbody>\n"
    has_cases = len({log.scenario.case for log in group}) > 1
    for log in group:
        key = log.summary()
        ego = f"{ego_label(log)}, {case_name(log.scenario)}" if has_cases else ego_label(log)
        cells = (
            ego, (log.plant or "recorded").replace("_", "-"), summarize_outcome(log),
            _value(key["min_gap_m"], "m", 2),
            _value(key["min_ttc_s"], "s", 1), _value(key["max_decel_mps2"], "m/s²", 1),
            _value(key["max_abs_ay_mps2"], "m/s²", 1),
            str(len(log.received)) if log.remotes is None else "unknown",
        )  # fmt: skip
        kind = ' class="collided"' if key["collided"] else ""
        yield f"<tr{kind}>" + "".join(f"<td>{_text(cell)}</td>" for cell in cells) + "</tr>\n"
    yield "</tbody>\n</table></div>\n"


def _value(value: float | None, unit: str, digits: int) -> str:
    return "none" if value is None else f"{max(value, 0.0):.{digits}f} {unit}"


def _picture(figure: ReportFigure, folder: FilePath | None) -> str:
    stream = io.BytesIO()
    figure.figure.savefig(stream, format="png", dpi=110)
    if folder is not None:
        (folder / f"{figure.name}.png").write_bytes(stream.getvalue())
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    caption = _text(figure.caption)
    return (
        '<figure><div class="scroll" tabindex="0" role="region" aria-label="Figure">'
        f'<img alt="{caption}" src="data:image/png;base64,{data}"></div>'
        f"<figcaption>{caption}</figcaption></figure>\n"
    )


def _text(text: str) -> str:
    """Text of any origin as HTML, with numbers and units on one line."""
    return re.sub(r"(\d) (m/s²|m/s|m|s)\b", "\\1\N{NO-BREAK SPACE}\\2", escape(sanitize_text(text)))

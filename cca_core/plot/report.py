"""One self-contained page about a set of runs: what V2V changed, then each scenario moving and in figures."""

import base64
import io
import re
from collections.abc import Callable, Iterator, Sequence
from html import escape
from pathlib import Path as FilePath

from cca_core.plot.animation import animate
from cca_core.plot.gallery import ReportFigure, report_figures, tuning_figure
from cca_core.plot.player import SCRIPT, STYLE
from cca_core.plot.story import describe_participants, describe_run, join_names
from cca_core.plot.style import case_name, ego_label, sanitize_text, scenario_name
from cca_core.plot.verdict import (
    baseline_and_v2v,
    first_collision,
    group_by_case,
    one_run_per_ego,
    summarize_outcome,
)
from cca_core.sim import Log

_DPI = 110
_STYLE = """
:root { color-scheme: light dark; --paper: #fff; --ink: #222; --soft: #5a5a5a; --rule: #d0d0d0;
  --card: #f6f7f5; --bad: #a33000; --good: #00619c; --fair: #555 }
@media (prefers-color-scheme: dark) {
  :root { --paper: #16181a; --ink: #e8e8e8; --soft: #b0b0b0; --rule: #444; --card: #202427; --bad: #ff8a5c;
    --good: #6cc0f2; --fair: #b0b0b0 }
}
* { box-sizing: border-box }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 1180px;
  margin: 0 auto; padding: 0 16px 48px; overflow-wrap: break-word }
h1 { font-size: clamp(1.25rem, 4vw, 1.75rem); line-height: 1.2; margin: .7em 0 .4em }
h2 { margin: 2em 0 .5em; border-top: 1px solid var(--rule); padding-top: 1em; line-height: 1.25 }
h3 { font-size: 1em; margin: 0 0 .3em; line-height: 1.3 }
.lead { font-size: 1.1em; margin: 0 0 .8em; max-width: 60em }
.cards { display: grid; gap: 10px; grid-template-columns: repeat(auto-fill, minmax(min(100%, 330px), 1fr)) }
.card { background: var(--card); border: 1px solid var(--rule); border-radius: 6px; padding: .6em .8em;
  color: inherit; text-decoration: none }
.card:hover, .card:focus-visible { border-color: var(--good) }
.card dl { margin: 0; display: grid; gap: .1em .7em; grid-template-columns: auto 1fr; font-size: .9em }
.card dt { color: var(--soft); white-space: nowrap } .card dd { margin: 0 }
.hit { color: var(--bad) } dd.hit, dd.good { font-weight: 600 }
.good { color: var(--good) } .fair { color: var(--fair) }
.note, figcaption { color: var(--soft); font-size: .9em }
.cca figcaption { color: inherit }
figure { margin: 1.2em 0 }
.scroll { overflow-x: auto }
figure .scroll img { display: block; width: 100%; min-width: 620px; border-radius: 4px; background: #fff }
table { border-collapse: collapse; width: 100%; font-size: .9em }
th, td { text-align: left; vertical-align: top; padding: .35em 1em .35em 0;
  border-bottom: 1px solid var(--rule) }
td:nth-child(3) { min-width: 13em } td:first-child { min-width: 9em }
td { font-variant-numeric: tabular-nums }
summary { cursor: pointer; padding: .5em 0; font-weight: 600 }
"""
_UNITS = re.compile(r"(\d) (m/s²|m/s|m|s)\b")
_EGOS = {"v2v": "With V2V", "driver": "Driver, no V2V", "sensor": "Sensor, no V2V"}


def write_report(
    runs: Sequence[Log],
    file: str | FilePath,
    *,
    figures: str | FilePath | None = None,
    progress: Callable[[], object] | None = None,
) -> None:
    """Write a page that says what V2V changed and shows what happened in each scenario.

    Parameters
    ----------
    runs : sequence of Log
        The runs, in the order in which their scenarios are told.
    file : str or pathlib.Path
        HTML file to write; it needs no other file and no network.
    figures : str or pathlib.Path, optional
        Folder into which all figures are written as PNG too.
    progress : callable, optional
        Called after each scenario.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    folder = None if figures is None else FilePath(figures)
    groups = group_by_case(runs)
    chapters = ""
    for i, group in enumerate(groups):
        chapters += "".join(_chapter(i, group, folder))
        if progress is not None:
            progress()
    both = tuning_figure(runs)
    more = f"<h2>Two tunings</h2>\n{_picture(both, folder)}" if both is not None else ""
    page = f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>Cooperative collision avoidance: what V2V changed</title>
<style>{_STYLE}{STYLE}</style>
</head>
<body>
<header data-first="">
<h1>Cooperative collision avoidance: what V2V changed</h1>
<p class="lead">{escape(sanitize_text(headline(groups)))}</p>
<div class="cards">
{"".join(part for i, group in enumerate(groups) for part in _card(i, group))}</div>
<p class="note">Every number on this page comes from the runs that are shown. Speeds at a contact are
relative; gaps are between body boxes. The driver and the sensor know what they see, the ego with V2V what
it hears as well.</p>
</header>
<main>
{chapters}{more}</main>
<script>{SCRIPT}</script>
</body>
</html>
"""
    FilePath(file).write_text(page, encoding="utf-8")


def headline(groups: Sequence[Sequence[Log]]) -> str:
    """Say in a sentence or two what V2V changed.

    Parameters
    ----------
    groups : sequence of sequence of Log
        Runs by scenario, as `grouped` sorts them.

    Returns
    -------
    text : str
        In how many scenarios the ego collides without V2V and with it, and what else V2V makes possible.
    """
    pairs = [pair for pair in map(baseline_and_v2v, groups) if len({log.scenario.v2v for log in pair}) == 2]
    if not pairs:
        return f"{len(groups)} scenarios were driven; none of them both with and without V2V."
    hits = [[first_collision(log) is not None for log in pair] for pair in pairs]
    without, with_v2v = (sum(column) for column in zip(*hits, strict=True))
    n = len(pairs)
    text = f"Without V2V the ego collides in {_count(without, n)}; with V2V in {_count(with_v2v, n)}."
    sensed = [log for group in groups for log in one_run_per_ego(group) if log.scenario.ego_type == "sensor"]
    driven = sum(pair[0].scenario.ego_type == "driver" for pair in pairs)
    if driven and sensed:
        hit = sum(first_collision(log) is not None for log in sensed)
        text += f" An automated ego with a sensor alone collides in {_count(hit, len(sensed))}."
    freed = [
        (pair[0], pair[1])
        for pair, hit in zip(pairs, hits, strict=True)
        if not any(hit) and _n_overtaken(pair[1]) > _n_overtaken(pair[0])
    ]
    if freed:
        names = join_names([case_name(pair[1].scenario) for pair in freed])
        text += f" When maneuvering ({names}) it stays behind slow traffic without V2V"
        text += " and passes it with V2V."
    return text


def _count(k: int, n: int) -> str:
    number = "none" if k == 0 else f"all {n}" if k == n else str(k)
    return number if k in (0, n) else f"{number} of {n} scenarios"


def _n_overtaken(log: Log) -> int:
    ahead = log.user_frenet[[0, -1], :, 0] > log.ego_frenet[[0, -1], None, 0]
    along = [user.direction > 0 for user in log.scenario.road_users]
    return int((ahead[0] & ~ahead[1] & along).sum())


def _card(i: int, group: Sequence[Log]) -> Iterator[str]:
    yield f'<a class="card" href="#scenario-{i}"><h3>{_text(_name(group))}</h3>\n<dl>'
    for log in one_run_per_ego(group):
        kind = "hit" if first_collision(log) is not None else "good" if log.scenario.v2v else "fair"
        yield f'<dt>{_EGOS[log.scenario.ego_type]}</dt><dd class="{kind}">{_text(summarize_outcome(log))}</dd>'
    yield "</dl></a>\n"


def _name(group: Sequence[Log]) -> str:
    scenario = baseline_and_v2v(group)[-1].scenario
    return scenario_name(scenario, cased=len({log.scenario.case for log in group}) == 1)


def _chapter(i: int, group: Sequence[Log], folder: FilePath | None) -> Iterator[str]:
    pair = baseline_and_v2v(group)
    yield f'<section id="scenario-{i}"><h2>{_text(_name(group))}</h2>\n'
    yield f"<p>{_text(describe_participants(pair[-1]))}</p>\n"
    first, *others = report_figures(group)
    yield _picture(first, folder)
    yield animate(pair, alone=False)
    yield "<ul>\n"
    yield from (
        f"<li><b>{_text(_EGOS[log.scenario.ego_type])}.</b> {_text(describe_run(log))}</li>\n" for log in pair
    )
    yield "</ul>\n"
    yield from _table(group)
    yield from (_picture(plate, folder) for plate in others if not plate.detail)
    yield "<details><summary>More figures and every decision</summary>\n"
    yield from (_picture(plate, folder) for plate in others if plate.detail)
    for log in pair:
        yield f"<p><b>{_EGOS[log.scenario.ego_type]}</b></p><ul>\n"
        yield from (f"<li>{t:.1f} s <b>{name}</b>: {_text(why)}</li>\n" for t, name, why in log.decisions)
        yield "</ul>\n"
    yield "</details></section>\n"


def _table(group: Sequence[Log]) -> Iterator[str]:
    names = ("Ego", "Plant", "Outcome", "Least gap", "Least TTC", "Peak deceleration", "Peak a_y", "Messages")
    yield '<div class="scroll" tabindex="0" role="region" aria-label="Key figures"><table>\n<thead><tr>'
    yield "".join(f"<th>{name}</th>" for name in names) + "</tr></thead>\n<tbody>\n"
    several = len({log.scenario.case for log in group}) > 1
    for log in group:
        key = log.summary()
        ego = f"{ego_label(log)}, {case_name(log.scenario)}" if several else ego_label(log)
        cells = (
            ego, log.plant.replace("_", "-"), summarize_outcome(log), _value(key["min_gap_m"], "m", 2),
            _value(key["min_ttc_s"], "s", 1), _value(key["max_decel_mps2"], "m/s²", 1),
            _value(key["max_abs_ay_mps2"], "m/s²", 1), str(len(log.received)),
        )  # fmt: skip
        kind = ' class="hit"' if key["collided"] else ""
        yield f"<tr{kind}>" + "".join(f"<td>{_text(cell)}</td>" for cell in cells) + "</tr>\n"
    yield "</tbody>\n</table></div>\n"


def _value(value: float | None, unit: str, digits: int) -> str:
    return "none" if value is None else f"{max(value, 0.0):.{digits}f}\N{NO-BREAK SPACE}{unit}"


def _picture(plate: ReportFigure, folder: FilePath | None) -> str:
    stream = io.BytesIO()
    plate.figure.savefig(stream, format="png", dpi=_DPI)
    if folder is not None:
        (folder / f"{plate.name}.png").write_bytes(stream.getvalue())
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    caption = _text(plate.caption)
    return (
        '<figure><div class="scroll" tabindex="0" role="region" aria-label="Figure">'
        f'<img alt="{caption}" src="data:image/png;base64,{data}"></div>'
        f"<figcaption>{caption}</figcaption></figure>\n"
    )


def _text(text: str) -> str:
    """Text of any origin as HTML, with numbers and units on one line."""
    return _UNITS.sub("\\1\N{NO-BREAK SPACE}\\2", escape(sanitize_text(text)))

"""One self-contained page about a set of runs."""

import base64
import io
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path as FilePath
from typing import Any

from cca_core.plot.figures import plot_time_series, plot_tunings
from cca_core.plot.story import cast, outcome, story
from cca_core.plot.style import title
from cca_core.plot.traffic import plot_traffic
from cca_core.sim import Log

_DPI = 120

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 1080px; margin: auto; padding: 0 16px }
h1 { font-size: 1.5em; line-height: 1.2 } h2 { margin-top: 2em; border-top: 1px solid #ccc; padding-top: 1em }
table { border-collapse: collapse; width: 100%; font-size: .9em }
th, td { text-align: left; vertical-align: top; padding: .35em .8em .35em 0; border-bottom: 1px solid #ddd }
td:nth-child(3), td:nth-child(4) { white-space: nowrap } .hit { color: #a33000; font-weight: bold }
figure { margin: 1.2em 0; overflow-x: auto } figure img { width: 100%; min-width: 720px; display: block }
figcaption { font-size: .9em; color: #555; position: sticky; left: 0 }
@media (max-width: 700px) {
  thead { display: none } tr { display: block; padding: .5em 0; border-bottom: 1px solid #ccc }
  td { display: flex; border: 0; padding: .1em 0 }
  td::before { content: attr(data-name); flex: 0 0 7.5em; color: #666 }
}
"""


def write_report(runs: Sequence[Log], file: str | FilePath) -> None:
    """Write a page that tells, tabulates and shows what happened in each run.

    Parameters
    ----------
    runs : sequence of Log
        The runs, in the order in which they are told.
    file : str or pathlib.Path
        HTML file to write; it needs no other file and no network.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    page = f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Cooperative collision avoidance: what happened</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>Cooperative collision avoidance: what happened</h1>
{"".join(_summary(runs))}
{"".join(_tunings(runs))}
{"".join(part for log in runs for part in _chapter(log))}
</body>
</html>
"""
    FilePath(file).write_text(page, encoding="utf-8")


def _summary(runs: Sequence[Log]) -> Iterator[str]:
    hits = sum(log.summary()["collided"] for log in runs)
    verdict = f"<span class='hit'>{hits} of {len(runs)} runs collide.</span>" if hits else "No run collides."
    yield f"<p>{verdict} Gaps are between body boxes; a_y is lateral acceleration.</p>\n<ul>\n"
    yield from (f"<li><b>{escape(title(log))}.</b> {escape(story(log))}</li>\n" for log in runs)
    names = ("Case", "Actions", "Least gap", "Peak a_y", "Outcome")
    head = "".join(f"<th>{name}</th>" for name in names)
    yield f"</ul>\n<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n"
    for log in runs:
        key = log.summary()
        actions = ", ".join(
            f"{t:.1f}\N{NO-BREAK SPACE}s\N{NO-BREAK SPACE}{name}" for t, name in key["actions"]
        )
        gap = "none near" if key["min_gap_m"] is None else f"{key['min_gap_m']:.2f} m"
        cells = (title(log), actions, gap, f"{abs(log.a_y).max():.2f} m/s²", outcome(log))
        row = zip(names, cells, strict=True)
        yield (
            "<tr>" + "".join(f'<td data-name="{name}">{escape(cell)}</td>' for name, cell in row) + "</tr>\n"
        )
    yield "</tbody>\n</table>\n"


def _tunings(runs: Sequence[Log]) -> Iterator[str]:
    """Show the two tunings of case 1, if both were run."""
    cases = {log.scenario.case: log for log in runs if log.scenario.v2v}
    if {"1-fast", "1-smooth"} <= cases.keys():
        yield "<h2>Two tunings</h2>\n"
        yield _picture(
            plot_tunings(cases["1-fast"], cases["1-smooth"]),
            "Tuned fast, the car leaves its lane later and changes over in less distance, with more lateral "
            "acceleration; tuned smooth, it takes more road.",
        )


def _chapter(log: Log) -> Iterator[str]:
    yield f"<h2>{escape(title(log))}</h2>\n<p>{escape(cast(log))}</p>\n<ul>\n"
    yield from (f"<li>{t:.1f} s <b>{name}</b>: {escape(reason)}</li>\n" for t, name, reason in log.decisions)
    yield "</ul>\n"
    yield _picture(
        plot_traffic(log),
        "Path and traffic. Boxes have the size of the vehicles; equal numbers belong to one moment. In the "
        "strips the solid line is where the ego has been, the dotted line where it will go.",
    )
    yield _picture(plot_time_series(log), "The same run over time; the background shows the action.")


def _picture(figure: Any, caption: str) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=_DPI)
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    alt = escape(caption, quote=True)
    return (
        f'<figure><img alt="{alt}" src="data:image/png;base64,{data}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>\n"
    )

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from cca_core import __version__
from cca_core.report import (
    describe_run,
    group_by_case,
    headline,
    one_run_per_ego,
    summarize_outcome,
    write_report,
)
from cca_core.sim import Log
from tests.support.browser import SIZES, faults, find_browser, inspect_page
from tests.support.paper_runs import Run

pytestmark = pytest.mark.requires("matplotlib")

BROWSER = find_browser()
VOID = {"meta", "img", "input", "br", "circle", "rect", "path"}


class Page(HTMLParser):
    """Checks that what is opened is closed, and collects what a page refers to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.images: list[str] = []
        self.refers: list[str] = []
        self.ids: list[str] = []
        self.scripts, self.tables, self.text = 0, 0, ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        if tag not in VOID:
            self.open.append(f"{tag}.{values.get('class') or ''}")
        self.refers += [
            v or "" for k, v in attrs if k in ("src", "href", "xlink:href", "action", "srcset", "data")
        ]
        self.ids += [v or "" for k, v in attrs if k == "id"]
        self.scripts += tag == "script"
        if tag == "img":
            self.images.append(values.get("alt") or "")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.handle_endtag(tag)

    def handle_endtag(self, tag: str) -> None:
        opened = self.open.pop()
        assert opened.partition(".")[0] == tag, f"</{tag}> closes <{opened}>"

    def handle_data(self, data: str) -> None:
        if not self.open or not self.open[-1].startswith(("script", "style")):
            self.text += data


@pytest.fixture(scope="module")
def runs(run: Run) -> list[Log]:
    return [
        run("eebl", "C", "v2v"), run("eebl", "A", "driver"), run("eebl", "sensor", "sensor"),
        run("curbside", "fast", "driver"), run("curbside", "fast", "sensor"), run("curbside", "fast", "v2v"),
        run("ima", "left-turn", "driver"), run("ima", "left-turn", "v2v"),
        run("maneuver", "2", "sensor"), run("maneuver", "2", "v2v"),
    ]  # fmt: skip


@pytest.fixture(scope="module")
def file(runs: list[Log], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    write_report(runs, folder / "report.html", figures=folder)
    return folder / "report.html"


def test_page_needs_no_other_file_and_no_network(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    page = Page(text)
    assert page.open == []
    assert all(each.startswith(("data:image/png;base64,", "#")) for each in page.refers)
    assert {each[1:] for each in page.refers if each.startswith("#")} <= set(page.ids)
    assert not re.search(r"https?:|@import|url\(|fetch\(|XMLHttp|WebSocket|<link|<iframe", text)
    assert all(page.images)
    assert len(text) < 6_000_000


def test_first_screen_names_paper_version_seed_and_date(file: Path) -> None:
    text = file.read_text(encoding="utf-8")
    header = Page(text[text.index("<header") : text.index("</header>") + 9]).text
    for part in (
        "Cooperative Collision Avoidance in a Connected",
        f"cca_core {__version__}, seed 1, 20",
        "Figs 5",
    ):
        assert part in header
    assert 'name="viewport" content="width=device-width' in text


def test_first_screen_states_what_v2v_changed(file: Path, runs: list[Log]) -> None:
    text = file.read_text(encoding="utf-8")
    header = Page(text[text.index("<header") : text.index("</header>") + 9]).text.replace("\u00a0", " ")
    groups = group_by_case(runs)
    assert headline(groups) in header
    for group in groups:
        for log in one_run_per_ego(group):
            assert summarize_outcome(log) in header


def test_page_has_narrative_and_key_figures_of_each_run(file: Path, runs: list[Log]) -> None:
    text = Page(file.read_text(encoding="utf-8")).text.replace("\u00a0", " ")
    for log in runs:
        key = log.summary()
        assert f"{key['max_decel_mps2']:.1f} m/s²" in text
        if key["min_gap_m"] is not None:
            assert f"{max(key['min_gap_m'], 0.0):.2f} m" in text
    for group in map(one_run_per_ego, group_by_case(runs)):
        for log in group:
            assert describe_run(log) in text
            for _, name, reason in log.decisions:
                assert f"{name}: {reason}" in text


def test_each_figure_of_the_paper_has_a_counterpart(file: Path) -> None:
    names = {path.stem for path in file.parent.glob("*.png")}
    for figure in ("fig05", "fig06_07", "fig06", "fig08", "fig09", "fig10", "fig11", "fig11_12", "fig16_17"):
        assert any(name.startswith(f"{figure}_") for name in names), figure
    assert len(Page(file.read_text(encoding="utf-8")).images) == len(names)


def test_each_scenario_has_an_animation(file: Path, runs: list[Log]) -> None:
    text = file.read_text(encoding="utf-8")
    groups = group_by_case(runs)
    assert text.count('class="cca"') == len(groups) + 1  # and one on the first screen
    assert text.count("<svg ") == sum(len(one_run_per_ego(group)) for group in groups) + 2
    assert Page(text).scripts == len(groups) + 2


def test_hostile_id_stays_text(hostile: Log, tmp_path: Path) -> None:
    file = tmp_path / "report.html"
    write_report([hostile], file)
    page = Page(file.read_text(encoding="utf-8"))
    assert page.open == []
    assert page.scripts == 3
    assert "alert(" in page.text


def test_report_without_other_vehicles(alone: Log, tmp_path: Path) -> None:
    write_report([alone], tmp_path / "report.html")
    assert Page((tmp_path / "report.html").read_text(encoding="utf-8")).open == []


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium or Chrome")
@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]}px")
def test_page_works_in_a_browser_without_network(file: Path, size: tuple[int, int]) -> None:
    found = inspect_page(BROWSER, file, size, still=size == SIZES[0])
    assert faults(found) == []
    assert found["top"][0] < 50.0
    assert "what V2V changed" in found["text"]

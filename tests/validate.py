"""Run all tests with the full number of random cases, and the studies; write docs/validation.md.

    python -m tests.validate [tests | tests/planner | tests/planner/test_work.py | studies | eebl | ...]

Without a part it runs everything. It resumes where it was stopped: test files that passed with the same
sources are not run again, nor are runs of a study. The page says which sources passed, so that this holds in
another clone as well. Called by `make validate`.
"""

import argparse
import ast
import datetime
import hashlib
import json
import os
import re
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from cca_core.errors import InputError
from cca_core.plot.study import plot_study
from cca_core.sim.scenarios.scenario import EGO_TYPES
from cca_core.sim.study.parameters import ParameterRanges
from cca_core.sim.study.sampling import STUDY_SCENARIOS
from cca_core.sim.study.source import code_of
from cca_core.sim.study.statistics import StudyTable
from cca_core.sim.study.store import Store
from cca_core.sim.study.study import Study, run_study

ROOT = Path(__file__).resolve().parents[1]
TESTS = ROOT / "tests"
STATE = ROOT / ".validate"
PAGE = ROOT / "docs" / "validation.md"
AVOIDABLE_RUNS = 2000
SEED = 33  # definitions and the planner were changed after looking at runs of smaller seeds
MAX_RATE = 0.002  # of avoidable collisions with V2V, one-sided at 95 %
STUDY_TIME = 2400.0  # of one processor for each study [s]
STUDY_COLUMNS = 8
NUMBERS = "v2v_speed", "latency", "loss", "radio_range"  # of a collision, on the page
HEAD = """\
# Validation: the full tests

This page lists the test files that passed with the full number of random cases, and the results of the
studies. A property has 1000 random cases instead of 50, or fewer if one case is a whole drive or a fit. The
name of a property fixes its seed. `make validate` writes this page, and continues where it was stopped.

The column *sources* is a digest of all that a result depends on. Comments and docstrings count only for tests
that read them. The result holds at each commit at which this digest is the same.
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the parts that have not passed yet; return 1 if anything fails."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "part",
        nargs="*",
        help=f"tests, a folder or file of them, studies, or {', '.join(STUDY_SCENARIOS)}",
    )
    parts = parser.parse_args(arguments).part or ["tests", "studies"]
    folders = tuple(part for part in parts if (ROOT / part).exists() and part.startswith("tests"))
    if unknown := set(parts) - {"studies", *folders, *STUDY_SCENARIOS}:
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    STATE.mkdir(exist_ok=True)
    suite = Suite(folders)
    studies = [name for name in STUDY_SCENARIOS if {name, "studies"} & set(parts)]
    print_plan(suite, bool(folders), studies)
    problems: list[str] = []
    try:
        if folders:
            problems = [f"{name} failed" for name in suite.run()]
        if not problems:
            problems = [problem for name in studies for problem in drive_study(name)]
    finally:  # also after an interruption
        write_page(suite)
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


def print_plan(suite: "Suite", with_tests: bool, studies: list[str]) -> None:
    """Print for each part what has passed already and how long the rest takes."""
    if with_tests:
        print(
            f"tests: {len(suite.passed)} of {len(suite.files)} files have passed, {len(suite.missing)} are to"
            f" run; {suite.expected_time()}"
        )
    for name in studies:
        done, _ = progress_of(name)
        rest = STUDY_TIME * (1.0 - done / AVOIDABLE_RUNS) / (os.cpu_count() or 1)
        print(f"{name}: {done} of {AVOIDABLE_RUNS} avoidable runs; about {rest / 60.0:.0f} min to go")


class Suite:
    """Test files, what they depend on, and their results with the present sources."""

    def __init__(self, wanted: tuple[str, ...] = ("tests",)) -> None:
        files = sorted(p for p in TESTS.rglob("test_*.py") if "bench" not in p.parts)
        self.files = {p.relative_to(ROOT).as_posix(): digest_of(p) for p in files}
        self.wanted = wanted
        self.memory = STATE / "passed.json"
        self.rows = self.stored()
        self.seconds = {name: row["seconds"] for name, row in self.rows.items()}

    @property
    def passed(self) -> dict[str, dict[str, Any]]:
        """Results of the files that passed with the present sources."""
        return {name: row for name, row in self.present.items() if not row["failed"]}

    @property
    def failed(self) -> dict[str, dict[str, Any]]:
        """Results of those that failed with the present sources."""
        return {name: row for name, row in self.present.items() if row["failed"]}

    @property
    def present(self) -> dict[str, dict[str, Any]]:
        """Results with the present sources."""
        return self.with_present(self.rows)

    def with_present(self, rows: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
        """Choose the results with the present sources."""
        return {name: row for name, row in rows.items() if row["code"] == self.files.get(name)}

    @property
    def missing(self) -> list[str]:
        """Files wanted that have not passed, the slowest of an earlier run first."""
        names = [name for name in self.files.keys() - self.passed.keys() if name.startswith(self.wanted)]
        return sorted(names, key=lambda name: -self.seconds.get(name, 0.0))

    def expected_time(self) -> str:
        """Text: expected time of the missing files, from their last run."""
        known = [self.seconds[name] for name in self.missing if name in self.seconds]
        text = f"about {sum(known) / 60.0 / (os.cpu_count() or 1):.0f} min to go"
        unknown = len(self.missing) - len(known)
        return f"{text}, and {unknown} files of unknown time" if unknown else text

    def run(self) -> list[str]:
        """Run the missing files, one on each processor at a time; return those that fail."""
        failed = []
        pool = ThreadPoolExecutor(os.cpu_count())
        running = {pool.submit(run_file, name): name for name in self.missing}
        try:
            for done in tqdm(as_completed(running), total=len(running), unit="file", disable=None):
                name, result = running[done], done.result()
                if result["failed"]:
                    failed.append(name)
                    tqdm.write(f"{name} failed")
                if result["tests"] or not result["failed"]:  # it was not interrupted
                    # another process may run other parts at the same time
                    self.rows = self.stored() | {name: {**result, "code": self.files[name]}}
                    self.save()
        finally:
            pool.shutdown(cancel_futures=True)
        return failed

    def stored(self) -> dict[str, dict[str, Any]]:
        """Results of all runs up to now, here or in the clone in which the page was written."""
        page = rows_of_page()
        memory = json.loads(self.memory.read_text()) if self.memory.exists() else {}
        return page | memory | self.with_present(page) | self.with_present(memory)

    def save(self) -> None:
        """Write the results, whole or not at all."""
        draft = self.memory.with_suffix(".draft")
        draft.write_text(json.dumps(self.rows, indent=1))
        draft.replace(self.memory)


def page_lines() -> list[str]:
    """Lines of the page as it was last written."""
    return PAGE.read_text(encoding="utf-8").splitlines() if PAGE.exists() else []


def rows_of_page() -> dict[str, dict[str, Any]]:
    """Results of test files that the page holds."""
    rows: dict[str, dict[str, Any]] = {}
    for line in page_lines():
        if found := re.fullmatch(r"\| `(tests/\S+)` \| (\d+) \| (\d+) \| (\d+) \| ([0-9a-f]{12}) \|", line):
            name, *numbers, code = found.groups()
            tests, skipped, seconds = map(int, numbers)
            rows[name] = {"tests": tests, "skipped": skipped, "failed": 0, "seconds": seconds, "code": code}
        elif found := re.fullmatch(
            r"- `(tests/\S+)`: (\d+) of (\d+) tests failed, in (\d+) s, sources ([0-9a-f]{12})", line
        ):
            name, *numbers, code = found.groups()
            failed, tests, seconds = map(int, numbers)
            rows[name] = {"tests": tests, "skipped": 0, "failed": failed, "seconds": seconds, "code": code}
    return rows


@cache
def inputs(file: Path) -> frozenset[Path]:
    """What a test file depends on: its package, what these import, directly or not, and files next to that.

    One that compares both forms of kernels depends on those that it imports, not on the other kernels.
    """
    if file.parent == TESTS:  # it may look at everything
        return frozenset({ROOT / name for name in git("ls-files").split()} - written_files())
    found: set[Path] = set()
    package = ROOT / "cca_core" / file.relative_to(TESTS).parts[0]
    waiting = {file, *(p / "conftest.py" for p in (TESTS, file.parent))}
    if not (file.parent.name == "kernel" and "check_forms" in file.read_text(encoding="utf-8")):
        waiting |= set(package.rglob("*.py"))
    waiting = {p for p in waiting if p.is_file()}
    while waiting:
        found |= waiting
        waiting = {used for one in waiting if one.suffix == ".py" for used in uses(one)} - found
    folders = {p.parent for p in found} - {ROOT / "cca_core", TESTS, TESTS / "support"}
    others = {p for folder in folders for p in folder.iterdir() if p.is_file()}
    return frozenset(found | {p for p in others if p.suffix not in (".py", ".so")})


@cache
def modules() -> frozenset[Path]:
    """All modules of library and tests."""
    return frozenset(p for folder in ("cca_core", "tests") for p in (ROOT / folder).rglob("*.py"))


@cache
def home(module: str, name: str) -> str:
    """Return the module that defines a name, which a package may only pass on."""
    file = ROOT / module.replace(".", "/") / "__init__.py"
    if file in modules():
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            passes_on = isinstance(node, ast.ImportFrom) and name in {alias.name for alias in node.names}
            if passes_on and node.module and node.module != module:
                return home(node.module, name)
    return module


@cache
def uses(file: Path) -> set[Path]:
    """Modules of library and tests that a file imports, or names as a text of its own."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {f"{home(node.module, alias.name)}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names |= set(re.findall(r"^(?:cca_core|tests)(?:\.\w+)+$", node.value))
    found: set[Path] = set()
    existing = modules()
    for name in names:
        parts = name.split(".")
        for end in range(len(parts), 1, -1):
            stem = "/".join(parts[:end])
            if files := {ROOT / f"{stem}.py", ROOT / f"{stem}/__init__.py"} & existing:
                found |= files
                break
    if file.parts[-2] in ("band", "follow", "path", "v2x", "planner", "sim"):  # a figure in Jupyter alone
        found = {p for p in found if "plot" not in p.parts}
    return {p for p in found if p.is_file() and p.relative_to(ROOT).parts[0] in ("cca_core", "tests")}


def digest_of(file: Path) -> str:
    """Digest of what a test file depends on: each byte if it may read docstrings or comments."""
    used = inputs(file)
    translates = any(p.parts[-3:-1] == ("cca_core", "codegen") for p in used)  # docstrings of kernels into C
    return digest(used, exact=file.parent == TESTS or translates)


def digest(files: Iterable[Path], *, exact: bool = False) -> str:
    """Digest of the contents of files; of Python only the code unless it is exact."""
    contents = (contents_of(file, exact) for file in sorted(files))
    return hashlib.sha256(b"\0".join(contents)).hexdigest()[:12]


@cache
def contents_of(file: Path, exact: bool) -> bytes:
    """Contents of a file; of Python only the code unless it is exact."""
    return file.read_bytes() if exact else code_of(file)


def run_file(name: str) -> dict[str, int]:
    """Run one file with all its cases, slow ones as well; count its tests."""
    report = STATE / f"{name.replace('/', '.')}.xml"
    report.unlink(missing_ok=True)
    begun = time.perf_counter()
    command = [sys.executable, "-m", "pytest", "-q", "-m", "", name, f"--junitxml={report}"]
    command += ["-o", "junit_family=xunit1"]  # with properties that tests record
    environment = os.environ | {"CCA_HYPOTHESIS_PROFILE": "full"}
    with report.with_suffix(".txt").open("w") as out:
        done = subprocess.run(command, cwd=ROOT, stdout=out, env=environment, check=False)
    seconds = round(time.perf_counter() - begun)
    if done.returncode not in (0, 1, 5) or not report.exists():  # it was interrupted
        return {"tests": 0, "skipped": 0, "failed": 1, "seconds": seconds}
    suite = ElementTree.parse(report).getroot().find("testsuite")
    counts = {key: int(suite.get(key, "0")) for key in ("tests", "failures", "errors", "skipped")}
    return {
        "tests": counts["tests"] - counts["skipped"],
        "skipped": counts["skipped"],
        "failed": counts["failures"] + counts["errors"],
        "seconds": seconds,
    }


def study_of(name: str) -> tuple[Study, Path, str]:
    """Study of a scenario, the file of its runs with the present sources, and the digest of these."""
    study = Study(parameters=ParameterRanges(scenario=name), seed=SEED, avoidable=AVOIDABLE_RUNS)
    sources = hashlib.sha256(study.fingerprint.encode()).hexdigest()[:12]
    return study, STATE / f"study_{name}_{sources}.db", sources


def study_of_page(name: str) -> list[str]:
    """Lines of a study that the page holds complete with the present sources: rates, then collisions."""
    lines = [line for line in page_lines() if line.startswith(f"| {name} |")]
    cells = lines[0].split(" | ") if lines else []
    is_present = len(cells) == STUDY_COLUMNS and cells[-1] == f"{study_of(name)[2]} |"
    return lines if is_present and float(cells[4].rstrip("%")) < 100.0 * MAX_RATE else []


def progress_of(name: str) -> tuple[int, StudyTable | None]:
    """Avoidable runs that a study has with the present sources, and its table if it is complete."""
    study, path, _ = study_of(name)
    if not path.exists():
        return (AVOIDABLE_RUNS if study_of_page(name) else 0), None
    try:
        with Store(path, study.fingerprint) as store:
            return study.table(store.rows)
    except InputError:  # another process drives it now
        return 0, None


def drive_study(name: str) -> list[str]:
    """Drive the missing runs of a study; return what is wrong with its result."""
    study, path, _ = study_of(name)
    if not path.exists() and study_of_page(name):
        return []
    with tqdm(total=AVOIDABLE_RUNS, desc=name, unit="avoidable run", disable=None) as bar:
        table = run_study(study, path, progress=lambda done, wanted: bar.update(done - bar.n) and None)
    table.write_csv(STATE / f"study_{name}.csv")
    bound = table.rate("v2v").upper_bound
    return [f"{name}: avoidable collisions with V2V up to {bound:.2%} (limit {MAX_RATE:.2%})"] * (
        bound >= MAX_RATE
    )


def write_page(suite: Suite) -> None:
    """Write the page and the pictures from all that has passed with the present sources."""
    studies = {name: progress_of(name) for name in STUDY_SCENARIOS}
    tables = [table for _, table in studies.values() if table is not None]
    for table in tables:
        plot_study([table], log=True).savefig(figure_of(table.scenario), dpi=120)
    today = datetime.datetime.now(tz=datetime.UTC).date()
    lines = [HEAD, f"Written at commit {commit()} on {today}.", "", "## Tests", "", *test_lines(suite)]
    lines += ["", "## Studies", "", *study_lines(studies)]
    kept = [line for name, (_, table) in studies.items() if table is None for line in study_of_page(name)[1:]]
    lines += collision_lines(tables, kept) if tables or kept else []
    complete = [name for name, (done, _) in studies.items() if done >= AVOIDABLE_RUNS]
    lines += figure_lines(complete) if complete else []
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_lines(suite: Suite) -> list[str]:
    """How many test files passed, and the table of these."""
    rows = sorted(suite.passed.items())
    return [
        *summary_lines(suite),
        "",
        "| file | tests | skipped | seconds | sources |",
        "|---|---|---|---|---|",
        *(
            f"| `{name}` | {row['tests']} | {row['skipped']} | {row['seconds']} | {row['code']} |"
            for name, row in rows
        ),
    ]


def summary_lines(suite: Suite) -> list[str]:
    """How many test files passed with the present sources, and what is known of the others."""
    total, n, passed = sum(row["tests"] for row in suite.passed.values()), len(suite.files), len(suite.passed)
    if passed == n:
        return [f"All {n} test files ({total} tests) have passed with the present code."]
    lines = [f"{passed} of {n} test files ({total} tests) have passed with the present code."]
    if others := n - passed - len(suite.failed):
        lines.append(f"Files without a result for this code yet: {others}.")
    if suite.failed:
        lines += ["", f"Files that failed with the present code: {len(suite.failed)}.", ""]
    return lines + [
        f"- `{name}`: {row['failed']} of {row['tests']} tests failed, in {row['seconds']} s,"
        f" sources {row['code']}"
        for name, row in sorted(suite.failed.items())
    ]


def study_lines(studies: dict[str, tuple[int, StudyTable | None]]) -> list[str]:
    """Table of collision rates."""
    lines = [
        f"Each study samples a scenario with seed {SEED} until {AVOIDABLE_RUNS} runs are avoidable; see",
        "[Studies](study.md). The table shows the collisions among the avoidable runs: number, rate and its",
        "95 % confidence interval. The upper bound is the one-sided bound of the rate with V2V, at 95 %.",
        "",
        "| scenario | runs | avoidable | with V2V | upper bound | driver | sensor | sources |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, (done, table) in studies.items():
        if table is None and done >= AVOIDABLE_RUNS:
            lines.append(study_of_page(name)[0])
            continue
        if table is None:
            lines.append(f"| {name} | not complete | {done} of {AVOIDABLE_RUNS} | | | | | |")
            continue
        rates = [table.rate(ego) for ego in EGO_TYPES]
        first, *rest = (f"{r.n_events}: {r.value:.2%} ({r.ci_low:.2%} to {r.ci_high:.2%})" for r in rates)
        bound, sources = f"{rates[0].upper_bound:.2%}", study_of(name)[2]
        cells = (name, len(table), rates[0].n, first, bound, *rest, sources)
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return lines


def figure_of(name: str) -> Path:
    """Picture of a study, written with the page."""
    return PAGE.with_name(f"study_{name}.png")


def written_files() -> set[Path]:
    """The page and its pictures, on which no result depends."""
    return {PAGE, *map(figure_of, STUDY_SCENARIOS)}


def figure_lines(names: list[str]) -> list[str]:
    """Pictures of complete studies."""
    lines = [
        "",
        "Fraction of all runs that end in a collision, avoidable or not, over latency and loss of messages.",
        "Intervals are at 95 %; the scale is linear below 1 %.",
    ]
    for name in names:
        lines += ["", f"![Fraction of runs of {name} with a collision]({figure_of(name).name})"]
    return lines


def collision_lines(tables: list[StudyTable], kept: list[str]) -> list[str]:
    """Table of all collisions with V2V; `kept` are rows of the page."""
    lines = [
        "",
        "All collisions with V2V:",
        "",
        "| scenario | run | with | at [m/s] | latency [s] | loss | range [m] | cause | last decision |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for table in tables:
        for index in np.flatnonzero(table.collided("v2v")).tolist():
            row = table.rows[index]
            numbers = (f"{row[key]:.2f}" for key in NUMBERS)
            other, last = row["v2v_collided_with"], row["v2v_last_decision"]
            cells = (table.scenario, index, other, *numbers, cause(row), last)
            lines.append(f"| {' | '.join(map(str, cells))} |")
    return lines + kept


def cause(row: dict[str, Any]) -> str:
    """Cause of a collision with V2V."""
    if row["avoiding_action"]:
        return f"**avoidable** ({row['avoiding_action']})"
    if row["t_hazard"] is None:
        return "no message of the hazard received"
    return f"first message of the hazard at {row['t_hazard']:.2f} s, too late to brake or to evade"


def commit() -> str:
    """Short hash of the commit, with a note on local changes outside the written page."""
    written = [f":!{file.relative_to(ROOT).as_posix()}" for file in written_files()]
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", *written).strip()
    return git("rev-parse", "--short", "HEAD").strip() + " with local changes" * bool(changed)


def git(*arguments: str) -> str:
    """Output of git in the project's folder."""
    return subprocess.run(["git", *arguments], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout


if __name__ == "__main__":
    sys.exit(main())

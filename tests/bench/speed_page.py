"""Write docs/performance.md from the results of pytest-benchmark and pytest. Called by `make bench`.

`python -m tests.bench.speed_page BENCH.json JUNIT.xml`: run times from the first file; budgets, outcomes and
tests without a run time from the second.
"""

import ast
import json
import re
import sys
import xml.etree.ElementTree as ElementTree
from datetime import datetime
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "performance.md"
REFERENCE = "test_speed", "test_reference_solve_banded"
# the result is not a run time but a table of docs/steering.md
WITHOUT_RUN_TIME = (
    "test_errors", "test_high_gain_controllers_with_dead_time", "test_robust", "test_recorded_drive",
    "test_table", "test_time_is_linear_in_size",
)  # fmt: skip
INTERNAL = ("us", "budget")
TITLES = {
    "test_speed": "Cycle",
    "test_cycle_speed": "Parts of a cycle",
    "test_kernel_speed": "Calls of the kernel",
    "test_band_speed": "Band",
    "test_baselines_speed": "Methods of Table 1",
    "test_decide_speed": "Decision",
    "test_decision_speed": "Decisions among twenty vehicles",
    "test_iso3888": "Double lane changes of ISO 3888",
    "test_path_speed": "Path",
    "test_steering": "Steering",
    "test_tracker_speed": "Tracks",
    "test_v2x_speed": "Messages, 200 at a time",
}
HEAD = """# Run times

This page shows how long each computation of the library takes, and how long it may take: its *budget*.
The planner has 20 ms for each cycle. Most cycles follow the last decision; ten times a second the
planner makes a new one.

| question | section |
|---|---|
| How long does a cycle take? | [Cycle](#cycle) |
| How long does a decision take? | [Decisions among twenty vehicles](#decisions-among-twenty-vehicles) |
| How long does a band take? | [Band](#band) |
| How long do the messages of 100 vehicles take? | [Tracks](#tracks) |
| How long do other methods take? | [Methods](#methods-of-table-1), and [their comparison](table1.md) |

`make bench` measures these times on one thread, with reference computations in the same run. The last
column compares the value with its budget; "-" means that there is none.

**Rows.** The cases of a test are in brackets. A_1.0, for example, is [scene A](band.md#speed) with a
clearance of 1 m. The further figures describe the result: `clearance_m` is in m, `curvature` is the
largest one [1/m], and `a_y_at_20` is the lateral acceleration that it causes at 20 m/s [m/s²].

**A missed budget does not mean a wrong result.** A budget is a limit that this project sets for a time,
or for a ratio of two times. If a measurement exceeds it, the result is still correct, but it comes later
than allowed. Either the code has become slower, or the machine was busy during the measurement. Then
`make bench` fails, and the row shows **missed**. Measure again on an idle machine. If the row is missed
again, the code has become slower: find the change that caused it.

**A late cycle is something else.** A cycle is late if its command is not ready after 20 ms. The budgets
of a cycle are shorter, so a cycle that misses its budget can still be in time. The rig and
[`simulate(real_time=True)`](simulation.md#real-time) count late cycles. The car then drives on with the
last command. If no more commands arrive, the drive-by-wire kit drives the last [safe
stop](rig.md#safe-stop).

The budgets apply to a machine that solves a banded system of 100 rows and two right-hand sides in 16.6
µs (`scipy.linalg.solve_banded`). On a slower machine they grow in proportion. `make bench` times this
reference once, before all tests. To compare machines, compare ratios of times, not times.
"""


def main() -> int:
    """Write the page."""
    bench = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    outcomes = read_outcomes(Path(sys.argv[2]))
    PAGE.write_text(page(bench, outcomes), encoding="utf-8")
    return 0


def read_outcomes(report: Path) -> dict[tuple[str, str], tuple[str, dict[str, str]]]:
    """State of each test, empty, "skipped" or the failure, and its properties, by module and name."""
    found = {}
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        failed = case.find("failure") if case.find("failure") is not None else case.find("error")
        state = "skipped" if case.find("skipped") is not None else ""
        if failed is not None:
            message = (failed.get("message") or "failed").splitlines()[0]
            state = re.sub(r"\d+\.\d+", lambda number: f"{float(number[0]):.4g}", message)
        properties = {p.get("name", ""): p.get("value", "") for p in case.iter("property")}
        found[case.get("classname", "").rpartition(".")[2], case.get("name", "")] = state, properties
    return found


def page(bench: dict[str, Any], outcomes: dict[tuple[str, str], tuple[str, dict[str, str]]]) -> str:
    """Text of the page."""
    timed = {key_of(entry): entry for entry in bench["benchmarks"]}
    budgets = [state for state, properties in outcomes.values() if "budget" in properties]
    missed = sum(state != "" for state in budgets)
    failed = sum(state not in ("", "skipped") for state, _ in outcomes.values()) - missed
    _, reference = outcomes.get(REFERENCE, ("", {}))
    cpu, made = bench["machine_info"]["cpu"], datetime.fromisoformat(bench["datetime"]).date()
    commit = bench["commit_info"].get("id", "")[:7] or "unknown"
    lines = [
        HEAD,
        f"Measured on {made}: {cpu.get('brand_raw', 'unknown processor')}, {cpu.get('count', '?')} cores, "
        f"Python {bench['machine_info']['python_version']}, commit {commit}"
        f"{' with local changes' if bench['commit_info'].get('dirty') else ''}. "
        + (f"The reference takes {format_time(1e-6 * float(reference['us']))}. " if reference else "")
        + (f"{missed} of {len(budgets)} budgets missed." if missed else f"All {len(budgets)} budgets kept.")
        + (f" {failed} failed for other reasons." if failed else ""),
    ]
    for module in sorted({module for module, _ in outcomes}):
        rows = [
            row(module, name, timed.get((module, name)), *outcomes[module, name])
            for at, name in outcomes
            if at == module and name.partition("[")[0] not in WITHOUT_RUN_TIME
        ]
        if rows:
            head = ["| measurement | median | smallest | further figures | budget |", "|---|---|---|---|---|"]
            lines += [
                "",
                f"## {TITLES.get(module, module)}",
                "",
                f"`tests/bench/{module}.py`",
                "",
                *head,
                *rows,
            ]
    return "\n".join(lines) + "\n"


def key_of(entry: dict[str, Any]) -> tuple[str, str]:
    """Module and name of a benchmark."""
    file, _, name = entry["fullname"].partition("::")
    return Path(file).stem, name


def row(module: str, name: str, entry: dict[str, Any] | None, state: str, properties: dict[str, str]) -> str:
    """One line of a table."""
    extra = (entry["extra_info"] if entry else {}) | properties
    further = ", ".join(f"{key} {value}" for key, value in extra.items() if key not in INTERNAL)
    times = [format_time(entry["stats"][key]) for key in ("median", "min")] if entry else ["", ""]
    if "us" in extra and not times[0]:
        times[0] = format_time(1e-6 * float(extra["us"]))
    if "budget" in extra:
        kept = f"{'**missed**' if state else 'kept'}: {extra['budget']}"
    else:
        kept = {"": "-", "skipped": "not run"}.get(state, f"**failed**: {state}")
    cells = (title(module, name), *times, further, kept)
    return f"| {' | '.join(cell.replace('|', '/').replace('<', '&lt;') for cell in cells)} |"


def title(module: str, name: str) -> str:
    """Name of a test in words, and its docstring."""
    function, _, values = name.partition("[")
    tree = ast.parse((ROOT / "tests" / "bench" / f"{module}.py").read_text(encoding="utf-8"))
    found = (n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == function)
    text = (ast.get_docstring(next(found)) or "").split("\n")[0]
    words = function.removeprefix("test_").replace("_", " ")
    return f"{words}{f' ({values[:-1]})' if values else ''}{f': {text[0].lower()}{text[1:]}' if text else ''}"


def format_time(seconds: float) -> str:
    """Time with a suitable unit."""
    unit, size = next(pair for pair in (("s", 1.0), ("ms", 1e-3), ("µs", 0.0)) if seconds >= pair[1])
    size = size or 1e-6
    digits = f"{seconds / size:.3g}"
    return f"{float(digits):.0f} {unit}" if re.search(r"e", digits) else f"{digits} {unit}"


if __name__ == "__main__":
    sys.exit(main())

"""Run every test file with the full number of random cases and write docs/validation.md.

Resumable: files that passed at this commit are not run again. Called by `make validate`.
"""

import datetime
import json
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STATE = ROOT / ".validate"
PAGE = ROOT / "docs" / "validation.md"


def main() -> int:
    """Run what has not passed yet; return 1 if anything failed."""
    commit = output("git", "rev-parse", "--short", "HEAD")
    if output("git", "status", "--porcelain", "--untracked-files=no"):
        commit += " with local changes"
    STATE.mkdir(exist_ok=True)
    memory = STATE / "passed.json"
    known = json.loads(memory.read_text()) if memory.exists() else {}
    rows = known.get(commit, {})
    files = sorted(p for p in (ROOT / "tests").rglob("test_*.py") if "bench" not in p.parts)
    for i, file in enumerate(files, 1):
        name = file.relative_to(ROOT).as_posix()
        if name not in rows:
            print(f"[{i}/{len(files)}] {name}", flush=True)
            result = run(name)
            if result["failed"]:
                print(f"{name} failed", file=sys.stderr)
                return 1
            rows[name] = result
            memory.write_text(json.dumps({commit: rows}, indent=1))
            write(commit, rows, len(files))
    return 0


def run(name: str) -> dict[str, float]:
    """Run one file with the full profile; count its tests."""
    report = STATE / "report.xml"
    begun = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "pytest", "-q", name, f"--junitxml={report}"],
        cwd=ROOT, env=os.environ | {"CCA_HYPOTHESIS_PROFILE": "full"}, check=False,
    )  # fmt: skip
    suite = ElementTree.parse(report).getroot().find("testsuite")
    counts = {key: int(suite.get(key, "0")) for key in ("tests", "failures", "errors", "skipped")}
    return {
        "tests": counts["tests"] - counts["skipped"],
        "skipped": counts["skipped"],
        "failed": counts["failures"] + counts["errors"],
        "seconds": round(time.perf_counter() - begun),
    }


def write(commit: str, rows: dict[str, dict[str, float]], files: int) -> None:
    """Write the page."""
    today = datetime.datetime.now(tz=datetime.UTC).date()
    total = sum(row["tests"] for row in rows.values())
    lines = [
        "# Validation",
        "",
        "Every test with the full number of random cases: 1000 per property instead of 50, the seed of each",
        "fixed by its name. Made by `make validate`, which resumes where it was stopped.",
        "",
        f"Commit {commit}, {today}: {len(rows)} of {files} test files, {total} tests, none failed.",
        "",
        "| file | tests | skipped | seconds |",
        "|---|---|---|---|",
        *(f"| `{n}` | {r['tests']} | {r['skipped']} | {r['seconds']} |" for n, r in sorted(rows.items())),
    ]
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def output(*command: str) -> str:
    """Output of a command in the project's folder."""
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


if __name__ == "__main__":
    sys.exit(main())

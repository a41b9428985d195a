"""Table of cases and its command line.

A case is a function that returns checks: tuples of (quantity, measured value, comparison, limit), with the
comparison one of ``>= <= == has lacks``. It holds if all of its checks do.
"""

import argparse
import functools
import math
import operator
import time
from collections.abc import Callable
from typing import NamedTuple

Check = tuple[str, object, str, object]
COMPARE: dict[str, Callable] = {
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "has": lambda whole, part: part in whole,
    "lacks": lambda whole, part: part not in whole,
}
NOMINAL_TIME = 0.075  # CPU time of `slowness` on the machine on which limits were set [s]


class Case(NamedTuple):
    """A case of a group."""

    group: str
    subject: str
    checks: Callable[[], list[Check]]


class Outcome(NamedTuple):
    """Result of a case."""

    holds: bool
    measured: str
    limits: str


class Table:
    """Cases by id, in the order in which they are defined."""

    def __init__(self, *parts: "Table") -> None:
        self.cases: dict[str, Case] = {}
        for part in parts:
            self.cases |= part.cases

    def case(self, group: str, name: str, subject: str) -> Callable:
        """Add the decorated function as a case."""

        def add(checks: Callable[[], list[Check]]) -> Callable[[], list[Check]]:
            self.cases[name] = Case(group, subject, checks)
            return checks

        return add

    def chosen(self, names: list[str]) -> dict[str, Case]:
        """Cases whose id or group is named; all if none is."""
        return {k: c for k, c in self.cases.items() if not names or {k, c.group} & set(names)}

    def main(self, description: str, arguments: list[str] | None = None) -> int:
        """Run the cases that the command line names; return how many fall short."""
        parser = argparse.ArgumentParser(prog="python -m tests.trials.faults", description=description)
        parser.add_argument("id", nargs="*", help="cases or groups to run; all by default")
        parser.add_argument("--list", action="store_true", help="list the cases")
        given = parser.parse_args(arguments)
        groups = {case.group for case in self.cases.values()}
        if unknown := set(given.id) - set(self.cases) - groups:
            parser.error(f"no such case or group: {', '.join(sorted(unknown))}")
        chosen = self.chosen(given.id)
        if given.list:
            return print_lines(chosen, lambda name, case: (f"{name:28} {case.subject}", True))
        begun = time.perf_counter()
        failed = print_lines(chosen, run_line)
        took = time.perf_counter() - begun
        print(f"\n{len(chosen) - failed} of {len(chosen)} hold, {failed} fall short ({took:.0f} s)")
        return failed


def print_lines(cases: dict[str, Case], line: Callable[[str, Case], tuple[str, bool]]) -> int:
    """Print a line for each case below its group; return how many fall short."""
    heading, failed = "", 0
    for name, case in cases.items():
        if case.group != heading:
            print(f"\n{case.group}")
            heading = case.group
        text, holds = line(name, case)
        failed += not holds
        print(f"  {text}", flush=True)
    return failed


def run_line(name: str, case: Case) -> tuple[str, bool]:
    """Run a case; return its line and whether it holds."""
    holds, measured, limits = outcome(case.checks)
    return f"{name:28} {'HOLDS' if holds else 'FALLS SHORT':11}  {measured}  |  wanted: {limits}", holds


def outcome(checks: Callable[[], list[Check]]) -> Outcome:
    """Run a case."""
    try:
        found = checks()
    except Exception as error:  # an unexpected exception counts against the library
        return Outcome(False, f"{type(error).__name__}: {str(error)[:90]}", "no such exception")
    holds = all(COMPARE[comparison](value, limit) for _, value, comparison, limit in found)
    measured = ", ".join(f"{quantity} {short(value)}" for quantity, value, _, _ in found)
    limits = ", ".join(f"{quantity} {comparison} {short(limit)}" for quantity, _, comparison, limit in found)
    return Outcome(holds, measured, limits)


def raised(function: Callable[[], object], *allowed: type[Exception]) -> str:
    """Name of the exception that a call raises; empty if there is none or it is allowed."""
    try:
        function()
    except allowed:
        return ""
    except Exception as error:  # the name is the result
        return type(error).__name__
    return ""


@functools.cache
def slowness() -> float:
    """CPU time of a loop on this machine, relative to the one on which limits were set, at least 1."""
    best = math.inf
    for _ in range(3):
        begun, total = time.thread_time(), 0.0
        for i in range(1_000_000):
            total += i * 0.5
        best = min(best, time.thread_time() - begun)
    return max(best / NOMINAL_TIME, 1.0)


def cpu(function: Callable[[], object]) -> float:
    """CPU time of a call [s], scaled to the machine on which limits were set."""
    begun = time.thread_time()
    function()
    return (time.thread_time() - begun) / slowness()


def short(value: object) -> str:
    """A value in at most 90 characters."""
    if isinstance(value, float):
        return f"{value:.3g}"
    text = str(value)
    return text if len(text) <= 90 else text[:87] + "..."

"""Table of cases and its command line, for `faults.py`. Nothing to run here.

A case is a function that returns checks: tuples of (what, measured value, comparison, wanted value), with the
comparison one of ``>= <= == has lacks``. It holds if all of its checks do.
"""

import argparse
import functools
import math
import operator
import time
from collections.abc import Callable

_COMPARE: dict[str, Callable[[object, object], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "has": lambda whole, part: part in whole,
    "lacks": lambda whole, part: part not in whole,
}
_NOMINAL = 0.075  # CPU time of `slowness` where it was written [s]


class Table:
    """Cases in the order in which they are defined."""

    def __init__(self) -> None:
        self.cases: dict[str, tuple[str, str, Callable[[], list[tuple]]]] = {}

    def case(self, group: str, name: str, what: str, function: Callable | None = None) -> Callable:
        """Add a case; without its function, return what decorates it."""
        if function is None:
            return lambda decorated: self.case(group, name, what, decorated)
        self.cases[name] = group, what, function
        return function

    def main(self, description: str) -> None:
        """Run the cases that the command line names."""
        parser = argparse.ArgumentParser(description=description)
        parser.add_argument("id", nargs="*", help="cases or groups to run; all if none is given")
        parser.add_argument("--list", action="store_true", help="list the cases")
        arguments = parser.parse_args()
        wanted = set(arguments.id) or set(self.cases)
        groups = {group for group, _, _ in self.cases.values()}
        if unknown := wanted - set(self.cases) - groups:
            parser.error(f"no such case or group: {', '.join(sorted(unknown))}")
        holds, run, heading = 0, 0, ""
        begun = time.perf_counter()
        for name, (group, what, function) in self.cases.items():
            if not {name, group} & wanted:
                continue
            if group != heading:
                print(f"\n{group}")
                heading = group
            if arguments.list:
                print(f"  {name:28} {what}")
                continue
            good, measured, asked = outcome(function)
            run, holds = run + 1, holds + good
            print(
                f"  {name:28} {'HOLDS' if good else 'FALLS SHORT':11}  {measured}  |  wanted: {asked}",
                flush=True,
            )
        if not arguments.list:
            took = time.perf_counter() - begun
            print(f"\n{holds} of {run} hold, {run - holds} fall short ({took:.0f} s)")


def outcome(function: Callable[[], list[tuple]]) -> tuple[bool, str, str]:
    """Run a case; return whether it holds, what was measured and what is wanted."""
    try:
        checks = function()
    except Exception as error:  # what a case does not expect counts against the library
        return False, f"{type(error).__name__}: {str(error)[:90]}", "no such exception"
    good = all(_COMPARE[how](value, limit) for _, value, how, limit in checks)
    measured = ", ".join(f"{what} {_short(value)}" for what, value, _, _ in checks)
    asked = ", ".join(f"{what} {how} {_short(limit)}" for what, _, how, limit in checks)
    return good, measured, asked


def raised(function: Callable[[], object], *allowed: type[Exception]) -> str:
    """Name of the exception that a call raises: empty if none or one that is allowed."""
    try:
        function()
    except allowed:
        return ""
    except Exception as error:  # the name is the result
        return type(error).__name__
    return ""


@functools.cache
def slowness() -> float:
    """By how much slower this machine is now than the one on which limits of time were set (at least 1)."""
    best = math.inf
    for _ in range(3):
        begun, total = time.thread_time(), 0.0
        for i in range(1_000_000):
            total += i * 0.5
        best = min(best, time.thread_time() - begun)
    return max(best / _NOMINAL, 1.0)


def cpu(function: Callable[[], object]) -> float:
    """CPU time of a call [s], as on the machine on which limits were set."""
    begun = time.thread_time()
    function()
    return (time.thread_time() - begun) / slowness()


def _short(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    text = str(value)
    return text if len(text) <= 90 else text[:87] + "..."

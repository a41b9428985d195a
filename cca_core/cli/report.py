"""``cca report``: the report of stored logs."""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path as FilePath

from cca_core.cli.results import draw_report, print_table
from cca_core.errors import InputError
from cca_core.sim import load_log

__all__ = ["run"]


def run(given: argparse.Namespace) -> int:
    """Read, print and draw; return the exit code."""
    logs = [load_log(str(file)) for file in _files(given.logs)]
    print_table(logs)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    if given.figures is not None:
        given.figures.mkdir(parents=True, exist_ok=True)
    draw_report(logs, given.out, given.figures)
    print(f"Open {given.out}")
    return 0


def _files(names: Sequence[FilePath]) -> Iterator[FilePath]:
    """Yield the files, and those in the folders in order of their names."""
    for name in names:
        found = sorted(name.glob("*.npz")) if name.is_dir() else [name]
        if not name.exists():
            raise InputError(f"log {str(name)!r} must exist, there is none")
        if not found:
            raise InputError(f"logs must be files .npz or folders of them, {str(name)!r} had none")
        yield from found

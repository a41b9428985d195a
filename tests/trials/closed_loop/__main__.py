"""Drive seeds: ``python -m tests.trials.closed_loop --seeds 0:200 [--family cut_in] [--json FILE]``."""

import argparse
import json
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import Any

import numpy as np

from tests.trials import closed_loop
from tests.trials.closed_loop.episode import Episode
from tests.trials.closed_loop.families import FAMILIES, MORE_FAMILIES

COLUMNS = "drives", "errors", "stationary", "avoidable", "in 1 s", "other"


def classify(collision: dict[str, Any], seed: int, family: str) -> str:
    """Kind of a collision.

    The ego was stationary, or full braking would have avoided it, from 1 s before the collision or from
    the first report of the other vehicle on.
    """
    if collision["v"] < 0.3:
        return "stationary"
    first = collision["first_report"]
    for kind, begin in (("in 1 s", collision["t"] - 1.0), ("avoidable", first)):
        if first is not None and Episode(seed, family).run(max(begin, first))["collision"] is None:
            return kind
    return "other"


def drives(first: int, last: int, family: str | None) -> Iterator[dict[str, Any]]:
    """Results of the seeds; collisions are classified and printed."""
    names = list(FAMILIES)
    for seed in range(first, last):
        name = family or names[seed % len(names)]
        result = Episode(seed, name).run()
        if c := result["collision"]:
            result["kind"] = classify(c, seed, name)
            print(
                f"seed {seed} {name}: {result['kind']}, t {c['t']}, with {c['with']}, v {c['v']}, "
                f"{c.get('action')}: {c.get('reason', '')[:60]}"
            )
        yield result


def print_table(counts: dict[str, Counter]) -> None:
    """Print collisions by family and kind."""
    total: Counter = Counter()
    print(f"\n{'family':20}" + "".join(f"{c:>11}" for c in COLUMNS))
    for name in sorted(counts):
        total.update(counts[name])
        print(f"{name:20}" + "".join(f"{counts[name][c]:11}" for c in COLUMNS))
    print(f"{'all':20}" + "".join(f"{total[c]:11}" for c in COLUMNS))


def main() -> None:
    """Drive the seeds that the command line names."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.trials.closed_loop", description=closed_loop.__doc__.splitlines()[0]
    )
    parser.add_argument("--seeds", default="0:40", help="first:last, without the last")
    parser.add_argument("--family", choices=[*FAMILIES, *MORE_FAMILIES], help="all seeds of one family")
    parser.add_argument("--json", help="file for a line of JSON for each drive")
    arguments = parser.parse_args()
    first, last = map(int, arguments.seeds.split(":"))
    counts: dict[str, Counter] = defaultdict(Counter)
    cycles: list[float] = []
    for result in drives(first, last, arguments.family):
        cycles += result.pop("cycles")
        row = counts[result["family"]]
        row["drives"] += 1
        row["errors"] += "error" in result
        if kind := result.get("kind"):
            row[kind] += 1
            row["avoidable"] += kind == "in 1 s"
        if arguments.json:
            with open(arguments.json, "a", encoding="utf-8") as out:
                out.write(json.dumps(result) + "\n")
    print_table(counts)
    ms = 1e3 * np.percentile(cycles, [50, 99, 100])
    times = f"median {ms[0]:.2f}, 99 % {ms[1]:.1f}, worst {ms[2]:.0f}"
    print(f"CPU time of a cycle [ms]: {times} ({len(cycles)} cycles)")


main()

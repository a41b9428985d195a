"""Write C for the vehicle computer: the steering law along a road, with a test harness.

``python -m cca_core.codegen --vehicle bmw_320i --road ROAD.gpx --out DIR`` writes sources that any C99
compiler builds. If there is gcc here, it builds them, runs the harness, and prints what they need. Without
arguments the C of the kernel is written anew.
"""

import argparse
import sys
from pathlib import Path

from cca_core.codegen import FOLDER, TranslationError, translate


def main(arguments: list[str] | None = None) -> int:
    """Run the command; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m cca_core.codegen", description=__doc__)
    parser.add_argument(
        "--vehicle", help="bmw_320i, ford_escort, vw_vanagon, or a JSON file of VehicleParams"
    )
    parser.add_argument("--road", type=Path, help="GPX, KML, GeoJSON, NMEA or table, as for Road.from_file")
    parser.add_argument("--out", type=Path, help="folder for the sources")
    parser.add_argument("--delay", type=float, default=0.0, help="dead time of the steering [s]")
    parser.add_argument("--a-y-max", type=float, default=8.0, help="limit of lateral acceleration [m/s^2]")
    parser.add_argument("--cases", type=int, default=2000, help="number of recorded steps")
    parser.add_argument("--seed", type=int, default=1, help="seed of their inputs")
    given = parser.parse_args(arguments)
    asked = (given.vehicle, given.road, given.out)
    if asked == (None, None, None):
        return _write_kernel()
    if None in asked:
        parser.error("--vehicle, --road and --out belong together")
    return _write_project(given)


def _write_kernel() -> int:
    try:
        texts = translate(FOLDER)
    except TranslationError as error:
        sys.stderr.write(f"{FOLDER}/{error}\n")
        return 1
    for name, text in texts.items():
        (FOLDER / "c" / name).write_text(text, encoding="utf-8")
    return 0


def _write_project(given: argparse.Namespace) -> int:
    # a kernel that is being written need not run to be translated
    from cca_core.codegen.export.measure import measure
    from cca_core.codegen.export.project import export_c, find_vehicle
    from cca_core.errors import CcaError
    from cca_core.path import Road

    try:
        vehicle, road = find_vehicle(given.vehicle), Road.from_file(given.road)
        export_c(
            given.out, vehicle, road.path, delay=given.delay, a_y_max=given.a_y_max, cases=given.cases,
            seed=given.seed,
        )  # fmt: skip
    except CcaError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    lines = [f"{given.out}: {road.path!r}", *measure(given.out.resolve())]
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())

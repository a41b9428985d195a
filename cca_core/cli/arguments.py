"""Words of the command line; importing this module is fast."""

import argparse
from pathlib import Path as FilePath

__all__ = ["STDOUT", "make_parser"]

STDOUT = FilePath("-")
"""Name that stands for the standard output."""

_EGO_TYPES = "v2v", "driver", "sensor"
_PLANTS = "single_track", "multi_body"


def make_parser() -> argparse.ArgumentParser:
    """Make the parser of all commands."""
    parser = argparse.ArgumentParser(
        prog="cca", description="Cooperative collision avoidance of connected vehicles.",
        epilog="cca COMMAND --help lists the arguments of a command; docs/command_line.md explains them.",
    )  # fmt: skip
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", title="commands")
    for name, (summary, add_arguments) in _COMMANDS.items():
        add_arguments(commands.add_parser(name, help=summary, description=f"{summary}."))
    return parser


class _Version(argparse.Action):
    """Prints the version of the library."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from cca_core import __version__

        print(f"cca {__version__}")
        parser.exit()


def _demo(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=FilePath, default=FilePath("out"), help="folder (default: out)")
    parser.add_argument("--route", type=FilePath, metavar="FILE", help="route of maneuvering; default: I-80")
    parser.add_argument("--km", type=float, default=20.0, help="length of the route to use [km]")
    parser.add_argument("--seed", type=int, default=1, help="seed of the messages")
    parser.add_argument(
        "--only", metavar="NAME", help="one scenario: eebl, ima, curbside or maneuver; default: all"
    )


def _fit(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("route", type=FilePath, help="GPX, KML, GeoJSON, NMEA, table; or .xodr, .net.xml")
    parser.add_argument("--tolerance", type=float, metavar="M", help="default: from the noise of the route")
    parser.add_argument("--part", type=int, metavar="I", help="one track, segment or line alone, from 0")
    parser.add_argument("--along", metavar="A,B,...", help="ids of roads or edges of a map, in driving order")
    parser.add_argument("--lane", type=int, metavar="I", help="lane of a map where the road begins")
    parser.add_argument("--max-gap", type=float, default=100.0, metavar="M", help="between joined parts")
    parser.add_argument(
        "--plot", type=FilePath, nargs="?", const=FilePath(), metavar="FILE.svg",
        help="picture; default: the route's name with .svg, in this folder",
    )  # fmt: skip


def _decode(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("log", type=FilePath, help="hex lines, pcap, JSON, CSV or ODE log; also .gz")
    parser.add_argument(
        "--csv", type=FilePath, nargs="?", const=STDOUT, metavar="FILE",
        help="write all fields of the messages; without FILE: print that table alone",
    )  # fmt: skip
    parser.add_argument("--quiet", action="store_true", help="counts alone")


def _drive(parser: argparse.ArgumentParser) -> None:
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("scenario", type=FilePath, nargs="?", metavar="SCENARIO.toml", help="road, ego, others")
    what.add_argument("--template", action="store_true", help="print a scenario to begin with")
    parser.add_argument("--ego", choices=(*_EGO_TYPES, "all"), help="instead of that in the file")
    parser.add_argument("--plant", choices=_PLANTS, help="instead of that in the file")
    parser.add_argument("--seed", type=int, help="instead of that in the file")
    parser.add_argument("--out", type=FilePath, metavar="FOLDER", help="default: out/SCENARIO")


def _study(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scenario", type=FilePath, help="eebl, ima, curbside, maneuver, or a file STUDY.toml with ranges"
    )
    n = parser.add_mutually_exclusive_group()
    n.add_argument("--runs", type=int, metavar="N", help="number of runs (default: 100)")
    n.add_argument("--avoidable", type=int, metavar="N", help="go on until N collisions were avoidable")
    parser.add_argument("--seed", type=int, help="seed of all samples")
    parser.add_argument("--plant", choices=_PLANTS, help="plant of the ego")
    parser.add_argument("--jobs", type=int, metavar="N", help="processes (default: one a processor)")
    parser.add_argument("--out", type=FilePath, default=FilePath("out"), help="folder (default: out)")


def _report(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("logs", type=FilePath, nargs="+", help="logs (.npz), or folders of them")
    parser.add_argument(
        "--out", type=FilePath, default=FilePath("report.html"), metavar="FILE", help="default: report.html"
    )
    parser.add_argument("--figures", type=FilePath, metavar="FOLDER", help="write the figures as PNG too")


_COMMANDS = {
    "demo": ("Drive the paper's scenarios with and without V2V, and report", _demo),
    "fit": ("Fit a smooth road to a route, and state its facts", _fit),
    "decode": ("List recorded Basic Safety Messages, and what was dropped", _decode),
    "drive": ("Drive a scenario that a file describes, and report", _drive),
    "study": ("Sample many runs, resumable, and count the collisions", _study),
    "report": ("Write the report of stored logs", _report),
}

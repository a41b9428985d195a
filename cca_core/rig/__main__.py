"""The rig on the command line: drive the paper's scenarios, or run one of the computers.

``python -m cca_core.rig run`` drives the scenarios through the processes. It writes report.html,
summary.json, links.png and the bus logs. ``plant``, ``vehicle`` and ``monitor`` run one computer each.
``replay`` sends a recorded bus log, ``control`` a line to the control port of a process.
"""

import argparse
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from cca_core._optional import require_extra
from cca_core.errors import CcaError
from cca_core.real_time import RealTimeSettings
from cca_core.rig.bus import BusLink
from cca_core.rig.bus_log import LOG_ENDINGS, read_bus_log, replay_bus
from cca_core.rig.clocks import RigClock
from cca_core.rig.processes import find_scenario, run_plant, run_vehicle, scenario_id
from cca_core.rig.records import write_record
from cca_core.rig.run import RigOptions, run_scenarios, write_summary
from cca_core.rig.udp import UdpLink
from cca_core.sim import paper_scenarios


def main(arguments: list[str] | None = None) -> int:
    """Run a command; return the exit code."""
    given = _parser().parse_args(arguments)
    try:
        return int(_COMMANDS[given.command](given))
    except CcaError as error:
        sys.stderr.write(f"{error}\n")
        return 2


def _parser() -> argparse.ArgumentParser:
    shared = argparse.ArgumentParser(add_help=False)
    shared.add_argument("--settings", type=Path, help="TOML file of the interfaces; default: in software")
    shared.add_argument("--number", type=int, default=0, help="number of this rig on the machine")
    shared.add_argument("--rate", type=float, default=1.0, help="seconds of the rig per second")
    shared.add_argument("--priority", type=int, default=0, help="priority of SCHED_FIFO, 0: normal")
    shared.add_argument("--plant", default="single_track", help="single_track or multi_body")
    shared.add_argument("--seed", type=int, help="seed of the messages")
    parser = argparse.ArgumentParser(prog="python -m cca_core.rig", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", parents=[shared], help="drive scenarios and write a report")
    run.add_argument("scenario", nargs="*", help="names such as maneuver/2/v2v; default: all of the paper")
    run.add_argument("--out", type=Path, default=Path("out/rig"), help="folder for the results")
    run.add_argument("--jobs", type=int, default=4, help="number of rigs at the same time")
    run.add_argument("--log", choices=LOG_ENDINGS, default=".blf", help="ending of the bus logs")
    for role in ("plant", "vehicle"):
        node = commands.add_parser(role, parents=[shared], help=f"run the {role} computer")
        node.add_argument("scenario")
        node.add_argument("--record", type=Path, help="file for its record")
    monitor = commands.add_parser("monitor", parents=[shared], help="serve a live page on this machine")
    monitor.add_argument("scenario")
    control = commands.add_parser("control", help="send a line to the control port of a process")
    control.add_argument("address")
    control.add_argument("line", nargs="+", help="driver on, driver off, utc OFFSET, drift RATE")
    replay = commands.add_parser("replay", parents=[shared], help="send a recorded bus log")
    replay.add_argument("log", type=Path)
    return parser


def _options(given: argparse.Namespace) -> RigOptions:
    return RigOptions(
        settings_file=given.settings, number=given.number, rate=given.rate, plant=given.plant,
        seed=given.seed, priority=given.priority,
    )  # fmt: skip


def _stop_flag() -> Callable[[], bool]:
    """Return whether the process was asked to end."""
    asked: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda received, _: asked.append(received))
    return lambda: bool(asked)


def _run(given: argparse.Namespace) -> int:
    require_extra("matplotlib", "rig")
    tqdm = require_extra("tqdm", "rig").tqdm
    from cca_core.report import summarize_outcome, write_report
    from cca_core.rig.figure import plot_links

    names = given.scenario or [scenario_id(each) for each in paper_scenarios()]
    for name in names:
        find_scenario(name)
    given.out.mkdir(parents=True, exist_ok=True)
    with tqdm(total=len(names), unit="scenario", desc="driving", disable=None) as bar:
        runs = run_scenarios(
            names, given.out, _options(given), jobs=given.jobs, log_ending=given.log,
            progress=lambda _: bar.update(),
        )  # fmt: skip
    write_summary(runs, given.out / "summary.json")
    plot_links([run.links for run in runs]).savefig(given.out / "links.png", dpi=110)
    write_report([run.log for run in runs], given.out / "report.html", figures=given.out)
    for run in runs:
        links, log = run.links, run.log
        sys.stdout.write(
            f"{scenario_id(log.scenario):28} {summarize_outcome(log):44} "
            f"{links['commands']['late']:4d} of {links['commands']['cycles']} commands late, "
            f"answer {links['command']['median_us'] / 1000.0:.1f} ms\n"
        )
    sys.stdout.write(f"Open {given.out / 'report.html'}\n")
    return 0


def _plant(given: argparse.Namespace) -> int:
    options = _options(given)
    record = run_plant(
        find_scenario(given.scenario), options.settings, RigClock(given.rate), plant=given.plant,
        seed=given.seed, real_time=_real_time(given), is_stopped=_stop_flag(),
        records=given.record is not None,
    )  # fmt: skip
    if given.record is not None:
        write_record(record, given.record)
    return 0


def _vehicle(given: argparse.Namespace) -> int:
    record = run_vehicle(
        find_scenario(given.scenario), _options(given).settings, RigClock(given.rate),
        real_time=_real_time(given), is_stopped=_stop_flag(), records=given.record is not None,
    )  # fmt: skip
    if given.record is not None:
        write_record(record, given.record)
    return 0


def _real_time(given: argparse.Namespace) -> RealTimeSettings:
    return RealTimeSettings(priority=given.priority, lock_memory=given.priority > 0)


def _monitor(given: argparse.Namespace) -> int:
    from cca_core.rig.monitor import serve

    settings = _options(given).settings
    sys.stdout.write(f"http://127.0.0.1:{settings.monitor_port}\n")
    sys.stdout.flush()
    serve(find_scenario(given.scenario), settings, is_stopped=_stop_flag())
    return 0


def _control(given: argparse.Namespace) -> int:
    link = UdpLink(None, [given.address])
    link.send(" ".join(given.line).encode("utf-8"))
    link.close()
    return 0


def _replay(given: argparse.Namespace) -> int:
    link = BusLink(_options(given).settings.bus)
    n = replay_bus(read_bus_log(given.log), link, rate=given.rate)
    link.close()
    sys.stdout.write(f"{n} frames sent\n")
    return 0


_COMMANDS: dict[str, Callable[[argparse.Namespace], int]] = {
    "run": _run, "plant": _plant, "vehicle": _vehicle, "monitor": _monitor, "control": _control,
    "replay": _replay
}  # fmt: skip

if __name__ == "__main__":
    sys.exit(main())

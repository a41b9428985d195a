"""Write left_turn.svg: a left turn in front of a hidden car, with the ego's own sensor and with V2V."""

from pathlib import Path

import numpy as np

from cca_core.plot.style import COLORS, ROLE_COLORS
from cca_core.report.road_svg import roads_svg
from cca_core.sim import Log, ima, simulate

VIEW = (-21.0, -11.5, 50.0, 18.0)  # x, y (down), width, height [m]
SCALE = 10.0  # units of the picture for each meter
TIMES = np.arange(6.0, 16.01, 0.2)  # [s]
HOLD = 2.0  # of the last pose [s]
STILL = 10.7  # pose without animation [s]
BAR = 26.0  # height of a line of text
KEY = (("ego", COLORS.ego), ("red car", ROLE_COLORS["red"]), ("truck", ROLE_COLORS["truck"]))

STYLE = f"""
text {{ font: 15px system-ui, sans-serif; fill: {COLORS.ink} }} .b {{ font-weight: 600 }}
.asphalt {{ fill: {COLORS.asphalt} }} .edge {{ stroke: {COLORS.line}; fill: none; stroke-width: .4 }}
.dashes {{ stroke: #fff; fill: none; stroke-width: .2; stroke-dasharray: 3 6 }}
.route {{ stroke: {COLORS.ego}; fill: none; stroke-width: .15; stroke-dasharray: .6 .8 }}
.stop {{ stroke: #fff; stroke-width: .6 }} .glass {{ fill: #fff; opacity: .6 }}
.hit {{ stroke: {COLORS.collision}; stroke-width: .6; fill: none }}
"""


def pose(log: Log, vehicle: int, t: float) -> tuple[float, float, float]:
    """Body center [m] and heading [deg] of the ego (-1) or a road user; the last one after the end."""
    row = min(int(np.searchsorted(log.t, t - 1e-6)), len(log.t) - 1)
    if vehicle >= 0:
        x, y, psi, _ = log.road_users[row, vehicle]
    else:
        box, _ = log.bodies()
        x, y, psi = box.x[row, 0], box.y[row, 0], log.ego[row, 2]
    return float(x), float(y), float(np.degrees(psi))


def moves(name: str, log: Log, vehicle: int) -> str:
    """Keyframes of a vehicle; it stands still for readers who ask for less motion."""
    if vehicle >= 0 and np.ptp(log.road_users[:, vehicle, :2], axis=0).max() < 0.01:
        return f".{name}{{{at(*pose(log, vehicle, STILL))}}}\n"
    total = TIMES[-1] - TIMES[0] + HOLD
    frames = []
    for t in TIMES:
        x, y, psi = pose(log, vehicle, float(t))
        frames.append(f"{100 * (t - TIMES[0]) / total:.1f}%{{{at(x, y, psi)}}}")
    frames.append(f"100%{{{at(*pose(log, vehicle, float(TIMES[-1])))}}}")
    return (
        f"@keyframes {name}{{{''.join(frames)}}}"
        f".{name}{{{at(*pose(log, vehicle, STILL))};animation:{name} {total:g}s linear infinite}}\n"
    )


def at(x: float, y: float, psi: float) -> str:
    """CSS transform of a pose; y of the picture is down."""
    return f"transform:translate({x:.2f}px,{-y:.2f}px) rotate({-psi:.1f}deg)"


def car(name: str, length: float, width: float, color: str) -> str:
    """Body with windshield."""
    return (
        f'<g class="{name}"><rect x="{-length / 2:g}" y="{-width / 2:g}" width="{length:g}" '
        f'height="{width:g}" rx=".4" fill="{color}"/>'
        f'<rect class="glass" x="{0.12 * length:g}" y="{-0.36 * width:g}" '
        f'width="{0.1 * length:g}" height="{0.72 * width:g}"/></g>'
    )


def panel(number: int, log: Log, heading: str, text: str) -> tuple[str, str]:
    """Keyframes and picture of a run."""
    x0, y0, width, height = VIEW
    top = number * (SCALE * height + BAR + 6.0)
    vehicle = log.scenario.vehicle
    movers = [(-1, "ego", vehicle.length, vehicle.width, COLORS.ego)]
    for i, user in enumerate(log.scenario.road_users):
        movers.append((i, user.id, user.length, user.width, ROLE_COLORS[user.id]))
    style = "".join(moves(f"{name}{number}", log, i) for i, name, *_ in movers)
    bodies = "".join(car(f"{name}{number}", length, wide, color) for _, name, length, wide, color in movers)
    hit = ""
    if log.collided_with:
        total = TIMES[-1] - TIMES[0] + HOLD
        share = 100 * (log.t[-1] - TIMES[0]) / total
        style += (
            f"@keyframes hit{{0%,{share:.1f}%{{opacity:0}}{share + 0.1:.1f}%,100%{{opacity:1}}}}"
            f".hit{{animation:hit {total:g}s linear infinite}}\n"
        )
        x, y, _ = pose(log, 0, float(log.t[-1]))
        hit = f'<g class="hit" transform="translate({x - 1.5:.2f} {-y:.2f})"><circle r="3"/></g>'
    road = roads_svg(log, np.zeros(2), (60.0, 60.0))
    return style, (
        f'<text x="2" y="{top + 18:g}"><tspan class="b">{heading}</tspan> {text}</text>'
        f'<svg x="0" y="{top + BAR:g}" width="{SCALE * width:g}" height="{SCALE * height:g}" '
        f'viewBox="{x0:g} {y0:g} {width:g} {height:g}"><rect x="{x0:g}" y="{y0:g}" width="{width:g}" '
        f'height="{height:g}" fill="{COLORS.verge}"/><g transform="scale(1 -1)">{road}</g>{bodies}{hit}</svg>'
    )


def key(y: float) -> str:
    """Colors of the vehicles."""
    return "".join(
        f'<rect x="{2 + 110 * i}" y="{y - 11:g}" width="22" height="11" rx="2" fill="{color}"/>'
        f'<text x="{30 + 110 * i}" y="{y:g}">{name}</text>'
        for i, (name, color) in enumerate(KEY)
    )


def main() -> None:
    """Drive both runs and write the picture next to this file."""
    sensor, v2v = (simulate(ima(ego_type=ego_type)) for ego_type in ("sensor", "v2v"))
    panels = [
        panel(0, sensor, "Own sensor only:", "the truck hides the red car; the ego hits it."),
        panel(1, v2v, "With V2V:", "the red car reports itself; the ego waits."),
    ]
    width, height = SCALE * VIEW[2], 2 * (SCALE * VIEW[3] + BAR) + 6.0 + BAR
    styles, bodies = ("".join(part) for part in zip(*panels, strict=True))
    Path(__file__).with_suffix(".svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}" '
        f'height="{height:g}" role="img"><title>{sensor}; {v2v}</title><style>{STYLE}{styles}'
        "@media (prefers-reduced-motion: reduce) { * { animation: none !important } }</style>"
        f'<rect width="100%" height="100%" fill="#fff"/>{bodies}{key(height - 8.0)}</svg>\n',
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()

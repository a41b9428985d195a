"""Defects of the paper's one-shot band, compared with the relaxed band."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.band import Band, BandStiffness, deformed, displacement, external_force, relax_band
from cca_core.errors import InputError
from cca_core.plot.legends import legend_above
from cca_core.plot.parked_car import EXAMPLE
from cca_core.plot.style import COLORS, COLUMN_WIDTH, new_figure, set_text_sizes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ONE_SHOT, _RELAXED = "paper, one shot", "relax_band"


def plot_defect(defect: str) -> "Figure":
    """Draw a defect of the paper's one-shot band next to the relaxed band.

    Parameters
    ----------
    defect : str
        One of `DEFECTS`.

    Returns
    -------
    figure : Figure
        Two axes; the paper's band in purple, the relaxed one in blue, the parked car in gray.

    Raises
    ------
    InputError
        If there is no such defect.
    MissingExtraError
        If matplotlib is not installed.
    """
    if defect not in _DRAWERS:
        raise InputError(f"defect must be one of {', '.join(DEFECTS)}, was {defect!r}")
    figure = new_figure(4.8, COLUMN_WIDTH)
    above, below = figure.subplots(2, 1)
    _DRAWERS[defect](above, below)
    for axis in (above, below):
        legend_above(axis, ncols=4)
    set_text_sizes(figure)
    figure.align_ylabels()
    return figure


def _route(h: float = 1.0) -> Array:
    x = np.arange(0.0, EXAMPLE.route_length + 0.5 * h, h)
    return np.column_stack((x, np.zeros_like(x)))


def _one_step(nodes: Array, d: float, ratio: float = EXAMPLE.k_e) -> Array:
    """Displacement by eqs 8 and 9 with the forces at given nodes."""
    return displacement(
        external_force(nodes, (0.5 * EXAMPLE.route_length, d), k_e=ratio, r_0=EXAMPLE.r_0), k_s=1.0
    )


def _one_shot(d: float, h: float = 1.0) -> Array:
    return deformed(_route(h), _one_step(_route(h), d))


def _balance(ratio: float) -> Array:
    """Nodes at which the paper's forces balance; damped, because the iteration would alternate."""
    u = np.zeros_like(_route())
    for _ in range(1000):
        u += (_one_step(_route() + u, EXAMPLE.d, ratio) - u) / (1.0 + 75.0 * ratio)
    return deformed(_route(), u)


def _relaxed(d: float = EXAMPLE.d, h: float = 1.0, **options: Any) -> Band:
    return relax_band(
        _route(h), [EXAMPLE.body(d)], vehicle=EXAMPLE.vehicle, clearance=EXAMPLE.clearance, **options
    )


def _plan(axis: Any, bands: Iterable[tuple[Array, str, str, str]], d: float, **style: Any) -> None:
    """Draw bands (nodes, label, color, line style) past the parked car."""
    for nodes, label, color, line in bands:
        axis.plot(*nodes.T, line, color=color, label=label, **style)
    axis.axhline(0.0, color=COLORS.ink, linewidth=1.0, linestyle=":", zorder=0)
    axis.fill(*EXAMPLE.body(d).corners().T, color=COLORS.parked, zorder=1)
    axis.set(xlabel="along the route [m]", ylabel="left of the\nroute [m]")


def _on_the_path(above: Any, below: Any) -> None:
    _plan(
        above,
        [(_one_shot(0.0), _ONE_SHOT, COLORS.paper, "-"), (_relaxed(0.0).nodes, _RELAXED, COLORS.ego, "-")],
        0.0,
    )
    above.set_title("Parked car on the route", loc="left")
    above.set_ylim(-1.3, 3.2)
    d = np.linspace(-2.0, 2.0, 81)
    below.plot(d, [np.abs(_one_shot(each)[:, 1]).max() for each in d], color=COLORS.paper, label=_ONE_SHOT)
    below.plot(d, [np.abs(_relaxed(each).displacement).max() for each in d], color=COLORS.ego, label=_RELAXED)
    below.plot(d, EXAMPLE.r_0 - np.abs(d), ":", color="black", label="required")
    below.set(xlabel="parked car left of the route [m]", ylabel="peak\ndisplacement [m]", ylim=(0.0, 3.4))
    below.set_title("Parked car next to the route", loc="left")


def _mesh(above: Any, below: Any) -> None:
    for h, line in ((2.0, ":"), (1.0, "--"), (0.5, "-")):
        for axis, nodes, color in (
            (above, _one_shot(EXAMPLE.d, h), COLORS.paper), (below, _relaxed(h=h).nodes, COLORS.ego),
        ):  # fmt: skip
            label = f"{h:g} m mesh: peak {nodes[:, 1].max():.1f} m"
            _plan(axis, [(nodes, label, color, line)], EXAMPLE.d)
    below.sharey(above)
    above.set_ylim(-2.0, 12.5)
    above.set_title(f"{_ONE_SHOT}: finer mesh, other band", loc="left")
    below.set_title(f"{_RELAXED}: finer mesh, same band", loc="left")


def _iteration(above: Any, below: Any) -> None:
    band, u, peaks = _relaxed(), np.zeros_like(_route()), [0.0]
    for i in range(13):
        u = _one_step(_route() + u, EXAMPLE.d)
        peaks.append(float(np.abs(u[:, 1]).max()))
        if i > 10:
            _plan(
                above,
                [(_route() + u, f"paper, solve {i + 1}", COLORS.paper, "-" if i % 2 else "--")],
                EXAMPLE.d,
            )
    _plan(above, [(band.nodes, _RELAXED, COLORS.ego, "-")], EXAMPLE.d)
    above.set_ylim(-1.6, 3.4)
    above.set_title("Forces computed again at the displaced nodes", loc="left")
    below.set_title("Peak after each solve", loc="left")
    below.plot(peaks, ".--", color=COLORS.paper, label="paper, repeated: it alternates")
    level = float(np.abs(band.displacement).max())
    below.plot(band.n_solves, level, "o", color=COLORS.ego, label=f"{_RELAXED}: done after {band.n_solves}")
    below.plot((0.0, 13.0), (level, level), color=COLORS.ego, linewidth=0.8)
    below.set(xlabel="linear systems solved [-]", ylabel="peak\ndisplacement [m]", ylim=(-0.2, 3.4))


def _short(above: Any, below: Any) -> None:
    soft = _balance(0.1)
    _plan(
        above,
        [(soft, "paper, in balance", COLORS.paper, "-"), (_relaxed().nodes, _RELAXED, COLORS.ego, "-")],
        EXAMPLE.d,
    )
    above.axhline(EXAMPLE.d + EXAMPLE.r_0, color="black", linestyle=":", label="required")
    above.set(xlim=(35.0, 65.0), ylim=(-1.6, 2.9))
    above.set_title("Past the parked car", loc="left")
    ratios = np.geomspace(0.01, 3.0, 12)
    gaps = [_gap(_balance(ratio)) for ratio in ratios]
    clearances = [
        _relaxed(stiffness=BandStiffness(k_s=1.0, k_c=2e4, k_e=ratio)).clearance for ratio in ratios.tolist()
    ]
    below.semilogx(ratios, gaps, ".-", color=COLORS.paper, label="paper, in balance")
    below.semilogx(ratios, clearances, ".-", color=COLORS.ego, label=_RELAXED)
    below.axhline(EXAMPLE.clearance, color="black", linestyle=":", label="limit")
    below.set_title("The stiffer the contact, the more clearance", loc="left")
    below.set(xlabel="penalty per spring stiffness k_e / k_s (1 m mesh) [-]", ylabel="clearance\nreached [m]")


def _gap(nodes: Array) -> float:
    """Clearance of straight lines through the nodes to the parked car [m]."""
    a, segment = nodes[:-1] - (0.5 * EXAMPLE.route_length, EXAMPLE.d), np.diff(nodes, axis=0)
    fraction = np.clip(-(a * segment).sum(axis=1) / (segment**2).sum(axis=1), 0.0, 1.0)
    return float(np.linalg.norm(a + fraction[:, None] * segment, axis=1).min()) - EXAMPLE.contact_distance


def _pins(above: Any, below: Any) -> None:
    x = np.arange(10.0)
    before, after = (np.column_stack((x + at, 0.0 * x)) for at in (-10.0, EXAMPLE.route_length + 1.0))
    for nodes, label, color in (
        (_one_shot(EXAMPLE.d), _ONE_SHOT, COLORS.paper), (_relaxed().nodes, _RELAXED, COLORS.ego),
    ):  # fmt: skip
        line = np.vstack((before, nodes, after))
        heading = np.arctan2(*np.diff(line, axis=0).T[::-1])
        above.plot(0.5 * (line[1:, 0] + line[:-1, 0]), np.degrees(heading), color=color, label=label)
        a_y = EXAMPLE.speed**2 * np.diff(heading) / np.linalg.norm(np.diff(line, axis=0), axis=1)[1:]
        label += f": peak {np.abs(a_y).max():.1f} m/s²"
        below.plot(line[1:-1, 0], a_y, color=color, label=label)
    above.set(xlabel="along the route [m]", ylabel="heading against\nthe route [°]")
    below.set(xlabel="along the route [m]", ylabel="lateral acc.\na_y [m/s²]")
    above.set_title("Heading", loc="left")
    below.set_title(f"Lateral acceleration at {EXAMPLE.speed:g} m/s", loc="left")


def _sides(above: Any, below: Any) -> None:
    measured = np.random.default_rng(1).normal(0.0, 0.05, 30)
    one_shots, bands = [_one_shot(d) for d in measured], [_relaxed(float(measured[0]))]
    for d in measured[1:].tolist():
        bands.append(_relaxed(d, previous=bands[-1]))
    for i, (shot, band) in enumerate(zip(one_shots, bands, strict=True)):
        names = ("", "") if i else (_ONE_SHOT, f"{_RELAXED} with previous")
        _plan(
            above,
            [(shot, names[0], COLORS.paper, "-"), (band.nodes, names[1], COLORS.ego, "-")],
            0.0,
            linewidth=0.7,
        )
    above.set_title("30 cycles, parked car measured with σ = 0.05 m", loc="left")
    below.set_title("Side on which each band passes", loc="left")
    t = 0.1 * np.arange(len(measured))
    below.plot(t, [_peak(shot[:, 1]) for shot in one_shots], ".-", color=COLORS.paper, label=_ONE_SHOT)
    below.plot(t, [_peak(band.displacement) for band in bands], ".-", color=COLORS.ego, label=f"{_RELAXED}")
    above.set_ylim(-3.2, 2.9)
    below.set(xlabel="time [s]", ylabel="peak displacement,\nleft positive [m]", ylim=(-3.2, 2.9))


def _peak(u: Array) -> float:
    return float(u[np.abs(u).argmax()])


def _clustering(above: Any, below: Any) -> None:
    bands = (
        (_one_shot(-0.1), _ONE_SHOT, COLORS.paper, ".-"),
        (_relaxed(-0.1).nodes, _RELAXED, COLORS.ego, ".-"),
    )
    _plan(above, bands, -0.1, markersize=6.0, linewidth=0.8)
    above.set(xlim=(42.0, 58.0), ylim=(-1.6, 3.6))
    above.set_title("Nodes near the parked car", loc="left")
    below.set_title("Shift of the nodes along the route", loc="left")
    for nodes, label, color, _ in bands:
        below.plot(_route()[:, 0], nodes[:, 0] - _route()[:, 0], ".-", color=color, label=label)
    below.set(xlabel="along the route [m]", ylabel="shift along\nthe route [m]", ylim=(-0.1, 0.1))


_DRAWERS = {
    "on the path": _on_the_path,
    "mesh": _mesh,
    "iteration": _iteration,
    "clearance": _short,
    "pins": _pins,
    "sides": _sides,
    "clustering": _clustering,
}
DEFECTS = tuple(_DRAWERS)
"""Defects of the one-shot band, for `plot_defect`."""

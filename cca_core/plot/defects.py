"""What the paper's one-shot band does wrong, beside what the relaxed band does."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import Array
from cca_core.band import Band, BandStiffness, deformed, displacement, external_force, relax_band
from cca_core.errors import InputError
from cca_core.geometry import Boxes, boxes
from cca_core.plot.style import EGO, PARKED, new_figure
from cca_core.vehicle import VehicleParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PAPER = "#882255"
_SHOT, _RELAXED = "paper, one shot", "relax_band"
_V = 20.0  # at which lateral accelerations are told [m/s]
_LENGTH, _ASKED = 100.0, 1.0  # route and clearance [m]
_K_E = 0.03  # external per spring stiffness of the paper's band [-]
_VEHICLE = VehicleParams.bmw_320i()
_CAR = 4.5, 1.8  # length and width of the parked car [m]
_APART = 0.5 * (_CAR[1] + _VEHICLE.width)  # of the centers when the bodies touch [m]
_R_0 = _APART + _ASKED
_BESIDE = -0.5  # where the parked car stands if not on the route [m]


def plot_defect(defect: str) -> "Figure":
    """Draw what the paper's one-shot band does wrong beside what the relaxed band does.

    Parameters
    ----------
    defect : str
        One of `DEFECTS`.

    Returns
    -------
    figure : Figure
        Two axes; the paper's band in purple, the relaxed one in blue.

    Raises
    ------
    InputError
        If there is no such defect.
    MissingExtraError
        If matplotlib is not installed.
    """
    if defect not in _DRAWERS:
        raise InputError(f"defect must be one of {', '.join(DEFECTS)}, was {defect!r}")
    figure = new_figure(3.1)
    left, right = figure.subplots(1, 2)
    _DRAWERS[defect](left, right)
    for axis in (left, right):
        axis.legend(fontsize=8, loc="best")
    return figure


def _route(h: float = 1.0) -> Array:
    x = np.arange(0.0, _LENGTH + 0.5 * h, h)
    return np.column_stack((x, np.zeros_like(x)))


def _car(d: float) -> Boxes:
    return boxes(0.5 * _LENGTH, d, 0.0, *_CAR)


def _pushed(nodes: Array, d: float, ratio: float = _K_E) -> Array:
    """Displacement by eqs 8 and 9 with the forces at given nodes."""
    return displacement(external_force(nodes, (0.5 * _LENGTH, d), k_e=ratio, r_0=_R_0), k_s=1.0)


def _one_shot(d: float, h: float = 1.0) -> Array:
    return deformed(_route(h), _pushed(_route(h), d))


def _balanced(ratio: float) -> Array:
    """Nodes at which the paper's forces balance; the iteration is damped, or it would flip."""
    u = np.zeros_like(_route())
    for _ in range(1000):
        u += (_pushed(_route() + u, _BESIDE, ratio) - u) / (1.0 + 75.0 * ratio)
    return deformed(_route(), u)


def _relaxed(d: float = _BESIDE, h: float = 1.0, **options: Any) -> Band:
    return relax_band(_route(h), [_car(d)], vehicle=_VEHICLE, clearance=_ASKED, **options)


def _plan(axis: Any, bands: Iterable[tuple[Array, str, str, str]], d: float, **style: Any) -> None:
    """Draw bands (nodes, label, color, line style) past the parked car."""
    for nodes, label, color, line in bands:
        axis.plot(*nodes.T, line, color=color, label=label, **style)
    axis.axhline(0.0, color="black", linewidth=0.8, linestyle=(0, (4, 4)), zorder=0)
    axis.fill(*_car(d).corners().T, color=PARKED, zorder=1)
    axis.set(xlabel="along the route [m]", ylabel="left of the route [m]")


def _on_the_path(left: Any, right: Any) -> None:
    _plan(left, [(_one_shot(0.0), _SHOT, _PAPER, "-"), (_relaxed(0.0).nodes, _RELAXED, EGO, "-")], 0.0)
    left.set_title("The parked car stands on the route", fontsize=10)
    d = np.linspace(-2.0, 2.0, 81)
    right.plot(d, [np.abs(_one_shot(each)[:, 1]).max() for each in d], color=_PAPER, label=_SHOT)
    right.plot(d, [np.abs(_relaxed(each).displacement).max() for each in d], color=EGO, label=_RELAXED)
    right.plot(d, _R_0 - np.abs(d), ":", color="black", label="needed")
    right.set(xlabel="parked car left of the route [m]", ylabel="peak displacement [m]", ylim=(0.0, 4.5))
    right.set_title("It stands beside the route", fontsize=10)


def _mesh(left: Any, right: Any) -> None:
    for h, line in ((2.0, ":"), (1.0, "--"), (0.5, "-")):
        for axis, nodes, color in (
            (left, _one_shot(_BESIDE, h), _PAPER), (right, _relaxed(h=h).nodes, EGO),
        ):  # fmt: skip
            label = f"a node each {h:g} m: peak {nodes[:, 1].max():.2f} m"
            _plan(axis, [(nodes, label, color, line)], _BESIDE)
    right.sharey(left)
    left.set_ylim(-2.0, 17.0)
    left.set_title(f"{_SHOT}: finer mesh, other band", fontsize=10)
    right.set_title(f"{_RELAXED}: finer mesh, same band", fontsize=10)


def _flipping(left: Any, right: Any) -> None:
    band, u, peaks = _relaxed(), np.zeros_like(_route()), [0.0]
    for i in range(13):
        u = _pushed(_route() + u, _BESIDE)
        peaks.append(float(np.abs(u[:, 1]).max()))
        if i > 10:
            _plan(left, [(_route() + u, f"paper, solve {i + 1}", _PAPER, "-" if i % 2 else "--")], _BESIDE)
    _plan(left, [(band.nodes, _RELAXED, EGO, "-")], _BESIDE)
    left.set_ylim(-1.6, 4.8)
    left.set_title("Forces taken anew at the displaced nodes", fontsize=10)
    right.plot(peaks, ".--", color=_PAPER, label="paper, repeated: flips for ever")
    level = float(np.abs(band.displacement).max())
    right.plot(band.n_solves, level, "o", color=EGO, label=f"{_RELAXED}: settled after {band.n_solves}")
    right.plot((0.0, 13.0), (level, level), color=EGO, linewidth=0.8)
    right.set(xlabel="linear systems solved [-]", ylabel="peak displacement [m]", ylim=(-0.2, 4.8))


def _short(left: Any, right: Any) -> None:
    soft = _balanced(0.1)
    _plan(left, [(soft, "paper, in balance", _PAPER, "-"), (_relaxed().nodes, _RELAXED, EGO, "-")], _BESIDE)
    left.axhline(_BESIDE + _R_0, color="black", linestyle=":", label="needed")
    left.set(xlim=(35.0, 65.0), ylim=(-1.6, 3.9))
    ratios = np.geomspace(0.01, 3.0, 12)
    gaps = [_gap(_balanced(ratio)) for ratio in ratios]
    kept = [
        _relaxed(stiffness=BandStiffness(k_s=1.0, k_c=2e4, k_e=ratio)).clearance for ratio in ratios.tolist()
    ]
    right.semilogx(ratios, gaps, ".-", color=_PAPER, label="paper, in balance")
    right.semilogx(ratios, kept, ".-", color=EGO, label=_RELAXED)
    right.axhline(_ASKED, color="black", linestyle=":", label="asked")
    right.set(xlabel="contact per spring stiffness k_e / k_s (1 m mesh) [-]", ylabel="clearance reached [m]")


def _gap(nodes: Array) -> float:
    """Clearance beside the parked car that straight lines through nodes leave."""
    a, way = nodes[:-1] - (0.5 * _LENGTH, _BESIDE), np.diff(nodes, axis=0)
    share = np.clip(-(a * way).sum(axis=1) / (way**2).sum(axis=1), 0.0, 1.0)
    return float(np.linalg.norm(a + share[:, None] * way, axis=1).min()) - _APART


def _pinned(left: Any, right: Any) -> None:
    x = np.arange(10.0)
    before, behind = (np.column_stack((x + at, 0.0 * x)) for at in (-10.0, _LENGTH + 1.0))
    for nodes, label, color in (
        (_one_shot(_BESIDE), _SHOT, _PAPER), (_relaxed().nodes, _RELAXED, EGO),
    ):  # fmt: skip
        line = np.vstack((before, nodes, behind))
        heading = np.arctan2(*np.diff(line, axis=0).T[::-1])
        left.plot(0.5 * (line[1:, 0] + line[:-1, 0]), np.degrees(heading), color=color, label=label)
        a_y = _V**2 * np.diff(heading) / np.linalg.norm(np.diff(line, axis=0), axis=1)[1:]
        label += f": peak {np.abs(a_y).max():.1f} m/s²"
        right.plot(line[1:-1, 0], a_y, color=color, label=label)
    left.set(xlabel="along the route [m]", ylabel="heading against the route [°]")
    right.set(xlabel="along the route [m]", ylabel=f"lateral acceleration\nat {_V:g} m/s [m/s²]")


def _sides(left: Any, right: Any) -> None:
    measured = np.random.default_rng(1).normal(0.0, 0.05, 30)
    shots, bands = [_one_shot(d) for d in measured], [_relaxed(float(measured[0]))]
    for d in measured[1:].tolist():
        bands.append(_relaxed(d, previous=bands[-1]))
    for i, (shot, band) in enumerate(zip(shots, bands, strict=True)):
        names = ("", "") if i else (_SHOT, f"{_RELAXED} with previous")
        _plan(left, [(shot, names[0], _PAPER, "-"), (band.nodes, names[1], EGO, "-")], 0.0, linewidth=0.7)
    left.set_title("30 cycles, parked car measured with σ = 0.05 m", fontsize=10)
    t = 0.1 * np.arange(len(measured))
    right.plot(t, [_peak(shot[:, 1]) for shot in shots], ".-", color=_PAPER, label=_SHOT)
    right.plot(t, [_peak(band.displacement) for band in bands], ".-", color=EGO, label=f"{_RELAXED}")
    left.set_ylim(-3.2, 5.6)
    right.set(xlabel="time [s]", ylabel="peak displacement,\nleft positive [m]", ylim=(-3.2, 5.6))


def _peak(u: Array) -> float:
    return float(u[np.abs(u).argmax()])


def _clustering(left: Any, right: Any) -> None:
    bands = (_one_shot(-0.1), _SHOT, _PAPER, ".-"), (_relaxed(-0.1).nodes, _RELAXED, EGO, ".-")
    _plan(left, bands, -0.1, markersize=6.0, linewidth=0.8)
    left.set(xlim=(42.0, 58.0), ylim=(-1.6, 4.9))
    for nodes, label, color, _ in bands:
        right.plot(_route()[:, 0], nodes[:, 0] - _route()[:, 0], ".-", color=color, label=label)
    right.set(xlabel="along the route [m]", ylabel="shift along the route [m]", ylim=(-0.1, 0.15))


_DRAWERS = {
    "on the path": _on_the_path,
    "mesh": _mesh,
    "iteration": _flipping,
    "clearance": _short,
    "pins": _pinned,
    "sides": _sides,
    "clustering": _clustering,
}
DEFECTS = tuple(_DRAWERS)
"""What the one-shot band does wrong, as `plot_defect` takes it."""

"""Steering gains: the admissible region at one speed, and margins over speed."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cca_core._checks import shown
from cca_core.errors import InputError
from cca_core.follow import GainRegion, Margins, PreviewGains
from cca_core.plot.legends import legend_above
from cca_core.plot.style import COLORS, COLUMN_WIDTH, TEXT, new_figure, set_text_sizes

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_gain_region(region: GainRegion, shipped: PreviewGains | None = None) -> "Figure":
    """Draw the admissible gains at one speed.

    Parameters
    ----------
    region : GainRegion
        Result of `gain_region` at one speed.
    shipped : PreviewGains, optional
        Schedule whose gains at that speed are marked.

    Returns
    -------
    figure : Figure
        The plane of k_p and k_d: the admissible region, contours of the worst decay and of the worst
        damping ratio, and the selected gains.

    Raises
    ------
    InputError
        If `region` or `shipped` is of another type.
    MissingExtraError
        If matplotlib is not installed.
    """
    if not isinstance(region, GainRegion):
        raise InputError(f"region must be a GainRegion, the result of gain_region, was {shown(region)}")
    if shipped is not None and not isinstance(shipped, PreviewGains):
        raise InputError(f"shipped must be PreviewGains, was {shown(shipped)}")
    figure = new_figure(4.5, COLUMN_WIDTH)
    axis = figure.subplots()
    _draw_region(axis, region)
    if region.selected is not None:
        axis.plot(*region.selected, "o", color="black", label="selected")
    if shipped is not None:
        at_p, at_d, _ = shipped.at(region.v_x)
        axis.plot(at_p, at_d, "D", color="black", fillstyle="none", markersize=9, label="schedule")
    axis.fill_between([], [], color=COLORS.admissible, label="admissible")
    axis.plot([], [], color=COLORS.ego, linewidth=0.9, label="worst decay")
    axis.plot([], [], color=COLORS.second, linewidth=0.9, linestyle="--", label="worst damping ratio")
    axis.set_xlabel("gain on the error at the preview point k_p [rad/m]")
    axis.set_ylabel("gain on its rate k_d [rad s/m]")
    axis.set_title(f"{region.v_x:g} m/s, preview distance {region.l_s:g} m", loc="left")
    legend_above(axis, ncols=3)
    set_text_sizes(figure)
    return figure


def _draw_region(axis: Any, region: GainRegion) -> None:
    k_p, k_d = region.k_p, region.k_d
    # the reserve changes evenly over the grid, so its zero is a smooth edge
    reserve = np.minimum(region.decay - region.requested[0], region.damping - region.requested[1])
    axis.contourf(k_p, k_d, reserve, levels=[0.0, math.inf], colors=[COLORS.admissible])
    # around the admissible gains, or all stable ones; before the labels: their gaps depend on the view
    shown, scale = (reserve > 0.0, 1.35) if (reserve > 0.0).any() else (region.decay > 0.0, 1.05)
    if shown.any():
        axis.set(xlim=(0.0, scale * float(k_p[shown].max())), ylim=(0.0, scale * float(k_d[shown].max())))
    decays, dampings = (0.0, 0.5, 1.0, 1.5, 2.0), (0.2, 0.4, 0.6)  # [1/s], [-]
    curves = axis.contour(k_p, k_d, region.decay, levels=decays, colors=COLORS.ego, linewidths=0.9)
    axis.clabel(curves, fmt=lambda value: f"{value:g} 1/s", fontsize=TEXT.legend)
    style = {"colors": COLORS.second, "linewidths": 0.9, "linestyles": "--"}
    curves = axis.contour(k_p, k_d, region.damping, levels=dampings, **style)
    axis.clabel(curves, fmt=lambda value: f"{value:g}", fontsize=TEXT.legend)
    around = [np.append(each[-1], each[::-1, -1]) for each in (k_p, k_d)]
    axis.plot(*around, ":", color=COLORS.route, linewidth=0.9, label="edge of the search")


def plot_margins(margins: Sequence[Margins]) -> "Figure":
    """Draw the robustness of a gain schedule over speed.

    Parameters
    ----------
    margins : sequence of Margins
        Results of `stability_margins` at increasing speeds.

    Returns
    -------
    figure : Figure
        Gain margin, phase margin, delay margin and disk margin over speed.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    figure = new_figure(4.2, COLUMN_WIDTH)
    v = [m.v_x for m in margins]
    rows = (
        ("gain margin [-]", [m.gain for m in margins]),
        ("phase margin [°]", [math.degrees(m.phase) for m in margins]),
        ("delay margin [s]", [m.delay for m in margins]),
        ("disk margin [-]", [m.disk for m in margins]),
    )
    for axis, (name, values) in zip(figure.subplots(2, 2, sharex=True).flat, rows, strict=True):
        axis.plot(v, values, "o-", color=COLORS.ego, markersize=4)
        finite = [value for value in values if math.isfinite(value)]
        axis.set_ylim(0.0, 1.1 * max(finite, default=1.0))
        axis.set_ylabel(name)
        axis.grid(alpha=0.3)
        if axis.get_subplotspec().is_last_row():
            axis.set_xlabel("speed [m/s]")
    figure.suptitle("Stability margins", x=0.02, ha="left", fontsize=TEXT.heading)
    set_text_sizes(figure)
    figure.align_ylabels()
    return figure

"""Draw noisy_log.svg: what cleaning and fitting make of a noisy recording."""

from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

from cca_core import fit_path
from cca_core.path import clean_route

NOISE = 1.0  # [m]


def recording() -> np.ndarray:
    """Return a street with a curve, a stop with jitter, an outlier and a U-turn of 4 m."""
    rng = np.random.default_rng(4)
    phi = np.arange(0.1, 1.0, 0.1)
    curve = np.column_stack((120.0 + 70.0 * np.sin(phi), 70.0 * (1.0 - np.cos(phi))))
    end = curve[-1] + np.arange(8.0, 80.0, 8.0)[:, None] * [np.cos(0.95), np.sin(0.95)]
    out = np.vstack((np.column_stack((np.arange(0.0, 121.0, 8.0), np.zeros(16))), curve, end))
    back = end[::-1] + 4.0 * np.array([-np.sin(0.95), np.cos(0.95)])
    xy = np.vstack((out, back)) + rng.normal(0.0, NOISE, (len(out) + len(back), 2))
    xy[5, 1] += 12.0
    return np.vstack((xy[:12], xy[12] + rng.normal(0.0, 2.0, (30, 2)), xy[13:]))


def main() -> None:
    """Draw the picture next to this file."""
    xy = recording()
    route = clean_route(xy)
    part, rows = route.parts[0], route.rows[0]
    path = fit_path(part)
    gone = np.setdiff1d(np.arange(len(xy)), rows)
    mpl.rcParams.update({"svg.hashsalt": "noisy_log", "svg.fonttype": "none", "font.size": 9})
    fig, ax = plt.subplots(figsize=(4.8, 3.2), layout="constrained")
    ax.plot(*xy[gone].T, "x", color="tab:red", ms=4, label="dropped or thinned by clean_route")
    ax.plot(*part.T, "o", color="0.5", ms=3, label="waypoints")
    if path.fit_report is not None and len(path.fit_report.missed):
        ax.plot(
            *part[path.fit_report.missed].T,
            "o",
            mfc="none",
            color="tab:orange",
            ms=8,
            label="missed, and named",
        )
    ax.plot(*path.sample(0.5).T, color="tab:blue", lw=1.2, label="fit_path")
    ax.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    fig.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    file = Path(__file__).with_suffix(".svg")
    fig.savefig(file, metadata={"Date": None})


if __name__ == "__main__":
    main()

"""Draw radio_health.svg: rates of messages, the clock, and when the radio is trusted."""

from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

from cca_core import LocalFrame
from cca_core.v2x import Bsm, Tracker, TrackerHealth, encode_bsm

FRAME = LocalFrame(40.0, -83.0)
SENDERS, DURATION = 5, 30.0
STEP_AT, STEP = 10.0, 18.0  # the receiver's clock changes from UTC to GPS time [s]
WRONG = 20.0  # from here on one sender's clock is 3 s late [s]


def run() -> list[TrackerHealth]:
    """Health every 0.1 s of a receiver of five cars."""
    rng, tracker, health = np.random.default_rng(1), Tracker(FRAME), []
    for k in range(round(10.0 * DURATION)):
        t = 0.1 * k
        for i in range(SENDERS):
            late = 3.0 if i == 0 and t >= WRONG else 0.0
            lat, lon = FRAME.to_geodetic((40.0 * i + 20.0 * (t - late), 0.0))
            bsm = Bsm(
                msg_count=k % 128, id=f"{i:08x}", sec_mark=round((t - late) % 60.0, 3) % 60.0,
                latitude_deg=float(lat), longitude_deg=float(lon), speed=20.0, psi=0.0, a_x=0.0, r=0.0,
                transmission="forward", length=4.5, width=1.8,
            )  # fmt: skip
            now = t + (STEP if t >= STEP_AT else 0.0)
            tracker.update(encode_bsm(bsm), now + 0.02 + rng.exponential(0.01))
        health.append(tracker.health(now + 0.09))
    return health


def main() -> None:
    """Draw the picture next to this file."""
    health = run()
    t = 0.1 * np.arange(len(health)) + 0.09
    mpl.rcParams.update({"svg.hashsalt": "radio_health", "svg.fonttype": "none", "font.size": 9})
    fig, (rates, clock) = plt.subplots(2, 1, figsize=(4.8, 4.2), sharex=True, layout="constrained")
    rates.plot(t, [h.received for h in health], color="0.6", label="received")
    rates.plot(t, [h.accepted for h in health], color="tab:blue", label="accepted")
    for kind, color in (("replay", "tab:red"), ("future", "tab:orange"), ("out_of_order", "tab:purple")):
        rate = [dict(h.rejected).get(kind, 0.0) for h in health]
        if max(rate) > 0.0:
            rates.plot(t, rate, color=color, label=f"rejected: {kind}")
    rates.set_ylabel("messages per second")
    offset = [np.nan if h.clock_offset is None else h.clock_offset for h in health]
    clock.plot(t, offset, color="tab:green", label="clock_offset")
    clock.set_ylabel("offset [s]")
    clock.set_xlabel("time [s]")
    untrusted = np.array([not h.trusted for h in health])
    for ax in (rates, clock):
        low, high = ax.get_ylim()
        ax.fill_between(t, low, high, where=untrusted, color="tab:red", alpha=0.15, lw=0, label="not trusted")
        ax.set_ylim(low, high)
        ax.grid(alpha=0.3)
    handles = rates.get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    clock.annotate("clock + 18 s", (STEP_AT, 9.0), (STEP_AT + 2.5, 5.0), arrowprops={"arrowstyle": "->"})
    clock.annotate("one sender 3 s late", (WRONG, 18.0), (WRONG + 1.0, 12.0), arrowprops={"arrowstyle": "->"})
    fig.savefig(Path(__file__).with_suffix(".svg"), metadata={"Date": None})


if __name__ == "__main__":
    main()

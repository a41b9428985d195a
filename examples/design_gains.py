"""Steering gains for a car of your own: design over speed, margins, and a figure of the region."""

import argparse
import math
from pathlib import Path

from cca_core import VehicleParams
from cca_core.follow import StabilityRegion, design_gains, gain_region, stability_margins

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--out", type=Path, help="folder for figures (extra plot)")
out = parser.parse_args().out

vehicle = VehicleParams(m=1650.0, I_z=2900.0, l_f=1.25, l_r=1.55, C_f=95e3, C_r=125e3, length=4.7, width=1.85)
demands = StabilityRegion(decay=0.5, damping=0.4, mass=(1.0, 1.2), friction=(0.8, 1.0))
gains = design_gains(vehicle, [5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0], region=demands)
margins = [stability_margins(vehicle, gains, v, delay=demands.delay) for v in gains.speeds]

print("   v   l_s     k_p       k_d     gain  phase  delay  disk")
print(" m/s     m   rad/m   rad s/m        -    deg      s     -")
for k_p, k_d, l_s, m in zip(gains.k_p, gains.k_d, gains.l_s, margins, strict=True):
    print(f"{m.v_x:4.0f}{l_s:6.1f}{k_p:8.4f}{k_d:10.5f}", end="")
    print(f"{m.gain:9.2f}{math.degrees(m.phase):7.1f}{m.delay:7.2f}{m.disk:6.2f}")

if out:
    from cca_core.plot import plot_gain_region, plot_margins

    out.mkdir(parents=True, exist_ok=True)
    found = gain_region(vehicle, 20.0, gains.at(20.0)[2], demands)
    plot_gain_region(found, gains).savefig(out / "region.png")
    plot_margins(margins).savefig(out / "margins.png")

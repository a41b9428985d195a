"""Design of the preview gains by D-stability over a range of vehicles."""

import warnings
from collections.abc import Sequence

import numpy as np

from cca_core._checks import check_array, check_real
from cca_core.errors import InputError
from cca_core.follow.advice import no_gains, oversteer_text
from cca_core.follow.schedule import SPEEDS, PreviewGains
from cca_core.follow.stability_region import GainRegion, StabilityRegion, gain_region
from cca_core.vehicle import VehicleParams


def design_gains(
    vehicle: VehicleParams,
    speeds: Sequence[float] = SPEEDS,
    *,
    region: StabilityRegion | None = None,
    preview_time: float = 1.1,
    min_preview: float = 4.4,
) -> PreviewGains:
    """Schedule preview gains over speed.

    Parameters
    ----------
    vehicle : VehicleParams
        The vehicle.
    speeds : sequence of float
        Grid [m/s], positive, increasing.
    region : StabilityRegion, optional
        Requirements on the poles, range of vehicles, delay.
    preview_time : float
        Preview distance per speed [s].
    min_preview : float
        Preview distance at low speed [m].

    Returns
    -------
    gains : PreviewGains
        At each speed the admissible gains with the fastest decay for every vehicle in the range.

    Raises
    ------
    InputError
        If an argument is out of range.
    NoGainsError
        If no gains are admissible at some speed. It ends with the nearest region that works at all speeds
        (then its `max_speed` is infinite), or else with one that works up to its `max_speed`.

    Warns
    -----
    UserWarning
        If the vehicle oversteers, with its critical speed.

    Notes
    -----
    The design always selects the fastest decay. Calmer steering comes from a longer `preview_time`, which
    lowers the gains and the feasible decay. More damping, more delay or a wider range of vehicles in `region`
    have the same effect. A steering lag of zero counts as 1 ms.
    """
    if not isinstance(vehicle, VehicleParams):
        raise InputError(f"vehicle must be VehicleParams, was {type(vehicle).__name__}")
    grid = check_array("speeds", speeds, (None,))
    if not len(grid):
        raise InputError("speeds must not be empty")
    region = region or StabilityRegion()
    preview_time = check_real("preview_time", preview_time, gt=0.0)
    min_preview = check_real("min_preview", min_preview, ge=0.0)
    for v_x in grid.tolist():
        check_real("speeds", v_x, gt=0.0)
    if (np.diff(grid) <= 0.0).any():
        raise InputError("speeds must increase")

    def evaluate(v_x: float, region: StabilityRegion) -> GainRegion:
        return gain_region(vehicle, v_x, max(preview_time * v_x, min_preview), region)

    found = [evaluate(v_x, region) for v_x in grid.tolist()]
    selected = [each.selected for each in found if each.selected is not None]
    if len(selected) < len(found):
        raise no_gains(vehicle, region, found, evaluate)
    if oversteer := oversteer_text(vehicle, region):
        warnings.warn(oversteer, stacklevel=2)
    k_p, k_d = zip(*selected, strict=True)
    return PreviewGains(speeds=tuple(grid.tolist()), k_p=k_p, k_d=k_d, l_s=tuple(each.l_s for each in found))

"""What works where a design of gains fails: the nearest region, the highest speed, the critical speed."""

import math
from collections.abc import Callable, Sequence
from dataclasses import fields, replace

import numpy as np

from cca_core._checks import Array, Mask
from cca_core.errors import InfeasibleError
from cca_core.follow.stability_region import GainRegion, StabilityRegion
from cca_core.vehicle import MAX_SPEED, VehicleParams

_SLACK = 1.0 - 1e-9  # of rounded floats, so that a region just reached is kept [-]
_MIN_ADVICE = 0.1  # of decay and damping, below which a car swings for long [1/s, -]
_LOW_SPEED = 2.0  # at which a region is sought if none works at the requested speeds [m/s]

Evaluate = Callable[[float, StabilityRegion], GainRegion]


class NoGainsError(InfeasibleError):
    """Raised by `design_gains` if no gains keep the region at some speed.

    Parameters
    ----------
    message : str
        Which speed fails, why, and the region that works.
    result : GainRegion, optional
        Gains at the lowest speed that fails.
    region : StabilityRegion, optional
        Nearest region that works at all requested speeds up to `max_speed`; None if none was found.
    max_speed : float
        Speed up to which `region` works [m/s]; ``math.inf``, and never None, if it works at all requested
        speeds or if there is no `region`.
    """

    def __init__(
        self,
        message: str,
        result: GainRegion | None = None,
        region: StabilityRegion | None = None,
        max_speed: float = math.inf,
    ) -> None:
        super().__init__(message, result)
        self.region = region
        self.max_speed = max_speed


def no_gains(
    vehicle: VehicleParams, region: StabilityRegion, found: Sequence[GainRegion], evaluate: Evaluate
) -> NoGainsError:
    """Return the error of a design that fails, with the nearest region that works."""
    failed = next(each for each in found if each.selected is None)
    nearest, max_speed = nearest_region(found, region), math.inf
    if nearest is not None:
        advice = f"region={_typed(nearest)} works at all speeds"
    else:
        nearest, max_speed, limit = _highest_speed(found, region, evaluate)
        advice = f"no region with decay and damping of at least {_MIN_ADVICE:g} works at {limit:g} m/s"
        if nearest is not None:
            advice += f"; region={_typed(nearest)} works up to {max_speed:.15g} m/s"
    message = (
        f"no gains at {failed.v_x:g} m/s with a preview of {failed.l_s:g} m keep decay {region.decay:g} 1/s "
        f"and damping {region.damping:g} at once (alone they reach {failed.decay.max():.2f} and "
        f"{failed.damping.max():.2f}) for {region.mass[0]:g} to {region.mass[1]:g} times the mass, "
        f"{region.friction[0]:g} to {region.friction[1]:g} times the friction and a delay of "
        f"{region.delay:g} s; "
    )
    oversteer = oversteer_text(vehicle, region)
    return NoGainsError(message + (oversteer and f"{oversteer}; ") + advice, failed, nearest, max_speed)


def oversteer_text(vehicle: VehicleParams, region: StabilityRegion) -> str:
    """Return the critical speed of the worst vehicle in a region, in words; empty if none oversteers.

    The critical speed is sqrt(C_f C_r L^2 / (m (C_f l_f - C_r l_r))) = sqrt(L / -K) with the understeer
    gradient K (Rajamani, Vehicle Dynamics and Control, 2012, section 3.3).
    """
    gradient = min(car.understeer_gradient for car in region.vehicles(vehicle))
    if gradient >= 0.0 or vehicle.wheelbase / -gradient > MAX_SPEED**2:
        return ""
    return (
        f"the vehicle oversteers (C_f l_f > C_r l_r): above its critical speed, "
        f"{math.sqrt(vehicle.wheelbase / -gradient):.1f} m/s at {region.mass[1]:g} times the mass and "
        f"{region.friction[0]:g} times the friction, only the steering keeps "
        f"it stable"
    )


def nearest_region(found: Sequence[GainRegion], region: StabilityRegion) -> StabilityRegion | None:
    """Return the region with the least relative reduction of decay and damping that works at all speeds.

    Both are reduced by the same factor, the largest one that works; then each is raised as far as the other
    one permits, and rounded down to hundredths. None if one of them ends below a tenth.
    """
    decay, damping = max(each.requested[0] for each in found), region.damping
    factor = _SLACK * min(_reach(each, decay, damping) for each in found)
    if factor <= 0.0:
        return None
    kept = [each.decay >= min(factor * decay, each.requested[0]) for each in found]
    reached = min(_best(each.damping, mask) for each, mask in zip(found, kept, strict=True))
    new_damping = _rounded_down(reached, damping, damping)
    kept = [each.damping >= new_damping for each in found]
    reached = min(
        math.inf if (fastest := _best(each.decay, mask)) >= each.requested[0] else fastest
        for each, mask in zip(found, kept, strict=True)
    )
    new_decay = _rounded_down(reached, decay, region.decay)
    if new_damping < min(damping, _MIN_ADVICE) or new_decay < min(decay, _MIN_ADVICE):
        return None
    return replace(region, decay=new_decay, damping=new_damping)


def _highest_speed(
    found: Sequence[GainRegion], region: StabilityRegion, evaluate: Evaluate
) -> tuple[StabilityRegion | None, float, float]:
    """Return a region, the speed up to which it works [m/s], and the lowest speed at which none does."""
    n = next(i for i in range(len(found)) if nearest_region(found[: i + 1], region) is None)
    limit = found[n].v_x
    below = list(found[:n]) or [evaluate(v, region) for v in (_LOW_SPEED,) if v < limit]
    nearest = nearest_region(below, region) if below else None
    if nearest is None:
        return None, math.inf, limit
    low, high = below[-1].v_x, limit
    while math.floor(low) + 1 < high:  # whole speeds between them
        v = float(math.floor(0.5 * (math.floor(low) + math.ceil(high))))
        low, high = (v, high) if evaluate(v, nearest).selected is not None else (low, v)
    return nearest, low, limit


def _typed(region: StabilityRegion) -> str:
    """Return a region as it is typed: decay, damping and what differs from the defaults."""
    changed = (each.name for each in fields(region) if getattr(region, each.name) != each.default)
    values = {name: getattr(region, name) for name in dict.fromkeys(("decay", "damping", *changed))}
    plain = (f"{name}={each if isinstance(each, tuple) else float(each)}" for name, each in values.items())
    return f"StabilityRegion({', '.join(plain)})"


def _reach(found: GainRegion, decay: float, damping: float) -> float:
    """Return the largest factor of both requirements that some gains reach at this speed."""
    # at low speed the request is limited, and more than the limit is not needed
    enough = found.decay >= found.requested[0]
    factors = np.where(enough, math.inf, found.decay / decay if decay > 0.0 else -math.inf)
    if damping > 0.0:
        factors = np.minimum(factors, found.damping / damping)
    else:
        factors = np.where(found.damping >= 0.0, factors, -math.inf)
    return float(factors.max())


def _best(values: Array, mask: Mask) -> float:
    return float(np.where(mask, values, -math.inf).max())


def _rounded_down(reached: float, needed: float, requested: float) -> float:
    """Return the request if what it needs is reached, else what is reached in hundredths."""
    return requested if reached >= needed else math.floor(_SLACK * reached * 100.0) / 100.0

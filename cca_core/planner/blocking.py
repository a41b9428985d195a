"""Blocking vehicles: what is on the route or on a maneuver, and what follows the ego."""

from collections.abc import Collection, Sequence
from dataclasses import replace

from cca_core.frenet import FrenetEgo, FrenetVehicle
from cca_core.planner.maneuver import Maneuver
from cca_core.planner.tuning import LeadSettings


def blocks_offset(other: FrenetVehicle, d: float, ego: FrenetEgo, settings: LeadSettings) -> bool:
    """Return whether a vehicle leaves less than the blocking gap to an ego at a lateral offset."""
    return abs(other.d - d) < 0.5 * ego.vehicle.width + settings.blocking_gap + other.half_width


def blocking_vehicles(
    vehicles: Sequence[FrenetVehicle], ego: FrenetEgo, settings: LeadSettings, ignored: Collection[str]
) -> list[FrenetVehicle]:
    """Return the vehicles on the route whose front is not behind the ego's rear, nearest first."""
    found = [
        n for n in vehicles
        if n.front > ego.rear and blocks_offset(n, 0.0, ego, settings) and n.id not in ignored
    ]  # fmt: skip
    return sorted(found, key=lambda n: n.s)


def vehicles_on_maneuver(
    maneuver: Maneuver,
    vehicles: Sequence[FrenetVehicle],
    ego: FrenetEgo,
    settings: LeadSettings,
    followed: Collection[str],
    *,
    degraded: bool,
) -> list[FrenetVehicle]:
    """Return the vehicles to keep behind, nearest first: followed ones; if degraded, also on the maneuver."""
    kept = [n for n in vehicles if n.id in followed]
    if degraded:
        # nominal positions of stale ones: braking for their bounds endangers those that are being passed
        others = [n.nominal() if n.is_stale else n for n in vehicles if n not in kept]
        offset = maneuver.offset_at
        kept += [
            replace(n, d=n.d - offset(n.s)) for n in others if blocks_offset(n, offset(n.s), ego, settings)
        ]
    return sorted(kept, key=lambda n: n.s)


def excluding(vehicles: Sequence[FrenetVehicle], excluded: Sequence[FrenetVehicle]) -> list[FrenetVehicle]:
    """Return the vehicles without others of the same ids."""
    ids = {n.id for n in excluded}
    return [n for n in vehicles if n.id not in ids]

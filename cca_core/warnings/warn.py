"""Warnings of the V2V applications, for all other vehicles at once."""

from collections.abc import Iterable
from typing import Literal

from cca_core.path import Path, Road
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState
from cca_core.warnings.alert import Alert, AlertSettings
from cca_core.warnings.rules import (
    blind_spot,
    do_not_pass,
    emergency_brake_light,
    forward_collision,
    intersection,
    left_turn,
    stationary_ahead,
)
from cca_core.warnings.view import warning_view

__all__ = ["warn"]

_APPLICATIONS = (
    emergency_brake_light, forward_collision, intersection, left_turn, stationary_ahead, blind_spot, do_not_pass,
)  # fmt: skip


def warn(
    state: VehicleState,
    vehicle: VehicleParams,
    road: Path | Road,
    remotes: Iterable[RemoteVehicle],
    *,
    intent: Literal["left", "right"] | None = None,
    near: float | None = None,
    settings: AlertSettings | None = None,
) -> tuple[Alert, ...]:
    """Warn of other vehicles.

    Parameters
    ----------
    state : VehicleState
        The ego now.
    vehicle : VehicleParams
        Its body.
    road : Path or Road
        Its route; a path is one lane of 3.5 m.
    remotes : iterable of RemoteVehicle
        What is known of the others; what cannot be used is left out, of two with one id the younger counts.
    intent : {"left", "right"}, optional
        Where the ego means to turn or to change lanes, as by its indicator.
    near : float, optional
        Path coordinate close to the ego [m], such as last cycle's.
    settings : AlertSettings, optional
        Thresholds.

    Returns
    -------
    alerts : tuple of Alert
        The most urgent first: by level, then by time. Of one vehicle there may be several.

    Raises
    ------
    InputError
        If `road` is neither a path nor a road, or `intent` or `near` is not what it must be.

    Notes
    -----
    Distances are along the route and across it, so they hold in bends. The ego keeps its speed. Where the
    ways of two vehicles cross is found as in `crossing`.
    """
    settings = AlertSettings() if settings is None else settings
    ego, others = warning_view(state, vehicle, road, remotes, intent=intent, near=near, settings=settings)
    found = [application(ego, other, settings) for other in others for application in _APPLICATIONS]
    alerts = [alert for alert in found if alert is not None]
    return tuple(sorted(alerts, key=lambda alert: (-alert.level, alert.time_to_conflict, alert.vehicle_id)))

"""Warnings of all V2V applications because of all other vehicles."""

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

_APPLICATIONS = (
    emergency_brake_light, forward_collision, intersection, left_turn, stationary_ahead, blind_spot,
    do_not_pass,
)  # fmt: skip


def warn(
    state: VehicleState,
    vehicle: VehicleParams,
    road: Path | Road,
    remotes: Iterable[RemoteVehicle],
    *,
    intent: Literal["left", "right"] | None = None,
    s_guess: float | None = None,
    settings: AlertSettings | None = None,
) -> tuple[Alert, ...]:
    """Return the warnings that the other vehicles cause.

    Parameters
    ----------
    state : VehicleState
        The ego now.
    vehicle : VehicleParams
        The ego's body.
    road : Path or Road
        Its route; a path is one lane of 3.5 m.
    remotes : iterable of RemoteVehicle
        The other vehicles. Invalid ones are left out; of two with one id the one with the smaller age counts.
    intent : {"left", "right"}, optional
        Side to which the ego intends to turn or to change lanes, as by its indicator.
    s_guess : float, optional
        Station close to the ego [m], such as that of the last cycle.
    settings : AlertSettings, optional
        Thresholds.

    Returns
    -------
    alerts : tuple of Alert
        The most urgent first: by level, then by time. One vehicle may cause several.

    Raises
    ------
    InputError
        If `road` is neither a path nor a road, or `intent` or `s_guess` is invalid.

    Notes
    -----
    Distances are along and across the route, so they hold in curves. The ego keeps its speed. Conflicts are
    those of `find_conflict`.
    """
    settings = AlertSettings() if settings is None else settings
    view = warning_view(state, vehicle, road, remotes, intent=intent, s_guess=s_guess, settings=settings)
    found = [application(view, other, settings) for other in view.vehicles for application in _APPLICATIONS]
    alerts = [alert for alert in found if alert is not None]
    return tuple(sorted(alerts, key=lambda alert: (-alert.level, alert.time_to_conflict, alert.vehicle_id)))

"""The ego in SUMO, by libsumo or traci (extra ``sumo``)."""

import math
from dataclasses import replace
from typing import Any

from cca_core._checks import check_real
from cca_core._optional import require_extra
from cca_core.adapters.conversions import (
    MotionDifferences,
    compass_to_heading,
    convert_reference,
    heading_to_compass,
    shift_point,
)
from cca_core.adapters.local_origin import Origin, check_origin, find_origin
from cca_core.adapters.sumo_net import read_road
from cca_core.errors import InputError
from cca_core.path import Road
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

_MAX_ACCELERATION = 20.0  # that is passed on [m/s^2]; SUMO reports more where it inserts or teleports
_MIN_STEP = 1e-3  # of SUMO [s]


class SumoWorld:
    """A running SUMO whose ego the library drives.

    SUMO keeps the traffic; the ego is moved to where its plant is. All other drivers react to it.

    Parameters
    ----------
    ego_id : str
        The ego in SUMO. From now on SUMO neither changes its lane nor limits its speed.
    vehicle : VehicleParams
        The ego; SUMO's gets its length and width.
    connection : module or traci.connection.Connection, optional
        ``libsumo``, ``traci`` or one of its connections, started; the default is libsumo.
    radius : float
        Distance from the ego within which vehicles are returned [m].
    turn_distance : float, optional
        Distance along the road over which the change of SUMO's headings gives the yaw rate of a vehicle [m].
        SUMO reports none, and its lanes are polylines: twice the distance of their corners is a good value.
        By default yaw rates are zero.
    origin : tuple of float, optional
        Position in the net that is x = y = 0 here [m], such as `SumoNet.origin`. By default it is 0, or,
        more than 900 km from there, near the ego at whole kilometers.

    Attributes
    ----------
    origin : tuple of float
        Position in the net that is x = y = 0 here [m].

    Raises
    ------
    InputError
        If SUMO has no vehicle `ego_id` now, or a distance is out of range.
    MissingExtraError
        If libsumo is not installed.

    Notes
    -----
    Positions of SUMO are those of the middle of the front bumper, its angles are clockwise from north in
    degrees. Its coordinates less the origin are taken as the local frame.
    """

    def __init__(
        self,
        ego_id: str,
        vehicle: VehicleParams,
        *,
        connection: Any = None,
        radius: float = 300.0,
        turn_distance: float | None = None,
        origin: Origin | None = None,
    ) -> None:
        self.ego_id, self.vehicle = ego_id, vehicle
        self.connection = require_extra("libsumo", "sumo") if connection is None else connection
        self.radius = check_real("radius", radius, gt=0.0)
        cars = self.connection.vehicle
        if ego_id not in cars.getIDList():
            raise InputError(f"ego_id must be a vehicle that SUMO has inserted, was {ego_id!r}")
        if abs(cars.getLength(ego_id) - vehicle.length) > 1e-3:
            cars.setLength(ego_id, vehicle.length)
        if abs(cars.getWidth(ego_id) - vehicle.width) > 1e-3:
            cars.setWidth(ego_id, vehicle.width)
        cars.setSpeedMode(ego_id, 0)
        cars.setLaneChangeMode(ego_id, 0)
        self.turn_distance = turn_distance
        if turn_distance is not None:
            check_real("turn_distance", turn_distance, ge=0.0)
        self.origin = find_origin(*cars.getPosition(ego_id)) if origin is None else check_origin(origin)
        self._motions: dict[str, MotionDifferences] = {}
        self._ego = self.ego_state()
        self._others = self._vehicles()

    def read_road(self, *, length: float = math.inf) -> Road:
        """Road along the ego's route.

        Parameters
        ----------
        length : float
            Distance from the beginning of the ego's lane after which no further edge is added [m].

        Returns
        -------
        road : Road
            It follows the ego's lane and its connections through the junctions. It ends where the route ends,
            or where the front bumper is at the end of a lane that leaves the route. Its lanes are those of
            the edges and of the opposite edges, each as far as it goes along. Its speed limits are those of
            the edges.

        Raises
        ------
        InputError
            If the ego has left the net.
        InfeasibleError
            If no path fits the lanes.
        """
        check_real("length", length, gt=0.0, allow_inf=True)
        return read_road(self.connection, self.ego_id, length, self.vehicle.front, self.origin)

    def ego_state(self) -> VehicleState:
        """Motion of the ego in SUMO.

        Returns
        -------
        state : VehicleState
            Center of gravity now, without sideslip, yaw rate and acceleration.
        """
        x, y, psi, v = _read_pose(self.connection, self.ego_id, self.origin)
        x, y = convert_reference(x, y, psi, self.vehicle, "front_bumper", "center_of_gravity")
        return VehicleState(x=x, y=y, psi=psi, v_x=v)

    def remotes(self, age: float = 0.0) -> tuple[RemoteVehicle, ...]:
        """Other vehicles near the ego.

        Parameters
        ----------
        age : float
            Time since SUMO's last step, by which they are dead-reckoned [s]; for an ego that is driven in
            shorter steps than SUMO.

        Returns
        -------
        vehicles : tuple of RemoteVehicle
            True motion at the centers of their bodies, with the ids of SUMO. Pedestrians are not among them.
        """
        return tuple(_dead_reckon(other, age) for other in self._others)

    def move_ego(self, state: VehicleState) -> None:
        """Move SUMO's ego, with its next step, to a state.

        Parameters
        ----------
        state : VehicleState
            Motion of the center of gravity. Lanes and route are found by SUMO; the ego may be off its route.
        """
        x, y = convert_reference(
            state.x, state.y, state.psi, self.vehicle, "center_of_gravity", "front_bumper"
        )
        cars, angle = self.connection.vehicle, heading_to_compass(state.psi)
        x, y = x + self.origin[0], y + self.origin[1]
        cars.moveToXY(self.ego_id, "", -1, x, y, angle, keepRoute=2)
        cars.setSpeed(self.ego_id, max(state.v_x, 0.0))
        self._ego = state

    def step(self) -> bool:
        """Let SUMO make a step.

        Returns
        -------
        has_ego : bool
            Whether the ego is still in SUMO; it leaves at the end of its route.
        """
        self.connection.simulationStep()
        self._others = self._vehicles()
        return self.ego_id in self.connection.vehicle.getIDList()

    def _vehicles(self) -> list[RemoteVehicle]:
        """Return all vehicles but the ego within the radius."""
        names = [name for name in self.connection.vehicle.getIDList() if name != self.ego_id]
        found = [_read_vehicle(self.connection, name, self.origin) for name in names]
        near = [o for o in found if math.hypot(o.x - self._ego.x, o.y - self._ego.y) <= self.radius]
        if self.turn_distance is None:
            return near
        t, known, distance = self.connection.simulation.getTime(), self._motions, self.turn_distance
        self._motions = {
            o.id: known.get(o.id) or MotionDifferences(min_interval=_MIN_STEP, min_distance=distance)
            for o in near
        }
        return [replace(o, r=self._motions[o.id].update(t, o.x, o.y, o.psi, o.v_x).r) for o in near]


def _read_pose(connection: Any, name: str, origin: Origin) -> tuple[float, float, float, float]:
    """Return the middle of a vehicle's front bumper, its heading and its speed."""
    cars = connection.vehicle
    x, y = cars.getPosition(name)
    x, y = x - origin[0], y - origin[1]
    return x, y, compass_to_heading(cars.getAngle(name)), cars.getSpeed(name)


def _read_vehicle(connection: Any, name: str, origin: Origin) -> RemoteVehicle:
    """Return a vehicle at the center of its body."""
    x, y, psi, v = _read_pose(connection, name, origin)
    length, width = connection.vehicle.getLength(name), connection.vehicle.getWidth(name)
    a_x = max(min(connection.vehicle.getAcceleration(name), _MAX_ACCELERATION), -_MAX_ACCELERATION)
    x, y = shift_point(x, y, psi, -0.5 * length)
    return RemoteVehicle(id=name, x=x, y=y, psi=psi, v_x=v, a_x=a_x, length=length, width=width)


def _dead_reckon(vehicle: RemoteVehicle, age: float) -> RemoteVehicle:
    """Return a vehicle a fraction of a step later: straight on, at constant acceleration."""
    if age == 0.0:
        return vehicle
    v = max(vehicle.v_x + vehicle.a_x * age, 0.0)
    x, y = shift_point(vehicle.x, vehicle.y, vehicle.psi, 0.5 * (vehicle.v_x + v) * age)
    return replace(vehicle, x=x, y=y, v_x=v, age=age)

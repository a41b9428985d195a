"""Recorder of runs of a loop of one's own."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from cca_core._checks import Array, check_real, shown
from cca_core.errors import InputError, Status
from cca_core.follow import SpeedSettings
from cca_core.frenet import CROSSING_SINE
from cca_core.frenet.convert import valid_vehicles
from cca_core.path import Path, Road, interpolate_path
from cca_core.planner.command import Command
from cca_core.planner.inputs import first_station
from cca_core.planner.settings import EvasionSettings
from cca_core.sim.log import Log
from cca_core.sim.log_builder import EventRecorder, TrackingError, find_collision
from cca_core.sim.scenarios.road_user import RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.vehicle import RemoteVehicle, VehicleParams, VehicleState

_NODE_DISTANCE = 1.0  # between the nodes of a driven path, at least [m]


class Planned(Protocol):
    """What a recorder reads of a planner."""

    vehicle: VehicleParams
    road: Road
    cruise_speed: float


class Recorder:
    """Record of a run of a loop of one's own, for everything that takes a `Log`.

    Parameters
    ----------
    planner : Planner
        The planner of the run, or any object with its `vehicle`, `road` and `cruise_speed`. They are read
        once, and so are `evasion` and `speed`, if it has them; a run on a new route is a new record.
    name, case : str, optional
        Name and case of the run in figures and reports.
    ego_type : {"v2v", "driver", "sensor"}, optional
        Controller of the ego in figures and reports. By default it follows from the vehicles: ``"sensor"`` if
        all of them have the `RemoteVehicle.source` ``"sensor"``, else ``"v2v"``.

    Raises
    ------
    InputError
        If `planner` lacks a vehicle, a road or a cruise speed, or the ego type is unknown.

    Notes
    -----
    The road users of the log are the vehicles that the ego knew, in the cycles in which it knew them:
    by their messages (`Log.tracked`) or by the sensor (`Log.visible`), as `RemoteVehicle.source` states.
    The scenario of the log describes the run when it began, and each road user when it appeared. One that
    appeared next to the road or heads across it has the path that it drove as its route.

    Examples
    --------
    >>> from cca_core import Planner, RemoteVehicle, VehicleParams, VehicleState
    >>> from cca_core.path import interpolate_path
    >>> route = interpolate_path([[0.0, 0.0], [500.0, 0.0]])
    >>> planner = Planner(VehicleParams.bmw_320i(), route, cruise_speed=15.0)
    >>> recorder = Recorder(planner, name="straight on")
    >>> van = RemoteVehicle(id="van", x=120.0, y=0.0, psi=0.0, v_x=15.0)
    >>> for k in range(50):
    ...     state = VehicleState(x=20.0 + 0.3 * k, y=0.0, psi=0.0, v_x=15.0)
    ...     command = planner.step(0.02 * k, state, [van])
    ...     recorder.add(0.02 * k, state, [van], command)
    >>> recorder.log()
    Log(straight on, v2v, recorded, 0.98 s)
    """

    def __init__(
        self,
        planner: Planned,
        *,
        name: str = "own run",
        case: str | None = None,
        ego_type: str | None = None,
    ) -> None:
        kinds: dict[str, type] = {"vehicle": VehicleParams, "road": Road}
        wrong = [each for each, kind in kinds.items() if not isinstance(getattr(planner, each, None), kind)]
        if wrong or not hasattr(planner, "cruise_speed"):
            raise InputError(
                "planner must have vehicle, road and cruise_speed as a Planner has, "
                f"{shown(planner)} has no such {' and '.join(wrong) or 'cruise_speed'}"
            )
        settings: dict[str, Any] = {
            each: getattr(planner, each)
            for each, kind in (("evasion", EvasionSettings), ("speed", SpeedSettings))
            if isinstance(getattr(planner, each, None), kind)
        }
        path = planner.road.path
        self._scenario = Scenario(
            name=str(name), case=case, road=planner.road, vehicle=planner.vehicle, start=path.start, v_x=0.0,
            cruise_speed=planner.cruise_speed, road_users=(),
            ego_type="v2v" if ego_type is None else ego_type, **settings,
        )  # fmt: skip
        self._has_type = ego_type is not None
        self._rows: list[tuple[float, ...]] = []  # columns as in `add`
        self._remotes: list[tuple[RemoteVehicle, ...]] = []
        self._frenet: list[list[tuple[float, float]]] = []  # of each of these
        self._stations: dict[str, float] = {}
        self._events = EventRecorder()
        self._tracking: TrackingError | None = None

    def __len__(self) -> int:
        return len(self._rows)

    def add(
        self,
        t: float,
        state: VehicleState,
        remotes: Iterable[RemoteVehicle],
        command: Command,
        *,
        a_y: float | None = None,
        awareness_range: float = math.inf,
    ) -> None:
        """Record a cycle: what `Planner.step` was given, and what it returned.

        Parameters
        ----------
        t : float
            Time [s], later than that of the last cycle.
        state : VehicleState
            The ego's motion.
        remotes : iterable of RemoteVehicle
            The other vehicles. They come and go by their ids. A record that the planner drops, because it is
            invalid, is left out.
        command : Command
            The command of this cycle.
        a_y : float, optional
            Lateral acceleration of the center of gravity [m/s^2], left positive. By default it is computed
            from speed, yaw rate and the change of the lateral speed.
        awareness_range : float
            Awareness range that the planner was given [m].

        Raises
        ------
        InputError
            If `t` does not increase, or a value has the wrong type or is not a number. The cycle is not
            recorded then.
        """
        t = self._check_time(t)
        if not isinstance(state, VehicleState):
            raise InputError(f"state must be a VehicleState, was {shown(state)}")
        if not isinstance(command, Command):
            raise InputError(f"command must be a Command, was {shown(command)}")
        reference: object = command.reference
        if not isinstance(reference, Path):
            raise InputError(f"command.reference must be a Path, was {shown(reference)}")
        steering, a_x = check_real("command.delta", command.delta), check_real("command.a_x", command.a_x)
        lateral = math.nan if a_y is None else check_real("a_y", a_y)
        known = check_real("awareness_range", awareness_range, ge=0.0, allow_inf=True)
        vehicles = _vehicles(remotes)
        path = self._scenario.road.path
        guess = self._rows[-1][12] if self._rows else first_station(path, state)
        s, d, _, _ = path.foot_point(state.x, state.y, guess)
        self._tracking = self._tracking or TrackingError(path, s)
        self._rows.append((
            t, state.x, state.y, state.psi, state.v_x, state.v_y, state.r, state.delta, state.a_x, lateral,
            steering, a_x, s, d, self._tracking.error(state, reference, (s, d)), known,
            command.status is not Status.OK,
        ))  # fmt: skip
        self._remotes.append(tuple(vehicles.values()))
        self._frenet.append(self._project(vehicles))
        self._events.record(
            t, state, command, vehicles.values(), [v.id for v in vehicles.values() if v.source != "v2v"],
            [(v.id, abs(v.v_x), v.a_x, False) for v in vehicles.values()],
            find_collision(
                self._scenario.vehicle, state,
                ((v.id, v.x, v.y, v.psi, v.length, v.width) for v in vehicles.values()),
            ),
        )  # fmt: skip

    def _check_time(self, t: float) -> float:
        t = check_real("t", t)
        if self._rows and t <= self._rows[-1][0]:
            raise InputError(f"t must be later than the last cycle at {self._rows[-1][0]!r} s, was {t!r} s")
        return t

    def _project(self, vehicles: dict[str, RemoteVehicle]) -> list[tuple[float, float]]:
        """Return station and lateral offset of each vehicle on the route [m]."""
        path, found = self._scenario.road.path, []
        for vehicle_id, vehicle in vehicles.items():
            guess = self._stations.get(vehicle_id)
            if guess is None:
                guess = float(path.project((vehicle.x, vehicle.y))[0])
            found.append(path.foot_point(vehicle.x, vehicle.y, guess)[:2])
        self._stations = dict(zip(vehicles, (s for s, _ in found), strict=True))
        return found

    def log(self) -> Log:
        """Return the log of all cycles recorded so far.

        Returns
        -------
        log : Log
            The run. Plant, seed, messages and run times are not known of a recorded run, and None or empty.

        Raises
        ------
        InputError
            If fewer than two cycles are recorded.
        """
        if len(self._rows) < 2:
            raise InputError(f"add must be called at least twice before log, was called {len(self)} times")
        rows = np.array(self._rows)
        t, ego = rows[:, 0], rows[:, 1:9]
        a_y = np.where(np.isnan(rows[:, 9]), ego[:, 3] * ego[:, 5] + np.gradient(ego[:, 4], t), rows[:, 9])
        ids = dict.fromkeys(vehicle.id for vehicles in self._remotes for vehicle in vehicles)
        index = {vehicle_id: i for i, vehicle_id in enumerate(ids)}
        users = np.full((len(rows), len(ids), 8), np.nan)
        sources = np.zeros((2, len(rows), len(ids)), dtype=bool)  # sensor, messages
        last: dict[str, RemoteVehicle] = {}
        for k, (vehicles, frenet) in enumerate(zip(self._remotes, self._frenet, strict=True)):
            for v, (s, d) in zip(vehicles, frenet, strict=True):
                i = index[v.id]
                users[k, i] = v.x, v.y, v.psi, v.v_x, v.a_x, v.r, s, d
                sources[int(v.source == "v2v"), k, i] = True
                last[v.id] = v
        road_users = tuple(
            self._road_user(last[vehicle_id], users[:, i], connected=bool(sources[1, :, i].any()))
            for vehicle_id, i in index.items()
        )
        path = self._scenario.road.path
        has_sensor_alone = bool(road_users) and not any(user.connected for user in road_users)
        ego_type = "sensor" if has_sensor_alone and not self._has_type else self._scenario.ego_type
        scenario = replace(
            self._scenario, ego_type=ego_type, road_users=road_users, duration=float(t[-1] - t[0]),
            v_x=max(float(ego[0, 3]), 0.0), start=min(max(float(rows[0, 12]), path.start), path.end),
        )  # fmt: skip
        return Log(
            scenario=scenario, plant=None, seed=None, t=t, ego=ego, a_y=a_y, command=rows[:, 10:12],
            ego_frenet=rows[:, 12:14], tracking=rows[:, 14], road_users=users[..., :4],
            user_motion=users[..., 4:6], user_frenet=users[..., 6:], visible=sources[0], tracked=sources[1],
            gap_held=np.zeros(len(rows), dtype=bool), decisions=tuple(self._events.decisions),
            events=tuple(self._events.events), received=(), messages={}, degraded=rows[:, 16] != 0.0,
            cycle_us=None, wall_s=None, reasons=tuple(self._events.reasons), remotes=tuple(self._remotes),
            awareness_range=rows[:, 15], cycle_reasons=tuple(self._events.cycle_reasons),
        )  # fmt: skip

    def _road_user(self, last: RemoteVehicle, rows: Array, *, connected: bool) -> RoadUser:
        """Return a vehicle as it appeared, with the size that it reported last."""
        rows = rows[np.isfinite(rows[:, 0])]
        _, _, psi, v, _, _, s, d = rows[0].tolist()
        road, half = self._scenario.road, 0.5 * last.width
        angle = psi - float(road.path.heading(s))
        is_on_road = road.right_edge - half < d < road.left_edge + half
        route = None
        if not is_on_road or abs(math.sin(angle)) > CROSSING_SINE:
            route, s, d, angle = _driven_path(rows[:, :2], psi), 0.0, 0.0, 0.0
        along = v * math.cos(angle) if v and route is None else math.cos(angle)
        return RoadUser(
            id=last.id, s=s, d=d, v_x=abs(v), direction=1 if along >= 0.0 else -1, length=last.length,
            width=last.width, route=route, connected=connected,
        )  # fmt: skip


def _vehicles(remotes: object) -> dict[str, RemoteVehicle]:
    """Return the valid vehicles by id, as the planner uses them."""
    if not isinstance(remotes, Iterable) or isinstance(remotes, (str, bytes)):
        raise InputError(f"remotes must be an iterable of RemoteVehicle, was {shown(remotes)}")
    given = list(remotes)
    for each in given:
        if not isinstance(each, RemoteVehicle):
            raise InputError(f"remotes must be an iterable of RemoteVehicle, held {shown(each)}")
    return valid_vehicles(given)[0]


def _driven_path(xy: Array, psi: float) -> Path:
    """Return the path through positions, or straight ahead from the first one if there is no other."""
    nodes = [xy[0]]
    for point in xy:
        if np.hypot(*(point - nodes[-1])) >= _NODE_DISTANCE:
            nodes.append(point)
    if len(nodes) == 1:
        nodes.append(xy[0] + 10.0 * np.array((math.cos(psi), math.sin(psi))))
    return interpolate_path(nodes)

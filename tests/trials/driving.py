"""Closed loop and message link on which the cases of `faults.py` run.

The ego is driven by `Planner` on `SingleTrackPlant` at 50 Hz; the gap between boxes is computed here, not by
the library. `Radio` makes 10 Hz message bytes of true vehicles and gives what `Tracker` makes of them.
Nothing to run here.
"""

# fmt: off

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from cca_core import (
    EvasionSettings,
    LocalFrame,
    Path,
    Planner,
    RemoteVehicle,
    Road,
    VehicleParams,
    VehicleState,
    fit_path,
)
from cca_core.sim import SingleTrackPlant
from cca_core.v2x import Bsm, Tracker, encode_bsm

CAR = VehicleParams.bmw_320i()
CYCLE = 0.02  # [s]
EPOCH = 1200.0  # senders' time when the drive begins [s]
ROAD_HEIGHT = 200.0  # of the ego's road [m]
OWN_ID = "000000ee"  # of the ego's own messages
World = Callable[[float, VehicleState], Sequence[RemoteVehicle]]


def remote(name: str, x: float, y: float, v_x: float = 0.0, psi: float = 0.0, **more) -> RemoteVehicle:
    """Another vehicle."""
    return RemoteVehicle(id=name, x=x, y=y, psi=psi, v_x=v_x, **more)


def straight(length: float = 2000.0) -> Path:
    """Straight path along +x."""
    return fit_path([(x, 0.0) for x in np.arange(0.0, length + 1.0, 10.0)])


def bend(radius: float, run_in: float = 200.0, angle: float = 2.3, left: bool = True) -> Path:
    """Straight for `run_in` meters, then a circular bend that begins at x = 0."""
    a = np.linspace(0.0, angle, max(int(radius * angle / 4.0), 12))[1:]
    side = 1.0 if left else -1.0
    before = [(x, 0.0) for x in np.arange(-run_in, 1.0, 4.0)]
    turn = [(radius * math.sin(p), side * radius * (1.0 - math.cos(p))) for p in a]
    return fit_path(before + turn, tolerance=0.03)


def at(path: Path, name: str, s: float, d: float = 0.0, v_x: float = 0.0, **more) -> RemoteVehicle:
    """Another vehicle at place (s, d) of a path; it heads against the path if `oncoming` is true."""
    x, y = path.to_cartesian(s, d)
    psi = float(path.heading(s)) + (math.pi if more.pop("oncoming", False) else 0.0)
    return remote(name, float(x), float(y), v_x, psi, **more)


def pose_on(path: Path, s: float, v_x: float, d: float = 0.0) -> VehicleState:
    """State of an ego at place (s, d) of a path that heads along it."""
    x, y = path.to_cartesian(s, d)
    return VehicleState(x=float(x), y=float(y), psi=float(path.heading(s)), v_x=v_x)


def along(v_x: float, x: float = 100.0, y: float = 0.0) -> VehicleState:
    """State of an ego that heads along +x."""
    return VehicleState(x=x, y=y, psi=0.0, v_x=v_x)


def cruise(road: Road, v: float, evasion: EvasionSettings | None = None, car: VehicleParams = CAR) -> Planner:
    """Planner of an ego that wants a speed."""
    return Planner(car, road, cruise_speed=v, evasion=evasion)


def corners(x: float, y: float, psi: float, length: float, width: float) -> np.ndarray:
    """Corners of a box, counter-clockwise."""
    along = 0.5 * length * np.array((math.cos(psi), math.sin(psi)))
    across = 0.5 * width * np.array((-math.sin(psi), math.cos(psi)))
    return np.array((x, y)) + np.array((along + across, across - along, -along - across, along - across))


def box_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Distance between two boxes given by their corners [m]; 0 if they overlap."""
    apart, least = False, math.inf
    for one, other in ((a, b), (b, a)):
        begin, edge = one, np.roll(one, -1, axis=0) - one
        size = np.hypot(edge[:, 0], edge[:, 1])
        to = other[None, :, :] - begin[:, None, :]
        along = (to * edge[:, None, :]).sum(2) / size[:, None]
        outwards = (to[:, :, 0] * edge[:, None, 1] - to[:, :, 1] * edge[:, None, 0]) / size[:, None]
        apart = apart or bool((outwards.min(axis=1) > 0.0).any())
        beyond = along - np.clip(along, 0.0, size[:, None])
        least = min(least, float(np.hypot(beyond, outwards).min()))
    return least if apart else 0.0


def gap(state: VehicleState, others: Iterable[RemoteVehicle], car: VehicleParams = CAR) -> float:
    """Least distance between the ego's box and those of others within 40 m [m]; else infinite."""
    c, s = math.cos(state.psi), math.sin(state.psi)
    x, y = state.x + car.box_offset * c, state.y + car.box_offset * s
    near = [o for o in others if math.hypot(o.x - x, o.y - y) < 40.0 + 0.5 * o.length]
    if not near:
        return math.inf
    ego = corners(x, y, state.psi, car.length, car.width)
    return min(box_distance(ego, corners(o.x, o.y, o.psi, o.length, o.width)) for o in near)


@dataclass
class Drive:
    """What happened, a row for each cycle: t, s, d, v, command a_x, a_y, gap, action, status, reason."""

    rows: list[tuple] = field(default_factory=list)
    command: object = None
    blind: bool = False  # whether the link told before any contact that it cannot be relied on

    def column(self, name: str) -> list:
        """One quantity of all cycles."""
        i = ("t", "s", "d", "v", "a_x", "a_y", "gap", "action", "status", "reason").index(name)
        return [row[i] for row in self.rows]

    def least(self, name: str) -> float:
        """Least value of a quantity."""
        return min(self.column(name))

    def largest(self, name: str) -> float:
        """Largest magnitude of a quantity."""
        return max(map(abs, self.column(name)))

    def last(self, name: str):
        """Value at the end."""
        return self.column(name)[-1]

    @property
    def actions(self) -> list[str]:
        """Actions in their order, repetitions left out."""
        names = self.column("action")
        return [name for i, name in enumerate(names) if i == 0 or name != names[i - 1]]


def drive(
    planner: Planner, state: VehicleState, world: World, duration: float, *, car: VehicleParams = CAR,
    radio: "Radio | None" = None, clock: Callable[[float], float] = lambda t: t,
    sensed: Callable[[float, VehicleState], VehicleState | None] = lambda t, state: state,
    told: Callable[[float, Sequence[RemoteVehicle]], Sequence[RemoteVehicle]] = lambda t, true: true,
) -> Drive:
    """Drive until the time is over or a box is touched.

    `world` gives the true others at a time; `told` (or `radio`) what is known of them; `clock` the planner's
    time; `sensed` the state that is handed to the planner.
    """
    plant, path, run = SingleTrackPlant(car, state), planner.road.path, Drive()
    s = float(path.project((state.x, state.y))[0])
    for k in range(round(duration / CYCLE)):
        t, state = k * CYCLE, plant.state
        true = list(world(t, state))
        awareness_range = math.inf
        if radio is None:
            known = told(t, true)
        else:
            known = radio.known(t, state, true)
            if radio.is_blind(t):
                run.blind, awareness_range = True, 0.0
        command = planner.step(clock(t), sensed(t, state), known, awareness_range=awareness_range)
        s, d, _, _ = path.foot_point(state.x, state.y, s)
        distance, decision = gap(state, true, car), command.decision
        run.rows.append((
            t, s, d, state.v_x, command.a_x, plant.a_y, distance, decision.action.name, command.status.name,
            decision.reason,
        ))
        run.command = command
        if distance <= 0.0:
            break
        plant.step(command.delta, command.a_x, CYCLE)
    return run


class Radio:
    """Messages of others ten times a second, 20 ms late, into a tracker.

    Parameters
    ----------
    clock : float
        By how much the receiver's clock is ahead of the senders' [s].
    sender : callable
        Temporary identity under which a vehicle sends at a time; None where nothing arrives.
    fields : callable
        Fields of the message that differ from the true ones, for a vehicle and a time.
    echo : bool
        Whether the ego's own message comes back as well.
    """

    def __init__(
        self, *, clock: float = 0.0, sender: Callable = lambda vehicle, t: vehicle.id,
        fields: Callable = lambda vehicle, t: {}, echo: bool = False,
    ) -> None:
        self.frame = LocalFrame(40.0, -83.0)
        self.clock, self.sender, self.fields, self.echo = clock, sender, fields, echo
        self.count, self.due = 0, 0.0
        # Hand OWN_ID and ROAD_HEIGHT over here once the library takes them; today it does not.
        self.tracker = Tracker(self.frame)

    def is_blind(self, t: float) -> bool:
        """Tell whether the tracker says that silence means nothing; change here if it says so otherwise."""
        return self.tracker.is_saturated(EPOCH + t + self.clock)

    def known(self, t: float, state: VehicleState, true: Sequence[RemoteVehicle]) -> Sequence[RemoteVehicle]:
        """Send what is due and return all tracks."""
        now = EPOCH + t + self.clock
        if t >= self.due - 1e-9:
            self.due += 0.1
            self.count += 1
            for i, vehicle in enumerate(true):
                name = self.sender(vehicle, t)
                if name is not None:
                    moment = EPOCH + t - 0.013 * i
                    self.tracker.update(self.message(vehicle, moment, name, self.count + 17 * i, t), now + 0.02)
            if self.echo:
                own = remote(
                    OWN_ID, state.x, state.y, state.v_x, state.psi, a_x=state.a_x, length=CAR.length, width=CAR.width
                )
                self.tracker.update(self.message(own, EPOCH + t, OWN_ID, self.count, t), now + 0.02)
        return self.tracker.vehicles(now, state)

    def message(self, vehicle: RemoteVehicle, moment: float, name: str, count: int, t: float) -> bytes:
        """Bytes of one message."""
        lat, lon = self.frame.to_geodetic((vehicle.x, vehicle.y))
        content = {
            "msg_count": count % 128, "id": name, "sec_mark": round(moment % 60.0 * 1000.0) % 60000 / 1000.0,
            "latitude_deg": float(lat), "longitude_deg": float(lon), "elevation": ROAD_HEIGHT,
            "speed": abs(vehicle.v_x), "psi": math.remainder(vehicle.psi, 2.0 * math.pi), "a_x": vehicle.a_x,
            "r": vehicle.r, "length": vehicle.length, "width": vehicle.width,
            "transmission": "reverse" if vehicle.v_x < 0.0 else "forward",
        }
        return encode_bsm(Bsm(**{**content, **self.fields(vehicle, t)}))

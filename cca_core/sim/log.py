"""Log of a run, cycle by cycle, and its metrics."""

from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from cca_core._checks import Array, Mask, check_real
from cca_core.decide import Action
from cca_core.geometry import Boxes, box_gap
from cca_core.sim.export import decision_index, run_columns, write_mcap, write_table
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.vehicle import RemoteVehicle


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Log:
    """One run, cycle by cycle.

    Parameters
    ----------
    scenario : Scenario
        Road, ego and road users of the run.
    plant : str or None
        Name of the ego's plant; None in a recorded run.
    seed : int or None
        Seed of the senders' phases and of the channel; None in a recorded run.
    t : ndarray, shape (n,)
        Time [s].
    ego : ndarray, shape (n, 8)
        x [m], y [m], psi [rad], v_x [m/s], v_y [m/s], r [rad/s], delta [rad], a_x [m/s^2].
    a_y : ndarray, shape (n,)
        Lateral acceleration of the center of gravity [m/s^2], left positive.
    command : ndarray, shape (n, 2)
        Commanded road-wheel angle [rad] and acceleration [m/s^2].
    ego_frenet : ndarray, shape (n, 2)
        Frenet coordinates s, d of the ego's center of gravity [m].
    tracking : ndarray, shape (n,)
        Lateral error to the reference path [m], left positive.
    road_users : ndarray, shape (n, n_users, 4)
        x [m], y [m], psi [rad], v_x [m/s] of the road users' body centers; NaN in cycles in which one is not
        `present`.
    user_motion : ndarray, shape (n, n_users, 2)
        Their acceleration [m/s^2] and yaw rate [rad/s].
    user_frenet : ndarray, shape (n, n_users, 2)
        Frenet coordinates s, d of the road users' body centers [m].
    visible, tracked : ndarray of bool, shape (n, n_users)
        Whether each road user is in the ego's line of sight, and whether the ego has a track of it from
        messages.
    gap_held : ndarray of bool, shape (n,)
        Whether the fixed time gap was kept instead of the command's acceleration.
    decisions : tuple of (float, str, str)
        Time [s], action and reason at each change of action.
    events : tuple of (float, str, str)
        Time [s], kind and vehicle of each event, once each: ``"first_visible"``, ``"first_received"``,
        ``"hazard_received"`` (first message of hard braking), ``"brakes"``, ``"stopped"``,
        ``"lateral_shift"``, ``"gap_released"`` (the ego's fixed time gap), ``"collision"``, ``"overlap"``
        (of a road user with another one).
    received : tuple of (int, bytes)
        Cycle and content of every message that arrived at the ego.
    messages : dict
        Number of messages that the road users ``"sent"``, that were ``"delivered"`` to the ego, and of the
        ego's own ``"ego_sent"`` and ``"ego_delivered"``.
    degraded : ndarray of bool, shape (n,)
        Whether the command's status was not `OK`.
    cycle_us : ndarray or None, shape (n,)
        Wall-clock time of each planner cycle [us]; differs between equal runs. None in a recorded run.
    wall_s : float or None
        Wall-clock time of the whole run [s]; None in a recorded run.
    missed_deadlines : int
        Number of cycles of a real-time run that ended after their deadline.
    reasons : tuple of (str, str)
        Activity and cause of each of `decisions`, as in `Decision`; none in a log of a file without them.
    cycle_reasons : tuple of str
        Reason of the command of each cycle; none in a log of a file without them.
    remotes : tuple of tuple of RemoteVehicle, optional
        Vehicles that the controller was given in each cycle of a recorded run (`Recorder`). In a simulated
        run they follow from `received` and `visible`.
    awareness_range : ndarray, shape (n,), optional
        Awareness range that it was given then [m].
    overlaps : tuple of (float, str, str, float)
        The first overlap of each pair of road users in a simulated run, which do not collide: time [s], id of
        the one that drives into the other, id of the other, and magnitude of the difference of both
        velocities [m/s]. What follows means little.
    """

    scenario: Scenario
    plant: str | None
    seed: int | None
    t: Array
    ego: Array
    a_y: Array
    command: Array
    ego_frenet: Array
    tracking: Array
    road_users: Array
    user_motion: Array
    user_frenet: Array
    visible: Mask
    tracked: Mask
    gap_held: Mask
    decisions: tuple[tuple[float, str, str], ...]
    events: tuple[tuple[float, str, str], ...]
    received: tuple[tuple[int, bytes], ...]
    messages: dict[str, int]
    degraded: Mask
    cycle_us: Array | None
    wall_s: float | None
    missed_deadlines: int = 0
    reasons: tuple[tuple[str, str], ...] = ()
    cycle_reasons: tuple[str, ...] = ()
    remotes: tuple[tuple[RemoteVehicle, ...], ...] | None = None
    awareness_range: Array | None = None
    overlaps: tuple[tuple[float, str, str, float], ...] = ()

    def __repr__(self) -> str:
        scenario = self.scenario
        collision = f", collision with {self.collided_with}" if self.collided_with else ""
        source = "recorded" if self.plant is None else f"{self.plant}, seed {self.seed}"
        return (
            f"Log({' '.join(filter(None, (scenario.name, scenario.case)))}, {scenario.ego_type}, "
            f"{source}, {self.duration:.2f} s{collision})"
        )

    @property
    def duration(self) -> float:
        """Time from the first to the last cycle [s]."""
        return float(self.t[-1] - self.t[0])

    @property
    def present(self) -> Mask:
        """Whether each road user takes part in each cycle, shape (n, n_users); in a simulation all do."""
        return np.isfinite(self.road_users[..., 0])

    @property
    def collision_row(self) -> int | None:
        """Cycle of the first collision, the last one of a simulated run; None if there was none."""
        rows = np.flatnonzero((self.gaps() <= 0.0).any(axis=1))
        return int(rows[0]) if len(rows) else None

    @property
    def collided_with(self) -> str:
        """Id of the road user that the ego collided with; empty if there was no collision."""
        return next((name for _, kind, name in self.events if kind == "collision"), "")

    def gaps(self) -> Array:
        """Signed distance between the boxes of the ego and of each road user.

        Returns
        -------
        gaps : ndarray, shape (n, n_users)
            Distance [m], negative if the boxes overlap; infinite while a road user is not `present`.
        """
        gaps: Array = np.where(self.present, box_gap(*self.bodies()), np.inf)
        return gaps

    def bodies(self) -> tuple[Boxes, Boxes]:
        """Boxes of the ego and of the road users.

        Returns
        -------
        ego, road_users : Boxes
            Fields of shape (n, 1) and (n, n_users); NaN while a road user is not `present`.
        """
        vehicle, users = self.scenario.vehicle, self.scenario.road_users
        x, y, psi = self.ego[:, 0:1], self.ego[:, 1:2], self.ego[:, 2:3]
        ego = vehicle.body_at(x, y, psi)
        others = Boxes(
            self.road_users[..., 0], self.road_users[..., 1], self.road_users[..., 2],
            np.array([u.length for u in users]), np.array([u.width for u in users]),
        )  # fmt: skip
        return ego, others

    def time_to_collision(self) -> Array:
        """Time to collision at constant speeds.

        Returns
        -------
        ttc : ndarray, shape (n,)
            Minimum over all road users that overlap the ego laterally and come closer [s]; infinite if there
            is none.
        """
        vehicle, users = self.scenario.vehicle, self.scenario.road_users
        size = np.array([(u.length, u.width) for u in users]).reshape(-1, 2)
        along = self.user_frenet[..., 0] - self.ego_frenet[:, None, 0]
        lateral = np.abs(self.user_frenet[..., 1] - self.ego_frenet[:, None, 1])
        gap = np.abs(along) - 0.5 * (vehicle.length + size[:, 0])
        heading = self.scenario.road.path.heading(self.user_frenet[..., 0])
        v_s = self.road_users[..., 3] * np.cos(self.road_users[..., 2] - heading)
        closing = (self.ego[:, None, 3] - v_s) * np.sign(along)
        relevant = (lateral < 0.5 * (vehicle.width + size[:, 1])) & (closing > 0.1) & (gap > 0.0)
        ttc = np.where(relevant, gap / np.where(relevant, closing, 1.0), np.inf)
        first: Array = ttc.min(axis=1, initial=np.inf)
        return first

    def closing_speed(self) -> float:
        """Relative speed of the ego and the nearest road user at the collision, or else in the last cycle.

        Returns
        -------
        speed : float
            Magnitude of the difference of both velocities [m/s], the severity of a collision; 0 without road
            users.
        """
        gaps, row = self.gaps(), self.collision_row
        row = len(gaps) - 1 if row is None else row
        if not np.isfinite(gaps[row]).any():
            return 0.0
        _, _, psi, v = self.road_users[row, int(np.argmin(gaps[row]))].tolist()
        ego = self.ego[row]
        velocity = (ego[3] + 1j * ego[4]) * np.exp(1j * ego[2])
        return float(abs(velocity - v * np.exp(1j * psi)))

    def time_of(self, event: str, vehicle_id: str = "ego") -> float:
        """First time of an event.

        Parameters
        ----------
        event : str
            Kind of event, as in `events`.
        vehicle_id : str
            Id of a road user, or ``"ego"``.

        Returns
        -------
        t : float
            Time [s]; infinite if it did not happen.
        """
        return next((t for t, kind, name in self.events if (kind, name) == (event, vehicle_id)), np.inf)

    @property
    def actions(self) -> list[str]:
        """Names of the actions in order, one for each change."""
        return [name for _, name, _ in self.decisions]

    def columns(self) -> dict[str, np.ndarray[Any, Any]]:
        """Everything that changes from cycle to cycle, for example for ``pandas.DataFrame``.

        Returns
        -------
        columns : dict of ndarray, shape (n,)
            In SI units, by name. Columns of a road user begin with its id and a dot; their numbers are NaN
            while it is not `present`.
        """
        return run_columns(self)

    def to_table(self, path: str | FilePath) -> None:
        """Write `columns` to a file, a row for each cycle.

        Parameters
        ----------
        path : str or pathlib.Path
            File to write. Its ending is ``.csv``, in which unknown numbers are empty and numbers read back
            exactly, or ``.parquet``.

        Raises
        ------
        InputError
            If the ending is another one.
        MissingExtraError
            If pyarrow is needed and not installed (extra ``parquet``).
        """
        write_table(run_columns(self), path)

    def to_mcap(self, path: str | FilePath, *, start_time: float = 0.0) -> None:
        """Write the run to an MCAP file, which Foxglove and other viewers show.

        Parameters
        ----------
        path : str or pathlib.Path
            File to write, as a rule ``.mcap``.
        start_time : float
            Time at t = 0 on the clock of the file [s], such as UTC since 1970.

        Raises
        ------
        InputError
            If a time would be negative in the file.
        MissingExtraError
            If mcap is not installed (extra ``mcap``).

        Notes
        -----
        Messages are JSON with a schema: ``/ego/pose`` (center of gravity), ``/vehicles`` (boxes of the ego
        and of all road users), ``/command``, ``/diagnostics``, ``/decisions`` (each change of action with its
        reason) and ``/events``.
        """
        write_mcap(self, path, check_real("start_time", start_time))

    def summary(self) -> dict[str, Any]:
        """Key figures of the run.

        Returns
        -------
        summary : dict
            One entry of ``summary.json``: outcome, gaps [m], time to collision [s], accelerations [m/s^2],
            tracking error [m], actions with their times [s], overlaps, cycle times [us]; None where unknown.
        """
        gaps = self.gaps()
        row = self.collision_row
        collided = row is not None
        nearest = self.scenario.road_users[int(np.argmin(gaps[row]))].id if collided else None
        jerk = np.abs(np.diff(self.ego[:, 7])) / np.diff(self.t)
        evading = np.array([Action(name).is_evading for name in self.actions])[decision_index(self)]
        return {
            "scenario": self.scenario.name,
            "case": self.scenario.case,
            "ego": self.scenario.ego_type,
            "v2v": self.scenario.v2v,
            "plant": self.plant,
            "seed": self.seed,
            "collided": collided,
            "collided_with": nearest,
            "closing_speed_mps": _rounded(self.closing_speed()) if collided else None,
            "min_gap_m": _rounded(gaps.min(initial=np.inf)),
            "min_ttc_s": _rounded(self.time_to_collision().min()),
            "max_abs_ay_mps2": _rounded(np.abs(self.a_y).max()),
            "max_decel_mps2": _rounded(max(0.0, -self.ego[:, 7].min())),
            "max_jerk_mps3": _rounded(jerk.max(initial=0.0)),
            "max_tracking_error_m": _rounded(np.abs(self.tracking).max()),
            "max_offset_m": _rounded(np.abs(self.ego_frenet[:, 1]).max()),
            "evading_s": _rounded(float(np.sum(np.diff(self.t)[evading[:-1]]))),
            "actions": [[round(t, 2), name] for t, name, _ in self.decisions],
            "events": [[round(t, 2), kind, vehicle_id] for t, kind, vehicle_id in self.events],
            "overlaps": [[round(t, 2), *ids, round(speed, 3)] for t, *ids, speed in self.overlaps],
            "messages": dict(self.messages),
            "missed_deadlines": self.missed_deadlines,
            "duration_s": _rounded(self.duration),
            "realtime_factor": None if self.wall_s is None else _rounded(self.duration / self.wall_s, 1),
            "cycle_us": None
            if self.cycle_us is None
            else {
                "median": _rounded(np.median(self.cycle_us), 0),
                "p99": _rounded(np.percentile(self.cycle_us, 99.0), 0),
                "max": _rounded(self.cycle_us.max(), 0),
            },
        }


def _rounded(value: Any, digits: int = 3) -> float | None:
    return round(float(value), digits) if np.isfinite(value) else None

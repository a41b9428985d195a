"""What the ego knows of others: message bytes through a radio channel, or the vehicle in front by sight."""

from dataclasses import replace

import numpy as np

from cca_core._checks import Array
from cca_core.path import LocalFrame
from cca_core.sim.scenario import RoadUser, Scenario
from cca_core.v2x import Channel, ChannelSettings, Sender, SenderSettings, Tracker
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["Radio", "Sight"]

_ORIGIN = 41.3, -105.6  # of the plane in which all runs take place: latitude and longitude [deg]


class Radio:
    """Each road user sends its state as bytes ten times a second; the ego tracks what arrives.

    Parameters
    ----------
    scenario : Scenario
        Road users and channel.
    rng : numpy.random.Generator
        Source of chance: phases of the senders, losses and delays of the channel.
    """

    def __init__(self, scenario: Scenario, rng: np.random.Generator) -> None:
        frame = LocalFrame(*_ORIGIN)
        self._users = scenario.users
        self._names = {f"{i:08x}": user.id for i, user in enumerate(scenario.users, 1)}
        self._senders = [Sender(name, frame, SenderSettings(), rng) for name in self._names]
        self._channel = Channel(scenario.channel or ChannelSettings(latency=scenario.latency), rng)
        self.tracker = Tracker(frame)

    def receive(self, t: float, poses: Array, acceleration: Array, ego: VehicleState) -> list[RemoteVehicle]:
        """Let all send, and take in what has arrived.

        Parameters
        ----------
        t : float
            Now [s].
        poses : ndarray, shape (n_users, 4)
            x, y [m], psi [rad] and speed [m/s] of the road users.
        acceleration : ndarray, shape (n_users,)
            Their accelerations [m/s^2].
        ego : VehicleState
            The receiver.

        Returns
        -------
        remotes : list of RemoteVehicle
            All that are tracked, by the names of the road users.
        """
        for sender, user, pose, a_x in zip(self._senders, self._users, poses, acceleration, strict=True):
            data = sender.poll(t, record(user, pose, float(a_x), "v2v"))
            if data is not None:
                self._channel.send(t, (float(pose[0]), float(pose[1])), data, sender=sender.id)
        for arrival in self._channel.receive(t, (ego.x, ego.y)):
            self.tracker.update(arrival.data, t)
        return [replace(v, id=self._names[v.id]) for v in self.tracker.vehicles(t, ego)]


class Sight:
    """The ego sees the vehicle in front of it on its lane, and nothing else.

    Parameters
    ----------
    scenario : Scenario
        Road users and the range of the sensor.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario

    def receive(self, poses: Array, acceleration: Array, places: Array, ego_s: float) -> list[RemoteVehicle]:
        """Look ahead.

        Parameters
        ----------
        poses : ndarray, shape (n_users, 4)
            x, y [m], psi [rad] and speed [m/s] of the road users.
        acceleration : ndarray, shape (n_users,)
            Their accelerations [m/s^2].
        places : ndarray, shape (n_users, 2)
            Their path coordinates s and d [m].
        ego_s : float
            Path coordinate of the ego [m].

        Returns
        -------
        remotes : list of RemoteVehicle
            The one in front, if it is within range.
        """
        users = self._scenario.users
        ahead = [
            (places[i, 0], i)
            for i, user in enumerate(users)
            if 0.0 < places[i, 0] - ego_s < self._scenario.sensor_range and abs(user.d) < 1.0
        ]
        if not ahead:
            return []
        i = min(ahead)[1]
        return [record(users[i], poses[i], float(acceleration[i]), "sensor")]


def record(user: RoadUser, pose: Array, a_x: float, source: str) -> RemoteVehicle:
    """Return a road user as it is now.

    Parameters
    ----------
    user : RoadUser
        Its name and size.
    pose : ndarray, shape (4,)
        x, y [m], psi [rad] and speed [m/s].
    a_x : float
        Its acceleration [m/s^2].
    source : str
        ``"v2v"`` or ``"sensor"``.

    Returns
    -------
    remote : RemoteVehicle
        Without error or age.
    """
    x, y, psi, v_x = pose.tolist()
    return RemoteVehicle(
        id=user.id, x=x, y=y, psi=psi, v_x=v_x, a_x=a_x, length=user.length, width=user.width, source=source
    )

"""What can be seen from the ego: range, field of view, and bodies that hide others."""

import cmath
import math
from collections import deque
from collections.abc import Sequence

from cca_core.geometry import wrap_angle
from cca_core.sim.scenarios.road_user import RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.v2x import Fix, dead_reckon
from cca_core.vehicle import RemoteVehicle, VehicleState

__all__ = ["Sensor", "visible_fraction"]

_Body = tuple[float, float, float, float, float]
_CORNERS = (complex(0.5, 0.5), complex(-0.5, 0.5), complex(-0.5, -0.5), complex(0.5, -0.5))
_RECOGNIZED = 0.5  # share of a face that must be seen
_EYE = 0.25  # share of the ego's length that the eye is ahead of the middle of the body


class Sensor:
    """Line of sight to each road user, and what a sensor reports of it.

    It reports true states with a delay, under the road users' own ids (perfect association), dead-reckoned to
    now; the eye is behind the windscreen, a quarter of the ego's length ahead of its middle.

    Parameters
    ----------
    scenario : Scenario
        Road users, range, field of view, weather and delay.

    Attributes
    ----------
    delay : float
        Age of what it reports [s]; 0 for a driver, whose reaction is elsewhere.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._users, self._vehicle = scenario.road_users, scenario.vehicle
        self._occluders = list(scenario.occluders)
        self._range = min(scenario.sensor_range, scenario.visibility)
        self._half = 0.5 * scenario.field_of_view
        self.delay = scenario.sensor_delay if scenario.ego_type != "driver" else 0.0
        self._frames: deque[tuple[float, Sequence[Sequence[float]], Sequence[bool]]] = deque()

    def visible(self, rows: Sequence[Sequence[float]], ego: VehicleState) -> list[bool]:
        """Tell who is seen.

        Parameters
        ----------
        rows : sequence of sequence of float
            x, y [m], psi [rad], ... of the middle of each road user.
        ego : VehicleState
            The ego now.

        Returns
        -------
        seen : list of bool
            Whether half of the face of each is in sight, in the field of view and within range.
        """
        vehicle, ahead = self._vehicle, cmath.exp(1j * ego.psi)
        middle = complex(*vehicle.center_at(ego.x, ego.y, ego.psi))
        eye = middle + _EYE * vehicle.length * ahead
        bodies = [(r[0], r[1], r[2], u.length, u.width) for r, u in zip(rows, self._users, strict=True)]
        seen = []
        for i, body in enumerate(bodies):
            to = complex(body[0], body[1])
            if abs(to - middle) >= self._range:
                seen.append(False)
                continue
            hiding = bodies[:i] + bodies[i + 1 :] + self._occluders
            seen.append(visible_fraction(eye, ego.psi, self._half, body, hiding) >= _RECOGNIZED)
        return seen

    def detections(
        self, t: float, rows: Sequence[Sequence[float]], seen: Sequence[bool]
    ) -> list[RemoteVehicle]:
        """Take in what is seen now, and report what was seen a delay ago.

        Parameters
        ----------
        t : float
            Now [s].
        rows : sequence of sequence of float
            x, y [m], psi [rad], speed [m/s], acceleration [m/s^2], yaw rate [rad/s] of each road user; kept,
            so that they must not change afterward.
        seen : sequence of bool
            Who is seen, as by `look`; kept likewise.

        Returns
        -------
        remotes : list of RemoteVehicle
            Vehicles with source ``"sensor"`` and the delay as age.
        """
        self._frames.append((t, rows, seen))
        while len(self._frames) > 1 and self._frames[1][0] <= t - self.delay + 1e-9:
            self._frames.popleft()
        then, rows, seen = self._frames[0]
        if then > t - self.delay + 1e-9:
            return []
        users = zip(self._users, rows, seen, strict=True)
        return [_moved(u, row, then, t) for u, row, is_seen in users if is_seen]


def visible_fraction(
    eye: complex, psi: float, half_angle: float, body: _Body, others: Sequence[_Body]
) -> float:
    """Share of the face of a body that can be seen.

    Parameters
    ----------
    eye : complex
        x + iy of the eye [m].
    psi : float
        Direction in which it looks [rad].
    half_angle : float
        Half its field of view [rad].
    body : tuple of float
        x, y [m], psi [rad], length, width [m] of the body looked at.
    others : sequence of tuple of float
        The bodies that may hide it, likewise; those that overlap it do not.

    Returns
    -------
    share : float
        Of the angle under which the body appears, the part that is in the field of view and not hidden [-].
    """
    to = cmath.phase(complex(body[0], body[1]) - eye)
    low, high = _outline(eye, to, body)
    size = high - low
    if size <= 0.0 or size >= math.pi:
        return 1.0
    off = wrap_angle(to - psi)
    hidden = [(low, min(-half_angle - off, high)), (max(half_angle - off, low), high)]
    for other in others:
        apart = wrap_angle(cmath.phase(complex(other[0], other[1]) - eye) - to)
        if abs(apart) > 0.75 * math.pi:
            continue
        start, end = (angle + apart for angle in _outline(eye, to + apart, other))
        start, end = max(start, low), min(end, high)
        if start < end:
            ray = cmath.exp(1j * (to + 0.5 * (start + end)))
            if _distance(eye, ray, other) < _distance(eye, ray, body):
                hidden.append((start, end))
    covered, until = 0.0, low
    for start, end in sorted(hidden):
        if end > max(start, until):
            covered += end - max(start, until)
            until = end
    return 1.0 - covered / size


def _outline(eye: complex, to: float, body: _Body) -> tuple[float, float]:
    """Angles of the outermost corners of a body, relative to the direction `to` of its middle."""
    x, y, psi, length, width = body
    turn, middle = cmath.exp(1j * psi), complex(x, y) - eye
    back = cmath.exp(-1j * to)
    angles = [
        cmath.phase((middle + turn * complex(c.real * length, c.imag * width)) * back) for c in _CORNERS
    ]
    return min(angles), max(angles)


def _distance(eye: complex, ray: complex, body: _Body) -> float:
    """Distance along a ray at which it enters a body; infinite if it misses it."""
    x, y, psi, length, width = body
    back = cmath.exp(-1j * psi)
    start, way = (eye - complex(x, y)) * back, ray * back
    first, last = 0.0, math.inf
    for at, speed, half in ((start.real, way.real, 0.5 * length), (start.imag, way.imag, 0.5 * width)):
        if abs(speed) < 1e-12:
            if abs(at) > half:
                return math.inf
            continue
        near, far = sorted(((-half - at) / speed, (half - at) / speed))
        first, last = max(first, near), min(last, far)
    return first if first <= last else math.inf


def _moved(user: RoadUser, row: Sequence[float], then: float, t: float) -> RemoteVehicle:
    """Dead-reckon what was seen."""
    fix = dead_reckon(Fix(then, *row), t)
    return RemoteVehicle(
        id=user.id, x=fix.x, y=fix.y, psi=fix.psi, v_x=fix.v, a_x=fix.a, r=fix.r, length=user.length,
        width=user.width, age=t - then, source="sensor",
    )  # fmt: skip

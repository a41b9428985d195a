"""Sensor of the ego: range, field of view and occlusion."""

import cmath
import math
from collections import deque
from collections.abc import Sequence

from cca_core.geometry import wrap_angle
from cca_core.sim.scenarios.road_user import RoadUser
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.v2x import Fix, dead_reckon
from cca_core.vehicle import RemoteVehicle, VehicleState

_Body = tuple[float, float, float, float, float]
_CORNERS = (complex(0.5, 0.5), complex(-0.5, 0.5), complex(-0.5, -0.5), complex(0.5, -0.5))


class Sensor:
    """Line of sight to each road user, and detections of the visible ones.

    Detections are true states with a delay, dead-reckoned to now, under the road users' own ids (perfect
    association). The eye is behind the windscreen, a quarter of the ego's length ahead of its center.

    Parameters
    ----------
    scenario : Scenario
        Road users, range, field of view, weather and delay.

    Attributes
    ----------
    delay : float
        Age of detections [s]; 0 for a driver, whose reaction time is modeled elsewhere.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._users, self._vehicle = scenario.road_users, scenario.vehicle
        self._occluders = list(scenario.occluders)
        self._range = min(scenario.sensor_range, scenario.visibility)
        self._half = 0.5 * scenario.field_of_view
        self.delay = scenario.sensor_delay if scenario.ego_type != "driver" else 0.0
        self._frames: deque[tuple[float, Sequence[Sequence[float]], Sequence[bool]]] = deque()

    def visible(self, rows: Sequence[Sequence[float]], ego: VehicleState) -> list[bool]:
        """Return which road users are visible.

        Parameters
        ----------
        rows : sequence of sequence of float
            x, y [m], psi [rad], ... of the center of each road user.
        ego : VehicleState
            The ego now.

        Returns
        -------
        visible : list of bool
            Whether half of the angular width of each is not occluded, in the field of view and within range.
        """
        vehicle, ahead = self._vehicle, cmath.exp(1j * ego.psi)
        middle = complex(*vehicle.center_at(ego.x, ego.y, ego.psi))
        eye = middle + 0.25 * vehicle.length * ahead
        bodies = [(r[0], r[1], r[2], u.length, u.width) for r, u in zip(rows, self._users, strict=True)]
        visible = []
        for i, body in enumerate(bodies):
            to = complex(body[0], body[1])
            if abs(to - middle) >= self._range:
                visible.append(False)
                continue
            occluders = bodies[:i] + bodies[i + 1 :] + self._occluders
            visible.append(visible_fraction(eye, ego.psi, self._half, body, occluders) >= 0.5)
        return visible

    def detections(
        self, t: float, rows: Sequence[Sequence[float]], visible: Sequence[bool]
    ) -> list[RemoteVehicle]:
        """Record the states now, and return the detections of a delay ago.

        Parameters
        ----------
        t : float
            Now [s].
        rows : sequence of sequence of float
            x, y [m], psi [rad], speed [m/s], acceleration [m/s^2], yaw rate [rad/s] of each road user.
            They are stored: do not change them afterward.
        visible : sequence of bool
            Result of `visible`; stored likewise.

        Returns
        -------
        remotes : list of RemoteVehicle
            Vehicles with source ``"sensor"`` and the delay as age.
        """
        self._frames.append((t, rows, visible))
        while len(self._frames) > 1 and self._frames[1][0] <= t - self.delay + 1e-9:
            self._frames.popleft()
        then, rows, visible = self._frames[0]
        if then > t - self.delay + 1e-9:
            return []
        users = zip(self._users, rows, visible, strict=True)
        return [_moved(u, row, then, t) for u, row, is_visible in users if is_visible]


def visible_fraction(
    eye: complex, psi: float, half_angle: float, body: _Body, others: Sequence[_Body]
) -> float:
    """Visible fraction of the angular width of a body.

    Parameters
    ----------
    eye : complex
        x + iy of the eye [m].
    psi : float
        Direction of view [rad].
    half_angle : float
        Half its field of view [rad].
    body : tuple of float
        x, y [m], psi [rad], length, width [m] of the body.
    others : sequence of tuple of float
        Bodies that may occlude it, likewise; those that overlap it do not.

    Returns
    -------
    fraction : float
        Part of the angle of the body that is in the field of view and not occluded [-].
    """
    to = cmath.phase(complex(body[0], body[1]) - eye)
    low, high = _outline(eye, to, body)
    size = high - low
    if size <= 0.0 or size >= math.pi:
        return 1.0
    off = wrap_angle(to - psi)
    occluded = [(low, min(-half_angle - off, high)), (max(half_angle - off, low), high)]
    for other in others:
        apart = wrap_angle(cmath.phase(complex(other[0], other[1]) - eye) - to)
        if abs(apart) > 0.75 * math.pi:
            continue
        start, end = (angle + apart for angle in _outline(eye, to + apart, other))
        start, end = max(start, low), min(end, high)
        if start < end:
            ray = cmath.exp(1j * (to + 0.5 * (start + end)))
            if _distance(eye, ray, other) < _distance(eye, ray, body):
                occluded.append((start, end))
    covered, until = 0.0, low
    for start, end in sorted(occluded):
        if end > max(start, until):
            covered += end - max(start, until)
            until = end
    return 1.0 - covered / size


def _outline(eye: complex, to: float, body: _Body) -> tuple[float, float]:
    """Return the angles of the outermost corners of a body, relative to the direction of its center."""
    x, y, psi, length, width = body
    turn, middle = cmath.exp(1j * psi), complex(x, y) - eye
    back = cmath.exp(-1j * to)
    angles = [
        cmath.phase((middle + turn * complex(c.real * length, c.imag * width)) * back) for c in _CORNERS
    ]
    return min(angles), max(angles)


def _distance(eye: complex, ray: complex, body: _Body) -> float:
    """Return the distance along a ray to a body; infinite if it misses."""
    x, y, psi, length, width = body
    back = cmath.exp(-1j * psi)
    start, course = (eye - complex(x, y)) * back, ray * back
    first, last = 0.0, math.inf
    for at, speed, half in ((start.real, course.real, 0.5 * length), (start.imag, course.imag, 0.5 * width)):
        if abs(speed) < 1e-12:
            if abs(at) > half:
                return math.inf
            continue
        near, far = sorted(((-half - at) / speed, (half - at) / speed))
        first, last = max(first, near), min(last, far)
    return first if first <= last else math.inf


def _moved(user: RoadUser, row: Sequence[float], then: float, t: float) -> RemoteVehicle:
    """Dead-reckon a detection."""
    fix = dead_reckon(Fix(then, *row), t)
    return RemoteVehicle(
        id=user.id, x=fix.x, y=fix.y, psi=fix.psi, v_x=fix.v, a_x=fix.a, r=fix.r, length=user.length,
        width=user.width, age=t - then, source="sensor",
    )  # fmt: skip

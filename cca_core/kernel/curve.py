"""A path of cubics over arc length, straight beyond both ends, and foot points of positions on it."""

import math
from typing import Annotated

from cca_core.kernel.box_gaps import norm
from cca_core.kernel.types import Grid, Int, Real, Reals, floor_within

__all__ = [
    "Curve",
    "CurveSamples",
    "curvature_at",
    "curve_point",
    "curve_points",
    "foot_point",
    "foot_points",
    "nearest_point",
    "nearest_points",
]

MAX_ITERATIONS = 12  # Newton converges in 2 to 4; positions far off a tight curve need more
STEP_TOLERANCE = 1e-9  # of the arc length [m]
BISECTIONS = 50
SMALLEST_SPEED = 1e-90  # of a degenerate segment, which has no direction; its cube is no zero [-]
FAR = 50.0  # from the last position, beyond which the next one is searched anew [m]
MAX_HALVINGS = 32  # of an interval of whole numbers

Breaks = Annotated[Reals, "segments + 1"]
Cubics = Annotated[Grid, "segments", 8]
Samples = Annotated[Reals, "count"]
Row = Annotated[Reals, "n"]
Points = Annotated[Grid, "n", 2]


class Curve:
    """A path. The kernel only reads it, so threads may share it."""

    segments: Int
    breaks: Breaks
    powers: Cubics  # ax, ay, bx, by, cx, cy, dx, dy of each, over meters from its break


class CurveSamples:
    """Points of a path from its first to its last one, for the search of the nearest one."""

    count: Int
    stride: Int  # between the samples that are compared first
    max_gap: Real  # bound of the length of the curve between two samples [m]
    s: Samples
    x: Samples
    y: Samples


def segment_at(curve: Curve, s: Real) -> Int:
    """Segment in which an arc length on the path lies."""
    low = 1
    high = curve.segments
    for _ in range(MAX_HALVINGS):
        if low >= high:
            break
        middle = (low + high) // 2
        if s < curve.breaks[middle]:
            high = middle
        else:
            low = middle + 1
    return low - 1


def curve_point(curve: Curve, s: Real) -> tuple[Real, Real, Real, Real, Real, Real]:
    """Position x, y [m], first and second derivative by arc length."""
    on = min(max(s, curve.breaks[0]), curve.breaks[curve.segments])
    i = segment_at(curve, on)
    powers = curve.powers
    t = on - curve.breaks[i]
    x = ((powers[i, 0] * t + powers[i, 2]) * t + powers[i, 4]) * t + powers[i, 6]
    y = ((powers[i, 1] * t + powers[i, 3]) * t + powers[i, 5]) * t + powers[i, 7]
    dx = (3.0 * powers[i, 0] * t + 2.0 * powers[i, 2]) * t + powers[i, 4]
    dy = (3.0 * powers[i, 1] * t + 2.0 * powers[i, 3]) * t + powers[i, 5]
    if s == on:
        return (
            x,
            y,
            dx,
            dy,
            6.0 * powers[i, 0] * t + 2.0 * powers[i, 2],
            6.0 * powers[i, 1] * t + 2.0 * powers[i, 3],
        )
    return x + (s - on) * dx, y + (s - on) * dy, dx, dy, 0.0, 0.0


def curve_points(curve: Curve, n: Int, s: Row, position: Points, first: Points, second: Points) -> None:
    """Positions, first and second derivatives at n arc lengths."""
    for i in range(n):
        position[i, 0], position[i, 1], first[i, 0], first[i, 1], second[i, 0], second[i, 1] = curve_point(
            curve, s[i]
        )


def curvature_of(dx: Real, dy: Real, ddx: Real, ddy: Real) -> Real:
    """Signed curvature from derivatives [1/m]."""
    speed = max(norm(dx, dy), SMALLEST_SPEED)
    return (dx * ddy - dy * ddx) / (speed * speed * speed)


def curvature_at(curve: Curve, s: Real) -> Real:
    """Signed curvature at an arc length [1/m]."""
    _, _, dx, dy, ddx, ddy = curve_point(curve, s)
    return curvature_of(dx, dy, ddx, ddy)


def foot_point(curve: Curve, x: Real, y: Real, s_guess: Real) -> tuple[Real, Real, Real, Real]:
    """Foot point by Newton's method from an initial guess: s, d [m], heading [rad] and curvature [1/m]."""
    s = s_guess
    px, py, dx, dy, ddx, ddy = curve_point(curve, s)
    for _ in range(MAX_ITERATIONS):
        speed2 = dx * dx + dy * dy
        out = (px - x) * dx + (py - y) * dy
        bend = (px - x) * ddx + (py - y) * ddy
        step = out / max(speed2 + bend, 0.2 * speed2, SMALLEST_SPEED)
        if -STEP_TOLERANCE < step < STEP_TOLERANCE:
            break
        s -= step
        px, py, dx, dy, ddx, ddy = curve_point(curve, s)
    d = (dx * (y - py) - dy * (x - px)) / max(norm(dx, dy), SMALLEST_SPEED)
    return s, d, math.atan2(dy, dx), curvature_of(dx, dy, ddx, ddy)


def foot_point_at_sample(curve: Curve, samples: CurveSamples, x: Real, y: Real, i: Int) -> tuple[Real, Real]:
    """Foot point s, d next to a sample; where Newton leaves the sample's interval, by bisection in it."""
    last = samples.count - 1
    low = samples.s[max(i - 1, 0)]
    high = samples.s[min(i + 1, last)]
    s, d, _, _ = foot_point(curve, x, y, samples.s[i])
    if low <= s <= high or (i == 0 and s < low) or (i == last and s > high):
        return s, d
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        px, py, dx, dy, _, _ = curve_point(curve, middle)
        if (px - x) * dx + (py - y) * dy < 0.0:
            low = middle
        else:
            high = middle
    px, py, dx, dy, _, _ = curve_point(curve, low)
    side = dx * (y - py) - dy * (x - px)
    return low, -norm(x - px, y - py) if side < 0.0 else norm(x - px, y - py)


def sample_distance(samples: CurveSamples, x: Real, y: Real, i: Int) -> Real:
    """Distance of a position from a sample [m]."""
    return norm(samples.x[i] - x, samples.y[i] - y)


def sample_after(samples: CurveSamples, i: Int, excess: Real) -> Int:
    """Next sample that may be nearer than a distance, which this one exceeds; past the last if none is."""
    return i + floor_within(excess / samples.max_gap, 1, samples.count)


def coarse_distance(samples: CurveSamples, x: Real, y: Real) -> Real:
    """Distance of a position from the nearest of a few samples [m]."""
    distance = math.inf
    i = 0
    for _ in range(samples.count):
        distance = min(distance, sample_distance(samples, x, y, i))
        i += samples.stride
        if i >= samples.count:
            break
    return distance


def nearest_sample_distance(samples: CurveSamples, x: Real, y: Real, bound: Real) -> Real:
    """Distance of a position from the nearest sample [m]; it is not above a known distance of one."""
    distance = bound
    i = 0
    for _ in range(samples.count):
        here = sample_distance(samples, x, y, i)
        distance = min(distance, here)
        i = sample_after(samples, i, here - distance)  # until there all are farther away
        if i >= samples.count:
            break
    return distance


def nearest_within(curve: Curve, samples: CurveSamples, x: Real, y: Real, bound: Real) -> tuple[Real, Real]:
    """Foot point s, d that is nearest on the whole path, from a distance of any sample."""
    n = samples.count
    # the nearest point of the curve has a sample within half a gap
    limit = nearest_sample_distance(samples, x, y, bound) + 0.5 * samples.max_gap
    best_s = samples.s[0]
    best_d = math.inf
    smallest = math.inf
    i = 0
    for _ in range(n):
        here = sample_distance(samples, x, y, i)
        if here <= limit:
            before = sample_distance(samples, x, y, max(i - 1, 0))
            after = sample_distance(samples, x, y, min(i + 1, n - 1))
            if here <= before and here <= after:
                s, d = foot_point_at_sample(curve, samples, x, y, i)
                # a straight continuation counts only where the end is the nearest point of the path
                apart = abs(d) if samples.s[0] <= s <= samples.s[n - 1] else here
                if apart < smallest:
                    smallest = apart
                    best_s = s
                    best_d = d
        i = sample_after(samples, i, here - limit)
        if i >= n:
            break
    return best_s, best_d


def nearest_point(curve: Curve, samples: CurveSamples, x: Real, y: Real) -> tuple[Real, Real]:
    """Foot point s, d of a position that is nearest on the whole path."""
    return nearest_within(curve, samples, x, y, coarse_distance(samples, x, y))


def foot_points(
    curve: Curve, n: Int, x: Row, y: Row, s_guess: Row, s: Row, d: Row, heading: Row, curvature: Row
) -> None:
    """Foot points of n positions from initial guesses."""
    for i in range(n):
        s[i], d[i], heading[i], curvature[i] = foot_point(curve, x[i], y[i], s_guess[i])


def nearest_points(curve: Curve, samples: CurveSamples, n: Int, x: Row, y: Row, s: Row, d: Row) -> None:
    """Nearest points of n positions on the whole path; those that follow each other are found sooner."""
    last = 0
    for i in range(n):
        few = sample_distance(samples, x[i], y[i], last)
        if i == 0 or few > FAR:
            few = coarse_distance(samples, x[i], y[i])
        s[i], d[i] = nearest_within(curve, samples, x[i], y[i], few)
        along = (s[i] - samples.s[0]) / (samples.s[samples.count - 1] - samples.s[0])
        last = floor_within(along * samples.count, 0, samples.count - 1)

"""Every construct of the kernel's Python, for the tests of the translator and of the binding."""

import math
from typing import Annotated

from cca_core.kernel.types import Flag, Grid, Int, Ints, Real, Reals, floor_within

__all__ = ["combine", "functions", "largest_of", "measure", "spin", "turn"]

STEP = 0.5
LIMIT = 3
BELOW = -1

Row = Annotated[Reals, "n"]


class Trial:
    """Fields of every kind."""

    n: Int
    m: Int
    is_ready: Flag
    gain: Real
    x: Row
    y: Row
    borders: Annotated[Reals, "n + 1"]
    grid: Annotated[Grid, "m", "n"]
    marks: Annotated[Ints, "n"]


def half(w: Trial, i: Int) -> Real:
    """Half of an element, which is counted."""
    w.marks[i] += 1
    return w.x[i] * STEP


def split(value: Real, low: Int) -> tuple[Int, Real]:
    """Whole and fractional part, within limits."""
    whole = floor_within(value, low, LIMIT)
    return whole, value - whole


def measure(w: Trial) -> Real:
    """Sum of a row; only reads."""
    total = 0.0
    for i in range(w.n):
        total += w.x[i]
    return total


def turn(w: Trial, gain: Real, is_back: Flag) -> Int:
    """Work on every field."""
    w.gain = gain
    x = w.x
    y = w.y
    count = 0
    for _ in range(2):
        for _ in range(w.m):
            count += 1
    for i in range(w.n - 1, BELOW, -1):
        h = half(w, i)
        y[i] = h + w.gain
        whole, rest = split(y[i], -LIMIT)
        if whole > 1 and not is_back:
            count += whole
        elif -0.5 < rest <= 0.25 or math.isnan(rest):
            count -= 1
            continue
        else:
            y[i] = max(rest, x[i], -y[i]) if is_back else abs(rest) / (2 + i)
        for o in range(0, w.m, 2):
            w.grid[o, i] = float(o) - (rest - y[i]) * (i + o)
    w.borders[w.n] = (-7 + w.n) // 2 + (w.n - 9) % 4 + 1 / 3
    for i in range(w.n):
        w.borders[i] = math.atan2(w.y[i], 1.0) + math.sin(math.pi * w.x[i])
        if not w.borders[i] < 2.0:
            break
    w.is_ready = not w.is_ready
    return min(count, 99)


def largest_of(n: Int, values: Row, marks: Annotated[Ints, "n"]) -> tuple[Int, Real, Flag]:
    """Largest marked value, where it is, and whether there is one."""
    at = -1
    largest = -math.inf
    for i in range(n):
        if marks[i] != 0 and values[i] > largest:
            largest = values[i]
            at = i
    return at, largest, at >= 0


def combine(w: Trial, other: Trial, n: Int, weights: Row, result: Row) -> None:
    """Weigh a workspace by another that is only read."""
    for i in range(n):
        result[i] = weights[i] * measure(other)
        w.x[i] += result[i]


def functions(x: Real, y: Real, out: Annotated[Reals, 16]) -> None:
    """Every function of libm that a kernel may call, within its domain."""
    positive = abs(x) + 1e-9
    unit = x / (1.0 + abs(x))
    out[0] = math.sqrt(positive)
    out[1] = math.sin(x)
    out[2] = math.cos(x)
    out[3] = math.tan(x)
    out[4] = math.asin(unit)
    out[5] = math.acos(unit)
    out[6] = math.atan(x)
    out[7] = math.atan2(x, y)
    out[8] = math.exp(min(x, 700.0))
    out[9] = math.log(positive)
    out[10] = math.pow(positive, min(max(y, -9.0), 9.0))
    out[11] = math.copysign(x, y)
    out[12] = math.fmod(x, positive * 0.3)
    out[13] = math.remainder(x, positive * 0.3)
    out[14] = float(floor_within(x, -100, 100))
    out[15] = 1.0 if math.isfinite(x) and not math.isnan(y) else 0.0


def spin(w: Trial, turns: Int) -> None:
    """Take long, for the tests of threads."""
    for _ in range(turns):
        for i in range(w.n):
            w.y[i] = math.sin(w.y[i] + w.x[i])

"""Random programs of the kernel's Python have the same results in Python and in C, bit for bit."""

import re
import shutil
from contextlib import suppress
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from cca_core.codegen import translate
from cca_core.codegen.build import KERNEL
from tests.support.kernel_forms import same
from tests.support.load_module import load
from tests.support.trial_compiler import NO_COMPILER, compile_to

FUNCTIONS, CALLS = 40, 20
BOUNDS = "n % 7", "5", "2, 9, 3", "6, -1, -1"
HEAD = """import math
from cca_core.kernel.types import Flag, Int, Real, floor_within
__all__ = [{names}]
"""
FUNCTION = """
def f{k}(a: Real, b: Real, n: Int, m: Int) -> tuple[Real, Int]:
    x = {first}
    j = {second}
    for i in range({bound}):
        if {test}:
            x {sign}= {third}
        elif {other}:
            j += {fourth}
        else:
            continue
        if {stop}:
            break
    return x, j % 1000
"""


# R, W and F stand for a part of that kind; divisors are not zero and roots are real, as in kernels
GRAMMAR = {
    "R": "(R) + R|R - (R)|R - R - (R)|(R) * (R)|(R - R) * R|-(R)|-R - (-R)|(R) / (2.0 + abs(R))"
    "|(W) / ((W) % 9 + 3)|max(R, R, 0.0)|min(R, R)|math.sqrt(abs(R))|math.sin(R) * math.cos(R)"
    "|math.atan2(R, R)|(R if F else R)|(R if F else R) + R|(R) * (W)|float(W) - (R)",
    "W": "W + W|W - (W)|(W) // 2|(W) // 7|(W) % 5|max(W, W)|floor_within(R, -99, 99)|((W) % 9) * ((W) % 9)"
    "|(W if F else W)|-(W)",
    "F": "R < R|W <= W|not (F)|(F or F)|F and F|-1.0 < a <= R|math.isfinite(R)|a != b",
}
ENDS = {"R": "a|b|x|0.5|-1.25|1e-3|math.pi|float(n)", "W": "n|m|3|-7", "F": "a < b|n >= m|n == 3"}


def sample_expression(kind: str, depth: int, random: np.random.Generator) -> str:
    """Draw an expression."""
    choices = (GRAMMAR if depth else ENDS)[kind].split("|")
    pattern = choices[random.integers(len(choices))]
    return re.sub(r"\b[RWF]\b", lambda part: sample_expression(part[0], max(depth - 1, 0), random), pattern)


def sample_function(k: int, random: np.random.Generator) -> str:
    """Draw a function."""
    first, second = (re.sub(r"\bx\b", "a", sample_expression(kind, 4, random)) for kind in "RW")
    parts = {"first": first, "second": second, "k": k, "bound": BOUNDS[k % 4], "sign": "+-*"[k % 3]}
    parts |= {"third": sample_expression("R", 2, random), "fourth": sample_expression("W", 2, random)}
    return FUNCTION.format(
        **parts, **{name: sample_expression("F", 2, random) for name in ("test", "other", "stop")}
    )


def both_forms(folder: Path, seed: int, *flags: str) -> tuple[dict[str, object], ModuleType]:
    """Return the functions of a random module in Python and in C."""
    random = np.random.default_rng(seed)
    names = [f"f{k}" for k in range(FUNCTIONS)]
    text = HEAD.format(names=", ".join(map(repr, names)))
    text += "".join(sample_function(k, random) for k in range(FUNCTIONS))
    (folder / "case.py").write_text(text, encoding="utf-8")
    for name, c in translate(folder).items():
        (folder / name).write_text(c, encoding="utf-8")
    shutil.copy(KERNEL / "c" / "lend.h", folder)
    python: dict[str, object] = {}
    exec(compile(text, "case.py", "exec"), python)
    return python, load(compile_to(folder, folder, *flags))


@pytest.mark.skipif(bool(NO_COMPILER), reason=NO_COMPILER or "-")
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in range(1, 20))])
def test_random_programs_have_the_same_bits(seed: int, tmp_path: Path) -> None:
    python, compiled = both_forms(tmp_path, seed, "-O3" if seed % 2 else "-O2")
    random = np.random.default_rng(seed)
    for k in range(FUNCTIONS):
        for _ in range(CALLS):
            a, b = (random.normal(size=2) * 10.0 ** random.integers(-3, 4)).tolist()
            given = (a, b, int(random.integers(-50, 50)), int(random.integers(-50, 50)))
            with suppress(ValueError):  # the sine of infinity, which a kernel must avoid
                expected = python[f"f{k}"](*given)  # type: ignore[operator]
                assert same(getattr(compiled, f"f{k}")(*given), expected), f"f{k}{given}"

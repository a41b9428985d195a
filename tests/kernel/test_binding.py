"""The binding of kernels to Python: kinds of arguments, sizes, results, and the same bits in both forms."""

import math
import threading
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from cca_core.kernel import bind
from cca_core.kernel.memory import lend
from tests.support.kernel_forms import FULL, QUICK, Filled, check_forms
from tests.support.trial_kernel.trial import Trial, combine, functions, largest_of, measure, spin, turn

pytestmark = pytest.mark.usefixtures("trial_compiled")
FORMS = ("c", "python")


def filled(random: np.random.Generator) -> Filled:
    """Return a workspace with a few NaN and infinities."""
    n, m = int(random.integers(1, 9)), int(random.integers(1, 4))
    x = random.normal(0.0, 2.0, n)
    x[random.random(n) < 0.1] = random.choice([math.nan, 1e300, -0.0])
    values = {"x": x, "is_ready": bool(random.integers(2)), "marks": random.integers(0, 5, n)}
    return Filled(Trial, {"n": n, "m": m}, values | {"borders": random.normal(size=n + 1)})


def turning(random: np.random.Generator) -> tuple[Any, ...]:
    """Arguments of `turn`."""
    return filled(random), float(random.normal()), bool(random.integers(2))


def marked(random: np.random.Generator) -> tuple[Any, ...]:
    """Arguments of `largest_of`."""
    n = int(random.integers(0, 9))
    return n, random.normal(size=n), random.integers(0, 2, n).astype(np.int32)


def weighed(random: np.random.Generator) -> tuple[Any, ...]:
    """Arguments of `combine`."""
    workspace = filled(random)
    n = workspace.sizes["n"]
    return workspace, filled(random), n, random.normal(size=n), np.zeros(n)


def scattered(random: np.random.Generator) -> tuple[Any, ...]:
    """Numbers of all sizes."""
    x, y = random.normal(size=2) * 10.0 ** random.uniform(-8, 8, 2)
    return x, y, np.zeros(16)


@pytest.mark.parametrize("count", [QUICK, pytest.param(FULL, marks=pytest.mark.slow)])
def test_functions_of_libm_equal_those_of_python(count: int) -> None:
    check_forms(functions, scattered, count)


def test_forms_of_trial_kernels_are_equal() -> None:
    check_forms(turn, turning, QUICK)
    check_forms(largest_of, marked, QUICK)
    check_forms(combine, weighed, QUICK)
    check_forms(measure, lambda random: (filled(random),), QUICK)


@pytest.mark.parametrize("form", FORMS)
def test_several_results_are_a_tuple(form: str) -> None:
    marks = np.array([1, 0, 1], dtype=np.int32)
    result = bind(largest_of, form)(3, np.array([1.0, 9.0, 2.0]), marks)
    assert result == (2, 2.0, True)
    assert [type(item) for item in result] == [int, float, bool]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("text", ["1.0", b"1.0"])
def test_text_is_no_number(form: str, text: object) -> None:
    with pytest.raises(TypeError, match="must be real number"):
        bind(functions, form)(text, 1.0, np.zeros(16))


@pytest.mark.parametrize("form", FORMS)
def test_numpy_numbers_are_accepted(form: str) -> None:
    lent = lend(Trial, form, n=np.int64(2), m=1)
    lent.arrays["x"][:] = 1.0
    assert bind(turn, form)(lent.workspace, np.float64(0.5), np.False_) >= 0
    assert lent.workspace.gain == 0.5


@pytest.mark.parametrize("form", FORMS)
def test_read_only_array_is_accepted_if_only_read(form: str) -> None:
    values, marks = np.ones(2), np.ones(2, dtype=np.int32)
    values.setflags(write=False)
    assert bind(largest_of, form)(2, values, marks)[0] == 0


@pytest.mark.parametrize("form", FORMS)
def test_read_only_array_is_refused_if_written(form: str) -> None:
    lent, result = lend(Trial, form, n=2, m=1), np.zeros(2)
    result.setflags(write=False)
    with pytest.raises((TypeError, BufferError, ValueError), match=r"read-?only|writable"):
        bind(combine, form)(lent.workspace, lend(Trial, form, n=2, m=1).workspace, 2, np.ones(2), result)


VALUES, MARKS = np.ones(3), np.ones(3, dtype=np.int32)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((4, VALUES, MARKS), "values must have at least 4"),
        ((3, VALUES, MARKS[:2]), "marks must have at least 3"),
        ((3, VALUES.astype(np.float32), MARKS), "values must be an array of float64"),
        ((3, VALUES, MARKS.astype(np.int64)), "marks must be an array of int32"),
        ((3, VALUES.reshape(3, 1), MARKS), "values must be a row"),
        ((3, np.ones(6)[::2], MARKS), "contiguous"),
        ((3, memoryview(bytearray(25))[1:].cast("d"), MARKS), "values must be aligned"),
        ((3.0, VALUES, MARKS), "integer"),
        ((2**40, VALUES, MARKS), "32 bits"),
        ((3, [1.0, 1.0, 1.0], MARKS), "bytes-like"),
        ((3, VALUES), "takes 3 arguments, was given 2"),
    ],
)
def test_wrong_arguments_raise(given: tuple[Any, ...], message: str) -> None:
    with pytest.raises((TypeError, ValueError, OverflowError, BufferError), match=message):
        bind(largest_of, "c")(*given)


def test_refused_call_gives_everything_back() -> None:
    lent, other = lend(Trial, "c", n=3, m=1), lend(Trial, "c", n=3, m=1)
    for _ in range(3):
        with pytest.raises(ValueError, match="result must have at least 3"):
            bind(combine, "c")(lent.workspace, other.workspace, 3, VALUES, np.zeros(2))
    bind(combine, "c")(lent.workspace, other.workspace, 3, VALUES, np.zeros(3))


def test_foreign_memory_is_no_workspace() -> None:
    with pytest.raises(TypeError, match="w must be a workspace"):
        bind(measure, "c")(np.zeros(1000))
    with pytest.raises(TypeError, match="w must be a workspace"):
        bind(measure, "c")(np.zeros(1))


def test_workspace_for_two_arguments_raises_if_changed() -> None:
    lent = lend(Trial, "c", n=3, m=1)
    with pytest.raises(RuntimeError, match="two threads"):
        bind(combine, "c")(lent.workspace, lent.workspace, 3, VALUES, np.zeros(3))


def test_second_thread_cannot_use_a_busy_workspace(trial_module: ModuleType) -> None:
    lent = lend(Trial, "c", n=1000, m=1)
    busy = threading.Thread(target=bind(spin, "c"), args=(lent.workspace, 20_000))
    busy.start()
    refused = 0
    while busy.is_alive():
        try:
            bind(measure, "c")(lent.workspace)
        except RuntimeError:
            refused += 1
    busy.join()
    assert refused > 0
    assert bind(measure, "c")(lent.workspace) == 0.0

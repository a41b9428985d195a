"""Workspaces: sizes, shared rows, reuse by threads."""

import copy
import pickle
import threading
from typing import Any

import numpy as np
import pytest

from cca_core.kernel.memory import MAX_REUSED, Lent, give_back, lend, put, reuse
from tests.support.trial_kernel.trial import Trial


@pytest.fixture(params=["c", "python"])
def lent(request: pytest.FixtureRequest, trial_compiled: Any) -> Lent[Trial]:
    return lend(Trial, request.param, n=4, m=2)


def test_arrays_have_sizes_of_annotations(lent: Lent[Trial]) -> None:
    shapes = {name: array.shape for name, array in lent.arrays.items()}
    assert shapes == {"x": (4,), "y": (4,), "borders": (5,), "grid": (2, 4), "marks": (4,)}
    assert lent.arrays["marks"].dtype == np.int32


def test_fields_are_attributes(lent: Lent[Trial]) -> None:
    workspace = lent.workspace
    assert (workspace.n, workspace.m, workspace.is_ready, workspace.gain) == (4, 2, False, 0.0)
    workspace.gain = 2.5
    lent.arrays["x"][1] = 7.0
    assert (workspace.gain, workspace.x[1]) == (2.5, 7.0)


@pytest.mark.parametrize("again", [copy.deepcopy, lambda lent: pickle.loads(pickle.dumps(lent))])
def test_copied_workspace_has_same_contents(lent: Lent[Trial], again: Any) -> None:
    lent.workspace.gain = 2.5
    lent.arrays["grid"][1, 2] = 7.0
    other = again(lent)
    assert (other.workspace.n, other.workspace.gain, other.workspace.grid[1, 2]) == (4, 2.5, 7.0)
    other.arrays["grid"][1, 2] = 8.0
    assert lent.arrays["grid"][1, 2] == 7.0


def test_reals_of_any_type_are_kept_as_float(lent: Lent[Trial]) -> None:
    class Marked(float):
        pass

    for given in (np.float32(0.1), np.int64(3), np.array(0.5), Marked(0.25), True):
        put(lent.workspace, gain=given)
        assert type(lent.workspace.gain) is float
        assert lent.workspace.gain == float(given)


def test_sizes_and_arrays_cannot_be_replaced(trial_compiled: Any) -> None:
    workspace: Any = lend(Trial, "c", n=4, m=2).workspace
    for name in ("n", "m", "x", "marks"):
        with pytest.raises(AttributeError):
            setattr(workspace, name, 9)


def test_missing_and_foreign_sizes_raise() -> None:
    with pytest.raises(ValueError, match="m"):
        lend(Trial, "python", n=4)
    with pytest.raises(ValueError, match="length"):
        lend(Trial, "python", n=4, m=2, length=3)


def test_workspace_is_reused_within_a_thread(trial_compiled: Any) -> None:
    first = reuse(Trial, n=3, m=1)
    assert reuse(Trial, n=3, m=1) is not first  # a call within a call has its own
    give_back(first)
    assert reuse(Trial, n=3, m=1) is first
    give_back(first)
    assert reuse(Trial, n=4, m=1) is not first
    found = []
    thread = threading.Thread(target=lambda: found.append(reuse(Trial, n=3, m=1)))
    thread.start()
    thread.join()
    assert found[0] is not first


def test_workspaces_of_a_thread_are_limited(trial_compiled: Any) -> None:
    first = reuse(Trial, n=1, m=1)
    give_back(first)
    for n in range(2, MAX_REUSED + 3):
        give_back(reuse(Trial, n=n, m=1))
    assert reuse(Trial, n=1, m=1) is not first

"""Loops over many problems in threads."""

import numpy as np
import pytest

from cca_core.kernel import bind
from cca_core.kernel.batches import in_chunks
from cca_core.kernel.memory import lend
from tests.support.trial_kernel.trial import Trial, spin


@pytest.mark.parametrize("threads", [1, 2, 3, 50])
@pytest.mark.parametrize("count", [0, 1, 7, 20])
def test_every_index_is_in_one_chunk(count: int, threads: int) -> None:
    done: list[tuple[int, int, int]] = []
    in_chunks(lambda *part: done.append(part), count, threads)
    done.sort()
    assert [i for _, first, end in done for i in range(first, end)] == list(range(count))
    assert [chunk for chunk, _, _ in done] == list(range(len(done)))
    assert len(done) <= max(threads, 1)


def test_error_in_a_chunk_is_raised() -> None:
    def fail(chunk: int, first: int, end: int) -> None:
        raise ValueError(f"chunk {chunk}")

    with pytest.raises(ValueError, match="chunk 0"):
        in_chunks(fail, 4, threads=2)


@pytest.mark.usefixtures("trial_compiled")
def test_threads_give_the_same_bits() -> None:
    results = []
    for threads in (1, 4):
        lent = [lend(Trial, "c", n=50, m=1) for _ in range(16)]
        for k, each in enumerate(lent):
            each.arrays["x"][:] = np.linspace(0.0, k, 50)

        def work(chunk: int, first: int, end: int, lent: list = lent) -> None:  # type: ignore[type-arg]
            for each in lent[first:end]:
                bind(spin, "c")(each.workspace, 100)

        in_chunks(work, 16, threads)
        results.append(np.array([each.arrays["y"] for each in lent]))
    assert np.array_equal(*results)

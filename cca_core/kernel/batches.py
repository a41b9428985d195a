"""Loops of the kernel over many problems, in threads if asked."""

from collections.abc import Callable


def in_chunks(call: Callable[[int, int, int], object], count: int, threads: int = 1) -> None:
    """Call `call(chunk, first, end)` for parts of range(count), each in a thread of its own.

    The results do not depend on the number of threads if each index is computed by itself. `chunk` chooses
    the workspace.
    """
    if threads <= 1 or count <= 1:
        call(0, 0, count)
        return
    from concurrent.futures import ThreadPoolExecutor  # few batches ask for threads

    chunks = min(threads, count)
    edges = [count * k // chunks for k in range(chunks + 1)]
    with ThreadPoolExecutor(chunks) as pool:
        for done in [pool.submit(call, k, edges[k], edges[k + 1]) for k in range(chunks)]:
            done.result()

"""Processes of this machine that drive the runs of a study."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager

__all__ = ["local_processes"]

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def local_processes() -> Iterator[ProcessPoolExecutor]:
    """Open one process for each processor, with one thread of linear algebra each.

    Yields
    ------
    pool : concurrent.futures.ProcessPoolExecutor
        Its processes leave interrupts to this one, and end when it does, even if it is killed.
    """
    with _one_thread():
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(mp_context=context, initializer=_begin_worker) as pool:
            yield pool


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes that are started now have one thread: libraries read it when they are loaded."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin_worker() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)

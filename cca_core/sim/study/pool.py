"""Pool of processes on this machine, one thread each."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager


@contextmanager
def local_processes(max_workers: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """Open a pool of processes that end with this one, even if it is killed."""
    with _one_thread():
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(max_workers, mp_context=context, initializer=_begin_worker) as pool:
            yield pool


@contextmanager
def _one_thread() -> Iterator[None]:
    """Limit processes that start now to one thread of linear algebra each."""
    names = "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin_worker() -> None:
    # the parent handles interrupts
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)

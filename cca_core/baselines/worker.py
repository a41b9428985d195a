"""A process of its own in which one method plans, so that it can be timed, pinned and stopped."""

import gc
import multiprocessing
import os
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, Protocol, Self

from cca_core.baselines.problem import Plan, Problem

__all__ = ["Worker"]

_READY = 60.0  # within this a method must be made [s]


class Planning(Protocol):
    """Something that plans."""

    def plan(self, problem: Problem) -> Plan:
        """Plan once.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        plan : Plan
            The answer.
        """


Timed = tuple[Plan | None, str, float]
"""A plan, or None and why there is none; and the processor time that it took [s]."""


class Worker:
    """Runs one method in another process.

    Parameters
    ----------
    make : callable
        Makes the method there; it must be importable by name, as a class or a `functools.partial` of one.
    limit : float
        Time after which a plan is given up and the process ended [s].
    core : int, optional
        Processor core to which the process is pinned, where the system can do that.

    Notes
    -----
    Processor time is counted, since other work on the machine does not lengthen it; garbage collection is
    off while a plan is made.
    """

    def __init__(self, make: Callable[[], Planning], *, limit: float = 10.0, core: int | None = None) -> None:
        self._make, self._limit, self._core = make, limit, core
        self._process: Any = None
        self._line: Connection | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def plan(self, problem: Problem) -> Timed:
        """Plan once.

        Parameters
        ----------
        problem : Problem
            What is to be driven.

        Returns
        -------
        timed : Timed
            Without plan the reason begins with ``"TIMEOUT"`` or ``"ERROR"``; the process is then made anew.
        """
        begun = time.perf_counter()
        line = self._line
        if line is None:
            line, failure = self._begin()
            if failure:
                self.close()
                return None, failure, time.perf_counter() - begun
            begun = time.perf_counter()
        try:
            line.send(problem)
            if line.poll(self._limit):
                answer: Timed = line.recv()
                return answer
            failure = f"TIMEOUT after {self._limit:g} s"
        except (EOFError, OSError) as error:
            failure = f"ERROR the process ended: {error!r}"
        self.close()
        return None, failure, time.perf_counter() - begun

    def _begin(self) -> tuple[Connection, str]:
        """Start the process; why it is not ready, empty if it is."""
        context = multiprocessing.get_context("spawn")
        self._line, other = context.Pipe()
        self._process = context.Process(target=_serve, args=(other, self._make, self._core), daemon=True)
        self._process.start()
        other.close()
        try:
            failure = str(self._line.recv()) if self._line.poll(_READY) else "TIMEOUT while it was made"
        except EOFError:
            failure = "ERROR the process ended while the method was made"
        return self._line, failure

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
        if self._line is not None:
            self._line.close()
        self._process = self._line = None


def _serve(line: Connection, make: Callable[[], Planning], core: int | None) -> None:
    """Make a method and answer problems until nobody asks any more."""
    if core is not None and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {core})
    try:
        method = make()
    except Exception as error:  # whatever a method does is an entry of the table
        line.send(f"ERROR {error!r}")
        return
    line.send("")
    while True:
        try:
            problem = line.recv()
        except EOFError:
            return
        gc.collect()
        gc.disable()
        begun = time.process_time()
        try:
            plan, failure = method.plan(problem), ""
        except Exception as error:
            plan, failure = None, f"ERROR {error!r}"
        spent = time.process_time() - begun
        gc.enable()
        line.send((plan, failure, spent))

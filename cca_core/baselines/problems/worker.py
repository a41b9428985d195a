"""A process in which one method plans, so that its processor time is measured and it can be stopped."""

import gc
import multiprocessing
import os
import statistics
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, NamedTuple, Self

from cca_core.baselines.problems.problem import Plan, PlanningMethod, Problem


class TimedPlan(NamedTuple):
    """A plan, or the reason why there is none, with its processor time."""

    plan: Plan | None
    failure: str  # begins with TIMEOUT or ERROR
    first: float  # processor time of the first plan [s]
    median: float  # of the repeated plans, or of the first one if none was repeated [s]


class Worker:
    """One method in another process, pinned to a processor core if one is given."""

    # A process pool cannot do this: it neither stops one call that hangs nor starts its process again.
    # Garbage collection is off during a plan.

    # `make` must be importable by name: a class, or a `functools.partial` of one
    def __init__(
        self,
        make: Callable[[], PlanningMethod],
        *,
        limit: float,
        core: int | None = None,
        start_limit: float = 60.0,
    ) -> None:
        self._make, self._limit, self._core, self._start_limit = make, limit, core, start_limit
        self._process: Any = None
        self._pipe: Connection | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def time(self, problem: Problem, *, repeats: int, enough: float) -> TimedPlan:
        """Plan once, and again up to `repeats` times or until `enough` seconds are spent."""
        plan, failure, first = self.plan(problem)
        times: list[float] = []
        while plan is not None and len(times) < repeats and first + sum(times) < enough:
            plan, failure, spent = self.plan(problem)
            times.append(spent)
        return TimedPlan(plan, failure, first, statistics.median(times) if times else first)

    def plan(self, problem: Problem) -> tuple[Plan | None, str, float]:
        """Plan once; after a failure the next call starts the process again."""
        begun = time.perf_counter()
        pipe = self._pipe
        if pipe is None:
            pipe, failure = self._start()
            if failure:
                self.close()
                return None, failure, time.perf_counter() - begun
            begun = time.perf_counter()
        try:
            pipe.send(problem)
            if pipe.poll(self._limit):
                answer: tuple[Plan | None, str, float] = pipe.recv()
                return answer
            failure = f"TIMEOUT after {self._limit:g} s"
        except (EOFError, OSError) as error:
            failure = f"ERROR the process ended: {error!r}"
        self.close()
        return None, failure, time.perf_counter() - begun

    def _start(self) -> tuple[Connection, str]:
        """Start the process; the text is the reason why it is not ready, empty if it is."""
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_serve, args=(other, self._make, self._core), daemon=True)
        self._process.start()
        other.close()
        try:
            failure = str(self._pipe.recv()) if self._pipe.poll(self._start_limit) else "TIMEOUT at start"
        except EOFError:
            failure = "ERROR the process ended while the method was made"
        return self._pipe, failure

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
        if self._pipe is not None:
            self._pipe.close()
        self._process = self._pipe = None


def _serve(pipe: Connection, make: Callable[[], PlanningMethod], core: int | None) -> None:
    """Make a method and plan for each problem received, until the pipe is closed."""
    if core is not None and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {core})
    try:
        method = make()
    except Exception as error:  # any failure of a method is an entry of the table
        pipe.send(f"ERROR {error!r}")
        return
    pipe.send("")
    while True:
        try:
            problem = pipe.recv()
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
        pipe.send((plan, failure, spent))

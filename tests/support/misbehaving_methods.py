"""Methods that fail in every way, and one that ignores all vehicles."""

import os
import time

import numpy as np

from cca_core import Status
from cca_core.baselines import Plan, Problem


class Straight:
    """Claims a plan along the route, through every vehicle."""

    def plan(self, problem: Problem) -> Plan:
        t = np.linspace(0.0, problem.duration, 200)
        xy = problem.road.path.position(problem.start + problem.v_x * t)
        return Plan(status=Status.OK, t=t, xy=xy, v_x=np.full(len(t), problem.v_x))


class Raises:
    def plan(self, problem: Problem) -> Plan:
        raise ValueError("its own error")


class Hangs:
    def plan(self, problem: Problem) -> Plan:
        time.sleep(60.0)
        return Plan(status=Status.INFEASIBLE)


class Dies:
    def plan(self, problem: Problem) -> Plan:
        os._exit(3)


class CannotBeMade:
    def __init__(self) -> None:
        raise RuntimeError("no license")

    def plan(self, problem: Problem) -> Plan:
        return Plan(status=Status.OK)


class Empty:
    """Claims a plan without a trajectory."""

    def plan(self, problem: Problem) -> Plan:
        return Plan(status=Status.OK)

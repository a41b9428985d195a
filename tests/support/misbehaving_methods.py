"""Methods that do what no method should, and one that does nothing."""

import os
import time

import numpy as np

from cca_core import Status
from cca_core.baselines import Plan, Problem


class Straight:
    """Along the route, whatever stands there."""

    def plan(self, problem: Problem) -> Plan:
        t = np.linspace(0.0, problem.duration, 200)
        xy = problem.road.path.position(problem.start + problem.v_x * t)
        return Plan(status=Status.OK, t=t, xy=xy, v_x=np.full(len(t), problem.v_x))


class Raises:
    def plan(self, problem: Problem) -> Plan:
        raise ValueError("of its own")


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
    """Claims to be good and has no way."""

    def plan(self, problem: Problem) -> Plan:
        return Plan(status=Status.OK)

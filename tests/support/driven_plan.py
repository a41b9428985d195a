"""A plan that is driven, for tests of modes and of actuation."""

import numpy as np

from cca_core.planner.certificate import Certificate, Grade, SafeStop
from cca_core.planner.records import DrivenPlan, LateralPath, PathKind, Profile
from cca_core.planner.scene import TIMES
from tests.support.planner_drives import straight

ROUTE = LateralPath(kind=PathKind.ROUTE, base=0, d=np.zeros(100))
STOP = SafeStop(t=np.zeros(1), delta=np.zeros(1), a_x=np.zeros(1), v=np.zeros(1), poses=np.zeros((1, 3)))


def plan(path: LateralPath = ROUTE, a: float = 0.0, free_a: float = 0.0) -> DrivenPlan:
    """A plan with a constant acceleration, and the acceleration without other vehicles [m/s^2]."""
    return DrivenPlan(
        t=0.0, path=path, reference=straight(), profile=Profile("go"), s=20.0 * TIMES, v=0.0 * TIMES + 20.0,
        a=np.full(len(TIMES), a), a_0=a, certificate=Certificate(grade=Grade.COMFORTABLE),
        limited_by="", yields_to="", free_a=free_a,
        safe_stop=STOP,
    )  # fmt: skip

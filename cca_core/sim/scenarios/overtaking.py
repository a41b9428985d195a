"""The paper's fourth scenario: maneuvering in traffic."""

import math
from typing import NamedTuple

from cca_core._checks import check_bool, check_real
from cca_core.errors import InputError
from cca_core.path import Lane, Path, Road
from cca_core.planner.settings import EvasionSettings
from cca_core.sim.scenarios.eebl import CAR
from cca_core.sim.scenarios.road_user import RoadUser
from cca_core.sim.scenarios.scenario import LANE_WIDTH, Scenario


class _Case(NamedTuple):
    """Traffic, tuning and figures of one case."""

    road_users: tuple[tuple[str, float, float, float, int], ...]
    """Id, station behind the ego's start [m], lateral offset [m], speed [m/s], direction of each."""
    cruise_speed: float = 20.0
    duration: float = 38.0
    lateral_acceleration: float = 2.0
    paper_figures: tuple[int, ...] = (13, 14, 15)


_SLALOM = (
    ("R1", 70.0, 0.0, 12.0, 1), ("R2", 120.0, LANE_WIDTH, 12.0, 1), ("R3", 170.0, 0.0, 12.0, 1),
)  # fmt: skip
_CASES = {
    "1-fast": _Case(_SLALOM, duration=32.0, lateral_acceleration=3.5),
    "1-smooth": _Case(_SLALOM, duration=32.0, lateral_acceleration=1.6),
    "2": _Case(
        (("R1", 70.0, 0.0, 17.0, 1), ("R2", 180.0, 0.0, 17.0, 1), ("A", -205.0, LANE_WIDTH, 35.0, 1)),
        cruise_speed=25.0, paper_figures=(16, 17),
    ),
    "3": _Case(
        (("R1", 70.0, 0.0, 12.0, 1), ("R2", 180.0, 0.0, 12.0, 1), ("A", 850.0, LANE_WIDTH, 20.0, -1)),
        paper_figures=(18, 19),
    ),
}  # fmt: skip

OVERTAKING_CASES = tuple(_CASES)
"""Cases of the overtaking scenario; the two tunings of case 1 are those of Fig. 15."""


def overtaking(case: str, path: Path, *, start: float = 20.0, v2v: bool = True) -> Scenario:
    """One case of the paper's fourth scenario, maneuvering in traffic (Figs 13-19).

    Parameters
    ----------
    case : {"1-fast", "1-smooth", "2", "3"}
        In case 1 the ego passes three slow vehicles on the right, left and right. In cases 2 and 3 it passes
        a first slow car at once; before it passes the second, it waits for a faster car from behind on the
        left lane (2) or for an oncoming one (3).
    path : Path
        Centerline of the ego's lane; about 1.3 km from `start` on.
    start : float
        Station of the ego at the start [m].
    v2v : bool
        Whether messages are exchanged; without, the ego has a sensor alone.

    Returns
    -------
    scenario : Scenario
        Speeds and gaps are engineering choices: the paper gives none.

    Raises
    ------
    InputError
        If the case is unknown or the road too short.
    """
    if case not in _CASES:
        raise InputError(f"case must be one of {', '.join(_CASES)}, was {case!r}")
    check_bool("v2v", v2v)
    made, start = _CASES[case], check_real("start", start)
    end = start + made.cruise_speed * made.duration + 100.0
    if path.end < end:
        raise InputError(f"path must reach {end:.0f} m for case {case}, ended at {path.end:.0f} m")
    users = tuple(
        RoadUser(
            id=name, s=start + x, d=d, v_x=v, direction=direction,
            reaction_time=1.15 if name == "A" else math.inf,
        )
        for name, x, d, v, direction in made.road_users
    )  # fmt: skip
    adjacent = Lane(d=LANE_WIDTH, width=LANE_WIDTH, direction=-1 if case == "3" else 1)
    return Scenario(
        name="maneuver", case=case,
        road=Road(path, (Lane(d=0.0, width=LANE_WIDTH), adjacent), speed_limit=36.0), vehicle=CAR,
        start=start, v_x=made.cruise_speed, cruise_speed=made.cruise_speed, road_users=users,
        duration=made.duration, hazard_id="R1",
        ego_type="v2v" if v2v else "sensor", paper_figures=made.paper_figures,
        evasion=EvasionSettings(
            lateral_acceleration=made.lateral_acceleration, awareness_range=math.inf,
            assumed_braking=0.0, assumed_acceleration=0.0,  # the paper's assumption
        ),
    )  # fmt: skip

"""The paper's fourth scenario, weave past slow cars and wait for others; and all four as a list."""

import math
from dataclasses import replace

from cca_core.errors import InputError
from cca_core.path import Lane, LocalFrame, Path, Road, fit_path
from cca_core.planner.settings import EvasionSettings
from cca_core.sim.scenarios.curbside import CURBSIDE_CASES, curbside
from cca_core.sim.scenarios.demo_road import demo_route, longest_stretch
from cca_core.sim.scenarios.eebl import CAR, LOSSY_CHANNEL, eebl
from cca_core.sim.scenarios.ima import ima
from cca_core.sim.scenarios.road_user import RoadUser
from cca_core.sim.scenarios.scenario import EGO_TYPES, Scenario

__all__ = ["OVERTAKING_CASES", "overtaking", "paper_scenarios"]

OVERTAKING_CASES = ("1-fast", "1-smooth", "2", "3")
"""Cases of the maneuvering scenario; the two tunings of case 1 are those of Fig. 15."""

_LANE = 3.5  # width [m]
_FIGURES = {"1-fast": (13, 14, 15), "1-smooth": (13, 14, 15), "2": (16, 17), "3": (18, 19)}


def overtaking(case: str, path: Path, *, start: float = 20.0, v2v: bool = True) -> Scenario:
    """One case of the paper's fourth scenario (Figs 13-19).

    Parameters
    ----------
    case : {"1-fast", "1-smooth", "2", "3"}
        Case 1 weaves past three slow vehicles on the right, left and right; in cases 2 and 3 the ego passes
        a first slow car at once and before the second waits for a faster car from behind on the left
        lane (2) or an oncoming one (3).
    path : Path
        Center line of the ego's lane; about 1.3 km from `start` on.
    start : float
        Where the ego starts on it [m].
    v2v : bool
        Whether messages are exchanged; without, a sensor sees what is in front.

    Returns
    -------
    scenario : Scenario
        Speeds and gaps are engineering choices: the paper gives none.

    Raises
    ------
    InputError
        If the case is unknown or the road too short.
    """
    if case not in OVERTAKING_CASES:
        raise InputError(f"case must be one of {', '.join(OVERTAKING_CASES)}, was {case!r}")
    cruise, slow = (25.0, 17.0) if case == "2" else (20.0, 12.0)
    if case in ("1-fast", "1-smooth"):
        others = [
            ("R1", 70.0, 0.0, slow, 1),
            ("R2", 120.0, _LANE, slow, 1),
            ("R3", 170.0, 0.0, slow, 1),
        ]
        duration = 32.0
    else:
        others = [("R1", 70.0, 0.0, slow, 1), ("R2", 180.0, 0.0, slow, 1)]
        others.append(("A", -205.0, _LANE, 35.0, 1) if case == "2" else ("A", 850.0, _LANE, 20.0, -1))
        duration = 38.0
    reach = start + cruise * duration + 100.0
    if path.end < reach:
        raise InputError(f"path must reach {reach:.0f} m for case {case}, ended at {path.end:.0f} m")
    users = tuple(
        RoadUser(
            id=name, s=start + x, d=d, v_x=v, direction=direction,
            reaction_time=1.15 if name == "A" else math.inf,
        )
        for name, x, d, v, direction in others
    )  # fmt: skip
    lanes = (
        Lane(d=0.0, width=_LANE),
        Lane(d=_LANE, width=_LANE, direction=-1 if case == "3" else 1),
    )
    return Scenario(
        name="maneuver", case=case, road=Road(path, lanes, speed_limit=36.0),
        vehicle=CAR,
        start=start, v_x=cruise, cruise_speed=cruise, road_users=users, duration=duration,
        ego_type="v2v" if v2v else "sensor", paper_figures=_FIGURES[case],
        evasion=EvasionSettings(
            lateral_acceleration={"1-fast": 3.5, "1-smooth": 1.6}.get(case, 2.0), awareness_range=math.inf,
            assumed_braking=0.0, assumed_acceleration=0.0,  # the paper's others go on as they are
        ),
    )  # fmt: skip


def paper_scenarios(path: Path | None = None, *, start: float | None = None) -> list[Scenario]:
    """All runs that show the paper's four scenarios.

    Parameters
    ----------
    path : Path, optional
        Road of the fourth scenario; the default is a stretch of motorway, `demo_route`.
    start : float, optional
        Where the ego starts on it [m]; the default is 220 m behind its beginning.

    Returns
    -------
    scenarios : list of Scenario
        The first three with messages, with a driver and with a sensor, curb-side at both speeds; the fourth
        with messages in all cases, through the same lossy channel as the others, and without in three.
    """
    if path is None:
        waypoints = demo_route()
        frame = LocalFrame(waypoints.lat[0], waypoints.lon[0])
        route = fit_path(frame.to_local(waypoints.lat, waypoints.lon))
        path = route.cut(*longest_stretch(route))
    begin = path.start + 220.0 if start is None else start
    return [
        *(eebl(case) for case in ("C", "A", "sensor")),
        *(ima(ego=ego) for ego in EGO_TYPES),
        *(curbside(case, ego=ego) for case in CURBSIDE_CASES for ego in EGO_TYPES),
        *(
            replace(overtaking(case, path, start=begin), channel=LOSSY_CHANNEL, shared_modem=True)
            for case in OVERTAKING_CASES
        ),
        *(overtaking(case, path, start=begin, v2v=False) for case in ("1-smooth", "2", "3")),
    ]

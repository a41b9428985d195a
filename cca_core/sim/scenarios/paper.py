"""All runs of the paper's four scenarios, as the demo drives them."""

from dataclasses import replace

from cca_core.path import LocalFrame, Path, fit_path
from cca_core.sim.scenarios.curbside import CURBSIDE_CASES, curbside
from cca_core.sim.scenarios.demo_road import demo_route, longest_stretch
from cca_core.sim.scenarios.eebl import LOSSY_CHANNEL, eebl
from cca_core.sim.scenarios.ima import ima
from cca_core.sim.scenarios.overtaking import OVERTAKING_CASES, overtaking
from cca_core.sim.scenarios.scenario import EGO_TYPES, Scenario


def paper_scenarios(path: Path | None = None, *, start: float | None = None) -> list[Scenario]:
    """All runs of the paper's four scenarios.

    Parameters
    ----------
    path : Path, optional
        Road of the fourth scenario; the default is 2.5 km of motorway, `demo_route`.
    start : float, optional
        Station of the ego's start on it [m]; the default is 220 m after its begin.

    Returns
    -------
    scenarios : list of Scenario
        The first three with each ego type, curb-side at both speeds; the fourth with messages in all cases,
        through the same lossy channel, and with the sensor alone in three.
    """
    if path is None:
        waypoints = demo_route()
        frame = LocalFrame(waypoints.lat[0], waypoints.lon[0])
        route = fit_path(frame.to_local(waypoints.lat, waypoints.lon), tolerance=0.3)
        path = route.cut(*longest_stretch(route))
    begin = path.start + 220.0 if start is None else start
    return [
        *(eebl(case) for case in ("C", "A", "sensor")),
        *(ima(ego_type=ego_type) for ego_type in EGO_TYPES),
        *(curbside(case, ego_type=ego_type) for case in CURBSIDE_CASES for ego_type in EGO_TYPES),
        *(
            replace(overtaking(case, path, start=begin), channel=LOSSY_CHANNEL, shared_modem=True)
            for case in OVERTAKING_CASES
        ),
        *(overtaking(case, path, start=begin, v2v=False) for case in ("1-smooth", "2", "3")),
    ]

"""CommonRoad scenarios that contain the ego's own recording."""

from pathlib import Path

from cca_core.sim import drive_commonroad, read_commonroad
from tests.trials.faults.files import file
from tests.trials.faults.table import Check, Table

TABLE = Table()


def recorded_state(tag: str, step: int, x: float, y: float = 0.0, v: float = 15.0) -> str:
    """State of a recorded vehicle."""
    return (
        f"<{tag}><position><point><x>{x}</x><y>{y}</y></point></position><orientation><exact>0.0</exact>"
        f"</orientation><time><exact>{step}</exact></time><velocity><exact>{v}</exact></velocity></{tag}>"
    )


def recorded(name: int, x: float, y: float = 0.0, v: float = 15.0) -> Path:
    """Scenario: one straight lane, a goal 140 m ahead of the ego (id 900), one car at constant speed."""
    bounds = "".join(
        f"<{tag}>" + "".join(f"<point><x>{a}</x><y>{b}</y></point>" for a in (0, 100, 200)) + f"</{tag}>"
        for tag, b in (("leftBound", 1.75), ("rightBound", -1.75))
    )
    goal = (
        "<goalState><position><rectangle><length>10</length><width>3.5</width><orientation>0</orientation>"
        "<center><x>150</x><y>0</y></center></rectangle></position><time><intervalStart>0</intervalStart>"
        "<intervalEnd>150</intervalEnd></time></goalState>"
    )
    shape = "<shape><rectangle><length>4.5</length><width>1.8</width></rectangle></shape>"
    states = "".join(recorded_state("state", k, x + 0.1 * v * k, y, v) for k in range(1, 60))
    return file(
        "scenario.xml",
        '<commonRoad commonRoadVersion="2020a" timeStepSize="0.1" benchmarkID="ZAM_Test-1">'
        f'<lanelet id="1">{bounds}</lanelet><dynamicObstacle id="{name}"><type>car</type>{shape}'
        f"{recorded_state('initialState', 0, x, y, v)}<trajectory>{states}</trajectory></dynamicObstacle>"
        f'<planningProblem id="900">{recorded_state("initialState", 0, 10.0)}{goal}</planningProblem>'
        "</commonRoad>",
    )


def collisions(name: int) -> list[Check]:
    """Drive with the ego's own recording among the obstacles."""
    run = drive_commonroad(read_commonroad(recorded(name, 10.0)))
    return [("collided with", run.summary()["collided_with"], "==", [])]


@TABLE.case("commonroad", "commonroad-own-recording", "the ego's own recording is among the obstacles")
def _():
    return collisions(8)


@TABLE.case("commonroad", "commonroad-own-id", "the same, under the id of the planning problem")
def _():
    return collisions(900)

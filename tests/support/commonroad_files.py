"""Small CommonRoad files written by hand."""

from pathlib import Path


def bound(tag: str, xs: tuple[float, ...], y: float) -> str:
    points = "".join(f"<point><x>{x}</x><y>{y}</y></point>" for x in xs)
    return f"<{tag}>{points}</{tag}>"


def lanelet(id_: int, xs: tuple[float, ...], y: float, inner: str = "") -> str:
    """Straight lanelet 3.5 m wide; `xs` against +x if it decreases."""
    side = 1.75 if xs[-1] > xs[0] else -1.75
    return (
        f'<lanelet id="{id_}">{bound("leftBound", xs, y + side)}{bound("rightBound", xs, y - side)}'
        f"{inner}</lanelet>"
    )


def state(tag: str, step: int, x: float, y: float, v: float, psi: float = 0.0) -> str:
    return (
        f"<{tag}><position><point><x>{x}</x><y>{y}</y></point></position>"
        f"<orientation><exact>{psi}</exact></orientation><time><exact>{step}</exact></time>"
        f"<velocity><exact>{v}</exact></velocity></{tag}>"
    )


BOX = "<shape><rectangle><length>4.5</length><width>1.8</width></rectangle></shape>"


def moving(id_: int, states: list[str], new: bool = True) -> str:
    tag, role = ("dynamicObstacle", "") if new else ("obstacle", "<role>dynamic</role>")
    first = states[0].replace("<state>", "<initialState>").replace("</state>", "</initialState>")
    rest = "".join(states[1:])
    return f'<{tag} id="{id_}">{role}<type>car</type>{BOX}{first}<trajectory>{rest}</trajectory></{tag}>'


def goal(time: tuple[int, int], inner: str = "") -> str:
    start, end = time
    return (
        f"<goalState>{inner}<time><intervalStart>{start}</intervalStart><intervalEnd>{end}</intervalEnd>"
        "</time></goalState>"
    )


REGION = (
    "<position><rectangle><length>10</length><width>3.5</width><orientation>0</orientation>"
    "<center><x>150</x><y>{y}</y></center></rectangle></position>"
)

ROAD = (
    lanelet(
        1, (0.0, 50.0, 100.0), 0.0, '<successor ref="2"/><adjacentLeft ref="3" drivingDir="same"/>'
        '<adjacentRight ref="5" drivingDir="opposite"/>',
    )
    + lanelet(
        2, (100.0, 150.0, 200.0), 0.0, '<predecessor ref="1"/><adjacentLeft ref="4" drivingDir="same"/>'
        '<adjacentRight ref="6" drivingDir="opposite"/>',
    )
    + lanelet(
        3, (0.0, 50.0, 100.0), 3.5, '<successor ref="4"/><adjacentRight ref="1" drivingDir="same"/>'
    )
    + lanelet(
        4, (100.0, 150.0, 200.0), 3.5, '<predecessor ref="3"/><adjacentRight ref="2" drivingDir="same"/>'
    )
    + lanelet(5, (100.0, 50.0, 0.0), -3.5)
    + lanelet(6, (200.0, 150.0, 100.0), -3.5)
)  # fmt: skip
"""Two lanes to the east and one to the west on the right-hand side of them, 200 m long."""


def problem(goals: str, v: float = 15.0, step: int = 0) -> str:
    return f'<planningProblem id="900">{state("initialState", step, 10.0, 0.0, v)}{goals}</planningProblem>'


def document(*inner: str, version: str = "2020a", dt: str = "0.1") -> str:
    return (
        f'<?xml version="1.0"?><commonRoad commonRoadVersion="{version}" timeStepSize="{dt}" '
        f'benchmarkID="ZAM_Test-1">{"".join(inner)}</commonRoad>'
    )


def written(folder: Path, text: str) -> Path:
    file = folder / "scenario.xml"
    file.write_text(text, encoding="utf-8")
    return file

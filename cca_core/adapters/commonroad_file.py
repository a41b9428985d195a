"""Files of CommonRoad in coordinates of any size."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory
from xml.etree.ElementTree import Element, SubElement, tostring

from cca_core._files import parse_tree, read_bytes
from cca_core._repr import short_repr
from cca_core.adapters.local_origin import Move, Origin, move_to_origin
from cca_core.sim import CommonRoadScenario, read_commonroad

__all__ = ["CommonRoadMap", "read_commonroad_map"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class CommonRoadMap(CommonRoadScenario):
    """Contents of a CommonRoad file near a local origin; `read_commonroad_map` makes it.

    Parameters
    ----------
    name : str
        Benchmark id.
    dt : float
        Time step of the recording [s].
    lanelets : mapping of int to Lanelet
        The road network, read-only; like all that follows, relative to the origin.
    obstacles : tuple of RecordedObstacle
        All other vehicles and obstacles.
    problems : tuple of PlanningProblem
        Planning problems; a map may have none.
    left_out, changed : tuple of str
        As in `CommonRoadScenario`.
    origin : tuple of float
        Position in the file that is x = y = 0 here [m].
    """

    origin: Origin = (0.0, 0.0)

    __repr__ = short_repr


def read_commonroad_map(file: str | FilePath, *, origin: Origin | None = None) -> CommonRoadMap:
    """Read a CommonRoad scenario or map, also in coordinates of UTM.

    Parameters
    ----------
    file : str or pathlib.Path
        File as for `cca_core.sim.read_commonroad`.
    origin : tuple of float, optional
        Position in the file that becomes x = y = 0 [m], such as that of another map. By default it is 0.
        A map whose middle is more than 900 km from there gets an origin near its middle, at whole kilometers.

    Returns
    -------
    scenario : CommonRoadMap
        What `cca_core.sim.read_commonroad` returns, and the `origin`. Lanelets, obstacles, starts and goals
        are all relative to the origin. A position of the same file or of its recording belongs to x and y
        less those of the origin; headings and speeds stay.

    Raises
    ------
    InputError
        If the file cannot be read or is not such a scenario.

    See Also
    --------
    join_lanelets : make the road along lanelets.
    cca_core.sim.drive_commonroad : drive a planning problem.
    """
    root = parse_tree(read_bytes(file), FilePath(file).name)
    found = move_to_origin(lambda move: _visit(root, move), origin)
    if any(found):
        with TemporaryDirectory() as folder:
            moved = FilePath(folder) / "moved.xml"
            moved.write_bytes(tostring(root, encoding="utf-8"))
            scenario = read_commonroad(moved)
    else:
        scenario = read_commonroad(file)
    values = {field.name: getattr(scenario, field.name) for field in fields(scenario)}
    return CommonRoadMap(**values, origin=found)


def _visit(root: Element, move: Move) -> None:
    """Move all positions."""
    for position in _positions(root):
        x, y = position.find("x"), position.find("y")
        if x is not None and y is not None:
            x.text, y.text = move(x.text or "", y.text or "")


def _positions(root: Element) -> Iterator[Element]:
    """Yield the elements that hold a position in the coordinates of the file."""
    for part in (part for element in root for part in element):
        if part.tag == "shape":  # of an obstacle, in its own axes
            continue
        for element in part.iter():
            if element.tag in ("rectangle", "circle") and element.find("center") is None:
                center = SubElement(element, "center")
                for tag in "xy":
                    SubElement(center, tag).text = "0"
            if element.tag in ("point", "center"):
                yield element

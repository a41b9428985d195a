"""Lanes of a map of OpenDRIVE against those that SUMO's `netconvert` makes of it."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from cca_core.adapters import read_opendrive, read_sumo_net
from tests.support.opendrive_files import geometry, lane, road, section, width, write_map


@pytest.mark.requires("libsumo")
def test_lanes_are_those_of_netconvert(tmp_path: Path) -> None:
    """A line of 100 m, a clothoid of 60 m and an arc of 150 m to the left."""
    sumo = pytest.importorskip("sumo")
    s = np.linspace(0.0, 60.0, 6001)
    psi = 0.5 * 0.01 / 60.0 * s * s
    x = 100.0 + float(np.trapezoid(np.cos(psi), s))
    y = float(np.trapezoid(np.sin(psi), s))
    line = [
        geometry(0.0, 0.0, 0.0, 0.0, 100.0),
        geometry(100.0, 100.0, 0.0, 0.0, 60.0, '<spiral curvStart="0" curvEnd="0.01"/>'),
        geometry(160.0, x, y, 0.3, 150.0, '<arc curvature="0.01"/>'),
    ]
    lanes = [lane(1), lane(-1, width(3.25)), lane(-2, width(3.0))]
    speed = '<type s="0" type="rural"><speed max="25" unit="m/s"/></type>'
    file = write_map(tmp_path, road("1", 310.0, line, [section(0.0, lanes)], types=speed))
    net = tmp_path / "map.net.xml"
    program = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
    options = ["--opendrive.curve-resolution", "0.5", "--opendrive.lane-shapes", "--geometry.min-dist", "0"]
    options += ["--offset.disable-normalization", "--geometry.remove", "false", "--no-turnarounds"]
    subprocess.run([program, "--opendrive-files", file, "-o", net, *options], check=True, capture_output=True)
    mapped, peer = read_opendrive(file), read_sumo_net(net)
    (edge,) = (id_ for id_ in peer.edge_ids if len(read_lanes(net, id_)) == 2)
    for lane_id, index in ((-1, 1), (-2, 0)):
        own = mapped.road_along(["1"], lane_id)
        shape = read_lanes(net, edge)[index]
        at, off = own.path.project(shape)
        inner = (at > own.path.start + 1.0) & (at < own.path.end - 1.0)
        assert np.abs(off[inner]).max() < 0.03  # corners every 0.5 m, at 1 cm
        length = float(np.hypot(*np.diff(shape, axis=0).T).sum())
        assert own.path.length == pytest.approx(length, abs=0.1)
        assert peer.road_along([edge], index).path.length == pytest.approx(length, abs=0.1)
        assert own.highest_limit(10.0, 10.0) == pytest.approx(25.0)
    assert mapped.road_along(["1"], -1).path.length == pytest.approx(310.0 + 1.625 * 1.8, abs=0.01)


def read_lanes(net: Path, edge: str) -> list[np.ndarray]:
    """Corners of the lanes of an edge, the right one first."""
    from xml.etree import ElementTree

    (found,) = (e for e in ElementTree.parse(net).getroot().iterfind("edge") if e.get("id") == edge)
    return [
        np.array([tuple(map(float, corner.split(",")))[:2] for corner in (one.get("shape") or "").split()])
        for one in found.iterfind("lane")
    ]

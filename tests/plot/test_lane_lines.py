"""Lines of roads in figures, where lanes begin, end and change their width."""

import numpy as np
import pytest

from cca_core import Lane, Path, Road
from cca_core.plot.lane_lines import road_lines
from cca_core.plot.svg import to_svg

LINE = Path([0.0, 300.0], [[[0.0, 0.0, 300.0, 0.0], [0.0, 0.0, 0.0, 0.0]]])
S = np.linspace(0.0, 300.0, 31)


def test_constant_lanes_have_constant_lines() -> None:
    edges, between = road_lines(Road(LINE, [Lane(d=0.0), Lane(d=3.5)]), S)
    assert [float(line.d[0]) for line in edges] == [-1.75, 5.25]
    assert [line.d.tolist() for line in between] == [[1.75] * 31]


def test_edge_follows_a_lane_that_ends() -> None:
    lane = Lane.from_boundaries([(0.0, 1.75, 5.25), (95.0, 1.75, 5.25), (155.0, 1.75, 1.75)])
    edges, between = road_lines(Road(LINE, [Lane(d=0.0), lane]), S)
    assert np.interp((50.0, 125.0, 200.0), *edges[1]) == pytest.approx((5.25, 3.5, 1.75))
    assert len(between) == 1  # the boundary between the lanes; the other one is the edge
    assert between[0].d == pytest.approx(1.75)


def test_svg_of_road_whose_lane_ends() -> None:
    lane = Lane.from_boundaries([(0.0, 1.75, 5.25), (95.0, 1.75, 5.25)])
    assert to_svg(Road(LINE, [Lane(d=0.0), lane])).startswith("<svg")

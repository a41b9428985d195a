"""A net of SUMO, written for tests."""

import math
from pathlib import Path


def corners(points: list[tuple[float, float]]) -> str:
    return " ".join(f"{x:.4f},{y:.4f}" for x, y in points)


def lane(edge: str, index: int, points: list[tuple[float, float]], speed: float, more: str = "") -> str:
    shape = f'shape="{corners(points)}"'
    return f'<lane id="{edge}_{index}" index="{index}" speed="{speed}" length="1" {shape} {more}/>'


def edge(id: str, start: str, end: str, *lanes: str) -> str:
    ends = f'from="{start}" to="{end}"' if start else 'function="internal"'
    return f'<edge id="{id}" {ends}>{"".join(lanes)}</edge>'


def link(first: str, i: int, second: str, k: int, via: str, turn: str) -> str:
    return f'<connection from="{first}" to="{second}" fromLane="{i}" toLane="{k}" via="{via}" dir="{turn}"/>'


def write_net(folder: Path) -> Path:
    """Two lanes east, over a junction straight on in two or left in one; then one lane, and one back."""
    angles = [0.5 * math.pi * k / 8 for k in range(9)]
    turn = [(200.0 + 21.75 * math.sin(a), 20.0 - 21.75 * math.cos(a)) for a in angles]
    wide = 'width="3.5"'
    parts = [
        edge(":B_0", "", "", *(lane(":B_0", i, [(200.0, y), (220.0, y)], 9.0, wide) for i, y in _EAST)),
        edge(":B_1", "", "", lane(":B_1", 0, turn, 6.0, wide)),
        edge(":B_2", "", "", lane(":B_2", 0, [(220.0, 1.75), (200.0, 1.75)], 9.0, wide)),
        edge(":D_0", "", "", lane(":D_0", 0, [(400.0, -1.75), (410.0, -1.75)], 9.0, wide)),
        edge("in", "A", "B", *(lane("in", i, [(0.0, y), (200.0, y)], 20.0, wide) for i, y in _EAST),
             lane("in", 2, [(0.0, -8.0), (200.0, -8.0)], 20.0, 'allow="bicycle" width="1"')),
        edge("on", "B", "D", *(lane("on", i, [(220.0, y), (400.0, y)], 25.0, wide) for i, y in _EAST)),
        edge("end", "D", "E", lane("end", 0, [(410.0, -1.75), (600.0, -1.75)], 14.0, wide)),
        edge("up", "B", "C", lane("up", 0, [(221.75, 20.0), (221.75, 200.0)], 14.0)),
        edge("back", "D", "B", lane("back", 0, [(400.0, 1.75), (220.0, 1.75)], 25.0, wide)),
        edge("out", "B", "A", lane("out", 0, [(200.0, 1.75), (0.0, 1.75)], 25.0, wide)),
        link("in", 0, "on", 0, ":B_0_0", "s"), link("in", 1, "on", 1, ":B_0_1", "s"),
        link("in", 1, "up", 0, ":B_1_0", "l"), link("back", 0, "out", 0, ":B_2_0", "s"),
        link("on", 1, "end", 0, ":D_0_0", "s"),
    ]  # fmt: skip
    file = folder / "small.net.xml"
    file.write_text(f'<?xml version="1.0"?><net version="1.9">{"".join(parts)}</net>', encoding="utf-8")
    return file


_EAST = ((0, -5.25), (1, -1.75))

"""Files of OpenDRIVE, written for tests."""

import math
from collections.abc import Sequence
from pathlib import Path


def geometry(s: float, x: float, y: float, heading: float, length: float, shape: str = "<line/>") -> str:
    return f'<geometry s="{s!r}" x="{x!r}" y="{y!r}" hdg="{heading!r}" length="{length!r}">{shape}</geometry>'


def width(a: float, b: float = 0.0, c: float = 0.0, d: float = 0.0, offset: float = 0.0) -> str:
    return f'<width sOffset="{offset!r}" a="{a!r}" b="{b!r}" c="{c!r}" d="{d!r}"/>'


def lane(
    id: int, widths: str = "", *, kind: str = "driving", before: int | None = None, after: int | None = None,
    speed: str = "",
) -> str:  # fmt: skip
    links = "" if before is None else f'<predecessor id="{before}"/>'
    links += "" if after is None else f'<successor id="{after}"/>'
    return f'<lane id="{id}" type="{kind}"><link>{links}</link>{widths or width(3.5)}{speed}</lane>'


def section(s: float, lanes: Sequence[str]) -> str:
    left = "".join(text for text in lanes if 'id="-' not in text.split(" type")[0])
    right = "".join(text for text in lanes if 'id="-' in text.split(" type")[0])
    center = '<center><lane id="0" type="none"/></center>'
    return f'<laneSection s="{s!r}"><left>{left}</left>{center}<right>{right}</right></laneSection>'


def road(
    id: str, length: float, geometries: Sequence[str], sections: Sequence[str] = (), *, link: str = "",
    offsets: str = "", types: str = "", heights: str = "", rule: str = "RHT", junction: str = "-1",
) -> str:  # fmt: skip
    body = "".join(sections) or section(0.0, [lane(1), lane(-1)])
    return (
        f'<road id="{id}" length="{length!r}" rule="{rule}" junction="{junction}"><link>{link}</link>{types}'
        f"<planView>{''.join(geometries)}</planView><elevationProfile>{heights}</elevationProfile>"
        f"<lanes>{offsets}{body}</lanes></road>"
    )


def write_map(folder: Path, *parts: str) -> Path:
    file = folder / "map.xodr"
    header = '<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="7"/>'
    file.write_text(f"{header}{''.join(parts)}</OpenDRIVE>", encoding="utf-8")
    return file


def crossing(tmp_path: Path) -> Path:
    """East in road 1, left in road 5 over a quarter circle of 20 m, north in road 2; straight on in 3."""
    quarter = 10.0 * math.pi
    ahead = '<successor elementType="junction" elementId="9"/>'
    one = road("1", 100.0, [geometry(0.0, 0.0, 0.0, 0.0, 100.0)], link=ahead)
    link = '<predecessor elementType="road" elementId="1" contactPoint="end"/>'
    turn = '<successor elementType="road" elementId="2" contactPoint="end"/>'
    on = '<successor elementType="road" elementId="3" contactPoint="start"/>'
    arc = geometry(0.0, 100.0, 0.0, 0.0, quarter, '<arc curvature="0.05"/>')
    inner = [section(0.0, [lane(-1, before=-1, after=1)])]
    five = road("5", quarter, [arc], inner, link=link + turn, junction="9")
    # road 2 points to the junction, so that its lane 1 leads away from it
    two = road("2", 80.0, [geometry(0.0, 120.0, 100.0, -0.5 * math.pi, 80.0)], link=ahead)
    straight = [section(0.0, [lane(-1, before=-1, after=-1)])]
    six = road("6", 40.0, [geometry(0.0, 100.0, 0.0, 0.0, 40.0)], straight, link=link + on, junction="9")
    three = road("3", 60.0, [geometry(0.0, 140.0, 0.0, 0.0, 60.0)])
    junction = '<junction id="9"><connection id="0" incomingRoad="1" connectingRoad="5" contactPoint="start">'
    junction += '<laneLink from="-1" to="-1"/></connection>'
    junction += '<connection id="1" incomingRoad="1" connectingRoad="6" contactPoint="start">'
    junction += '<laneLink from="-1" to="-1"/></connection></junction>'
    return write_map(tmp_path, one, two, three, five, six, junction)

"""Files of OpenDRIVE, written for tests."""

from collections.abc import Sequence
from pathlib import Path

LANES = {1: "3.5", -1: "3.5"}


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

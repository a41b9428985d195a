"""Maps of tests elsewhere: the same file with other coordinates."""

import re
from decimal import Decimal
from pathlib import Path

FAR = [("691234.5", "5334567.25"), ("-3500000", "120000.125"), ("0", "-8000001"), ("691234.5", "334567.25")]
"""Positions of UTM and others by which maps are moved [m], as texts."""


def numbers(by: tuple[str, str]) -> tuple[float, float]:
    return float(by[0]), float(by[1])


def plus(text: str, by: str) -> str:
    return str(Decimal(text) + Decimal(by))


def moved_commonroad(text: str, by: tuple[str, str]) -> str:
    """A CommonRoad file with all positions moved but those in the shapes of obstacles."""
    parts = re.split(r"(<shape>.*?</shape>)", text, flags=re.DOTALL)
    for i in range(0, len(parts), 2):
        for tag, step in zip("xy", by, strict=True):
            parts[i] = re.sub(
                f"(<{tag}>)([^<]*)", lambda found, step=step: found[1] + plus(found[2], step), parts[i]
            )
    return "".join(parts)


def moved_file(file: Path, by: tuple[str, str]) -> Path:
    """A file of OpenDRIVE or SUMO beside the given one, moved."""
    text = file.read_text(encoding="utf-8")
    if file.name.endswith(".net.xml"):
        text = re.sub(
            r"([-\d.]+),([-\d.]+)", lambda pair: f"{plus(pair[1], by[0])},{plus(pair[2], by[1])}", text
        )
    else:
        for tag, step in zip("xy", by, strict=True):
            text = re.sub(
                rf'(<geometry [^>]*\b{tag}=")([^"]*)',
                lambda found, step=step: found[1] + plus(found[2], step),
                text,
            )
    far = file.with_name(f"far_{file.name}")
    far.write_text(text, encoding="utf-8")
    return far

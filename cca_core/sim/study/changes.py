"""What differs between the definitions of two studies, in words."""

import json
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from cca_core._files import parse_json
from cca_core.errors import InputError

LIBRARY = "the version or the sources of cca_core"
_SCENARIO = "parameters.scenario"
_NAMES = {"source": LIBRARY, "definition": "the source of the scenario", _SCENARIO: "the scenario"}
_NO_NAMES: Mapping[str, str] = MappingProxyType({})
_MAX_TEXT = 60  # of a value that is shown


def describe_changes(before: str, now: str, names: Mapping[str, str] = _NO_NAMES) -> str:
    """Return what differs between two fingerprints of studies, empty if nothing does or one is of no study.

    Parts of the definition may have `names` of their own.
    """
    try:
        old, new = (_flat(parse_json(text, "study")) for text in (before, now))
    except (InputError, TypeError, ValueError, RecursionError):
        return ""
    if not old or not new:
        return ""
    differing = [key for key in (*new, *(old.keys() - new.keys())) if old.get(key) != new.get(key)]
    found = (names[key] if key in names else _change(key, old, new, {**_NAMES, **names}) for key in differing)
    return ", ".join(dict.fromkeys(found))


def _change(key: str, old: Mapping[str, Any], new: Mapping[str, Any], names: Mapping[str, str]) -> str:
    """Return the name of a part, with both values where they are short."""
    values = [content.get(key) for content in (old, new)]
    sources = [value for value in values if isinstance(value, str) and "\n" in value]
    if len(sources) == 2:
        lines = _changed_lines(*sources)
        what = "plant" if key == "plant" else "scenario"
        return f"the source of the {what}{_pair(*lines) if any(lines) else ''}"
    if sources and key == "plant":
        return "the plant"
    if key in names:
        return names[key]
    if key not in old or key not in new:  # another scenario or another version has other parts
        return names[_SCENARIO] if key.startswith(_SCENARIO) else LIBRARY
    return key.removeprefix("parameters.") + _pair(*values)


def _pair(before: Any, now: Any) -> str:
    """Return both values if they are short, else nothing."""
    texts = [json.dumps(value) for value in (before, now)]
    return f" (was {texts[0]}, is {texts[1]})" if max(map(len, texts)) <= _MAX_TEXT else ""


def _changed_lines(before: str, now: str) -> tuple[str, str]:
    """Return the first line of each of two sources that the other one does not have."""
    old, new = ([line.strip() for line in text.splitlines()] for text in (before, now))
    lines = [next((line for line in a if line not in b), "") for a, b in ((old, set(new)), (new, set(old)))]
    return lines[0], lines[1]


def _flat(content: object, name: str = "") -> dict[str, Any]:
    """Return the values of inner tables under names with dots."""
    if not isinstance(content, dict):
        return {name: content} if name else {}
    return {key: value for pair in _inner(content, name) for key, value in pair.items()}


def _inner(content: dict[str, Any], name: str) -> Iterator[dict[str, Any]]:
    for key, value in content.items():
        yield _flat(value, f"{name}.{key}" if name else key)

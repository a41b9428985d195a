"""The HTML, CSS and JavaScript of the report, which lie next to this module."""

from functools import cache
from importlib.resources import files
from string import Template


@cache
def read_text(name: str) -> str:
    """Text of a file of this package."""
    return (files(__package__) / name).read_text(encoding="utf-8")


def fill(file: str, /, **values: str) -> str:
    """Text of an HTML file with each ``$name`` replaced."""
    return Template(read_text(file)).substitute(values)

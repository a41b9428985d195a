"""Contents of files from outside: limited in size and depth, without a document type declaration."""

import json
import re
from pathlib import Path as FilePath
from typing import Any
from xml.etree import ElementTree

import numpy as np

from cca_core._checks import shown
from cca_core.errors import InputError

MAX_BYTES = 50_000_000
MAX_DEPTH = 100  # of elements in elements, or lists in lists
MAX_ELEMENTS = 5_000_000  # an element takes about 100 bytes
_JSON_TEXT = re.compile(rb'"(?:[^"\\]++|\\.)*+"?', re.DOTALL)


def read_bytes(file: str | FilePath, *, max_bytes: int = MAX_BYTES, name: str = "file") -> bytes:
    """Return the content of a file that is not too large."""
    try:
        with FilePath(file).open("rb") as stream:
            data = stream.read(max_bytes + 1)
    except TypeError:
        raise InputError(f"{name} must be a path, was {shown(file)}") from None
    except OSError as error:
        raise InputError(f"{name} {str(file)!r} cannot be read: {error.strerror}") from None
    except ValueError as error:  # a null character
        raise InputError(f"{name} {str(file)!r} cannot be read: {error}") from None
    if len(data) > max_bytes:
        raise InputError(f"{name} must be at most {max_bytes // 1_000_000} MB long")
    return data


class XmlTarget:
    """Receives the elements of an XML file; a subclass keeps what it needs."""

    def __init__(self) -> None:
        self.depth = 0
        self._elements = 0

    def doctype(self, *_: object) -> None:
        """Refuse a document type declaration, and with it all entities."""
        raise InputError("DOCTYPE must not occur in the file")

    def start(self, tag: str, attributes: dict[str, str], /) -> Any:
        """Count an element."""
        self.depth += 1
        self._elements += 1
        if self.depth > MAX_DEPTH:
            raise InputError(f"elements must be nested at most {MAX_DEPTH} deep")
        if self._elements > MAX_ELEMENTS:
            raise InputError(f"file must have at most {MAX_ELEMENTS} elements")

    def end(self, tag: str, /) -> Any:
        """Leave an element."""
        self.depth -= 1


class _Tree(XmlTarget):
    """Builds the tree of elements."""

    def __init__(self) -> None:
        super().__init__()
        builder = ElementTree.TreeBuilder()
        self._start, self._end, self.data, self.close = (
            builder.start,
            builder.end,
            builder.data,
            builder.close,
        )

    def start(self, tag: str, attributes: dict[str, str], /) -> None:
        super().start(tag, attributes)
        self._start(tag, attributes)

    def end(self, tag: str, /) -> None:
        self.depth -= 1
        self._end(tag)


def parse_xml(data: bytes, target: XmlTarget, name: str) -> Any:
    """Pass the elements of an XML text to `target`; `name` is that of the file."""
    parser = ElementTree.XMLParser(target=target)
    try:
        # in one call: the parser would start a long token again with every further one
        parser.feed(data)
        return parser.close()
    except InputError:
        raise
    except (ElementTree.ParseError, LookupError, ValueError, OverflowError) as error:
        raise InputError(f"file {name!r} is broken XML: {error}") from None


def parse_tree(data: bytes, name: str) -> ElementTree.Element:
    """Return the root of an XML text."""
    root: ElementTree.Element = parse_xml(data, _Tree(), name)
    return root


def parse_json(data: str | bytes, name: str) -> Any:
    """Return the value of a JSON text; `name` says what it is."""
    try:
        raw = data.encode() if isinstance(data, str) else data
        brackets = np.frombuffer(_JSON_TEXT.sub(b"", raw), dtype=np.uint8)
        opened = (brackets == ord("[")) | (brackets == ord("{"))
        closed = (brackets == ord("]")) | (brackets == ord("}"))
        if np.cumsum(opened.astype(np.int32) - closed).max(initial=0) > MAX_DEPTH:
            raise InputError(f"{name} must be nested at most {MAX_DEPTH} deep")
        return json.loads(data)
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError(f"{name} must be JSON, was not: {str(error)[:100]}") from None

"""Contents of files from outside: limited in size and depth, without a document type declaration."""

import json
import re
from pathlib import Path as FilePath
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np

from cca_core._checks import shown
from cca_core.errors import InputError

MAX_BYTES = 50_000_000
MAX_DEPTH = 100  # of elements in elements, or lists in lists
MAX_ELEMENTS = 5_000_000  # an element takes about 100 bytes
_MAX_TAG = 1_000_000  # with its attributes, a comment alike [bytes]
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

    def data(self, text: str, /) -> Any:
        """Take text within an element."""

    def close(self) -> Any:
        """Return what was kept."""


class _Tree(XmlTarget):
    """Builds the tree of elements."""

    def __init__(self) -> None:
        super().__init__()
        self._builder = ElementTree.TreeBuilder()

    def start(self, tag: str, attributes: dict[str, str], /) -> None:
        super().start(tag, attributes)
        self._builder.start(tag, attributes)

    def end(self, tag: str, /) -> None:
        self.depth -= 1
        self._builder.end(tag)

    def data(self, text: str, /) -> None:
        self._builder.data(text)

    def close(self) -> ElementTree.Element:
        return self._builder.close()


def parse_xml(data: bytes, target: XmlTarget, name: str) -> Any:
    """Pass the elements of an XML text to `target`; `name` is that of the file."""
    parser = expat.ParserCreate()  # without namespaces, which would be copied into every name
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = target.doctype
    parser.StartElementHandler, parser.EndElementHandler = target.start, target.end
    parser.CharacterDataHandler = target.data
    try:
        for begin in range(0, len(data), _MAX_TAG):
            parser.Parse(data[begin : begin + _MAX_TAG], False)
            # the parser starts an unfinished tag again with every piece
            if begin - parser.CurrentByteIndex > _MAX_TAG:
                raise InputError(f"file must have tags of at most {_MAX_TAG / 1e6:g} MB")
        parser.Parse(b"", True)
    except InputError:
        raise
    except (expat.ExpatError, LookupError, ValueError, OverflowError) as error:
        raise InputError(f"file {name!r} is broken XML: {error}") from None
    return target.close()


def parse_tree(data: bytes, name: str) -> ElementTree.Element:
    """Return the root of an XML text."""
    root: ElementTree.Element = parse_xml(data, _Tree(), name)
    return root


def parse_json(data: str | bytes, name: str) -> Any:
    """Return the value of a JSON text; `name` names it in messages."""
    try:
        raw = data.encode() if isinstance(data, str) else data
        brackets = np.frombuffer(_JSON_TEXT.sub(b"", raw), dtype=np.uint8)
        brackets = brackets[np.isin(brackets, np.frombuffer(b"[]{}", dtype=np.uint8))]
        steps = np.where((brackets == ord("[")) | (brackets == ord("{")), 1, -1).astype(np.int32)
        if np.cumsum(steps, dtype=np.int32).max(initial=0) > MAX_DEPTH:
            raise InputError(f"{name} must be nested at most {MAX_DEPTH} deep")
        return json.loads(data)
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError(f"{name} must be JSON, was not: {str(error)[:100]}") from None

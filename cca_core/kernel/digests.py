"""Digests of all that a compiled kernel is made from; runs without the library, while it is installed."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

KERNEL = Path(__file__).parent
HOST = frozenset({"__init__", "types", "memory", "batches", "digests"})
"""Modules of this folder that are no kernels."""


def sources(folder: Path) -> list[Path]:
    """Files of a folder that hold kernels."""
    return sorted(path for path in folder.glob("*.py") if path.stem not in HOST)


def digest(folder: Path) -> str:
    """SHA-256 of what the C is translated from: the kernels in a folder, their types and the translator."""
    return _sha256([*sources(folder), KERNEL / "types.py", *sorted(KERNEL.parent.glob("codegen/*.py"))])


def c_digest(folder: Path) -> str:
    """SHA-256 of the C in a folder."""
    return _sha256(sorted(path for path in folder.glob("*") if path.suffix in (".c", ".h")))


def _sha256(files: Iterable[Path]) -> str:
    """SHA-256 of names and texts, whatever their line ends."""
    total = hashlib.sha256()
    for file in files:
        total.update(file.name.encode() + b"\0" + file.read_bytes().replace(b"\r\n", b"\n") + b"\0")
    return total.hexdigest()

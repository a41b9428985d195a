"""Rows that an interrupted run does not measure again."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any, TypeVar

from cca_core.sim.study.store import Store

Row = TypeVar("Row")


def kept_row(
    store: Store | None,
    key: tuple[object, ...],
    kind: Callable[..., Row],
    measure: Callable[[], Row],
    progress: Callable[[Row], None] | None,
) -> Row:
    """Row of a store, or a new one that is added to it and reported."""
    name = " | ".join(map(str, key))
    if store is not None and name in store.rows:
        return kind(**store.rows[name])
    row: Any = measure()
    if store is not None:
        store.add(name, asdict(row))
    if progress is not None:
        progress(row)
    return row  # type: ignore[no-any-return]

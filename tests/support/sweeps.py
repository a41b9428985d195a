"""Sweeps of which `make test` runs a part."""

from typing import Any

import pytest


def sweep(*cases: Any, quick: int = 1) -> list[Any]:
    """Cases of a parameter: the first ones in `make test`, all of them in `make validate`."""
    rest = (case if isinstance(case, tuple) else (case,) for case in cases[quick:])
    return [*cases[:quick], *(pytest.param(*values, marks=pytest.mark.slow) for values in rest)]

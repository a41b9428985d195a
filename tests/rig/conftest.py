"""Rigs of two processes that end with their test."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cca_core.sim import Scenario
from tests.support.rig_processes import Rig


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[[Scenario], Rig]]:
    rigs: list[Rig] = []

    def begin(scenario: Scenario) -> Rig:
        rigs.append(Rig(scenario, tmp_path, 40 + os.getpid() % 400))
        return rigs[0]

    yield begin
    for rig in rigs:
        rig.close()

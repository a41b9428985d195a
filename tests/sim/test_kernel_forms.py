"""A run is the same log, bit for bit, whether the kernel is C or Python."""

import hashlib
import math
import os
import subprocess
import sys
from dataclasses import fields, replace

import numpy as np
import pytest

from cca_core.sim import Log, paper_scenarios, simulate
from tests.support.kernel_forms import needs_c
from tests.support.sweeps import sweep

CLOCKS = ("cycle_us", "wall_s", "missed_deadlines", "scenario")  # of the machine, and the input
NAMES = [f"{s.name}-{s.case}-{s.ego_type}" for s in paper_scenarios()]
QUICK = "maneuver-3-sensor"


def digest(log: Log) -> str:
    """SHA-256 of all that a run has produced."""
    total = hashlib.sha256()
    for field in fields(log):
        value = getattr(log, field.name)
        if field.name not in CLOCKS:
            total.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
    return total.hexdigest()


def digest_of(name: str, duration: float) -> str:
    """Digest of the beginning of a run, of this process."""
    scenario = paper_scenarios()[NAMES.index(name)]
    return digest(simulate(replace(scenario, duration=min(duration, scenario.duration))))


@needs_c
@pytest.mark.parametrize(("name", "duration"), sweep((QUICK, 4.0), *((name, math.inf) for name in NAMES)))
def test_log_in_c_equals_log_in_python(name: str, duration: float) -> None:
    asked = f'"{name}", float("{duration}")'
    code = f"from tests.sim.test_kernel_forms import digest_of; print(digest_of({asked}))"
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "CCA_KERNEL": "python"}, capture_output=True,
        text=True, check=True, timeout=300.0,
    )  # fmt: skip
    assert done.stdout.strip() == digest_of(name, duration)

"""What all tests share: recorded data, Hypothesis profiles, the `requires` mark."""

import os
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

ROOT = Path(__file__).resolve().parents[1]

if find_spec("rclpy") is None:  # a program that a test runs, read by doctest
    collect_ignore = ["support/ros_drive.py"]

settings.register_profile(
    "ci", deadline=None, derandomize=True, max_examples=50, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("full", parent=settings.get_profile("ci"), max_examples=1000)
settings.load_profile(os.environ.get("CCA_HYPOTHESIS_PROFILE", "ci"))


def pytest_runtest_setup(item: pytest.Item) -> None:
    for mark in item.iter_markers("requires"):
        for module in mark.args:
            if find_spec(module) is None:
                pytest.skip(f"needs {module}")


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder with recorded data (gps/, bsm/, commonroad/), which the repository does not hold."""
    folder = Path(os.environ.get("CCA_DATA_DIR", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no recorded data at {folder}; set CCA_DATA_DIR")
    return folder

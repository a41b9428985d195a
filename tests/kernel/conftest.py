"""Trial kernels, compiled once."""

from types import ModuleType

import pytest

from cca_core import kernel
from tests.support.trial_compiler import NO_COMPILER, compile_trial


@pytest.fixture(scope="session")
def trial_module(tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    """Return the compiled trial kernels."""
    if NO_COMPILER:
        pytest.skip(NO_COMPILER)
    return compile_trial(tmp_path_factory.mktemp("trial"))


@pytest.fixture
def trial_compiled(trial_module: ModuleType, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Bind the trial kernels instead of those of the library."""
    monkeypatch.setattr(kernel, "COMPILED", trial_module)
    return trial_module

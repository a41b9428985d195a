import subprocess
import sys

import pytest


@pytest.mark.parametrize("module", ["cca_core", "cca_core.plot.svg", "cca_core.report"])
def test_import_does_not_load_matplotlib(module: str) -> None:
    code = f"import sys, {module}; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0

"""Hook of hatchling: compile the kernel where there is a compiler; without one the wheel is pure Python."""

import os
import runpy
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class KernelHook(BuildHookInterface[Any]):
    """Add the compiled kernel to a wheel; an editable install gets it beside its Python."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile before the wheel is filled. CCA_KERNEL=c makes a failure an error, python skips it."""
        wish = os.environ.get("CCA_KERNEL", "")
        if wish == "python":
            return
        compile_kernel = runpy.run_path(str(Path(self.root, "cca_core", "codegen", "build.py")))[
            "compile_kernel"
        ]
        package = Path(self.root, "cca_core", "kernel")
        self.scratch = tempfile.TemporaryDirectory()  # lives as long as this hook
        target = package if version == "editable" else Path(self.scratch.name)
        try:
            made: Path = compile_kernel(package, target)
        except Exception as error:  # setuptools has no common class of what compilers do wrong
            if wish == "c":
                raise
            self.app.display_warning(f"the kernel is not compiled, it runs in Python: {error}")
            return
        if version != "editable":
            build_data["force_include"][str(made)] = f"cca_core/kernel/{made.name}"
        build_data["pure_python"] = False
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"cp311-abi3-{platform}"

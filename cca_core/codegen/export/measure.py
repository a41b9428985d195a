"""Size, stack and time of a C project, by a compiler of this machine."""

import re
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off")
PARTS = ("kernel", "model")
_NODE = re.compile(r'^node: \{ title: "([^"]+)" label: "[^"]*?(\d+) bytes')
_EDGE = re.compile(r'^edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')


def measure(folder: Path, compiler: str = "gcc") -> list[str]:
    """Build a project, run its harness, and describe what it needs; the first line is that of the harness."""
    if shutil.which(compiler) is None:
        return [f"not built: no {compiler} on this machine"]
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        sources = [str(folder / f"{part}.c") for part in (*PARTS, "harness")]
        built = _run(scratch, compiler, *FLAGS, *sources, "-o", "harness", "-lm")
        if built.returncode:
            return [f"not built: {built.stderr.strip()}"]
        run = _run(scratch, str(scratch / "harness"), str(folder / "cases.txt"))
        lines = [run.stdout.strip() or run.stderr.strip()]
        flags = (*FLAGS, "-fcallgraph-info=su", "-c")
        if all(_run(scratch, compiler, *flags, source).returncode == 0 for source in sources[:-1]):
            graphs = [(scratch / f"{part}.ci").read_text(encoding="utf-8") for part in PARTS]
            bytes_used = deepest_stack(graphs, "model_step")
            lines.append(f"{bytes_used} bytes of stack, without those of the C library")
            if shutil.which("size"):
                table = _run(scratch, "size", *(f"{part}.o" for part in PARTS)).stdout.splitlines()[1:]
                sizes = [sum(map(int, row.split()[:3])) for row in table]
                lines.append(f"{sizes[0]} bytes of kernel, {sizes[1]} bytes of model and its constants")
        return lines


def _run(folder: Path, *command: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def deepest_stack(graphs: list[str], root: str) -> int:
    """Return the stack of the deepest chain of calls from a function, from call graphs of gcc [bytes]."""
    own: dict[str, int] = {}
    calls: dict[str, set[str]] = {}
    for line in "\n".join(graphs).splitlines():
        if node := _NODE.match(line):
            own[node[1]] = int(node[2])
        elif edge := _EDGE.match(line):
            calls.setdefault(edge[1], set()).add(edge[2])

    @cache
    def depth(name: str) -> int:  # the kernel has no recursion
        return own.get(name, 0) + max(map(depth, calls.get(name, ())), default=0)

    return depth(root)

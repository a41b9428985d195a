"""Translate the kernel, written in a small part of Python, to C99.

Whatever lies outside of that part is an error that names file and line. The C does the same arithmetic in the
same order, so results are equal bit for bit if the compiler does not contract products and sums.
"""

import re
import textwrap
from pathlib import Path

from cca_core.codegen.binding import binding
from cca_core.codegen.kinds import TranslationError as TranslationError
from cca_core.codegen.program import Program
from cca_core.kernel.digests import digest, sources

FOLDER = Path(__file__).resolve().parents[1] / "kernel"
NOTE = "/* Made from the Python of cca_core/kernel by `make kernel`: edit that. */"
# Python's max and min give the first of equals, and the first if the second is not a number; its // and %
# of a positive number are rounded down
HELPERS = {
    "real_max": "static inline double real_max(double a, double b) { return b > a ? b : a; }",
    "real_min": "static inline double real_min(double a, double b) { return b < a ? b : a; }",
    "int_max": "static inline int int_max(int a, int b) { return b > a ? b : a; }",
    "int_min": "static inline int int_min(int a, int b) { return b < a ? b : a; }",
    "int_rest": "static inline int int_rest(int a, int b) { return a < 0 ? b - 1 - (-1 - a) % b : a % b; }",
    "int_floor": "static inline int int_floor(int a, int b) { return a < 0 ? -1 - (-1 - a) / b : a / b; }",
    "floor_within": """static inline int floor_within(double value, int low, int high)
{
    if (!(value >= low)) {
        return low;
    }
    return value >= high ? high : (int)floor(value);
}""",
}
HEADER = """
#ifndef CCA_KERNEL_H
#define CCA_KERNEL_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif"""
HEADER_END = """
#ifdef __cplusplus
}
#endif

#endif"""
SOURCE = """#include "kernel.h"

#include <float.h>
#include <math.h>

/* compile with -ffp-contract=off: a fused product and sum has other bits than Python */
#if FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD > 1 || defined(__FAST_MATH__)
#error "the kernel needs strict arithmetic of doubles"
#endif
#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif
"""
MAX_WIDTH = 110


def wrapped(line: str) -> str:
    """Break a line after commas and before operators; a macro must stay on one."""
    margin = line[: len(line) - len(line.lstrip())]
    if len(line) <= MAX_WIDTH or line.startswith("#"):
        return line
    kept = line.strip() if line.startswith("/*") else re.sub(r"(?<!,) (?![-+*/<>=&|?:])", "\0", line.strip())
    indents = (margin, f"{margin}    ")
    width = MAX_WIDTH - len(indents[1])
    lines = textwrap.wrap(kept, width, break_long_words=False, break_on_hyphens=False)
    return "\n".join(indents[i > 0] + part.replace("\0", " ") for i, part in enumerate(lines))


def translate(folder: Path, *modules: str) -> dict[str, str]:
    """Translate a folder, or some modules and what they need, to texts of kernel.h, kernel.c and python.c."""
    program = Program(folder)
    for module in modules or [path.stem for path in sources(folder)]:
        program.add(module)
    lines = [wrapped(line) for line in program.lines]
    used = set(re.findall(r"\w+(?=\()", "\n".join(lines)))
    helpers = [text for name, text in HELPERS.items() if name in used]
    parts = {
        "kernel.h": [HEADER, *map(wrapped, program.header), HEADER_END],
        "kernel.c": [SOURCE, *helpers, *lines],
        "python.c": binding(program.kernels, program.structures, digest(folder)),
    }
    return {name: "\n".join([NOTE, *text]) + "\n" for name, text in parts.items()}
